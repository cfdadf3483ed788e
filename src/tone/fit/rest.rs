//! The residual of a fit near its line, and the parts of it along the directions in which a tone changes.
//!
//! Let a tone's amplitude or phase follow Legendre's polynomial of order p over the record. Besides its line c the tone then has the bins
//! `c (-1)^i j^p j_p(x)`, with spherical Bessel functions of `x = pi (d - i)`, which are orthogonal to one another. A residual along their
//! real part is a change of the amplitude, one along their imaginary part a change of the phase. The fit itself takes order 0 and the phase
//! of order 1, which is a frequency. So a tone that moves shows in five directions of higher order. Noise is no stronger in these
//! directions than elsewhere.
//!
//! With s and c the sine and the cosine of `pi d`, and `y = 1/x`, the functions follow from one another:
//!
//! ```text
//! (-1)^i j_0 = s y      (-1)^i j_1 = (s y - c) y      j_2 = 3 y j_1 - j_0      j_3 = 5 y j_2 - j_1
//! ```
//!
//! The middle of N samples lies half a sample before the middle of N sampling intervals, for which the formulas hold. So a bin is turned by
//! `-x / N` against them. Turning it back adds `j / N` times the bin's product with `x j_p`, which follows from the other products, as the
//! fit leaves nothing along `j_0`:
//!
//! ```text
//! (-1)^i x j_1 = s y - c      (-1)^i x j_2 = 3 (s y - c) y - s      (-1)^i x j_3 = 5 j_2 - s y + c
//! ```

use crate::math::scalar::{Scalar, cosine};
use crate::math::series::line_shape;
use core::f64::consts::{FRAC_PI_4, PI};
use num_complex::Complex;

/// Bins on each side that are read.
pub(super) const NEAR: usize = 8;

/// The bins on each side whose power is summed.
pub(super) const SCALES: [i32; 3] = [2, 4, NEAR as i32];

/// The residual of a fit near its line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest<T> {
    /// The power in the bins up to 2, 4 and 8 from the peak, in squared codes.
    pub within: [T; 3],
    /// The residual times the functions of order 1, 2 and 3, in codes.
    pub along: [Complex<T>; 3],
    /// The square of the cosine of pi times the offset.
    pub cosine_squared: T,
}

/// The sums over the bins while they grow.
#[derive(Clone, Copy)]
pub(super) struct Sums<T> {
    /// pi times the offset, with its sine and cosine.
    x: T,
    sine: T,
    cosine: T,
    along: [Complex<T>; 3],
    /// The sum of the residual.
    all: Complex<T>,
}

impl<T: Scalar> Sums<T> {
    /// Sums for a tone at the offset d; `centre` is the residual of the peak's own bin.
    pub fn new(d: T, centre: Complex<T>) -> Self {
        let of = T::new;
        let x = d * of(PI);
        // The angle is doubled twice.
        let quarter = d * of(FRAC_PI_4);
        let cos = cosine(quarter * quarter);
        let half = of(2.0) * cos * cos - T::one();
        let z = x * x;
        // j_p = x^p g_p, and g_1 = 5 g_2 - x^2 g_3.
        let g3 = series(z, [18.0, 44.0, 78.0]) * of(1.0 / 105.0);
        let g2 = series(z, [14.0, 36.0, 66.0]) * of(1.0 / 15.0);
        let g1 = of(5.0) * g2 - z * g3;
        Self {
            x,
            sine: x * line_shape(d),
            cosine: of(2.0) * half * half - T::one(),
            along: [centre * (x * g1), centre * (z * g2), centre * (z * x * g3)],
            all: centre,
        }
    }

    /// The number of which [`Sums::add`] takes the reciprocal, for the bin i bins from the peak.
    #[inline(always)]
    pub fn argument(&self, i: i32) -> T {
        self.x - T::new(PI) * T::from_i32(i)
    }

    /// Adds the residual of a bin within [`NEAR`] other than the peak's own. `y` is the reciprocal of its [`Sums::argument`].
    #[inline(always)]
    pub fn add(&mut self, left: Complex<T>, y: T) {
        let zeroth = self.sine * y;
        let first = (zeroth - self.cosine) * y;
        let second = T::new(3.0) * first * y - zeroth;
        let third = T::new(5.0) * second * y - first;
        for (sum, shape) in self.along.iter_mut().zip([first, second, third]) {
            *sum = *sum + left * shape;
        }
        self.all = self.all + left;
    }

    /// The sums of bins that have the turn by half a sample in a record of `n` samples. Without the correction a record that runs backwards
    /// would leave another residual.
    pub fn turned_back(mut self, n: i32) -> Self {
        let share = T::one() / T::from_i32(n);
        let quarter = |z: Complex<T>| Complex::new(-z.im, z.re) * share;
        let [first, second, third] = self.along;
        let (cosine, sine) = (self.all * self.cosine, self.all * self.sine);
        self.along = [
            first - quarter(cosine),
            second + quarter(first * T::new(3.0) - sine),
            third + quarter(second * T::new(5.0) + cosine),
        ];
        self
    }

    /// The result, with the power up to each of [`SCALES`].
    pub fn rest(&self, within: [T; 3]) -> Rest<T> {
        Rest { within, along: self.along, cosine_squared: self.cosine * self.cosine }
    }
}

#[cfg(test)]
impl<T: Scalar> Rest<T> {
    /// No residual.
    pub(crate) fn none() -> Self {
        let zero = T::zero();
        let along = [Complex::new(zero, zero); 3];
        Self { within: [zero; 3], along, cosine_squared: zero }
    }
}

/// `1 - z/a (1 - z/b (1 - z/c))`, the beginning of a Bessel function of `z = x^2`.
fn series<T: Scalar>(z: T, [a, b, c]: [f64; 3]) -> T {
    let last = T::one() - z * T::new(1.0 / c);
    T::one() - z * T::new(1.0 / a) * (T::one() - z * T::new(1.0 / b) * last)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bins of a tone whose phase bends: the line leaves only the second function of them.
    #[test]
    fn a_bent_phase_is_along_the_second_function() {
        for d in [-0.5, -0.1, 0.0, 0.3, 0.9] {
            let function = |i: i32, order: usize| {
                let x = PI * (d - f64::from(i));
                let (sin, cos) = (libm::sin(x), libm::cos(x));
                let j1 = (sin / x - cos) / x;
                let j2 = 3.0 * j1 / x - sin / x;
                let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
                sign * [j1, j2, 5.0 * j2 / x - j1][order]
            };
            for order in 0..3 {
                let small = [d / 3.0 * PI, 0.0, 0.0][order];
                let centre = if d == 0.0 { small } else { function(0, order) };
                let mut sums = Sums::new(d, Complex::new(centre, 0.0));
                for i in (1..=8).flat_map(|i| [-i, i]) {
                    let y = 1.0 / (PI * (d - f64::from(i)));
                    sums.add(Complex::new(function(i, order), 0.0), y);
                }
                let rest = sums.rest([0.0; 3]);
                let squares = [1.0 / 3.0, 1.0 / 5.0, 1.0 / 7.0][order];
                for (other, along) in rest.along.iter().enumerate() {
                    let expected = if other == order { squares } else { 0.0 };
                    assert!((along.re - expected).abs() < 0.025, "{d} {order}: {rest:?}");
                    assert_eq!(along.im, 0.0);
                }
            }
        }
    }
}
