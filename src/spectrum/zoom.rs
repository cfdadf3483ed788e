//! A few bins of a record without its spectrum, for a tone whose place is known: mix, decimate by N/32,
//! transform 32 points.
//!
//! With `L = N/32`, centre bin c and block m of L samples,
//!
//! ```text
//! y[m] = sum over n < L of x[m L + n] exp(-j 2 pi c n / N)        Y[c + i] = sum over m of y[m] exp(-j 2 pi (c + i) m / 32)
//! ```
//!
//! The oscillator starts anew in each block, so its L factors are a table, and the centre only shifts the index of the
//! transform. Y is not the record's spectrum but that seen through a boxcar of L samples: see
//! [`crate::estimate::locked`] for the exact model. A constant offset falls into the one bin whose index is a
//! multiple of 32.
//!
//! Integers throughout. The products with Q15 factors are summed exactly and then shifted so that the 32-point
//! transform, which grows by 32, fits: N = 1024 samples of 12 bits keep 2^-8 code.

use super::fft::twiddle::MAX_LENGTH;
use crate::acquire::sample::{Codes, Record};
use crate::estimate::least_squares::circle;
use num_complex::Complex;

/// Points after decimation.
pub const POINTS: usize = 32;

/// Samples in the longest block that becomes a point.
const LONGEST: usize = MAX_LENGTH / POINTS;

/// The factors of one centre.
#[derive(Clone, Debug)]
pub struct Oscillator {
    centre: i32,
    /// cos and -sin, [`ONE`] for 1.
    factors: [[i16; 2]; LONGEST],
}

/// Bins about a centre, as [`Oscillator::zoom`] leaves them.
#[derive(Clone, Debug)]
pub struct Zoom {
    points: [Complex<i32>; POINTS],
    shift: u32,
}

impl Oscillator {
    /// The factors for centre bin `centre` of records of `n` samples (64 to 4096). Cost: n/32 sines.
    pub fn new(centre: i32, n: usize) -> Self {
        let mut factors = [[0; 2]; LONGEST];
        for (factor, k) in factors.iter_mut().zip(0..n as i32 / POINTS as i32) {
            let turn = circle::<f32>(centre.wrapping_mul(k), n as i32);
            *factor = [q15(turn.re), q15(-turn.im)];
        }
        Self { centre, factors }
    }

    /// The centre bin.
    pub const fn centre(&self) -> i32 {
        self.centre
    }

    /// Mixes, decimates and transforms a record of N samples.
    pub fn zoom<R: Record, const N: usize>(&self, samples: &[R::Sample; N], codes: Codes) -> Zoom {
        let length = N / POINTS;
        // The largest part of a sum is length 2^(bits - 1) 2^15, I/Q twice that; a point shall not exceed 2^25.
        let bits = length.trailing_zeros() + codes.bits() - 1 + 15 + u32::from(R::IQ);
        let shift = bits.saturating_sub(25);
        let mut points = [Complex::new(0, 0); POINTS];
        let factors = self.factors.get(..length).unwrap_or_default();
        let mut rest = samples.as_slice();
        for point in &mut points {
            let Some((block, tail)) = rest.split_at_checked(length) else {
                break;
            };
            rest = tail;
            let sum = mix::<R>(block, factors);
            *point = Complex::new((sum.re >> shift) as i32, (sum.im >> shift) as i32);
        }
        Zoom { points: transform(points), shift }
    }
}

/// The sum of a block's samples times their factors, exactly.
fn mix<R: Record>(block: &[R::Sample], factors: &[[i16; 2]]) -> Complex<i64> {
    let mut sum = Complex::new(0i64, 0i64);
    for (&sample, &[cos, sin]) in block.iter().zip(factors) {
        let [i, q] = R::parts(sample).map(i32::from);
        let (cos, sin) = (i32::from(cos), i32::from(sin));
        // Each product is below 2^30.
        sum.re = sum.re.wrapping_add(i64::from(i * cos));
        sum.im = sum.im.wrapping_add(i64::from(i * sin));
        if R::IQ {
            sum.re = sum.re.wrapping_sub(i64::from(q * sin));
            sum.im = sum.im.wrapping_add(i64::from(q * cos));
        }
    }
    sum
}

impl Zoom {
    /// Bin k of the record, near the centre, in stored units.
    pub fn bin(&self, k: i32) -> Complex<i32> {
        let index = k.rem_euclid(POINTS as i32) as usize;
        self.points.get(index).copied().unwrap_or(Complex::new(0, 0))
    }

    /// One stored unit in codes.
    pub fn unit(&self) -> f32 {
        libm::ldexpf(1.0 / ONE, self.shift as i32)
    }
}

/// A factor of 1. Not 2^15, which 16 bits do not hold.
const ONE: f32 = 32767.0;

fn q15(x: f32) -> i16 {
    libm::rintf(x * ONE) as i16
}

