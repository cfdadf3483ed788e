//! A value in each bin of a window.

use super::constants::WIDTH;
use num_complex::Complex;

/// A value in each bin of a window.
pub type Shape = [Complex<f32>; WIDTH];

/// Nothing in any bin.
pub const NOTHING: Shape = [Complex::new(0.0, 0.0); WIDTH];

/// The product of two shapes as vectors of real numbers.
pub fn dot(a: &Shape, b: &Shape) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.re * b.re + a.im * b.im).sum()
}

/// Takes a multiple of a shape away.
pub fn take(from: &mut Shape, shape: &Shape, times: f32) {
    for (from, shape) in from.iter_mut().zip(shape) {
        from.re -= shape.re * times;
        from.im -= shape.im * times;
    }
}

/// A quarter turn on.
pub fn quarter(z: Complex<f32>) -> Complex<f32> {
    Complex::new(-z.im, z.re)
}

/// `z j^turns`.
pub fn turned(z: Complex<f32>, turns: usize) -> Complex<f32> {
    match turns % 4 {
        0 => z,
        1 => quarter(z),
        2 => -z,
        _ => -quarter(z),
    }
}
