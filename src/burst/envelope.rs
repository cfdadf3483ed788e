//! The Gaussian envelope of a burst, from the powers of its points.
//!
//! The powers of a Gaussian envelope of deviation s are a Gaussian of variance `v = s^2 / 2`. Their moments over the whole record would
//! hold the noise of all points, so they are taken under a gate about the last middle, a Gaussian of variance `2 v'` with the last `v'`.
//! The product of two Gaussians is one, whose variance w gives the next v:
//!
//! ```text
//! 1 / v = 1 / w - 1 / (2 v')
//! ```

use super::baseband::{POINTS, place, used};
use crate::math::scalar::Scalar as _;

/// An envelope `exp(-(t - middle)^2 / 2 deviation^2)`, in records.
#[derive(Clone, Copy, Debug)]
pub(super) struct Envelope {
    pub middle: f32,
    pub deviation: f32,
}

/// The least and the greatest deviation that 64 points can show, in records.
pub(super) const LEAST: f32 = 0.03;
pub(super) const MOST: f32 = 0.42;

/// Steps of the iteration: the gate follows the envelope, whose variance it halves.
const STEPS: usize = 10;

/// The median of at most 64 numbers; 0 of none.
pub(super) fn median(values: &heapless::Vec<f32, POINTS>) -> f32 {
    let middle = values.len() / 2;
    let rank = |value: f32| values.iter().filter(|&&other| other < value).count();
    // Several equal numbers share a rank: the result is the largest number of a rank up to the middle.
    let below = values.iter().copied().filter(|&value| rank(value) <= middle);
    below.fold(0.0, f32::max)
}

impl Envelope {
    /// The level at a place.
    pub fn at(&self, place: f32) -> f32 {
        let u = (place - self.middle) / self.deviation;
        if u.abs() > 9.0 { 0.0 } else { libm::expf(-0.5 * u * u) }
    }

    /// The envelope of these powers, from a guess: their moments under a gate of the envelope's own shape, which is twice as long. The
    /// noise is the median of the points outside the gate.
    pub fn fitted(self, powers: &[f32; POINTS]) -> Self {
        let mut beside = heapless::Vec::<f32, POINTS>::new();
        for (index, &power) in powers.iter().enumerate() {
            if used(index) && (place(index) - self.middle).abs() > 3.0 * self.deviation {
                // There is room.
                let _ = beside.push(power);
            }
        }
        // The median of an exponential number is ln 2 of its mean.
        let noise = if beside.len() < 8 { 0.0 } else { median(&beside) / core::f32::consts::LN_2 };
        let (mut middle, mut variance) = (self.middle, 0.5 * self.deviation * self.deviation);
        for _ in 0..STEPS {
            let gate = Envelope { middle, deviation: (2.0 * variance).root() };
            let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
            for (index, &power) in powers.iter().enumerate() {
                if used(index) {
                    let at = place(index) - middle;
                    let weight = (power - noise) * gate.at(place(index));
                    sum += weight;
                    first += weight * at;
                    second += weight * at * at;
                }
            }
            let mean = first / sum;
            let spread = second / sum - mean * mean;
            if !(sum > 0.0 && spread > 0.0) {
                break;
            }
            // The product of two Gaussians: the inverses of the variances add.
            let own = (1.0 / spread - 0.5 / variance).max(1.0 / (0.5 * MOST * MOST));
            let moved = mean * (own + 0.5 / variance) / own;
            middle = (middle + moved).clamp(0.0, 1.0);
            variance = (1.0 / own).clamp(0.4 * LEAST * LEAST, 0.5 * MOST * MOST);
        }
        Self { middle, deviation: (2.0 * variance).root() }
    }
}
