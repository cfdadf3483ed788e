//! Logarithms and exponentials for odds: to 2e-4, by polynomials, a tenth of a library's instructions.

use crate::math::scalar::larger;
use core::f32::consts::{LN_2, LOG2_E};

/// The natural logarithm of a positive number, within 1e-4.
#[inline(always)]
pub fn ln(x: f32) -> f32 {
    let bits = larger(x, 1e-35).to_bits();
    let power = (bits >> 23) as i32 - 127;
    let m = f32::from_bits(bits & 0x7f_ffff | 0x3f80_0000);
    // The quartic is exact at 1 and 2, so the whole is continuous.
    let of_mantissa = (((-0.054_370_93 * m + 0.433_932_44) * m - 1.440_592_2) * m + 2.792_836_5)
        * m
        - 1.731_726_4;
    of_mantissa + power as f32 * LN_2
}

/// The exponential, within a share of 2e-4; held to the range of single precision.
#[inline(always)]
pub fn exp(x: f32) -> f32 {
    let y = (x * LOG2_E).clamp(-120.0, 120.0);
    let whole = y as i32 - i32::from(y < 0.0);
    let part = y - whole as f32;
    let of_part = ((0.078_967_26 * part + 0.224_693_16) * part + 0.696_324_8) * part + 0.999_900_3;
    f32::from_bits(((whole + 127) as u32) << 23) * of_part
}

/// The logarithm of a product of positive numbers: few logarithms for many factors.
#[derive(Clone, Copy, Debug)]
pub struct Product {
    logs: f32,
    product: f32,
}

impl Product {
    /// The empty product.
    pub const ONE: Self = Self { logs: 0.0, product: 1.0 };

    /// One more factor, of up to 1e18.
    #[inline(always)]
    pub fn times(&mut self, factor: f32) {
        self.product *= factor;
        if !(1e-18..1e18).contains(&self.product) {
            self.logs += ln(self.product);
            self.product = 1.0;
        }
    }

    /// The logarithm.
    #[inline(always)]
    pub fn ln(self) -> f32 {
        self.logs + ln(self.product)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_librarys_functions() {
        for i in -3000..=3000 {
            let x = i as f32 * 0.025;
            let (y, exact) = (exp(x), libm::expf(x));
            assert!((y - exact).abs() < 2e-4 * exact, "exp {x}: {y} {exact}");
            assert!((ln(exact) - libm::logf(exact)).abs() < 2e-4, "ln {exact}");
        }
        let mut product = Product::ONE;
        (0..40).for_each(|_| product.times(1e10));
        assert!((product.ln() - 400.0 * core::f32::consts::LN_10).abs() < 1e-2);
    }
}
