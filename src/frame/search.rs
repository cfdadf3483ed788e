//! The search for the place of most evidence in the map.
//!
//! A beat that walks through cells within the frame is smeared: so the search goes through a few velocities, whose walks differ by a cell a
//! frame, and takes each chirp's bin where the velocity puts it.

use super::echo::Echo;
use super::map::Map;
use super::transform::{Factors, MOST};
use crate::math::scalar::{Scalar as _, nearest};
use heapless::{Deque, Vec};
use num_complex::Complex;

/// Columns on each side whose noise a column is compared with.
const BESIDE: usize = 8;

/// The most velocities that are tried.
const WALKS: i32 = 64;

/// Bins around a place that the search leaves out once a fit from there has led to a known echo.
pub(super) const HIDDEN: usize = 4;

/// `exp` of Euler's constant: the mean of exponential numbers over their geometric mean.
const GEOMETRIC: f32 = 1.781_072_4;

/// The strongest echo in the map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strongest {
    pub echo: Echo,
    /// The power of its cell over the noise of its neighbourhood.
    pub ratio: f32,
    /// The power of its cell.
    power: f32,
}

impl Strongest {
    /// Whether it has more evidence than another one.
    pub fn is_better(&self, other: &Self) -> bool {
        is_better([self.ratio, self.power], [other.ratio, other.power])
    }
}

/// Whether nothing walks: within half a cell.
fn is_still(first: f32, last: f32) -> bool {
    first.abs().max(last.abs()) < 0.5
}

/// From this ratio on the noise of a neighbourhood is the leakage of the place itself: the power decides.
const FAR: f32 = 200.0;

/// Whether the first of two `[ratio, power]` has more evidence.
fn is_better([ratio, power]: [f32; 2], [other_ratio, other_power]: [f32; 2]) -> bool {
    if ratio > FAR && other_ratio > FAR { power > other_power } else { ratio > other_ratio }
}

/// A column's strongest place, and the mean logarithm of its powers.
#[derive(Clone, Copy, Debug)]
struct Peak {
    bin: i32,
    half: bool,
    row: usize,
    power: f32,
    log: f32,
}

/// A sum of logarithms, as a product of mantissas and a sum of exponents: one logarithm for all.
struct Logarithms {
    /// From 1 up to 2.
    mantissa: f32,
    exponent: i32,
}

impl Logarithms {
    const NONE: Self = Self { mantissa: 1.0, exponent: 0 };

    /// Adds that of a number which is not subnormal.
    fn push(&mut self, x: f32) {
        const MANTISSA: u32 = (1 << (f32::MANTISSA_DIGITS - 1)) - 1;
        let bits = x.to_bits();
        self.exponent += (bits >> (f32::MANTISSA_DIGITS - 1)) as i32 - (f32::MAX_EXP - 1);
        self.mantissa *= f32::from_bits(bits & MANTISSA | 1.0f32.to_bits());
        if self.mantissa >= 2.0 {
            self.mantissa *= 0.5;
            self.exponent += 1;
        }
    }

    fn sum(&self) -> f32 {
        self.exponent as f32 * core::f32::consts::LN_2 + self.mantissa.log_e()
    }
}

/// The walks in bins a frame, from the first to the last in steps of one.
pub(super) struct Walks {
    pub first: f32,
    pub last: f32,
}

