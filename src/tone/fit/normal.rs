//! The normal equations of a line: two real columns F1 and F2 whose sizes a and b are unknown, and the place p on which both depend.
//!
//! ```text
//! data = a F1(p) + b F2(p) + noise        Gi = dFi/dp
//! ```
//!
//! a and b follow by elimination at each p, and the step in p from what they leave. A complex column with an unknown complex size is two
//! real ones, a column of which only one exists has a second of size 1 beside all data. Whatever the data are, bins, points in time or
//! products of bins, the equations need no more than inner products.

use crate::math::scalar::Scalar;
use core::ops::{Add, Div, Neg, Sub};
use num_complex::Complex;
use num_traits::One;

/// Inner products of the columns, of their derivatives, and of the data.
pub(crate) struct Products<T> {
    pub g11: T,
    pub g12: T,
    pub g22: T,
    /// F1 and F2 with the data.
    pub r: [T; 2],
    /// G1 F1, G1 F2, G2 F1, G2 F2.
    pub b11: T,
    pub b12: T,
    pub b21: T,
    pub b22: T,
    /// G1 G1, G1 G2, G2 G2.
    pub d11: T,
    pub d12: T,
    pub d22: T,
    /// G1 and G2 with the data.
    pub q: [T; 2],
}

/// One evaluation of the normal equations.
pub(crate) struct Step<T> {
    /// The gradient; divided by its information it is the step in p.
    pub gradient: T,
    pub information: T,
    /// The sizes a and b.
    pub line: Complex<T>,
    /// Their slope over p.
    pub slope: Complex<T>,
}

/// A number with the four operations: a float, or one for cores without an FPU.
pub(crate) trait Number:
    Copy + One + Add<Output = Self> + Sub<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
}

impl<T> Number for T where
    T: Copy + One + Add<Output = T> + Sub<Output = T> + Div<Output = T> + Neg<Output = T>
{
}

impl<T: Scalar> Products<T> {
    /// The products of a complex column F with a complex size: `aa = |F|^2`, `turned = G* F`, `dd = |G|^2`, and both with the data.
    #[inline(always)]
    pub fn complex(aa: T, turned: Complex<T>, dd: T, pp: Complex<T>, qq: Complex<T>) -> Self {
        let zero = T::zero();
        let Complex { re, im } = turned;
        Self {
            g11: aa,
            g12: zero,
            g22: aa,
            r: [pp.re, pp.im],
            b11: re,
            b12: -im,
            b21: im,
            b22: re,
            d11: dd,
            d12: zero,
            d22: dd,
            q: [qq.re, qq.im],
        }
    }

    /// The products of one real column F: with itself, with its derivative G, of G with itself, and of both with the data.
    #[inline(always)]
    pub fn real(ff: T, fg: T, gg: T, r: T, q: T) -> Self {
        let zero = T::zero();
        Self {
            g11: ff,
            g12: zero,
            g22: T::one(),
            r: [r, zero],
            b11: fg,
            b12: zero,
            b21: zero,
            b22: zero,
            d11: gg,
            d12: zero,
            d22: zero,
            q: [q, zero],
        }
    }
}

impl<T: Number> Products<T> {
    /// The step in p, and the sizes of the columns.
    #[inline(always)]
    pub fn step(&self) -> Step<T> {
        self.step_of(|more| more)
    }

    /// The step if the data are less columns of these sizes, so that all products with them are small.
    #[inline(always)]
    pub fn step_beyond(&self, first: Complex<T>) -> Step<T> {
        self.step_of(|more| Complex::new(first.re + more.re, first.im + more.im))
    }

    #[inline(always)]
    fn step_of(&self, whole: impl FnOnce(Complex<T>) -> Complex<T>) -> Step<T> {
        let Self { g11, g12, g22, r: [r1, r2], q: [q1, q2], .. } = *self;
        let inverse = T::one() / (g11 * g22 - g12 * g12);
        let solved =
            |x: T, y: T| Complex::new((g22 * x - g12 * y) * inverse, (g11 * y - g12 * x) * inverse);
        let more = solved(r1, r2);
        let line = whole(more);
        let Complex { re: a, im: b } = line;
        let x1 = a * self.b11 + b * self.b21;
        let x2 = a * self.b12 + b * self.b22;
        let own = a * a * self.d11 + (a + a) * b * self.d12 + b * b * self.d22;
        let slope = solved(x1, x2);
        let information = own - (x1 * slope.re + x2 * slope.im);
        let left1 = q1 - (more.re * self.b11 + more.im * self.b12);
        let left2 = q2 - (more.re * self.b21 + more.im * self.b22);
        Step {
            gradient: a * left1 + b * left2,
            information,
            line,
            slope: Complex::new(-slope.re, -slope.im),
        }
    }
}

impl<T: Scalar> Step<T> {
    /// The step in bins, where p changes at this speed with them.
    pub fn forward(&self, speed: T) -> T {
        self.gradient / (self.information * speed)
    }

    /// The sizes at `onward` from the p of this step.
    pub fn line_at(&self, onward: T) -> Complex<T> {
        self.line + self.slope * onward
    }
}
