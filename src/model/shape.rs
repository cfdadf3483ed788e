//! A value in each bin of a window.

use super::constants::WIDTH;
use num_complex::Complex;

/// A value in each bin of a window.
pub type Shape = [Complex<f32>; WIDTH];

/// Nothing in any bin.
pub const NOTHING: Shape = [Complex::new(0.0, 0.0); WIDTH];

/// Bins are taken three at a time: [`WIDTH`] is a multiple of three, and a loop with a third of the turns costs a core a third less.
const AT_ONCE: usize = 3;
const _: () = assert!(WIDTH.is_multiple_of(AT_ONCE));

/// The product of two shapes as vectors of real numbers.
pub fn dot(a: &Shape, b: &Shape) -> f32 {
    let mut sum = 0.0;
    for (a, b) in a.as_chunks::<AT_ONCE>().0.iter().zip(b.as_chunks::<AT_ONCE>().0) {
        for (a, b) in a.iter().zip(b) {
            sum += a.re * b.re + a.im * b.im;
        }
    }
    sum
}

/// Subtracts a multiple of a shape.
pub fn take(from: &mut Shape, shape: &Shape, times: f32) {
    let chunks = from.as_chunks_mut::<AT_ONCE>().0.iter_mut();
    for (from, shape) in chunks.zip(shape.as_chunks::<AT_ONCE>().0) {
        for (from, shape) in from.iter_mut().zip(shape) {
            from.re -= shape.re * times;
            from.im -= shape.im * times;
        }
    }
}

/// A number turned by a quarter turn.
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