impl Map<'_> {
    /// The walks of the velocities that a target may have; those of the unambiguous ones where no velocities are bound.
    pub fn walks(&self) -> Walks {
        let plan = self.plan;
        let half = 0.5 * plan.alias_mps();
        let [low, high] = plan.bounds.velocity;
        let [low, high] = if plan.bounds.limit_velocity() { [low, high] } else { [-half, half] };
        let cells = plan.walk * plan.chirps as f32;
        let [a, b] = [low * cells, high * cells];
        Walks { first: a.min(b), last: a.max(b) }
    }

    /// The number of walks that are tried.
    pub fn steps(&self) -> i32 {
        let Walks { first, last } = self.walks();
        if is_still(first, last) { 1 } else { (libm::ceilf(last - first) as i32).clamp(1, WALKS) }
    }

    /// The place of most evidence by the walk of this number.
    #[inline(never)] // its room on the stack is not beside a fit's
    pub fn search(&self, step: i32, hidden: &Vec<(i32, i32), HIDDEN>) -> Option<Strongest> {
        let factors = Factors::new(2 * self.plan.chirps);
        let Walks { first, last } = self.walks();
        let share = (step as f32 + 0.5) / self.steps() as f32;
        let walk = if is_still(first, last) { 0.0 } else { first + (last - first) * share };
        self.search_walking(walk / self.plan.chirps as f32, &factors, hidden)
    }

    fn search_walking(
        &self,
        walk: f32,
        factors: &Factors,
        hidden: &Vec<(i32, i32), HIDDEN>,
    ) -> Option<Strongest> {
        let plan = self.plan;
        let (chirps, length) = (plan.chirps, 2 * plan.chirps);
        let mut before = [Complex::new(0.0, 0.0); MOST];
        let mut here = before;
        let mut peaks = Deque::<Peak, { 2 * BESIDE + 1 }>::new();
        let (mut best, mut best_ratio) = (None::<Peak>, 0.0);
        let mut judge = |peaks: &Deque<Peak, { 2 * BESIDE + 1 }>, at: usize| {
            let Some(peak) = peaks.iter().nth(at) else { return };
            let mean = peaks.iter().map(|peak| peak.log).sum::<f32>() / peaks.len().max(1) as f32;
            let ratio = peak.power / (GEOMETRIC * libm::expf(mean));
            let least = best.map_or(0.0, |best| best.power);
            if is_better([ratio, peak.power], [best_ratio, least]) {
                (best, best_ratio) = (Some(*peak), ratio);
            }
        };
        let mut looked = 0;
        for place in 0..plan.bins as i32 {
            let bin = plan.first + place;
            if let Some(column) = here.first_chunk_mut() {
                self.column(bin, walk, column);
            }
            here.iter_mut().skip(chirps).for_each(|point| *point = Complex::new(0.0, 0.0));
            factors.transform(&mut here);
            let mut peak = Peak { bin, half: false, row: 0, power: -1.0, log: 0.0 };
            let mut logarithms = Logarithms::NONE;
            for (at, (point, earlier)) in here.iter().zip(&before).take(length).enumerate() {
                let row = factors.frequency(at);
                let power = point.norm_sqr();
                if row & 1 == 0 {
                    logarithms.push(power.max(f32::MIN_POSITIVE));
                }
                // Half a bin below, where both bins hold 81 %.
                let both =
                    if place > 0 { (point + earlier).norm_sqr() * (0.5 / 0.81) } else { 0.0 };
                let (size, half) = if both > power { (both, true) } else { (power, false) };
                if size > peak.power && !is_hidden(hidden, bin, row, length) {
                    (peak.power, peak.row, peak.half) = (size, row, half);
                }
            }
            peak.log = logarithms.sum() / chirps as f32;
            core::mem::swap(&mut before, &mut here);
            if peaks.is_full() {
                peaks.pop_front();
            }
            // There is room.
            let _ = peaks.push_back(peak);
            // The column that has as many on both sides, or fewer below the first.
            if place as usize >= BESIDE {
                let at = peaks.len() - 1 - BESIDE.min(peaks.len() - 1);
                judge(&peaks, at);
                looked += 1;
            }
        }
        // The last columns have fewer above.
        let left = plan.bins.saturating_sub(looked).min(peaks.len());
        for at in peaks.len() - left..peaks.len() {
            judge(&peaks, at);
        }
        let Peak { bin, half, row, power, .. } = best?;
        let row = if row >= chirps { row as i32 - length as i32 } else { row as i32 };
        let mut echo = Echo {
            peak: if half { bin - 1 } else { bin },
            offset: if half { 0.5 } else { 0.0 },
            row: row >> 1,
            turn: if row & 1 == 0 { 0.0 } else { 0.5 },
            alias: 0,
            amplitude: Complex::new(0.0, 0.0),
            walk: 0.0,
            bend: 0.0,
            curve: 0.0,
        };
        // The allowed alias with this walk.
        let per_turn = plan.velocity.float * plan.walk;
        let [first, last] = plan.aliases(&echo);
        let walks = (per_turn * chirps as f32).abs() > 1e-3;
        let wanted = if walks { nearest(walk / per_turn - echo.turns(plan)) } else { 0.0 };
        echo.alias = (wanted.clamp(-1e6, 1e6) as i32).max(first).min(last);
        echo.move_on(plan);
        Some(Strongest { echo, ratio: best_ratio, power })
    }
}

fn is_hidden(hidden: &Vec<(i32, i32), HIDDEN>, bin: i32, row: usize, length: usize) -> bool {
    hidden.iter().any(|&(at, hidden_row)| {
        let apart = (row as i32 - hidden_row) & (length as i32 - 1);
        (bin - at).abs() <= 2 && apart.min(length as i32 - apart) <= 4
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_are_summed() {
        let mut random = 1u32;
        let mut logarithms = Logarithms::NONE;
        let mut sum = 0.0;
        for _ in 0..300 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let x = f32::from_bits((random >> 2).max(f32::MIN_POSITIVE.to_bits()));
            logarithms.push(x);
            sum += f64::from(x).ln();
            assert!((f64::from(logarithms.sum()) - sum).abs() < 1e-5 * sum.abs().max(1.0));
        }
    }
}
