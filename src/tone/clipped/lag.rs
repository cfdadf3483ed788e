//! The noise of a clipped record, from samples at which its tone has the same phase.
//!
//! The harmonics that clipping makes lie all over the spectrum. In a record with a fifth of its
//! samples at one rail the bins show a noise 35 dB too strong. But harmonics repeat when the tone
//! does. Take a lag L after which the tone's phase returns, except for a small rest. Then
//!
//! ```text
//! x[n - L] - 2 cos(2 pi rest) x[n] + x[n + L]        rest = f L less whole turns
//! ```
//!
//! contains nothing of the tone and hardly anything of its harmonics, even with soft limiting. White noise of power P has the power
//! `P (2 + 4 cos^2(2 pi rest))` there. Terms with a sample at a rail are left out.

use super::super::noise::ROUNDING;
use super::part::Part;
use crate::acquire::codes::{Between, Codes};
use crate::frequency::Frequency;
use crate::tone::fit::fixed::square;
use heapless::Vec;

/// The longest lag, samples. Among 256 lags at least one has a rest below a 256th of a turn (Dirichlet).
const LONGEST: usize = 256;

/// Terms come in groups of successive samples. A tone near a simple fraction of the rate has only
/// a few phases, and a group meets all of them.
const GROUPS: usize = 16;
const GROUP: usize = 8;

/// The fewest terms of an estimate.
const FEWEST: i32 = 8;

/// A lag after which a tone returns to its phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// The lag in samples, at least 1 and at most a third of the record.
    pub samples: usize,
    /// `2 - 2 cos(2 pi rest)`.
    bend: f32,
}

impl Lag {
    /// The lag with the least rest in a record of `samples` samples. It is the last denominator of the frequency's continued fraction that
    /// is short enough. Cost: a subtraction for each whole number in the fraction, some twenty, at most as many as the longest lag.
    pub fn from_frequency(frequency: Frequency, samples: usize) -> Self {
        let longest = (samples / 3).min(LONGEST) as u32;
        // Euclid's algorithm for a turn and a step. `least` is the rest after `best` steps.
        let step = frequency.0.to_bits().unsigned_abs();
        let (mut last, mut least) = (step.wrapping_neg(), step);
        let (mut before, mut best) = (1u32, 1u32);
        loop {
            // Quotients are small, and many cores have no division.
            let (mut rest, mut next) = (last, before);
            while rest >= least && next <= longest {
                (rest, next) = (rest.wrapping_sub(least), next.wrapping_add(best));
            }
            if next > longest {
                break;
            }
            (last, least, before, best) = (least, rest, best, next);
        }
        let angle = least as f32 * (core::f32::consts::TAU / 4_294_967_296.0);
        // 4 sin^2 of half the angle. It is below a sixtieth for records of 512 samples and more.
        Self { samples: best as usize, bend: angle * angle }
    }

    /// The noise power of a part, in squared codes, not below the rounding of the converter;
    /// `None` if the rails leave too few terms. Cost: about 25 instructions a term, at most 128
    /// terms.
    ///
    /// The result is too low by some tenths of a dB at most, because noise near a rail is cut off.
    pub(super) fn noise(self, part: Part, codes: Codes) -> Option<f32> {
        let inside = Between::new(codes.rails());
        let Terms { sum, power, count } = self.terms(part, inside);
        if count < FEWEST {
            return None;
        }
        // Without the share of a constant offset.
        let power = power.wrapping_mul(count as u64).wrapping_sub(square(sum) as u64) as f32;
        let terms = (256 * count * (count - 1)) as f32;
        let middle = 2.0 - self.bend;
        Some((power / (terms * (2.0 + middle * middle))).max(ROUNDING as f32))
    }

    /// The sums over the terms whose samples are inside.
    #[inline(always)]
    fn terms(self, part: Part, inside: Between) -> Terms {
        let bend = (self.bend * (1u32 << 18) as f32) as i32;
        let apart = (part.length.saturating_sub(2 * self.samples) / GROUPS).max(GROUP);
        let mut terms = Terms { sum: 0, power: 0, count: 0 };
        let mut places = [const { Vec::<i16, GROUP>::new() }; 3];
        for n in (0..GROUPS).map(|group| group * apart) {
            let [first, second, third] = &mut places;
            let first = part.from(n, first);
            let second = part.from(n + self.samples, second);
            let third = part.from(n + 2 * self.samples, third);
            for ((&a, &b), &c) in first.iter().zip(second).zip(third).take(GROUP) {
                if inside.holds(a) && inside.holds(b) && inside.holds(c) {
                    let [a, b, c] = [a, b, c].map(i32::from);
                    // In sixteenths of a code; it fits in 22 bits.
                    let term = 16 * (a - 2 * b + c) + (b.wrapping_mul(bend) >> 14);
                    terms.sum = terms.sum.wrapping_add(term);
                    terms.power = terms.power.wrapping_add(square(term) as u64);
                    terms.count += 1;
                }
            }
        }
        terms
    }
}

/// Sums over the terms that count.
struct Terms {
    sum: i32,
    power: u64,
    count: i32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use fixed::types::I0F32;

    #[test]
    fn no_lag_leaves_less() {
        let mut step = 1u32;
        for samples in [64, 256, 4096] {
            for round in 0..2000u32 {
                step = step.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                // Fractions with small denominators, too.
                let denominator = 2 + u64::from(round % 40);
                let simple = ((u64::from(step) % denominator) << 32) / denominator;
                for bits in [step as i32, (step >> 20) as i32, simple as u32 as i32, i32::MIN] {
                    let found = Lag::from_frequency(Frequency(I0F32::from_bits(bits)), samples);
                    let rest = |lag: usize| bits.wrapping_mul(lag as i32).unsigned_abs();
                    let least = (1..=(samples / 3).min(LONGEST)).min_by_key(|&lag| rest(lag));
                    assert_eq!(Some(rest(found.samples)), least.map(rest), "{bits} {samples}");
                }
            }
        }
    }
}
