//! A number for cores without an FPU. It costs a fifth of a software `f32` and is six bits finer.

use super::{inverse, shifted, zeros};
use core::ops::{Add, Div, Mul, Neg, Sub};
use num_traits::One;

/// `mantissa * 2^exponent`. The mantissa is 0 or within 2^29..2^30. Results are rounded towards
/// minus infinity. Exponents stay far from the ends of their type, because nothing here multiplies
/// more than a few numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scaled {
    mantissa: i32,
    exponent: i32,
}

/// Bits of a mantissa.
const WIDTH: u32 = 30;

impl Scaled {
    /// Zero. Its exponent is below every other number's, so that adding zero loses nothing.
    pub const ZERO: Self = Self { mantissa: 0, exponent: -(1 << 20) };

    /// `integer * 2^exponent`.
    pub fn new(integer: i32, exponent: i32) -> Self {
        let size = integer.unsigned_abs();
        if size == 0 {
            return Self::ZERO;
        }
        if size >> WIDTH != 0 {
            // The size 2^31 itself needs one bit less.
            let down = size >> (WIDTH + 1);
            return Self { mantissa: integer >> (1 + down), exponent: exponent + 1 + down as i32 };
        }
        if size >> (WIDTH - 1) != 0 {
            return Self { mantissa: integer, exponent };
        }
        let room = zeros(size).wrapping_sub(32 - WIDTH) & 31;
        Self { mantissa: integer << room, exponent: exponent.wrapping_sub(room as i32) }
    }

    /// `sum * 2^exponent`.
    pub fn from_sum(sum: i64, exponent: i32) -> Self {
        let (high, low) = ((sum >> 32) as i32, sum as u32);
        // If the upper word is the sign alone, the lower word without its top bits is the number.
        if high == high >> 31 && (low as i32 >> 31) == high {
            return Self::new(low as i32, exponent);
        }
        // The sum goes up by this many bits. Then its upper word is the number.
        let room = zeros(((high ^ (high >> 31)) as u32) << 1 | 1) & 31;
        let high = (high << room) | ((low >> 1) >> (31 - room)) as i32;
        Self::new(high, exponent.wrapping_add(32).wrapping_sub(room as i32))
    }

    /// `x * 2^exponent`; 0 if `x` is not a number or too small to be normal.
    pub fn from_float(x: f32, exponent: i32) -> Self {
        let bits = x.to_bits();
        let power = (bits >> 23 & 0xff) as i32;
        if power == 0 || power == 255 {
            return Self::ZERO;
        }
        let size = ((bits & 0x7f_ffff | 0x80_0000) << 6) as i32;
        let mantissa = if x < 0.0 { -size } else { size };
        Self { mantissa, exponent: power - 156 + exponent }
    }

    /// The number with this many fractional bits, saturated.
    pub fn bits(self, fraction: u32) -> i32 {
        let up = self.exponent.wrapping_add(fraction as i32);
        match up {
            ..0 => self.mantissa >> up.unsigned_abs().min(31),
            0 => self.mantissa,
            1 => self.mantissa << 1,
            _ if self.mantissa < 0 => i32::MIN,
            _ => i32::MAX,
        }
    }

    /// The number times `2^exponent` as a float; 0 if it is too small for a float.
    pub fn float(self, exponent: i32) -> f32 {
        let bits = (self.mantissa as f32).to_bits();
        let power = (bits >> 23 & 0xff) as i32 + self.exponent + exponent;
        let sign = bits & 1 << 31;
        match power {
            _ if self.mantissa == 0 => 0.0,
            1..255 => f32::from_bits(sign | (power as u32) << 23 | bits & 0x7f_ffff),
            255.. => f32::from_bits(sign | f32::INFINITY.to_bits()),
            _ => 0.0,
        }
    }
}

impl One for Scaled {
    fn one() -> Self {
        Self { mantissa: 1 << (WIDTH - 1), exponent: 1 - WIDTH as i32 }
    }
}

impl Neg for Scaled {
    type Output = Self;

    fn neg(self) -> Self {
        Self { mantissa: -self.mantissa, ..self }
    }
}

