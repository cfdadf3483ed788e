//! The normal equations: sums over the bins, inner products, and the step that follows from them.

use super::super::{STEP_LIMIT, limit};
use super::side::Side;
use crate::math::scalar::Scalar;
use core::ops::{Add, Div, Neg, Sub};
use num_complex::Complex;
use num_traits::One;

/// The eight sums over the bins beside the peak.
pub(super) struct Sums<T> {
    pub aa: T,
    pub s1: T,
    pub bb: T,
    pub dd: T,
    pub r1: T,
    pub r2: T,
    pub q1: T,
    pub q2: T,
}

/// One evaluation of the normal equations at an offset.
pub(in super::super) struct Step<T> {
    /// The gradient; divided by the gradient's information it is the step, in units of p.
    pub gradient: T,
    pub information: T,
    pub line: Complex<T>,
    /// The slope of `line` over p.
    pub slope: Complex<T>,
}

impl<T: Scalar> Step<T> {
    /// The step in bins, where p changes at this speed.
    pub fn forward(&self, speed: T) -> T {
        limit(self.gradient / (self.information * speed), STEP_LIMIT)
    }
}

/// Inner products of the basis F1 = (1, 0) h and F2 = (-e u, s) h, of its derivatives G1 and G2 by p,
/// and of the data.
pub(in super::super) struct Products<T> {
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

/// A number with the four operations: a float, or one for cores without an FPU.
pub(in super::super) trait Number:
    Copy + One + Add<Output = Self> + Sub<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
}

impl<T> Number for T where
    T: Copy + One + Add<Output = T> + Sub<Output = T> + Div<Output = T> + Neg<Output = T>
{
}

impl<T: Number> Products<T> {
    /// The normal equations: the line by elimination, and the step that follows from it.
    #[inline(always)]
    pub fn step(&self) -> Step<T> {
        let Self { g11, g12, g22, r: [r1, r2], q: [q1, q2], .. } = *self;
        let inverse = T::one() / (g11 * g22 - g12 * g12);
        let a = (g22 * r1 - g12 * r2) * inverse;
        let b = (g11 * r2 - g12 * r1) * inverse;
        let x1 = a * self.b11 + b * self.b21;
        let x2 = a * self.b12 + b * self.b22;
        let own = a * a * self.d11 + (a + a) * b * self.d12 + b * b * self.d22;
        let slope = Complex::new((g22 * x1 - g12 * x2) * inverse, (g11 * x2 - g12 * x1) * inverse);
        let information = own - (x1 * slope.re + x2 * slope.im);
        Step {
            gradient: a * (q1 - x1) + b * (q2 - x2),
            information,
            line: Complex::new(a, b),
            slope: Complex::new(-slope.re, -slope.im),
        }
    }

    /// Removes the part along a vector of length 1, given its products with F1, F2, G1, G2 and the data.
    pub fn less(&mut self, f1: T, f2: T, g1: T, g2: T, data: T) {
        self.g11 = self.g11 - f1 * f1;
        self.g12 = self.g12 - f1 * f2;
        self.g22 = self.g22 - f2 * f2;
        self.r = [self.r[0] - f1 * data, self.r[1] - f2 * data];
        self.b11 = self.b11 - g1 * f1;
        self.b12 = self.b12 - g1 * f2;
        self.b21 = self.b21 - g2 * f1;
        self.b22 = self.b22 - g2 * f2;
        self.d11 = self.d11 - g1 * g1;
        self.d12 = self.d12 - g1 * g2;
        self.d22 = self.d22 - g2 * g2;
        self.q = [self.q[0] - g1 * data, self.q[1] - g2 * data];
    }
}

impl<T: Scalar> Sums<T> {
    /// Adds a side, with `r` one over its distance from e p.
    #[inline(always)]
    pub fn add(&mut self, side: &Side<T>, ep: T, r: T) {
        let h = ep * r;
        let slope = (T::one() - h) * r;
        self.aa = self.aa + h * h;
        self.s1 = self.s1 + slope;
        self.bb = self.bb + h * slope;
        self.dd = self.dd + slope * slope;
        self.r1 = self.r1 + h * side.x.re;
        self.r2 = self.r2 + h * side.v;
        self.q1 = self.q1 + slope * side.x.re;
        self.q2 = self.q2 + slope * side.v;
    }
}
