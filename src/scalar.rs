//! The floating-point type of the last step: `f64` in proofs on the host, `f32` on the target.

use num_complex::Complex;
use num_traits::Float;

/// A float whose elementary functions give the same bits on every machine.
///
/// `num_traits::Float` takes `sin`, `ln` and the like from the platform where `std` is present,
/// and platforms differ in the last digit. The functions here always come from the pure-Rust
/// `libm` crate, so a result on the host equals the one on the target. The four operations and
/// `sqrt` are exact by IEEE 754 and are used directly.
pub trait Scalar: Float + core::fmt::Debug + Send + Sync + 'static {
    /// The constant `x`, rounded once.
    fn of(x: f64) -> Self;
    /// The integer `x`, rounded once.
    fn of_i32(x: i32) -> Self;
    /// The value as `f64`, exactly.
    fn wide(self) -> f64;
    /// `exp(j 2 pi turns)`.
    fn unit(turns: Self) -> Complex<Self>;
    /// The angle of `z` in radians, in `-pi..=pi`.
    fn angle(z: Complex<Self>) -> Self;
    /// The arc tangent in radians.
    fn arctan(self) -> Self;
    /// The natural logarithm.
    fn log_e(self) -> Self;
}

macro_rules! scalar {
    ($t:ty, $sin:path, $cos:path, $atan2:path, $atan:path, $log:path, $($wide:tt)*) => {
        impl Scalar for $t {
            fn of(x: f64) -> Self {
                x as $t
            }
            fn of_i32(x: i32) -> Self {
                x as $t
            }
            fn wide(self) -> f64 {
                $($wide)*(self)
            }
            fn unit(turns: Self) -> Complex<Self> {
                let radians = turns * <$t>::of(core::f64::consts::TAU);
                Complex::new($cos(radians), $sin(radians))
            }
            fn angle(z: Complex<Self>) -> Self {
                $atan2(z.im, z.re)
            }
            fn arctan(self) -> Self {
                $atan(self)
            }
            fn log_e(self) -> Self {
                $log(self)
            }
        }
    };
}

scalar!(f32, libm::sinf, libm::cosf, libm::atan2f, libm::atanf, libm::logf, f64::from);
scalar!(f64, libm::sin, libm::cos, libm::atan2, libm::atan, libm::log, core::convert::identity);
