//! The floating-point type of the last step: `f64` in the host's proofs, `f32` on the target.

use num_complex::Complex;
use num_traits::Float;

/// A float whose elementary functions give equal bits on every machine.
///
/// With `std`, `num_traits::Float` takes `sin`, `ln` and the like from the platform, and platforms
/// differ in the last digit. The functions here always come from the pure-Rust `libm` crate or from
/// this file, so the host gets the target's result. The four operations and `sqrt` are exact by
/// IEEE 754 and are used directly.
pub trait Scalar: Float + core::fmt::Debug + Send + Sync + 'static {
    /// The constant `x`, rounded once.
    fn new(x: f64) -> Self;
    /// The integer `x`, rounded once.
    fn from_i32(x: i32) -> Self;
    /// The integer `x`, rounded once.
    fn from_u64(x: u64) -> Self;
    /// `2^exponent`, exact, for exponents -126..=127.
    fn two_to(exponent: i32) -> Self;
    /// The square root. Cost: one instruction on a core with an FPU.
    fn root(self) -> Self;
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
    ($t:ty, $word:ty, $unit:path, $sqrt:path, $atan2:path, $atan:path, $log:path, $($wide:tt)*) => {
        impl Scalar for $t {
            fn new(x: f64) -> Self {
                x as $t
            }
            fn from_i32(x: i32) -> Self {
                x as $t
            }
            fn from_u64(x: u64) -> Self {
                x as $t
            }
            fn two_to(exponent: i32) -> Self {
                let biased = exponent.saturating_add(<$t>::MAX_EXP - 1) as $word;
                <$t>::from_bits(biased << (<$t>::MANTISSA_DIGITS - 1))
            }
            fn root(self) -> Self {
                $sqrt(self)
            }
            fn wide(self) -> f64 {
                $($wide)*(self)
            }
            fn unit(turns: Self) -> Complex<Self> {
                $unit(turns)
            }
            fn angle(z: Complex<Self>) -> Self {
                $atan2(z.im, z.re)
            }
            fn arctan(self) -> Self {
                $atan(self)
            }
            #[inline(never)] // once in an image: it is no part of a loop
            fn log_e(self) -> Self {
                $log(self)
            }
        }
    };
}

scalar!(f32, u32, unit_f32, root_f32, libm::atan2f, libm::atanf, libm::logf, f64::from);
scalar!(
    f64,
    u64,
    unit_f64,
    libm::sqrt,
    libm::atan2,
    libm::atan,
    libm::log,
    core::convert::identity
);

fn unit_f64(turns: f64) -> Complex<f64> {
    let radians = turns * core::f64::consts::TAU;
    Complex::new(libm::cos(radians), libm::sin(radians))
}

/// `exp(j 2 pi turns)` by the series for an eighth of a turn. `libm` works in `f64` inside, which a core without a double FPU emulates.
/// Whole turns and quarters are subtracted exactly, so the error is below 1.5e-7 for any angle.
fn unit_f32(turns: f32) -> Complex<f32> {
    let rest = turns - nearest(turns);
    let quarter = whole(4.0 * rest);
    let x = (rest - 0.25 * quarter as f32) * core::f32::consts::TAU;
    let (cos, sin) = (cosine(x * x), x * sinc(x * x));
    match quarter {
        0 => Complex::new(cos, sin),
        1 => Complex::new(-sin, cos),
        -1 => Complex::new(sin, -cos),
        _ => Complex::new(-cos, -sin),
    }
}

/// The nearest whole number, halves away from zero: that of `libm::roundf` in a fifth of its instructions on a core with an FPU.
#[inline(never)] // once in an image
pub fn nearest(x: f32) -> f32 {
    // From 2^23 on all floats are whole; so is what is no number.
    if x.abs() < 8_388_608.0 { whole(x) as f32 } else { x }
}

/// [`nearest`] for |x| < 2^31.
fn whole(x: f32) -> i32 {
    // The largest float below a half: the sum must not round up to the next whole number.
    (x + 0.499_999_97_f32.copysign(x)) as i32
}

/// `c0 + z (c1 + z (...))`, unrolled by the compiler so that the constants cost no conversion.
macro_rules! horner {
    ($z:expr, $last:expr) => { T::new($last) };
    ($z:expr, $c:expr, $($rest:expr),+) => { T::new($c) + $z * horner!($z, $($rest),+) };
}

