//! The sums of [`super::super::rest`] in integers.

use super::{product, reciprocal, shifted};
use crate::estimate::least_squares::rest::Moments;
use num_complex::Complex;

/// Powers and moments of what is left beside the peak; bins as in [`super`], moments in Q22.
#[derive(Default)]
pub(super) struct Near {
    within: [u64; 3],
    powers: [[i64; 2]; 4],
}

impl Near {
    /// Adds what is left i bins from the peak of a tone at d, in Q30; its power.
    #[inline(always)]
    pub fn add(&mut self, i: i32, d: i32, left: [i32; 2]) -> u64 {
        let [re, im] = left.map(|part| product(part, part) as u64);
        let power = re.wrapping_add(im);
        let [two, four, eight] = &mut self.within;
        let scale = match i.abs() {
            ..=2 => two,
            3..=4 => four,
            _ => eight,
        };
        *scale = scale.wrapping_add(power);
        let y = reciprocal(d, i);
        let square = shifted::<22>(y, y);
        let weights = [y, square, shifted::<22>(square, y), shifted::<22>(square, square)];
        for (sums, weight) in self.powers.iter_mut().zip(weights) {
            for (sum, part) in sums.iter_mut().zip(left) {
                *sum = sum.wrapping_add(product(weight, part));
            }
        }
        power
    }

    /// As floats, for bins whose unit is `scale` codes, with what is left of the peak's own.
    pub fn moments(&self, centre: Complex<f32>, scale: f32) -> Moments<f32> {
        const Q22: f32 = 1.0 / 4_194_304.0;
        let mut moments = Moments::new(centre);
        for (sum, &power) in moments.within.iter_mut().zip(&self.within) {
            *sum += power as f32 * (scale * scale);
        }
        for (sum, power) in moments.powers.iter_mut().zip(&self.powers) {
            let [re, im] = power.map(|sum| sum as f32 * (scale * Q22));
            *sum = Complex::new(re, im);
        }
        moments
    }
}
