//! Numbers in steps of 2^-32, to floats and back, in a handful of instructions: the conversions of the crate `fixed` are generic, and take
//! two hundred where the compiler optimises for size.

use fixed::types::I32F32;

/// Steps in 1.
const STEPS: f32 = 4_294_967_296.0;

/// The nearest float, of two equally near ones the even one.
#[inline]
pub(crate) fn to_f32(x: I32F32) -> f32 {
    x.to_bits() as f32 / STEPS
}

/// A number in steps, rounded towards 0. The cast saturates and turns NaN into 0: unlike a conversion of the crate `fixed`, it cannot
/// panic.
#[inline]
pub(crate) fn in_steps(x: f32) -> I32F32 {
    I32F32::from_bits((x * STEPS) as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_are_those_of_the_crate() {
        for bits in
            [0, 1, -1, (1 << 24) + 1, (1 << 25) + 2, 3 << 40, i64::MAX, i64::MIN, -(1 << 33) - 513]
        {
            let x = I32F32::from_bits(bits);
            assert_eq!(to_f32(x).to_bits(), x.to_num::<f32>().to_bits(), "{bits}");
        }
        assert_eq!(in_steps(f32::NAN), I32F32::ZERO);
        assert_eq!(in_steps(1e30), I32F32::MAX);
        assert_eq!(in_steps(-0.25), I32F32::from_num(-0.25));
    }
}