impl Mul for Scaled {
    type Output = Self;

    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        let exponent = self.exponent.wrapping_add(other.exponent).wrapping_add(WIDTH as i32);
        let mantissa = shifted::<{ WIDTH - 1 }>(self.mantissa, other.mantissa);
        if mantissa.unsigned_abs() >> WIDTH != 0 {
            return Self { mantissa: mantissa >> 1, exponent };
        }
        Self { mantissa, exponent: exponent.wrapping_sub(1) }
    }
}

impl Add for Scaled {
    type Output = Self;

    #[inline(never)]
    fn add(self, other: Self) -> Self {
        let apart = self.exponent.wrapping_sub(other.exponent);
        let (sum, exponent) = if apart >= 0 {
            (self.mantissa + (other.mantissa >> apart.min(31)), self.exponent)
        } else {
            ((self.mantissa >> apart.wrapping_neg().min(31)) + other.mantissa, other.exponent)
        };
        Self::new(sum, exponent)
    }
}

impl Sub for Scaled {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

/// A quotient by zero is zero.
impl Div for Scaled {
    type Output = Self;

    #[inline(never)]
    fn div(self, other: Self) -> Self {
        let size = other.mantissa.unsigned_abs();
        if size == 0 {
            return Self::ZERO;
        }
        // 2^61 / (2 size), within 2^30..=2^31.
        let inverse = (inverse::of(size << 1) >> 1) as i32;
        let inverse = if other.mantissa < 0 { -inverse } else { inverse };
        // 1/size = inverse / 2^59.
        self * Self::new(inverse, other.exponent.wrapping_neg().wrapping_sub(59))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scaled(x: f64) -> Scaled {
        let exponent = if x == 0.0 { 0 } else { x.abs().log2().floor() as i32 - 40 };
        Scaled::from_sum((x / 2f64.powi(exponent)) as i64, exponent)
    }

    fn value(x: Scaled) -> f64 {
        f64::from(x.mantissa) * 2f64.powi(x.exponent)
    }

    #[test]
    fn the_four_operations() {
        let numbers =
            [0.0, 1.0, -1.0, 2.0, 0.3, -0.7, 1e-5, -3e7, 1.999_999, 123.456, -1024.0, 8e9];
        for a in numbers {
            for b in numbers {
                let near = |got: Scaled, exact: f64, size: f64| {
                    let error = (value(got) - exact).abs();
                    assert!(error <= 8e-9 * size, "{a} {b}: {got:?} {exact}");
                };
                let (x, y) = (scaled(a), scaled(b));
                near(x + y, a + b, a.abs() + b.abs());
                near(x - y, a - b, a.abs() + b.abs());
                near(x * y, a * b, (a * b).abs());
                near(x / y, if b == 0.0 { 0.0 } else { a / b }, (a / b).abs().min(1e30));
            }
            assert!((f64::from(scaled(a).float(0)) - a).abs() <= 1e-7 * a.abs(), "{a}");
            assert_eq!(value(Scaled::from_float(a as f32, 3)) / 8.0, f64::from(a as f32));
            let bits = scaled(a).bits(20);
            let exact = (a * 1_048_576.0).clamp(i32::MIN.into(), i32::MAX.into());
            assert!((f64::from(bits) - exact).abs() <= 1.0 + 1e-8 * exact.abs(), "{a}: {bits}");
        }
        assert_eq!(Scaled::one(), Scaled::new(1, 0));
        assert_eq!(Scaled::new(i32::MIN, 0).float(0), -2f32.powi(31));
        assert_eq!(Scaled::new(1, 100).float(100), f32::INFINITY);
        assert_eq!(Scaled::new(-1, -100).float(-100), 0.0);
        for sum in [i64::MAX, i64::MIN, 1 << 31, -(1 << 31), (1 << 32) - 1, 1 << 40, -1, 0] {
            assert!(
                (value(Scaled::from_sum(sum, 3)) / 8.0 / sum as f64 - 1.0).abs() < 4e-9 || sum == 0
            );
        }
    }
}
