//! The fit beside slow terms: the leakage of a drift and of a hum, see [`slow`].

use super::super::{Fit, START_LIMIT, limit, slow};
use super::{Both, Problem, Step, each};
use crate::math::scalar::Scalar;
use crate::spectrum::bins::REACH;
use heapless::Vec;
use num_complex::Complex;

/// The slow terms in the bins of a fit.
struct Slow<T> {
    centre: slow::Values<T>,
    sides: Vec<slow::Values<T>, { 2 * REACH }>,
    /// The terms' products with the data.
    data: [T; slow::TERMS],
}

/// The slow terms' products with the model's basis and its derivative.
type Shares<T> = [[T; 4]; slow::TERMS];

/// The inner product of two bins as real vectors.
fn dot<T: Scalar>(a: Complex<T>, b: Complex<T>) -> T {
    a.re * b.re + a.im * b.im
}

/// Gauss-Newton steps of a fit beside slow terms.
pub(in super::super) const STEPS: u32 = 2;

/// The fit beside the leakage of a drift and of a hum of up to one and a half cycles, whose own bins lie below: see [`slow`].
pub(in super::super) fn fit_beside_slow<T: Scalar>(
    n: i32,
    peak: i32,
    centre: Complex<T>,
    beside: impl Iterator<Item = Both<T>>,
) -> Option<Fit<T>> {
    if !Problem::has_tone(n, peak, centre) {
        return None;
    }
    let mut problem = Problem::new(n, peak, centre);
    problem.read(beside);
    let first = slow::FIRST.min(peak - 2);
    problem.sides.retain(|side| peak + side.i >= first);
    problem.room[0] = peak - first;
    let slow = problem.slow_terms(n);
    let (low, high) = problem.limits();
    let mut d = limit(problem.start(), START_LIMIT).max(low).min(high);
    let (mut p, mut speed) = problem.p_of(d);
    let (mut step, mut shares) = problem.step_beside(p, &slow);
    for _ in 0..STEPS {
        d = (d + step.forward(speed)).max(low).min(high);
        (p, speed) = problem.p_of(d);
        (step, shares) = problem.step_beside(p, &slow);
    }
    step.information = step.information * speed * speed;
    problem.take_slow_terms(step.line, &shares, &slow);
    let mut fit = problem.finish(d, p, &step);
    fit.dof = fit.dof.saturating_sub(slow::TERMS as u32).max(1);
    Some(fit)
}

impl<T: Scalar> Problem<T> {
    /// The slow terms in these bins, and their products with the data.
    fn slow_terms(&self, n: i32) -> Slow<T> {
        let mut slow = Slow {
            centre: slow::values(self.peak, n),
            sides: Vec::new(),
            data: [T::zero(); slow::TERMS],
        };
        for side in &self.sides {
            // The vector has room for all sides.
            let _ = slow.sides.push(slow::values(self.peak + side.i, n));
        }
        let basis = slow::Basis::from_values(core::iter::once(&slow.centre).chain(&slow.sides));
        slow.centre = basis.turned(&slow.centre);
        slow.data = slow.centre.map(|q| dot(q, self.centre));
        for (terms, side) in slow.sides.iter_mut().zip(&self.sides) {
            *terms = basis.turned(terms);
            let data = slow.data.iter_mut().zip(terms);
            data.for_each(|(sum, &mut q)| *sum = *sum + dot(q, side.x));
        }
        slow
    }

    /// The slow terms' products with the model's basis and with its derivative at p: with `(1, 0) h`,
    /// `(-e u, s) h`, `(1, 0) h'` and `(-e u, s) h'`.
    fn shares(&self, p: T, slow: &Slow<T>) -> Shares<T> {
        // The peak itself: h = 1, h' = 0.
        let mut shares = slow.centre.map(|q| [q.re, q.im, T::zero(), T::zero()]);
        let (ep, mut all) = (self.e * p, slow.sides.iter());
        each(&self.sides, ep, |side, r| {
            let Some(terms) = all.next() else { return };
            let h = ep * r;
            let slope = (T::one() - h) * r * self.e;
            for (share, q) in shares.iter_mut().zip(terms) {
                let v = side.s * q.im - side.w * q.re;
                let parts = [h * q.re, h * v, slope * q.re, slope * v];
                share.iter_mut().zip(parts).for_each(|(sum, part)| *sum = *sum + part);
            }
        });
        shares
    }

    /// [`Problem::step`] with slow terms as further linear unknowns: the part along the terms is taken out of every inner product.
    #[inline(never)]
    fn step_beside(&self, p: T, slow: &Slow<T>) -> (Step<T>, Shares<T>) {
        let shares = self.shares(p, slow);
        let mut products = self.products(p);
        for (&[f1, f2, g1, g2], data) in shares.iter().zip(slow.data) {
            products.less(f1, f2, g1, g2, data);
        }
        (products.step(), shares)
    }

    /// Subtracts the slow terms from the bins, given the line and the terms' shares.
    fn take_slow_terms(&mut self, line: Complex<T>, shares: &Shares<T>, slow: &Slow<T>) {
        let mut heights = slow.data;
        for (height, &[f1, f2, ..]) in heights.iter_mut().zip(shares) {
            *height = *height - line.re * f1 - line.im * f2;
        }
        let sum = |terms: &slow::Values<T>| {
            let zero = Complex::new(T::zero(), T::zero());
            terms.iter().zip(heights).fold(zero, |sum, (&q, height)| sum + q * height)
        };
        self.centre = self.centre - sum(&slow.centre);
        for (side, terms) in self.sides.iter_mut().zip(&slow.sides) {
            side.x = side.x - sum(terms);
            side.v = side.s * side.x.im - side.w * side.x.re;
        }
    }
}
