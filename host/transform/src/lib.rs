//! The exact transform, in floats: a plan for any length. It is a package of its own so that rustfft, whose
//! code is generic, is compiled once and not again in every tool and test.

pub use rustfft::Fft;
pub use rustfft::num_complex;
use rustfft::{FftNum, FftPlanner};
use std::sync::Arc;

/// A float that can be transformed.
pub trait Transform: FftNum {
    /// The transform of `n` points, unscaled, with `exp(-j 2 pi k m / n)`.
    fn forward(n: usize) -> Arc<dyn Fft<Self>>;
    /// Its inverse except for the factor `n`.
    fn inverse(n: usize) -> Arc<dyn Fft<Self>>;
}

macro_rules! transform {
    ($($t:ty)*) => {$(
        impl Transform for $t {
            fn forward(n: usize) -> Arc<dyn Fft<Self>> {
                FftPlanner::new().plan_fft_forward(n)
            }
            fn inverse(n: usize) -> Arc<dyn Fft<Self>> {
                FftPlanner::new().plan_fft_inverse(n)
            }
        }
    )*};
}

transform!(f32 f64);
