//! How probable hypotheses are together, and where they have the frequency.

use super::leftover::exponential;
use crate::math::scalar::Scalar as _;

/// The weight of hypotheses, as a logarithm, with mean and variance of the offset in bins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belief {
    /// Of the weight.
    pub log: f32,
    /// The mean, bins.
    pub offset: f32,
    /// The variance, bins squared.
    pub variance: f32,
}

impl Belief {
    /// What is impossible.
    pub const NEVER: Self = Self { log: f32::NEG_INFINITY, offset: 0.0, variance: 0.0 };

    /// With another prior.
    pub fn times(self, log: f32) -> Self {
        Self { log: self.log + log, ..self }
    }

    /// Either of two.
    pub fn or(self, other: Self) -> Self {
        /// A share below 1e-9 changes nothing.
        const NOTHING: f32 = -20.0;
        let (more, less) = if self.log >= other.log { (self, other) } else { (other, self) };
        let behind = less.log - more.log;
        // What is impossible, or no number, is the other.
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

/// How many sizes of a cause there are, each 16 times the variance of the one below, from that of the noise to `most`; and the
/// logarithm of that number.
pub fn sizes(most: f32) -> (i32, f32) {
    let power = (most.clamp(1.0, 1e12).to_bits() >> 23) as i32 - 127;
    let count = 1 + power / 4;
    (count, (count as f32).log_e())
}

/// The variance of the size of this number: `16^number`.
pub fn size(number: i32) -> f32 {
    f32::two_to(4 * number)
}
