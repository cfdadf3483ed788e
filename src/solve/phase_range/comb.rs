//! The turns that a phase allows, evenly apart, and the probability of each given a range by frequency.

use crate::math::fixed_point::in_steps;
use crate::math::scalar::Scalar as _;
use fixed::types::I32F32;

/// From these odds on a turn is sure: at most one in ten thousand of such answers is another turn.
pub const SURE: f32 = 1e4;

/// Degrees of freedom of a sigma: a ring of eight stretches has 50, short records fewer.
pub const DOF: f32 = 40.0;

/// Candidates are listed within this many standard deviations: beyond lie 6 of 100,000.
const LISTED: f32 = 4.5;

/// The integral of [`weight`], which is `sqrt(2 pi)` for many degrees of freedom.
const AREA: f32 = 2.506_628 * (1.0 + 0.25 / DOF);

/// The most turns on one side that are listed.
const MOST: f32 = 32_767.0;

/// A range that agrees with a phase.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CandidateRange {
    /// Range, metres.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub range: I32F32,
    /// The probability of this range, 0 to 1.
    pub odds: f32,
}

/// Evenly spaced candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Comb {
    /// The candidate nearest to the range by frequency.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    nearest: I32F32,
    /// Its distance beyond the range by frequency, metres.
    beyond: f32,
    /// From one candidate to the next, metres.
    pub spacing: f32,
    /// One standard deviation of the range by frequency, metres, and the sum of all weights.
    sigma: f32,
    total: f32,
    /// The number of candidates.
    listed: i32,
}

/// Student's density over its height, at this many standard deviations.
fn weight(deviations: f32) -> f32 {
    let square = deviations * deviations;
    libm::expf(-0.5 * (DOF + 1.0) * (1.0 + square / DOF).log_e())
}

impl Comb {
    /// The comb with one tooth at `nearest`, `beyond` the range by frequency, whose standard deviation is `sigma`; and the odds of this tooth against
    /// all others. A sigma that is not finite and positive leaves no candidate.
    pub fn new(nearest: I32F32, beyond: f32, spacing: f32, sigma: f32) -> (Self, f32) {
        if !(sigma > 0.0 && sigma.is_finite() && spacing > 0.0 && spacing.is_finite()) {
            return (Self::default(), 0.0);
        }
        let own = weight(beyond / sigma);
        let mut others = 0.0;
        if sigma < 1.5 * spacing {
            for turn in 1..=12 {
                let away = turn as f32 * spacing;
                others += weight((beyond + away) / sigma) + weight((beyond - away) / sigma);
            }
        } else {
            // By Poisson's sum the sum is the integral to 1e-15.
            others = (AREA * sigma / spacing - own).max(own);
        }
        let turns = (LISTED * sigma / spacing + 1.0).min(MOST) as i32;
        let odds = own / others.max(f32::MIN_POSITIVE);
        let listed = 2 * turns + 1;
        (Self { nearest, beyond, spacing, sigma, total: own + others, listed }, odds)
    }

    /// The candidates, the most probable first.
    pub fn candidates(&self) -> impl Iterator<Item = CandidateRange> + use<> {
        let &Self { nearest, beyond, spacing, sigma, total, listed } = self;
        // Towards the range by frequency first.
        let side = if beyond > 0.0 { -1 } else { 1 };
        (0..listed).map(move |place| {
            let turn = if place & 1 == 1 { side * (place + 1) / 2 } else { -side * place / 2 };
            let away = turn as f32 * spacing;
            CandidateRange {
                range: nearest.saturating_add(in_steps(away)),
                odds: weight((beyond + away) / sigma) / total,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Probabilities sum to 1, fall, and give the odds of the first.
    #[test]
    fn candidates_are_a_distribution() {
        for sigma in [0.05f32, 0.2, 0.7, 1.4, 1.6, 5.0, 40.0] {
            for beyond in [-0.5f32, -0.2, 0.0, 0.3, 0.49] {
                let (comb, odds) = Comb::new(I32F32::from_num(7.0 + beyond), beyond, 1.0, sigma);
                let all: Vec<CandidateRange> = comb.candidates().collect();
                let sum: f32 = all.iter().map(|candidate| candidate.odds).sum();
                assert!((sum - 1.0).abs() < 2e-4, "{sigma} {beyond}: {sum}");
                assert!(all.is_sorted_by(|a, b| a.odds >= b.odds), "{sigma} {beyond}");
                let first = all[0].odds;
                assert!(odds > 1e3 || (odds / (first / (1.0 - first)) - 1.0).abs() < 2e-3);
                for CandidateRange { range, .. } in all {
                    let turns = range.to_num::<f64>() - 7.0 - f64::from(beyond);
                    assert!((turns - turns.round()).abs() < 1e-5);
                }
            }
        }
        for sigma in [0.0, f32::NAN, f32::INFINITY] {
            let (comb, odds) = Comb::new(I32F32::ZERO, 0.1, 1.0, sigma);
            assert_eq!((comb.candidates().count(), odds), (0, 0.0));
        }
    }
}
