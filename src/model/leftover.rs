//! The evidence of the energy that a fit leaves about the noise.
//!
//! Either the noise at the tone is the ring's, which the ring determines with a few dozen degrees of freedom, or it is louder, by a factor
//! that is known only to lie in a wide range. In both cases the unknown power is integrated out of the likelihood; the result is a mixture of
//! the two.

use super::constants::{LOUDER, LOUDER_RANGE};
use super::logarithm::{exp, ln};
use crate::math::scalar::larger;

/// The probability of an energy with `free` degrees of freedom, beside a ring with `ring` degrees of freedom.
#[derive(Clone, Copy, Debug)]
pub struct Leftover {
    /// The energy over half the ring's power of a bin: noise alone leaves `free`.
    energy: f32,
    free: f32,
    ring: f32,
    /// The terms of a louder noise's likelihood that do not depend on the energy, over those of the ring's noise.
    own: f32,
    /// The logarithm of the likelihood of the energy itself.
    log: f32,
}

impl Leftover {
    /// The evidence of this energy.
    pub fn new(energy: f32, free: f32, ring: f32) -> Self {
        let (energy, free) = (larger(energy, 1e-9), larger(free, 1.0));
        let beta = log_gamma(0.5 * ring) + log_gamma(0.5 * free) - log_gamma(0.5 * (ring + free));
        let prior = ln(LOUDER / LOUDER_RANGE / (1.0 - LOUDER));
        let own = prior - 0.5 * ring * ln(ring) + beta;
        let mut leftover = Self { energy, free, ring, own, log: 0.0 };
        leftover.log = leftover.less(0.0).0;
        leftover
    }

    /// The noise's power over the ring's if nothing is explained.
    pub fn scale(&self) -> f32 {
        self.less(0.0).1
    }

    /// How much the logarithm of the likelihood gains if this energy is explained, and the noise's power over the ring's in that case.
    pub fn less(&self, explained: f32) -> (f32, f32) {
        let Self { energy, free, ring, own, log } = *self;
        let left = larger(energy - explained, 1e-6 * energy);
        let by_ring = -0.5 * (ring + free) * ln(ring + left);
        let scale = (ring + left) / (ring + free);
        if left <= free {
            return (by_ring - log, scale);
        }
        let own = own - 0.5 * free * ln(left);
        let ahead = own - by_ring;
        let louder = 1.0 / (1.0 + exp(-ahead));
        // The sum of both, relative to the larger one.
        let sum = if ahead > 0.0 { own - ln(louder) } else { by_ring - ln(1.0 - louder) };
        (sum - log, scale + louder * (left / free - scale))
    }
}

/// The logarithm of the gamma function, by Stirling's series two steps up.
fn log_gamma(x: f32) -> f32 {
    let y = x + 2.0;
    let over = 1.0 / y;
    let series = over * (1.0 / 12.0 - over * over * (1.0 / 360.0));
    (y - 0.5) * ln(y) - y + 0.918_938_5 + series - ln(x * (x + 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gammas() {
        for x in [0.5, 1.0, 1.5, 3.0, 10.0, 31.5, 66.5] {
            assert!((log_gamma(x) - libm::lgammaf(x)).abs() < 2e-4 * x.max(1.0), "{x}");
        }
    }

    /// In noise as loud as the ring's the scale is near 1, and in noise a hundred times as loud near 100.
    #[test]
    fn the_noise_is_the_rings_or_its_own() {
        assert_eq!(Leftover::new(63.0, 63.0, 52.0).less(0.0), (0.0, 1.0));
        let scale = Leftover::new(6300.0, 63.0, 52.0).scale();
        assert!((scale - 100.0).abs() < 1e-2, "{scale}");
    }
}
