//! From samples to a few complex bins around the strongest line.

pub mod band;
pub mod bins;
pub mod engine;
pub mod fft;
pub mod layout;
pub mod neighbourhood;
mod pairs;
pub mod peak;
pub mod scan;
pub mod view;
pub mod zoom;
#[cfg(dsp)]
mod zoom_dsp;

use crate::acquire::codes::Codes;
use crate::acquire::sample::{Cells as _, Real, Record};
use engine::{Engine, I32};
use layout::Layout;
use num_complex::Complex;
use view::View;

/// The spectrum of one record of `N` samples.
///
/// Real records have bins `0..=N/2`, I/Q records `0..N`. A bin's value times `2^exponent` is the
/// discrete Fourier transform in ADC codes, unscaled: a real tone of amplitude `A` has a line of
/// `A N / 2`.
///
/// The spectrum stores the points of the complex transform. For I/Q these are the bins. For real records they are the transform of N/2
/// pairs of neighbours, and each bin is split from the points when it is read. The engine decides the format of the numbers (see
/// [`engine`]).
#[derive(Clone)]
pub struct Spectrum<R: Record, const N: usize, E: Engine = I32> {
    cells: Aligned<R::Cells<E::Part, N>>,
    exponent: i32,
}

/// The alignment lets kernels read and write whole words.
#[derive(Clone)]
#[repr(align(4))]
struct Aligned<T>(T);

/// Without its points.
impl<R: Record, const N: usize, E: Engine> core::fmt::Debug for Spectrum<R, N, E> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Spectrum").field("exponent", &self.exponent).finish_non_exhaustive()
    }
}

impl<R: Record, const N: usize, E: Engine> Default for Spectrum<R, N, E> {
    fn default() -> Self {
        Self::new()
    }
}

impl<R: Record, const N: usize, E: Engine> Spectrum<R, N, E> {
    /// Work memory for a record of `N` samples; [`Spectrum::transform`] fills it.
    ///
    /// The function compiles only for the lengths that the FFT supports: 64, 128, ... 4096.
    pub const fn new() -> Self {
        let _ = Layout::of::<R, N>();
        Self { cells: Aligned(R::Cells::<E::Part, N>::ZERO), exponent: 0 }
    }

    /// Transforms `samples` by the engine. Cost: `host-tests/budget.json` has the instructions.
    pub fn transform(&mut self, samples: &[R::Sample; N], codes: Codes) {
        let points = self.cells.0.points_mut();
        self.exponent = E::transform::<R, N>(R::pairs(samples), codes, points);
    }

    /// [`Spectrum::transform`] by its definition in portable code, on any core. Tests compare
    /// kernels with it.
    pub fn transform_portably(&mut self, samples: &[R::Sample; N], codes: Codes) {
        let points = self.cells.0.points_mut();
        self.exponent = E::transform_portably::<R, N>(R::pairs(samples), codes, points);
    }

    /// The points of the complex transform: N for an I/Q record, N/2 for a real one.
    pub fn points(&self) -> &[[E::Part; 2]] {
        self.cells.0.points()
    }

    /// The bins, to read.
    #[inline]
    pub fn view(&self) -> View<'_> {
        let (layout, points) = (Layout::of::<R, N>(), E::points(self.points()));
        View { layout, exponent: self.exponent, points }
    }

    /// The number of bins: `N/2 + 1` for real records, `N` for I/Q.
    pub const fn bins(&self) -> usize {
        Layout::of::<R, N>().bins()
    }

    /// The exponent: a stored value times `2^exponent` is in ADC codes.
    pub const fn exponent(&self) -> i32 {
        self.exponent
    }

    /// [`View::bin`].
    pub fn bin(&self, k: i32) -> Complex<i32> {
        self.view().bin(k)
    }

    /// [`View::power`].
    pub fn power(&self, k: i32) -> u64 {
        self.view().power(k)
    }
}

impl<const N: usize> Spectrum<Real, N> {
    /// Replaces the value of bin N/4, which one point holds alone.
    pub(crate) fn put_quarter(&mut self, bin: Complex<i32>) {
        if let Some(point) = self.cells.0.points_mut().get_mut(N / 4) {
            *point = [bin.re, bin.im.wrapping_neg()];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::mem::MaybeUninit;
    use std::println;

    /// A window over an end of a real spectrum, or over both, holds the values of its single bins.
    fn compare<const N: usize>() {
        let (mut spectrum, mut seed) = (Spectrum::<Real, N>::new(), N as u32);
        let samples = core::array::from_fn(|_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 20) as i16 - 2048
        });
        spectrum.transform(&samples, Codes::signed::<12>());
        let n = N as i32;
        for (first, count) in (-n - 3..n + 3).flat_map(|first| [(first, 3), (first, 79)]) {
            let mut places = [MaybeUninit::uninit(); 79];
            let bins = spectrum.view().fill(first, &mut places[..count]);
            let each = (first..).take(count).map(|k| spectrum.bin(k)).map(|x| [x.re, x.im]);
            assert!(bins.iter().copied().eq(each), "N = {N}: {count} bins from {first}");
        }
    }

    #[test]
    fn a_window_over_an_end_is_mirrored() {
        println!("seeds: the lengths");
        compare::<64>();
        compare::<128>();
        compare::<1024>();
        compare::<4096>();
    }
}