/// Whether the type is single precision, which needs half the terms.
fn single<T: Scalar>() -> bool {
    T::epsilon() > T::new(1e-10)
}

/// `cos x` of `z = x^2`, |x| <= pi/4.
pub fn cosine<T: Scalar>(z: T) -> T {
    if single::<T>() {
        return horner!(z, 1.0, -1.0 / 2.0, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40320.0);
    }
    horner!(
        z,
        1.0,
        -1.0 / 2.0,
        1.0 / 24.0,
        -1.0 / 720.0,
        1.0 / 40320.0,
        -1.0 / 3628800.0,
        1.0 / 479001600.0,
        -1.0 / 87178291200.0
    )
}

/// `sin(x) / x` of `z = x^2`, |x| <= pi/4.
pub fn sinc<T: Scalar>(z: T) -> T {
    if single::<T>() {
        return horner!(z, 1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362880.0);
    }
    horner!(
        z,
        1.0,
        -1.0 / 6.0,
        1.0 / 120.0,
        -1.0 / 5040.0,
        1.0 / 362880.0,
        -1.0 / 39916800.0,
        1.0 / 6227020800.0,
        -1.0 / 1307674368000.0
    )
}

/// The reciprocals of four numbers, by one division, which takes as long as fourteen products.
#[inline(always)]
pub(crate) fn inverses<T: Scalar>([a, b, c, d]: [T; 4]) -> [T; 4] {
    let (ab, cd) = (a * b, c * d);
    let all = T::one() / (ab * cd);
    let (one_ab, one_cd) = (cd * all, ab * all);
    [b * one_ab, a * one_ab, d * one_cd, c * one_cd]
}

/// The larger number; `b` if `a` is NaN. Three instructions, where a library's is a call.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(not(any(short_products, all(target_os = "none", target_abi = "eabihf"))))]
fn root_f32(x: f32) -> f32 {
    libm::sqrtf(x)
}

#[cfg(short_products)]
fn root_f32(x: f32) -> f32 {
    root_by_bits(x)
}

/// The square root, bit by bit. It rounds as IEEE 754 demands, so it equals `libm`'s. `libm`'s
/// takes half as long again on cores with short products.
#[cfg(any(short_products, test))]
fn root_by_bits(x: f32) -> f32 {
    const LEADING: u32 = 1 << 23;
    let bits = x.to_bits();
    let power = bits >> 23;
    if !(1..255).contains(&power) {
        // Zero, negative, infinite, NaN, or subnormal.
        return libm::sqrtf(x);
    }
    // The remainder of x, 1..4 with 24 bits after the point, and 25 bits of the root: one more than the result keeps.
    let mut rest = (bits & (LEADING - 1) | LEADING) << (2 - (power & 1));
    let (mut root, mut bit) = (0, 2 * LEADING);
    while bit > 0 {
        let less = 2 * root + bit;
        if less <= rest {
            rest -= less;
            root += bit;
        }
        rest *= 2;
        bit >>= 1;
    }
    // The leading bit adds to the exponent. No root lies halfway between two floats.
    f32::from_bits(((power.div_ceil(2) + 62) << 23) + root.div_ceil(2))
}

/// The FPU's square root. It rounds as IEEE 754 demands, so it equals `libm`'s. The root of a
/// negative number is NaN in both.
#[cfg(all(target_os = "none", target_abi = "eabihf"))]
fn root_f32(x: f32) -> f32 {
    #[unsafe(naked)]
    extern "C" fn root(x: f32) -> f32 {
        // The directive tells the assembler of the FPU, which every core with this calling convention has.
        core::arch::naked_asm!(".fpu fpv4-sp-d16", "vsqrt.f32 s0, s0", "bx lr")
    }
    root(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_by_bits_is_the_librarys() {
        let ends = [0, 1, 0x7f_ffff, 0x80_0000, 0x3f80_0000, 0x7f7f_ffff, 0x7f80_0000, 0x7fc0_0000];
        let spread = (0..1 << 20).map(|i: u32| i.wrapping_mul(4093));
        // Two octaves, all bits but the last three.
        let all = (0x3f80_0000..0x4080_0000).step_by(7);
        for bits in ends.into_iter().chain(spread).chain(all) {
            let x = f32::from_bits(bits);
            assert_eq!(root_by_bits(x).to_bits(), libm::sqrtf(x).to_bits(), "{x:e}");
        }
    }
}
