//! The transform over the chirps: a power of two of complex floats.

use crate::math::scalar::Scalar as _;
use num_complex::Complex;

/// Twice the most chirps: the search looks at half bins.
pub(super) const MOST: usize = 512;

/// The factors of a transform of up to [`MOST`] points: `exp(-j 2 pi i / length)`.
pub(super) struct Factors {
    length: usize,
    table: [Complex<f32>; MOST / 2],
}

impl Factors {
    /// For `length` points, a power of two up to [`MOST`].
    pub fn new(length: usize) -> Self {
        let step = 1.0 / length.max(1) as f32;
        let mut table = [Complex::new(0.0, 0.0); MOST / 2];
        for (i, factor) in table.iter_mut().take(length / 2).enumerate() {
            *factor = f32::unit(-(i as f32) * step);
        }
        Self { length, table }
    }

    /// Transforms in place. The frequencies come out in the order of their reversed bits, see [`Factors::frequency`].
    pub fn transform(&self, points: &mut [Complex<f32>; MOST]) {
        let Some(points) = points.get_mut(..self.length) else { return };
        let (mut length, mut stride) = (self.length, 1);
        while length >= 2 {
            let half = length / 2;
            let mut rest = &mut *points;
            while let Some((block, others)) =
                core::mem::take(&mut rest).split_at_mut_checked(length)
            {
                rest = others;
                let Some((low, high)) = block.split_at_mut_checked(half) else { return };
                let factors = self.table.iter().step_by(stride.max(1));
                for ((a, b), factor) in low.iter_mut().zip(high).zip(factors) {
                    let difference = *a - *b;
                    *a += *b;
                    *b = difference * factor;
                }
                if rest.is_empty() {
                    break;
                }
            }
            (length, stride) = (half, stride * 2);
        }
    }

    /// The frequency at a place of the result, of `0..length`.
    pub const fn frequency(&self, place: usize) -> usize {
        let bits = self.length.trailing_zeros();
        if bits == 0 { 0 } else { (place as u32).reverse_bits().wrapping_shr(32 - bits) as usize }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transform_is_the_sum_that_defines_it() {
        for length in [16, 64, 512] {
            let factors = Factors::new(length);
            let sample =
                |i: usize| Complex::new((i * i % 97) as f32 - 48.0, (i * 31 % 53) as f32 - 26.0);
            let mut points = [Complex::new(0.0, 0.0); MOST];
            points.iter_mut().take(length).enumerate().for_each(|(i, point)| *point = sample(i));
            factors.transform(&mut points);
            for (place, point) in points.iter().take(length).enumerate() {
                let k = factors.frequency(place);
                let turns = |i: usize| -((k * i % length) as f64) / length as f64;
                let sum: Complex<f64> = (0..length)
                    .map(|i| {
                        let x = sample(i);
                        f64::unit(turns(i)) * Complex::new(f64::from(x.re), f64::from(x.im))
                    })
                    .sum();
                let off = Complex::new(f64::from(point.re), f64::from(point.im)) - sum;
                assert!(off.norm_sqr().sqrt() < 5e-3, "{length} {place}: {off}");
            }
        }
    }
}
