//! From samples to a few complex bins around the strongest line.

pub mod bins;
pub mod engine;
pub mod fft;
pub mod neighbourhood;
mod pairs;
pub mod peak;
pub mod scan;
pub mod zoom;
#[cfg(dsp)]
mod zoom_dsp;

use crate::acquire::codes::Codes;
use crate::acquire::sample::{Cells as _, Real, Record};
use crate::math::products;
use core::mem::MaybeUninit;
use core::ops::RangeInclusive;
use engine::{Engine, I32};
use fft::integer::{self, Point};
use num_complex::Complex;
use peak::Band;
use scan::Scan;

/// An offset stands out of its neighbours if it has this many times the power of both. Noise does so in one record of 81: one over the
/// square of this number plus 1.
pub const STANDS_OUT: u64 = 8;

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

/// The samples of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Size {
    /// The number of samples.
    pub n: usize,
    /// Whether the samples are I/Q pairs.
    pub iq: bool,
}

impl Size {
    /// Bins from one to another, round the circle for I/Q.
    #[inline(always)] // a size that is known at compile time leaves little of it
    pub(crate) const fn apart(self, a: i32, b: i32) -> i32 {
        let (apart, n) = (a.wrapping_sub(b), self.n as i32);
        if !self.iq {
            return apart.wrapping_abs();
        }
        let apart = match apart.checked_rem_euclid(n) {
            Some(apart) => apart,
            None => 0,
        };
        if apart < n - apart { apart } else { n - apart }
    }
}

/// The bins of a spectrum of any kind, length and engine. What reads bins here is compiled once for all of them.
pub trait Source {
    /// The record's samples.
    fn size(&self) -> Size;

    /// [`Spectrum::exponent`].
    fn exponent(&self) -> i32;

    /// The error in bins that the engine adds to a frequency, see [`Engine::error`].
    fn error(&self) -> f32;

    /// [`Spectrum::bin`].
    fn bin(&self, k: i32) -> Complex<i32>;

    /// The bins from `first` on, one for each of `places`.
    fn fill<'a>(&self, first: i32, places: &'a mut [MaybeUninit<Point>]) -> &'a [Point];

    /// The bins from `first` on without the offset of an I/Q converter: bin 0 is the mean of its neighbours where it stands out of them. A
    /// tone's leakage is smooth enough, and the mean's second difference is 0.
    fn fill_beside_offset<'a>(
        &self,
        first: i32,
        places: &'a mut [MaybeUninit<Point>],
    ) -> &'a [Point];
}

impl<R: Record, const N: usize, E: Engine> Source for Spectrum<R, N, E> {
    fn size(&self) -> Size {
        Size { n: N, iq: R::IQ }
    }

    fn exponent(&self) -> i32 {
        self.exponent
    }

    fn error(&self) -> f32 {
        E::error(N, R::IQ)
    }

    fn bin(&self, k: i32) -> Complex<i32> {
        Spectrum::bin(self, k)
    }

