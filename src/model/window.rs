//! The bins around a peak, with the phase's origin in the middle of the record: amplitude, phase and frequency of a tone are
//! uncorrelated there.

use super::constants::{REACH, WIDTH};
use super::far::Reach;
use super::shape::{NOTHING, Shape};
use crate::math::series::circle;
use num_complex::Complex;

/// The bins within [`REACH`] of a peak.
#[derive(Clone, Debug)]
pub struct Window {
    /// Samples of the record.
    pub n: usize,
    /// Whether the record consists of I/Q pairs.
    pub iq: bool,
    /// The peak's bin; negative at negative frequencies.
    pub peak: i32,
    /// The bins, turned to the record's middle, in codes; unused bins are 0.
    pub bins: Shape,
    /// 1 for each bin that is used, 0 for a bin at or beyond an end of a real spectrum, and for the offset's bin of I/Q.
    pub used: [f32; WIDTH],
    /// Cosine and sine of `pi (2 peak + i) / N` of a real record's bins, for the mirror image.
    pub(super) across: Shape,
}

impl Window {
    /// A window of any bins: `bin(i)` returns the bin i bins from the peak, in codes, with i from -16 to 16. It is called for used bins
    /// only.
    pub fn new(n: usize, iq: bool, peak: i32, bin: impl Fn(i32) -> Complex<f32>) -> Self {
        let length = (n as i32).max(2);
        let half = length / 2;
        let peak = if iq && peak > half { peak - length } else { peak };
        let (mut bins, mut used, mut across) = (NOTHING, [0.0; WIDTH], NOTHING);
        let places = bins.iter_mut().zip(&mut used).zip(&mut across);
        for (i, ((place, used), across)) in Self::places().zip(places) {
            let k = peak.wrapping_add(i);
            let inside = if iq {
                k.checked_rem_euclid(length).unwrap_or(0) != 0 || peak == 0
            } else {
                0 < k && k < half
            };
            if inside {
                *used = 1.0;
                let turned = bin(i) * circle::<f32>(k, 2 * length).conj();
                *place = if k & 1 == 0 { turned } else { -turned };
            }
            if !iq {
                *across = circle::<f32>(k.wrapping_add(peak), 2 * length);
            }
        }
        Self { n, iq, peak, bins, used, across }
    }

    /// The number of real values in the used bins.
    pub fn numbers(&self) -> f32 {
        2.0 * self.used.iter().sum::<f32>()
    }

    /// Bins from the peak of a real record to the nearer end of its spectrum; a large number for I/Q.
    pub fn from_end(&self) -> i32 {
        if self.iq { i32::MAX } else { self.peak.min(self.n as i32 / 2 - self.peak) }
    }

    /// Whether a line at `offset` bins from the peak is within the spectrum, and its mirror image away from it.
    pub fn has(&self, offset: f32) -> bool {
        let bins = self.peak as f32 + offset;
        self.iq || (0.5 < bins && bins < self.n as f32 * 0.5 - 0.5)
    }

    /// Where lines outside the window are tried, below and above the peak: halfway between bins, where they leak most; `None` if there is no
    /// spectrum outside.
    pub fn outside(&self) -> [Option<(f32, Reach)>; 2] {
        /// Bins beyond the window's last: the nearest place from which the leakage of all lines farther off has nearly one shape.
        const BEYOND: f32 = 4.5;
        /// Bins from 0 Hz: a drift leaks more than noise up to here.
        const SLOW: f32 = 3.0 * REACH as f32;
        /// A shorter record has no more bins than the window.
        const SHORTEST: usize = 128;
        if self.n < SHORTEST {
            return [None; 2];
        }
        let last = REACH as f32;
        let near = last + BEYOND;
        let to_zero = self.peak.abs() as f32;
        let seen = to_zero <= last + 1.0;
        // A drift of the mean, and slow hum, are lines at 0 Hz.
        let slow = match (seen, self.iq) {
            (true, true) => Some((to_zero, Reach::Slow)),
            (true, false) => None,
            _ if to_zero < SLOW => Some((to_zero - 0.5, Reach::Outside)),
            _ => Some((near, Reach::Outside)),
        };
        let to_end = if self.iq { f32::INFINITY } else { (self.n as i32 / 2 - self.peak) as f32 };
        let other = (to_end > near + 1.0).then_some((near, Reach::Outside));
        let [below, above] = if self.peak < 0 { [other, slow] } else { [slow, other] };
        [below.map(|(place, reach)| (-place, reach)), above]
    }

    /// The distances of the bins from the peak.
    pub fn places() -> impl Iterator<Item = i32> {
        -(REACH as i32)..=REACH as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A real line stands between 0 Hz and half the rate, half a bin away from both; an I/Q line anywhere.
    #[test]
    fn a_line_is_within_the_spectrum() {
        let window = |iq, peak| Window::new(64, iq, peak, |_| Complex::new(0.0, 0.0));
        for (peak, offset, inside) in
            [(30, 1.4, true), (30, 1.6, false), (2, -1.4, true), (2, -1.6, false)]
        {
            assert_eq!(window(false, peak).has(offset), inside, "{peak} {offset}");
            assert!(window(true, peak).has(offset));
        }
    }
}
