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
pub(super) const TERMS: usize = 3;

/// The bins between which slow terms matter. Above them slow terms are negligible; below them they
/// cannot be told from a tone.
pub const HIGHEST: i32 = 48;
pub const LOWEST: i32 = 3;

/// Bins below this one may hold a hum's own line.
pub(super) const FIRST: i32 = 4;

/// The values of the terms in a bin: `turn` times `j line`, `parabola` and `j rest`.
struct Bin<T> {
    turn: Complex<T>,
    line: T,
    parabola: T,
    rest: T,
}

impl<T: Scalar> Bin<T> {
    /// Bin `k` of a record of `n` samples. The scale makes all values about 1 at bin 8.
    fn new(k: i32, n: i32) -> Self {
        let turn = circle::<T>(k, n.saturating_mul(2));
        let near = T::of(8.0 * core::f64::consts::PI) / (T::of_i32(n) * turn.im);
        let square = near * near;
        Self { turn, line: near, parabola: square * turn.re, rest: square * near }
    }
}

/// The terms as vectors over some bins, of length 1 and orthogonal to one another.
pub(super) struct Basis<T> {
    n: i32,
    /// One over the lengths of line, parabola, and of the rest less its share of the line.
    line: T,
    parabola: T,
    rest: T,
    /// The share.
    share: T,
}

impl<T: Scalar> Basis<T> {
    /// Over these bins of a record of `n` samples, three or more.
    pub fn of(n: i32, bins: impl Iterator<Item = i32>) -> Self {
        let zero = T::zero();
        let [mut pp, mut ll, mut lr, mut rr] = [zero; 4];
        for Bin { line, parabola, rest, .. } in bins.map(|k| Bin::<T>::new(k, n)) {
            pp = pp + parabola * parabola;
            ll = ll + line * line;
            lr = lr + line * rest;
            rr = rr + rest * rest;
        }
        let share = lr / ll;
        let one = T::one();
        let left = (rr - share * lr).max(T::epsilon() * rr);
        Self { n, line: one / ll.root(), parabola: one / pp.root(), rest: one / left.root(), share }
    }

    /// The vectors' values in bin `k`.
    pub fn bin(&self, k: i32) -> [Complex<T>; TERMS] {
        let Bin { turn, line, parabola, rest }: Bin<T> = Bin::new(k, self.n);
        let across = Complex::new(-turn.im, turn.re);
        let rest = (rest - self.share * line) * self.rest;
        [turn * (parabola * self.parabola), across * (line * self.line), across * rest]
    }
}
