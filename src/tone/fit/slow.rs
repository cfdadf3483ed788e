//! Slow terms, which leak into a tone's bins: a drift, and hum of less than two cycles in the
//! record.
//!
//! With `t = pi k / N`, a straight line over the record has the bins `j exp(j t) / sin t`, and a parabola `exp(j t) cos t / sin^2 t`. Any
//! other slow term, far from its own bins, has nearly `j exp(j t) / sin^3 t`. So three real numbers are fitted to the residual of a tone in
//! its bins.

use crate::math::scalar::Scalar;
use crate::math::series::circle;
use num_complex::Complex;

/// The number of fitted terms.
pub(super) const TERMS: usize = 3;

/// The bins between which slow terms matter. Above them slow terms are negligible; below them they
/// cannot be separated from a tone.
pub const HIGHEST: i32 = 48;
pub const LOWEST: i32 = 3;

/// Bins below this one may hold a hum's own line.
pub(super) const FIRST: i32 = 4;

/// A share of a fit's residual. Slow terms with less power than this share in bins 1 and 2 change no answer: these bins hold 1.25 parts or
/// more of at most 1.64 in all bins, since a straight line's bins fall as `1/k` and all others faster. Where the tone moves as well, even a
/// drift of much less power than the whole residual matters.
const SHARE: f32 = 1.0 / 30.0;

/// Whether slow terms with these powers in bins 1 and 2 may explain a part of the residual power of a fit.
pub(super) fn may_explain([one, two]: [f32; 2], left: f32) -> bool {
    one + two > SHARE * left
}

/// The terms' values in a bin.
pub(super) type Values<T> = [Complex<T>; TERMS];

/// The terms' values in bin `k` of a record of `n` samples: line, parabola and the rest. The scale makes
/// their sizes about 1 at bin 8.
pub(super) fn values<T: Scalar>(k: i32, n: i32) -> Values<T> {
    let turn = circle::<T>(k, n.saturating_mul(2));
    let near = T::new(8.0 * core::f64::consts::PI) / (T::from_i32(n) * turn.im);
    let square = near * near;
    let line = Complex::new(-turn.im, turn.re) * near;
    [line, turn * (square * turn.re), line * square]
}

/// The basis that makes the terms vectors of length 1 over some bins, orthogonal to one another. Line and parabola are orthogonal already:
/// one is a quarter turn on.
pub(super) struct Basis<T> {
    /// The reciprocals of the lengths: of the line, of the parabola, and of the rest less its share of the line.
    scales: [T; TERMS],
    share: T,
}

impl<T: Scalar> Basis<T> {
    /// The basis from the terms' values in all of the bins, three or more.
    pub fn from_values<'a>(bins: impl Iterator<Item = &'a Values<T>>) -> Self
    where
        T: 'a,
    {
        let zero = T::zero();
        let [mut ll, mut pp, mut lr, mut rr] = [zero; 4];
        for &[line, parabola, rest] in bins {
            ll = ll + line.norm_sqr();
            pp = pp + parabola.norm_sqr();
            lr = lr + line.re * rest.re + line.im * rest.im;
            rr = rr + rest.norm_sqr();
        }
        let share = lr / ll;
        let left = (rr - share * lr).max(T::epsilon() * rr);
        Self { scales: [ll, pp, left].map(|square| T::one() / square.root()), share }
    }

    /// The vectors' values in a bin, from the terms' values.
    pub fn turned(&self, &[line, parabola, rest]: &Values<T>) -> Values<T> {
        let [l, p, r] = self.scales;
        [line * l, parabola * p, (rest - line * self.share) * r]
    }
}
