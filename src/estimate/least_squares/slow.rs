//! Slow terms, which leak into a tone's bins: a drift, and hum of less than two cycles in the
//! record.
//!
//! With `t = pi k / N`, a straight line over the record has the bins `j exp(j t) / sin t`, and a
//! parabola `exp(j t) cos t / sin^2 t`. Any other slow term, far from its own bins, has nearly `j
//! exp(j t) / sin^3 t`. So three real numbers are fitted to the residual of a tone in its bins.

use crate::math::scalar::Scalar;
use crate::math::series::circle;
use num_complex::Complex;

/// The number of fitted terms.
pub(super) const TERMS: u32 = 3;

/// The bins between which slow terms matter. Above them slow terms are negligible; below them they
/// cannot be told from a tone.
pub const HIGHEST: i32 = 48;
pub const LOWEST: i32 = 3;

/// Bins below this one may hold a hum's own line.
pub(super) const FIRST: i32 = 4;

/// The three terms: line, parabola, and the rest.
pub(super) type Terms<T> = [T; TERMS as usize];

/// The terms' values in a bin: `turn` times `j line`, `parabola` and `j rest`.
pub(super) struct Bin<T> {
    turn: Complex<T>,
    line: T,
    parabola: T,
    rest: T,
}

impl<T: Scalar> Bin<T> {
    /// Bin `k` of a record of `n` samples. The scale makes all values about 1 at bin 8.
    pub fn new(k: i32, n: i32) -> Self {
        let turn = circle::<T>(k, n.saturating_mul(2));
        let near = T::of(8.0 * core::f64::consts::PI) / (T::of_i32(n) * turn.im);
        let square = near * near;
        Self { turn, line: near, parabola: square * turn.re, rest: square * near }
    }

    /// The terms' sum in this bin.
    pub fn value(&self, &[line, parabola, rest]: &Terms<T>) -> Complex<T> {
        self.turn * Complex::new(parabola * self.parabola, line * self.line + rest * self.rest)
    }
}

/// The sums of the normal equations, which fall into two parts.
pub(super) struct Sums<T> {
    pp: T,
    py: T,
    ll: T,
    lr: T,
    rr: T,
    ly: T,
    ry: T,
}

impl<T: Scalar> Sums<T> {
    pub fn new() -> Self {
        let zero = T::zero();
        Self { pp: zero, py: zero, ll: zero, lr: zero, rr: zero, ly: zero, ry: zero }
    }

    pub fn add(&mut self, bin: Bin<T>, left: Complex<T>) {
        let y = left * bin.turn.conj();
        self.pp = self.pp + bin.parabola * bin.parabola;
        self.py = self.py + bin.parabola * y.re;
        self.ll = self.ll + bin.line * bin.line;
        self.lr = self.lr + bin.line * bin.rest;
        self.rr = self.rr + bin.rest * bin.rest;
        self.ly = self.ly + bin.line * y.im;
        self.ry = self.ry + bin.rest * y.im;
    }

    /// The terms.
    pub fn solve(&self) -> Terms<T> {
        let Self { pp, py, ll, lr, rr, ly, ry } = *self;
        let inverse = T::one() / (ll * rr - lr * lr);
        [(rr * ly - lr * ry) * inverse, py / pp, (ll * ry - lr * ly) * inverse]
    }
}
