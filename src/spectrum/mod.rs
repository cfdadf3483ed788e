//! From samples to a few complex bins around the strongest line.

pub mod bins;
pub mod fft;
pub mod peak;
pub mod sweep;
pub mod zoom;

use crate::acquire::sample::{Cells as _, Codes, Record};
use core::mem::MaybeUninit;
use fft::integer::{Point, split};
use fft::twiddle::splits;
use num_complex::Complex;

/// Calls a transform for the number of points that a record has.
macro_rules! by_length {
    ($record:ident, $n:ident, $transform:path, $arguments:tt) => {{
        use $transform as transform;
        match if $record::IQ { $n } else { $n / 2 } {
            32 => transform::<32> $arguments,
            64 => transform::<64> $arguments,
            128 => transform::<128> $arguments,
            256 => transform::<256> $arguments,
            512 => transform::<512> $arguments,
            1024 => transform::<1024> $arguments,
            2048 => transform::<2048> $arguments,
            _ => transform::<4096> $arguments,
        }
    }};
}

/// The integer spectrum of one record of `N` samples.
///
/// Real records have bins `0..=N/2`, I/Q records `0..N`. A bin's value times
/// `2^exponent` is the discrete Fourier transform in ADC codes, unscaled (a full-scale real tone
/// of amplitude `A` has a line of `A N / 2`).
///
/// What is stored are the points of the complex transform: for I/Q the bins themselves, for real
/// records the transform of N/2 pairs of neighbours, from which each bin is split when it is asked for.
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
        let (pairs, bits, points) = (R::pairs(samples), codes.bits(), self.cells.points_mut());
        self.exponent = by_length!(R, N, fft::transform, (pairs, bits, points));
    }

    /// [`Spectrum::transform`] by its definition in portable code, whatever the core: what kernels are compared
    /// with.
    pub fn transform_portably(&mut self, samples: &[R::Sample; N], codes: Codes) {
        let (pairs, bits, points) = (R::pairs(samples), codes.bits(), self.cells.points_mut());
        self.exponent = by_length!(R, N, fft::integer::transform, (pairs, bits, points));
    }

    /// The points of the complex transform: N of an I/Q record, N/2 of a real one.
    pub fn points(&self) -> &[Point] {
        self.cells.points()
    }

    /// The strongest bin of the whole of a real record but DC and Nyquist, and the power of all.
    pub(crate) fn sweep(&self) -> sweep::Sweep {
        let (points, table) = (self.cells.points(), const { splits(N) });
        by_length!(R, N, fft::sweep, (points, table))
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
        let mirrored = k > N / 2;
        let [re, im] = split(points, const { splits(N) }, if mirrored { N - k } else { k });
        Complex::new(re, if mirrored { im.wrapping_neg() } else { im })
    }

    /// The K bins from `first` on, as [`Spectrum::bin`] numbers them: on a core with the DSP extension a fifth of
    /// the cost of one by one.
    #[inline]
    pub fn window<'a, const K: usize>(
        &self,
        first: i32,
        place: &'a mut MaybeUninit<[Point; K]>,
    ) -> &'a [Point; K] {
        if !R::IQ && first >= 1 && first.saturating_add(K as i32) <= N as i32 / 2 {
            return fft::window(self.points(), const { splits(N) }, first as usize, place);
        }
        place.write(core::array::from_fn(|index| {
            let x = self.bin(first.wrapping_add(index as i32));
            [x.re, x.im]
        }))
    }

    /// `|X[k]|^2` in stored units, as [`Spectrum::bin`] numbers the bins.
    pub fn power(&self, k: i32) -> u64 {
        power(self.bin(k))
    }
}

const ZERO: Complex<i32> = Complex::new(0, 0);

/// `|z|^2` without overflow for any `i32` parts.
pub const fn power(z: Complex<i32>) -> u64 {
    sweep::power([z.re, z.im])
}