/// The transform of 32 points, decimation in frequency, output in order.
fn transform(mut points: [Complex<i32>; POINTS]) -> [Complex<i32>; POINTS] {
    for half in [16, 8, 4, 2, 1] {
        let mut rest = points.as_mut_slice();
        while let Some((block, tail)) = rest.split_at_mut_checked(2 * half) {
            rest = tail;
            let Some((low, high)) = block.split_at_mut_checked(half) else {
                break;
            };
            let mut index = 0;
            for (a, b) in low.iter_mut().zip(high) {
                let difference = *a - *b;
                *a += *b;
                *b = FACTORS.get(index).map_or(difference, |factor| turn(difference, factor));
                index += POINTS / 2 / half;
            }
        }
    }
    let mut ordered = points;
    for (index, point) in (0u32..).zip(&points) {
        let place = index.reverse_bits() >> (32 - POINTS.trailing_zeros());
        if let Some(cell) = ordered.get_mut(place as usize) {
            *cell = *point;
        }
    }
    ordered
}

fn turn(x: Complex<i32>, &[cos, sin]: &[i32; 2]) -> Complex<i32> {
    let times = |x: i32, w: i32| i64::from(x) * i64::from(w);
    let re = times(x.re, cos) - times(x.im, sin);
    let im = times(x.re, sin) + times(x.im, cos);
    Complex::new(((re + HALF) >> 30) as i32, ((im + HALF) >> 30) as i32)
}

const HALF: i64 = 1 << 29;

/// `exp(-j 2 pi k / 32)` in Q30, k = 0..16.
const FACTORS: [[i32; 2]; POINTS / 2] = factors();

// Const functions cannot use `get_mut`; an index out of range would be a compile error.
#[allow(clippy::indexing_slicing)]
const fn factors() -> [[i32; 2]; POINTS / 2] {
    let mut table = [[0; 2]; POINTS / 2];
    let mut k = 0;
    while k < POINTS / 2 {
        let (sin, cos) = super::fft::twiddle::sin_cos(k, POINTS);
        table[k] = [q30(cos), q30(-sin)];
        k += 1;
    }
    table
}

const fn q30(x: f64) -> i32 {
    let scaled = x * 1_073_741_824.0;
    (if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 }) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acquire::sample::{Iq, Real};
    use crate::scalar::Scalar;

    /// The definition in the module's text, in f64.
    fn exact<const N: usize>(x: &[Complex<f64>], centre: i32, i: i32) -> Complex<f64> {
        let length = N / POINTS;
        let mut sum = Complex::new(0.0, 0.0);
        for (index, x) in x.iter().enumerate() {
            let (m, n) = (index / length, index % length);
            let turns = f64::from(centre) * n as f64 / N as f64
                + f64::from(centre + i) * m as f64 / POINTS as f64;
            sum += x * f64::unit(-turns.fract());
        }
        sum
    }

    fn check<R: Record, const N: usize>(centre: i32) {
        let tone = |n: usize| {
            let z = f64::unit((f64::from(centre) + 0.3) * n as f64 / N as f64 % 1.0) * 1900.0;
            Complex::new(z.re.round(), if R::IQ { z.im.round() } else { 0.0 })
        };
        let x: std::vec::Vec<_> = (0..N).map(tone).collect();
        let samples = core::array::from_fn(|n| R::of_parts([x[n].re as i16, x[n].im as i16]));
        let zoom = Oscillator::new(centre, N).zoom::<R, N>(&samples, Codes::Signed12);
        for i in -8..=8 {
            let got = zoom.bin(centre + i);
            let got = Complex::new(f64::from(got.re), f64::from(got.im)) * f64::from(zoom.unit());
            let error = (got - exact::<N>(&x, centre, i)).norm_sqr().sqrt();
            assert!(error < 1900.0 * N as f64 * 1e-4, "N {N}, centre {centre}, {i}: {error}");
        }
    }

    #[test]
    fn bins_are_those_of_the_definition() {
        for centre in [9, 20, 25] {
            check::<Real, 64>(centre);
            check::<Iq, 64>(centre);
        }
        for centre in [12, 100, 490] {
            check::<Real, 1024>(centre);
            check::<Iq, 1024>(-centre);
        }
        check::<Real, 4096>(1000);
        check::<Iq, 4096>(-1000);
    }

    #[test]
    fn rails_do_not_overflow() {
        let samples = [-32768i16; 4096];
        let zoom = Oscillator::new(16, 4096).zoom::<Real, 4096>(&samples, Codes::Signed16);
        // All of it in bin 0, within the largest part.
        assert!(zoom.bin(0).re.unsigned_abs() < 1 << 31);
        assert!(zoom.bin(0).norm_sqr_wide().sqrt() * f64::from(zoom.unit()) > 8e7);
    }

    trait Wide {
        fn norm_sqr_wide(&self) -> f64;
    }
    impl Wide for Complex<i32> {
        fn norm_sqr_wide(&self) -> f64 {
            f64::from(self.re).powi(2) + f64::from(self.im).powi(2)
        }
    }
}
