//! Values in the bins of a window, and along the orders of an envelope.

use super::constants::{P, WIDTH};
use num_complex::Complex;

/// A value in each bin of a window.
pub type Shape = [Complex<f32>; WIDTH];

/// Nothing in any bin.
pub const NOTHING: Shape = [ZERO; WIDTH];

/// A real column, by bins.
pub type Column = [f32; WIDTH];

/// A value for each order of an envelope.
pub type Reals = [f32; P];

/// A complex value for each order of an envelope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orders {
    /// The real parts.
    pub re: Reals,
    /// The imaginary parts.
    pub im: Reals,
}

impl Orders {
    /// Nothing in any order.
    pub const ZERO: Self = Self { re: [0.0; P], im: [0.0; P] };

    /// The orders, from 0 up.
    pub fn iter(&self) -> impl Iterator<Item = Complex<f32>> {
        self.re.iter().zip(&self.im).map(|(re, im)| Complex::new(*re, *im))
    }
}

/// Zero.
pub const ZERO: Complex<f32> = Complex::new(0.0, 0.0);

/// The product of two numbers as vectors.
#[inline(always)]
pub fn along(a: Complex<f32>, b: Complex<f32>) -> f32 {
    a.re * b.re + a.im * b.im
}

/// The product of the first `O` orders.
#[inline(always)]
pub fn inner<const O: usize>(a: &Reals, b: &Reals) -> f32 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b).take(O) {
        sum += a * b;
    }
    sum
}

/// `z j^turns`.
#[inline(always)]
pub fn turned(z: Complex<f32>, turns: usize) -> Complex<f32> {
    match turns % 4 {
        0 => z,
        1 => Complex::new(-z.im, z.re),
        2 => -z,
        _ => Complex::new(z.im, -z.re),
    }
}

/// The energy of a residual.
pub fn energy(bins: &Shape) -> f32 {
    bins.iter().map(Complex::norm_sqr).sum()
}
