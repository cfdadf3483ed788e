//! Sine and cosine by their series, in Q30.

use super::times;

/// `c0 + z (c1 + z (...))` in Q30.
macro_rules! horner {
    ($z:expr, $last:expr) => { const { series($last) } };
    ($z:expr, $c:expr, $($rest:expr),+) => { const { series($c) } + times($z, horner!($z, $($rest),+)) };
}

const fn series(x: f64) -> i32 {
    (x * (1u64 << 30) as f64) as i32
}

/// `cos x` of `z = x^2`, |x| <= pi/4.
pub(super) fn cosine(z: i32) -> i32 {
    horner!(z, 1.0, -1.0 / 2.0, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40320.0)
}

/// `sin(x) / x` of `z = x^2`, |x| <= pi/4.
pub(super) fn sinc(z: i32) -> i32 {
    horner!(z, 1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362880.0)
}
