//! The bins beside the peak, and one over the distance of each from the tone.

use crate::math::scalar::{Scalar, inverses};
use num_complex::Complex;

/// A bin beside the peak.
#[derive(Clone, Copy)]
pub(super) struct Side<T> {
    /// The distance from the peak in bins.
    pub i: i32,
    /// e u
    pub w: T,
    pub s: T,
    pub x: Complex<T>,
    pub v: T,
}

/// The sides that share a division.
const GROUP: usize = 4;

impl<T: Scalar> Side<T> {
    #[inline(always)]
    pub fn new(i: i32, w: T, s: T, x: Complex<T>) -> Self {
        Side { i, w, s, x, v: s * x.im - w * x.re }
    }

    /// The residual of a bin in which the model is h times the basis.
    #[inline(always)]
    pub fn left(&self, line: Complex<T>, h: T) -> Complex<T> {
        let model = Complex::new(line.re - line.im * self.w, line.im * self.s);
        self.x - model * h
    }
}

/// Each side with one over its distance from e p.
#[inline(always)]
pub(super) fn each<T: Scalar>(sides: &[Side<T>], ep: T, mut take: impl FnMut(&Side<T>, T)) {
    let (groups, rest) = sides.as_chunks::<GROUP>();
    for group in groups {
        let inverses = inverses(group.each_ref().map(|side| ep - side.w));
        group.iter().zip(inverses).for_each(|(side, r)| take(side, r));
    }
    for side in rest {
        take(side, T::one() / (ep - side.w));
    }
}