    fn fill<'a>(&self, first: i32, places: &'a mut [MaybeUninit<Point>]) -> &'a [Point] {
        Spectrum::fill(self, first, places)
    }

    fn fill_beside_offset<'a>(
        &self,
        first: i32,
        places: &'a mut [MaybeUninit<Point>],
    ) -> &'a [Point] {
        Spectrum::fill_beside_offset(self, first, places)
    }
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
        const { assert!(fft::twiddle::supported(N), "N must be 64, 128, ... 4096") };
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

    /// The strongest bin of a band, of equals the lowest, and the total power of the band's bins.
    pub(crate) fn search(&self, band: Band) -> Scan {
        let bins = self.range(band);
        if let Some(scan) = bins.and_then(|bins| E::search::<R, N>(self.points(), bins)) {
            return scan;
        }
        // One window after the other.
        let mut places = [MaybeUninit::uninit(); 17];
        let (mut scan, mut next) = (Scan::from(band.low as usize), band.low);
        let mut left = band.width() as usize;
        while left > 0 {
            let count = left.min(places.len());
            let window = self.fill(next, places.get_mut(..count).unwrap_or_default());
            scan = scan.then(scan::over(window, next as usize, core::convert::identity));
            next = next.wrapping_add(count as i32);
            left -= count;
        }
        scan
    }

    /// [`Spectrum::search`] by its definition in portable code.
    pub(crate) fn search_portably(&self, band: Band) -> Scan {
        let bins = self.range(band);
        if let Some(scan) = bins.and_then(|bins| E::search_portably::<R, N>(self.points(), bins)) {
            return scan;
        }
        (band.low..=band.high).fold(Scan::from(band.low as usize), |mut scan, k| {
            scan.see(k as usize, self.power(k));
            scan
        })
    }

    /// The range of a band's bins, if the band neither wraps round nor is mirrored.
    fn range(&self, band: Band) -> Option<RangeInclusive<usize>> {
        let (low, high) = (usize::try_from(band.low).ok()?, usize::try_from(band.high).ok()?);
        (low <= high && high < self.bins()).then_some(low..=high)
    }

    /// The number of bins: `N/2 + 1` for real records, `N` for I/Q.
    pub const fn bins(&self) -> usize {
        if R::IQ { N } else { N / 2 + 1 }
    }

    /// The exponent: a stored value times `2^exponent` is in ADC codes.
    pub const fn exponent(&self) -> i32 {
        self.exponent
    }

    /// Bin `k` in stored units, for any `k`: an I/Q spectrum wraps round, a real one is mirrored
    /// and conjugated at both ends, `X[-k] = conj X[k]`.
    pub fn bin(&self, k: i32) -> Complex<i32> {
        let (k, mirrored) = Self::held(k);
        let bin = E::bin::<R, N>(self.points(), k);
        let [re, im] = if mirrored { conjugate(bin) } else { bin };
        Complex::new(re, im)
    }

    /// The stored bin for bin `k`, and whether bin `k` is its mirror image.
    #[inline(always)]
    fn held(k: i32) -> (usize, bool) {
        let k = k.checked_rem_euclid(N as i32).unwrap_or(0) as usize;
        let mirrored = !R::IQ && k > N / 2;
        (if mirrored { N - k } else { k }, mirrored)
    }

    /// The K bins from `first` on, numbered as in [`Spectrum::bin`]. On a core with the DSP extension a window costs a fifth of K single
    /// bins.
    #[inline]
    pub fn window<'a, const K: usize>(
        &self,
        first: i32,
        place: &'a mut MaybeUninit<[Point; K]>,
    ) -> &'a [Point] {
        self.fill(first, place.as_mut())
    }

    /// Whether each of `count` bins from `first` on has less than this power, see [`Engine::is_below`].
    #[inline]
    pub(crate) fn is_below(&self, power: u64, first: i32, count: usize) -> bool {
        let first = if R::IQ && first >= N as i32 { first - N as i32 } else { first };
        usize::try_from(first)
            .is_ok_and(|first| E::is_below::<R, N>(self.points(), first..first + count, power))
    }

    /// The bins from `first` on, one for each of `places`.
    pub(crate) fn fill<'a>(&self, first: i32, places: &'a mut [MaybeUninit<Point>]) -> &'a [Point] {
        let end = first.saturating_add(places.len() as i32);
        if !R::IQ && first >= 1 && end <= N as i32 / 2 {
            return E::window::<R, N>(self.points(), first as usize, places);
        }
        // A window with a row of bins between the ends; the mirrored bins are copies of these.
        let row = (first.max(1), end.min(const { N as i32 / 2 }));
        if !R::IQ && row.0 < row.1 {
            return self.fill_mirrored(first, row, places);
        }
        let bin = |index| {
            let Complex { re, im } = self.bin(first.wrapping_add(index));
            [re, im]
        };
        integer::filled(places, (0..).map(bin))
    }

    /// The bins of a real record from `first` on: a row of bins between DC and Nyquist, `from` one `to` another, and copies for the
    /// mirrored bins beyond.
    #[inline(never)] // a window beside no end has a shorter way
    fn fill_mirrored<'a>(
        &self,
        first: i32,
        (from, to): (i32, i32),
        places: &'a mut [MaybeUninit<Point>],
    ) -> &'a [Point] {
        let middle = from.wrapping_sub(first) as usize..to.wrapping_sub(first) as usize;
        let other = |place: usize, row: &[Point]| {
            let k = first.wrapping_add(place as i32);
            let (held, mirrored) = Self::held(k);
            match row.get(held.wrapping_sub(from as usize)) {
                Some(&bin) if mirrored => conjugate(bin),
                Some(&bin) => bin,
                None => {
                    let Complex { re, im } = self.bin(k);
                    [re, im]
                }
            }
        };
        integer::filled_from_middle(
            places,
            middle,
            |places| E::window::<R, N>(self.points(), from as usize, places),
            other,
        )
        .unwrap_or_default()
    }

    /// [`Source::fill_beside_offset`].
    fn fill_beside_offset<'a>(
        &self,
        first: i32,
        places: &'a mut [MaybeUninit<Point>],
    ) -> &'a [Point] {
        if !R::IQ {
            return self.fill(first, places);
        }
        let part = |k: i32| {
            let Complex { re, im } = self.bin(k);
            [re, im]
        };
        let bins = integer::filled(places, (0..).map(|index| part(first.wrapping_add(index))));
        let zero = first.wrapping_neg().rem_euclid(const { N as i32 }) as usize;
        // A short record's window goes round the circle more than once.
        for offset in bins.iter_mut().skip(zero).step_by(N) {
            let beside = [part(-1), part(1)];
            let [below, above] = beside.map(products::power);
            if products::power(*offset) / STANDS_OUT > below.saturating_add(above) {
                let [[a, b], [c, d]] = beside;
                *offset = [(a >> 1).wrapping_add(c >> 1), (b >> 1).wrapping_add(d >> 1)];
            }
        }
        bins
    }

    /// `|X[k]|^2` in stored units, with the bins numbered as in [`Spectrum::bin`].
    pub fn power(&self, k: i32) -> u64 {
        power(self.bin(k))
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

/// `|z|^2`; no `i32` parts overflow it.
pub const fn power(z: Complex<i32>) -> u64 {
    products::power([z.re, z.im])
}

/// The mirror image of a bin.
#[inline(always)]
fn conjugate([re, im]: Point) -> Point {
    [re, im.wrapping_neg()]
}

#[cfg(test)]
mod tests {
    use super::*;
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
            let bins = spectrum.fill(first, &mut places[..count]);
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
