//! The evidence of the energy that a fit leaves about the noise.
//!
//! Either the noise at the tone is the ring's, which the ring determines with a few dozen degrees of freedom, or it is louder, by a factor
//! of which only a wide range is known. Each has a likelihood once its unknown power is integrated out; the two are mixed.

use super::constants::{LOUDER, LOUDER_RANGE};
use crate::math::scalar::Scalar as _;

/// The probability of an energy with `free` degrees of freedom, beside a ring with `ring` degrees of freedom.
#[derive(Clone, Copy, Debug)]
pub struct Leftover {
    /// The energy over half the ring's power of a bin: noise alone leaves `free`.
    energy: f32,
    free: f32,
    ring: f32,
    /// The terms of both likelihoods that do not depend on the energy.
    own_part: f32,
    ring_part: f32,
    /// The logarithm of the likelihood of the energy itself.
    log: f32,
}

impl Leftover {
    /// The evidence of this energy.
    pub fn new(energy: f32, free: f32, ring: f32) -> Self {
        let (energy, free) = (energy.max(1e-9), free.max(1.0));
        let beta = log_gamma(0.5 * ring) + log_gamma(0.5 * free) - log_gamma(0.5 * (ring + free));
        let own_part = (LOUDER / LOUDER_RANGE).log_e() - 0.5 * ring * ring.log_e() + beta;
        let ring_part = (1.0 - LOUDER).log_e();
        let mut leftover = Self { energy, free, ring, own_part, ring_part, log: 0.0 };
        leftover.log = leftover.less(0.0).0;
        leftover
    }

    /// The energy.
    pub fn energy(&self) -> f32 {
        self.energy
    }

    /// The energy's degrees of freedom.
    pub fn free(&self) -> f32 {
        self.free
    }

    /// The logarithm by which the noise is more probable if this energy is explained, and the noise's power over the ring's then.
    pub fn less(&self, explained: f32) -> (f32, f32) {
        let Self { energy, free, ring, own_part, ring_part, log } = *self;
        let left = (energy - explained).max(1e-6 * energy);
        let both = 0.5 * (ring + free);
        let by_ring = ring_part - both * (ring + left).log_e();
        let scale = (ring + left) / (ring + free);
        if left <= free {
            return (by_ring - log, scale);
        }
        let own = own_part - 0.5 * free * left.log_e();
        let ahead = own - by_ring;
        let louder = 1.0 / (1.0 + exponential(-ahead));
        // The sum of both, relative to the larger one.
        let sum = if ahead > 0.0 { own - louder.log_e() } else { by_ring - (1.0 - louder).log_e() };
        (sum - log, scale + louder * (left / free - scale))
    }
}

/// The logarithm of the gamma function, by Stirling's series two steps up.
fn log_gamma(x: f32) -> f32 {
    let y = x + 2.0;
    let over = 1.0 / y;
    let series = over * (1.0 / 12.0 - over * over * (1.0 / 360.0));
    (y - 0.5) * y.log_e() - y + 0.918_938_5 + series - (x * (x + 1.0)).log_e()
}

/// `exp(x)`, held to the range of single precision.
pub fn exponential(x: f32) -> f32 {
    libm::expf(x.clamp(-80.0, 80.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gammas() {
        for x in [0.5, 1.0, 1.5, 3.0, 10.0, 31.5, 66.5] {
            assert!((log_gamma(x) - libm::lgammaf(x)).abs() < 3e-5 * x.max(1.0), "{x}");
        }
    }

    /// In noise as loud as the ring's the scale is near 1, and in noise a hundred times as loud near 100.
    #[test]
    fn the_noise_is_the_rings_or_its_own() {
        let quiet = Leftover::new(63.0, 63.0, 52.0);
        assert_eq!(quiet.less(0.0), (0.0, 1.0));
        let (_, scale) = Leftover::new(6300.0, 63.0, 52.0).less(0.0);
        assert!((scale - 100.0).abs() < 1e-2, "{scale}");
    }
}
