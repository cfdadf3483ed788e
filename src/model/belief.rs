//! The joint probability of hypotheses, and the frequency that they give.

use super::logarithm::{exp, ln};

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

    /// The belief in any of these hypotheses. Those with less than a thousandth of the best one's weight do not count.
    pub fn any(all: &[Self]) -> Self {
        const LOST: f32 = 7.0;
        let mut best = Self::NEVER;
        for belief in all {
            if belief.log > best.log {
                best = *belief;
            }
        }
        if best.log == f32::NEG_INFINITY {
            return best;
        }
        // Relative to the best: offsets are much larger than their deviations.
        let (mut sum, mut mean, mut square) = (0.0, 0.0, 0.0);
        for belief in all.iter().filter(|belief| belief.log > best.log - LOST) {
            let (weight, apart) = (exp(belief.log - best.log), belief.offset - best.offset);
            sum += weight;
            mean += weight * apart;
            square += weight * (belief.variance + apart * apart);
        }
        let over = 1.0 / sum;
        let mean = mean * over;
        Self {
            log: best.log + ln(sum),
            offset: best.offset + mean,
            variance: square * over - mean * mean,
        }
    }
}
