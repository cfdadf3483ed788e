//! From samples to a few complex bins around the strongest line.

pub mod bins;
pub mod fft;
pub mod peak;
pub mod zoom;

use crate::acquire::sample::{Cells as _, Codes, Record};
use num_complex::Complex;

/// The integer spectrum of one record of `N` samples.
///
/// Real records have bins `0..=N/2`, I/Q records `0..N`. A stored value times
/// `2^exponent` is the discrete Fourier transform in ADC codes, unscaled (a full-scale real tone
/// of amplitude `A` has a line of `A N / 2`).
#[derive(Clone, Debug)]
pub struct Spectrum<R: Record, const N: usize> {
    cells: R::Cells<N>,
    exponent: i32,
}

impl<R: Record, const N: usize> Default for Spectrum<R, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<R: Record, const N: usize> Spectrum<R, N> {
    /// Work memory for a record of `N` samples, to be filled by [`Spectrum::transform`].
    ///
    /// Compiles only for the lengths the FFT supports: 64, 128, ... 4096.
    pub const fn new() -> Self {
        const { assert!(fft::twiddle::supported(N), "N must be 64, 128, ... 4096") };
        Self { cells: R::Cells::<N>::ZERO, exponent: 0 }
    }

    /// Transforms `samples` by the integer FFT (see [`fft::integer`]).
    pub fn transform(&mut self, samples: &[R::Sample; N], codes: Codes) {
        self.exponent = if R::IQ {
            fft::integer::complex::<N>(R::pairs(samples), codes.bits(), self.cells.points_mut())
        } else {
            fft::integer::real::<N>(R::pairs(samples), codes.bits(), self.cells.points_mut())
        };
    }

    /// The number of bins: `N/2 + 1` for real records, `N` for I/Q.
    pub const fn bins(&self) -> usize {
        if R::IQ { N } else { N / 2 + 1 }
    }

    /// A stored value times `2^exponent` is in ADC codes.
    pub const fn exponent(&self) -> i32 {
        self.exponent
    }

    /// Bin `k`, which wraps round for I/Q and is mirrored (conjugated) at both ends of a real
    /// spectrum, so that every `k` has a value: `X[-k] = conj X[k]`.
    pub fn bin(&self, k: i32) -> Complex<i32> {
        let points = self.cells.points();
        let k = k.checked_rem_euclid(N as i32).unwrap_or(0) as usize;
        if R::IQ {
            return points.get(k).map_or(ZERO, |p| Complex::new(p[0], p[1]));
        }
        let half = N / 2;
        let (index, mirrored) = if k > half { (N - k, true) } else { (k, false) };
        // Bins 0 and N/2 of a real record are real and share the first cell.
        let Some(&[first, second]) = points.get(index % half) else {
            return ZERO;
        };
        match index {
            0 => Complex::new(first, 0),
            _ if index == half => Complex::new(second, 0),
            _ if mirrored => Complex::new(first, second.wrapping_neg()),
            _ => Complex::new(first, second),
        }
    }

    /// `|X[k]|^2` in stored units, as [`Spectrum::bin`] numbers the bins.
    pub fn power(&self, k: i32) -> u64 {
        power(self.bin(k))
    }
}

const ZERO: Complex<i32> = Complex::new(0, 0);

/// `|z|^2` without overflow for any `i32` parts.
pub const fn power(z: Complex<i32>) -> u64 {
    let (re, im) = (z.re as i64, z.im as i64);
    (re * re) as u64 + (im * im) as u64
}
