//! The causes that show in the bins themselves: slow terms, leakage, and lines farther off.
//!
//! A cause is a set of columns, each a shape of bins with one unknown size of normal prior variance t. With G the products of the columns
//! less the part that the fit can take, and a their products with the residual, the cause explains the energy `a' (G + 1/t)^-1 a`, and its
//! flexibility costs `ln det(1 + t G) / 2` in the logarithm of its probability. The sizes t are a factor of 16 apart, and all equally
//! probable.

use super::belief::{Belief, size, sizes};
use super::causes::{Best, Ground, Place};
use super::chance;
use super::constants::{NEAR, PEAK, PEAKS, WIDTH};
use super::factor::{Factor, Rows, product};
use super::joint::{COLUMNS, Joint, Solution};
use super::line::Bins;
use super::shape::{Shape, dot};
use super::window::Window;
use super::{leak, slow};
use crate::math::scalar::Scalar as _;
use num_complex::Complex;

/// Further columns, less the part that the fit takes of them.
struct Further<const K: usize> {
    gram: Rows<K>,
    along: [f32; K],
    pull: [f32; K],
}

impl<const K: usize> Further<K> {
    fn new(solution: &Solution, columns: &[Shape; K]) -> Self {
        let mut beside = Self { gram: [[0.0; K]; K], along: [0.0; K], pull: [0.0; K] };
        let mut taken = [[0.0; COLUMNS]; K];
        let sums = beside.along.iter_mut().zip(&mut beside.pull).zip(&mut taken);
        for (((along, pull), taken), column) in sums.zip(columns) {
            *along = dot(column, &solution.left);
            (*taken, *pull) = solution.taken(column);
            *pull = -*pull;
        }
        for (a, (row, (column, mine))) in
            beside.gram.iter_mut().zip(columns.iter().zip(&taken)).enumerate()
        {
            let others = columns.iter().zip(&taken).take(a + 1);
            for (cell, (other, theirs)) in row.iter_mut().zip(others) {
                *cell = dot(column, other) - product(mine, theirs);
            }
        }
        beside
    }

    /// The belief at one size, and the columns' most probable values.
    fn sized(&self, ground: &Ground, t: f32) -> (Belief, [f32; K]) {
        let (mut gram, over) = (self.gram, 1.0 / t);
        for (i, row) in gram.iter_mut().enumerate() {
            if let Some(own) = row.get_mut(i) {
                *own = own.max(0.0) + over;
            }
        }
        let factor = Factor::from_rows(&gram, K);
        let (seen, pull) = (factor.forward(&self.along), factor.forward(&self.pull));
        let cost = 0.5 * (factor.log_determinant() + K as f32 * t.log_e());
        let (offset, variance) = (product(&pull, &seen), product(&pull, &pull));
        let belief = ground.belief(product(&seen, &seen), cost, offset, variance);
        (belief, factor.backward(&seen))
    }

    fn weigh(&self, ground: &Ground, most: f32) -> (Belief, Best, [f32; K]) {
        let (count, log) = sizes(most);
        let (mut all, mut best, mut value) = (Belief::NEVER, Best::NONE, [0.0; K]);
        for number in 0..count {
            let t = size(number);
            let (belief, values) = self.sized(ground, t);
            let belief = belief.times(-log);
            if belief.log > best.log {
                (best, value) = (Best { log: belief.log, variance: t }, values);
            }
            all = all.or(belief);
        }
        (all, best, value)
    }
}

/// The belief in slow terms, of any size up to ten times the tone.
#[inline(never)]
pub fn slow(ground: &Ground, window: &Window, solution: &Solution) -> Belief {
    let beside = Further::new(solution, &slow::columns(window));
    beside.weigh(ground, 100.0 * ground.strength).0
}

/// The belief in leakage, of lines as strong as the tone or weaker.
#[inline(never)]
pub fn leak(ground: &Ground, window: &Window, solution: &Solution) -> Belief {
    let beside = Further::new(solution, &leak::columns(window));
    beside.weigh(ground, ground.strength).0
}

/// Two lines at equal distances below and above the tone.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Distance of the lines from the tone, bins.
    pub distance: f32,
    /// The belief in the pair.
    pub belief: Belief,
    /// Real and imaginary part of the lower and of the upper line, at the most probable size.
    pub values: [f32; 4],
}

impl Pair {
    /// No pair.
    pub const NONE: Self =
        Self { distance: f32::INFINITY, belief: Belief::NEVER, values: [0.0; 4] };
}

/// The belief in a pair of lines at a distance; `prior` is the logarithm of the distance's prior.
#[inline(never)]
pub fn sidebands(
    ground: &Ground,
    window: &Window,
    joint: &Joint,
    solution: &Solution,
    distance: f32,
    prior: f32,
) -> Pair {
    let offsets = [joint.tone.offset - distance, joint.tone.offset + distance];
    if !offsets.iter().all(|offset| window.has(*offset)) {
        return Pair::NONE;
    }
    let [[re, im, _], [other, turned, _]] =
        offsets.map(|offset| Bins::at(window, offset).columns(Complex::new(0.0, 0.0)));
    let beside = Further::new(solution, &[re, im, other, turned]);
    let (belief, _, values) = beside.weigh(ground, 2.0 * ground.strength);
    Pair { distance, belief: belief.times(prior), values }
}

/// Lines beyond the close ones, a quarter of a bin on each side of the strongest peaks of the residual.
#[inline(never)]
pub fn lines(
    ground: &Ground,
    window: &Window,
    joint: &Joint,
    solution: &Solution,
    prior: impl Fn(f32) -> f32,
) -> [[Place; 2]; PEAKS] {
    let mut powers = [0.0; WIDTH];
    for ((power, left), i) in powers.iter_mut().zip(&solution.left).zip(Window::places()) {
        *power = if i.abs() >= 2 { left.norm_sqr() } else { 0.0 };
    }
    let limit = 2.0 * chance::ratio(PEAK, 2.0, ground.leftover.free());
    let mut peaks = [(0.0, 0); PEAKS];
    for (place, i) in Window::places().enumerate() {
        let at = |place: usize| powers.get(place).copied().unwrap_or(0.0);
        let power = at(place);
        if power > limit && power >= at(place.wrapping_sub(1)) && power >= at(place + 1) {
            let mut this = (power, i);
            for peak in &mut peaks {
                if this.0 > peak.0 {
                    core::mem::swap(peak, &mut this);
                }
            }
        }
    }
    peaks.map(|(power, i)| {
        [-0.25, 0.25].map(|aside| {
            let offset = i as f32 + aside;
            let distance = offset - joint.tone.offset;
            if power == 0.0 || distance.abs() <= NEAR || !window.has(offset) {
                return Place::NONE;
            }
            let [real, imaginary, _] = Bins::at(window, offset).columns(Complex::new(0.0, 0.0));
            let beside = Further::new(solution, &[real, imaginary]);
            let (belief, best, value) = beside.weigh(ground, 2.0 * ground.strength);
            let prior = prior(distance);
            let best = Best { log: best.log + prior, ..best };
            Place { distance, belief: belief.times(prior), best, value }
        })
    })
}
