//! A burst's signal about its frequency: 64 bins transformed back to 64 points in time.
//!
//! With `X` the spectrum of the tapered record, c the centre bin and `t_k` the bins' taper, the points are
//!
//! ```text
//! z[n] = (1 / N) sum over k of t_k X[c + k] exp(j 2 pi k n / 64)        k = -32 .. 31
//! ```
//!
//! each divided by the record's taper at its place.

use crate::math::scalar::Scalar as _;
use crate::spectrum::layout::Layout;
use crate::spectrum::view::View;
use core::mem::MaybeUninit;
use core::ops::RangeInclusive;
use num_complex::Complex;

/// Points in time, and bins.
pub(super) const POINTS: usize = 64;
/// Points at each end of the record over which it is tapered, so that its ends do not ring in the others.
const TAPERED: f32 = 6.0;
/// Points whose taper is a fifth or less are not used: the points at the very ends.
const USED: RangeInclusive<usize> = 2..=POINTS - 2;
/// Bins on each side that pass whole; from there to 32 the bins are tapered, too.
const WHOLE: f32 = 16.0;

/// The mean of the squares of the bins' taper: the ratio of a point's noise to the noise of bins that pass whole.
pub(super) const PASSED: f32 = 0.6875;
/// The correlation of the noise of neighbouring points: the sum of the taper's squares times `cos(2 pi k / 64)`, over the sum of its
/// squares.
pub(super) const CORRELATION: f32 = 0.370_397_7;

/// The factor of the record's taper at a place, in records from its beginning.
pub(super) fn taper(place: f32) -> f32 {
    let end = place.min(1.0 - place) * POINTS as f32 / TAPERED;
    if end >= 1.0 {
        return 1.0;
    }
    let sine = f32::unit(0.25 * end.clamp(0.0, 1.0)).im;
    sine * sine
}

/// The signal within 32 bins of a bin, moved to frequency 0.
pub(super) struct Baseband {
    /// Points in codes: half a real tone's amplitude, the whole of an I/Q tone's. 0 where the taper is small.
    pub points: [Complex<f32>; POINTS],
}

/// The place of a point, in records.
pub(super) fn place(index: usize) -> f32 {
    index as f32 / POINTS as f32
}

/// Whether a point is used.
pub(super) fn used(index: usize) -> bool {
    USED.contains(&index)
}

impl Baseband {
    /// The baseband of a tapered record's spectrum, about bin `centre`.
    pub fn from_view(view: &View, centre: i32) -> Self {
        let Layout { n, iq, .. } = *view.layout;
        let zero = Complex::new(0.0, 0.0);
        let unit = libm::ldexpf(1.0, view.exponent) / n as f32;
        let mut places = [const { MaybeUninit::uninit() }; POINTS];
        let half = POINTS as i32 / 2;
        let read = view.fill(centre.saturating_sub(half), &mut places);
        let mut bins = [zero; POINTS];
        for (&[re, im], k) in read.iter().zip(-half..) {
            let at = centre.saturating_add(k);
            // Beyond the spectrum of a real record lies its image.
            if !iq && !(1..n as i32 / 2).contains(&at) {
                continue;
            }
            let end = (half as f32 - k.unsigned_abs() as f32) / (half as f32 - WHOLE);
            let sine = f32::unit(0.25 * end.clamp(0.0, 1.0)).im;
            let factor = unit * sine * sine;
            if let Some(bin) = bins.get_mut(k as usize & (POINTS - 1)) {
                *bin = Complex::new(re as f32 * factor, im as f32 * factor);
            }
        }
        let mut points = inverse(&bins);
        for (index, point) in points.iter_mut().enumerate() {
            *point = if used(index) { *point / taper(place(index)) } else { zero };
        }
        Self { points }
    }
}

/// `sum over k of bins[k] exp(j 2 pi k n / 64)`, as eight times eight.
fn inverse(bins: &[Complex<f32>; POINTS]) -> [Complex<f32>; POINTS] {
    const SIDE: usize = 8;
    let zero = Complex::new(0.0f32, 0.0);
    let turns: [Complex<f32>; POINTS] = core::array::from_fn(|k| f32::unit(place(k)));
    let turn = |k: usize| turns.get(k & (POINTS - 1)).copied().unwrap_or(zero);
    let of = |values: &[Complex<f32>; POINTS], k: usize| values.get(k).copied().unwrap_or(zero);
    // inner[a + 8 b] = sum over c of bins[8 c + b] exp(j 2 pi c a / 8)
    let inner: [Complex<f32>; POINTS] = core::array::from_fn(|at| {
        let (a, b) = (at % SIDE, at / SIDE);
        (0..SIDE).fold(zero, |sum, c| sum + of(bins, SIDE * c + b) * turn(SIDE * c * a))
    });
    core::array::from_fn(|n| {
        let a = n % SIDE;
        (0..SIDE).fold(zero, |sum, b| sum + of(&inner, a + SIDE * b) * turn(b * n))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_with_a_fifth_of_the_taper_are_used() {
        for index in 0..POINTS {
            assert_eq!(used(index), taper(place(index)) > 0.2, "{index}");
        }
        assert_eq!(f32::unit(0.25).im, 1.0);
    }
}
