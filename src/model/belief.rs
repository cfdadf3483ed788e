//! The joint probability of hypotheses, and the frequency that they give.

use super::leftover::exponential;
use crate::math::scalar::Scalar as _;

/// The weight of hypotheses, as a logarithm, with mean and variance of the offset in bins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belief {
    /// The logarithm of the weight.
    pub log: f32,
    /// The mean, bins.
    pub offset: f32,
    /// The variance, bins squared.
    pub variance: f32,
}

impl Belief {
    /// The belief in an impossible hypothesis.
    pub const NEVER: Self = Self { log: f32::NEG_INFINITY, offset: 0.0, variance: 0.0 };

    /// The belief with another prior.
    pub fn times(self, log: f32) -> Self {
        Self { log: self.log + log, ..self }
    }

    /// The belief in either of two hypotheses.
    pub fn or(self, other: Self) -> Self {
        /// A share below 1e-9 changes nothing.
        const NOTHING: f32 = -20.0;
        let (more, less) = if self.log >= other.log { (self, other) } else { (other, self) };
        let behind = less.log - more.log;
        // If one is impossible, or NaN, the result is the other.
        if behind.is_nan() || behind <= NOTHING {
            return more;
        }
        let share = exponential(behind);
        let part = share / (1.0 + share);
        let apart = less.offset - more.offset;
        Self {
            log: more.log + (1.0 + share).log_e(),
            offset: more.offset + part * apart,
            variance: more.variance
                + part * (less.variance - more.variance)
                + part * (1.0 - part) * apart * apart,
        }
    }
}

/// The number of sizes of a cause, each 16 times the variance of the one below, from the noise's variance to `most`; and the logarithm of
/// this number.
pub fn sizes(most: f32) -> (i32, f32) {
    let power = (most.clamp(1.0, 1e12).to_bits() >> 23) as i32 - 127;
    let count = 1 + power / 4;
    (count, (count as f32).log_e())
}

/// The variance of the size with this number: `16^number`.
pub fn size(number: i32) -> f32 {
    f32::two_to(4 * number)
}
