//! Engines. An engine transforms a record in its own numbers and reads bins from the stored points.
//!
//! | engine | numbers | memory for N real samples | signal to error at least, N = 1024: real at 0 / -40 dBFS | I/Q |
//! |---|---|---|---|---|
//! | [`I32`] | `i32`, Q15 factors | 4 N bytes | 90 / 90 dB | 90 / 90 dB |
//! | `F32` | `f32`, by the crate microfft (feature `microfft`) | 4 N bytes | 136 / 115 dB | 136 / 112 dB |
//!
//! A [`Spectrum`](super::Spectrum) names its engine in its type. Code that reads a spectrum takes
//! any engine.

#[cfg(feature = "microfft")]
use super::fft::float;
use super::fft::twiddle::{Packed, sines, splits};
use super::fft::{self, integer};
use super::pairs::{self, Pairs};
use super::peak::SKIRT;
use super::scan::{self, Scan, power_sum};
use crate::acquire::codes::Codes;
use crate::acquire::sample::{Part, Record};
use crate::math::products;
use core::convert::identity;
use core::mem::MaybeUninit;
use core::ops::{Range, RangeInclusive};
use integer::{Pair, Point};

/// The share of a line's power that the integer transform leaves in other bins: -90 dB.
pub const RESIDUE: f64 = 1e-9;

/// Calls a transform with the number of points in a record.
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

/// An engine. `points` are the N points of an I/Q record of N samples, which are its bins, or the N/2 points of a real record, from which
/// its bins are read.
pub trait Engine: Copy + core::fmt::Debug + Send + Sync + 'static {
    /// The type of a stored part.
    type Part: Part;

    /// The error in bins that the engine and the fit's `f32` add to the frequency of a strong line, rms over frequencies and phases, for
    /// records of `n` samples. Rounded factors cause most of it: their errors follow the line, and do not show as noise beside it. Measured
    /// against an exact transform: host-tests, `engine_error`.
    fn error(n: usize, iq: bool) -> f32;

    /// Whether the transform first subtracts the middle of unsigned codes, so that bin 0 lacks this offset.
    const CENTRED: bool;

    /// Transforms a record. Returns the exponent of its bins: a stored value times `2^exponent` is in codes.
    fn transform<R: Record, const N: usize>(
        pairs: &[Pair],
        codes: Codes,
        points: &mut [[Self::Part; 2]],
    ) -> i32;

    /// [`Engine::transform`] by its definition in portable code, on any core.
    fn transform_portably<R: Record, const N: usize>(
        pairs: &[Pair],
        codes: Codes,
        points: &mut [[Self::Part; 2]],
    ) -> i32 {
        Self::transform::<R, N>(pairs, codes, points)
    }

    /// Bin k in stored units: k is 0..N of an I/Q record, 0..=N/2 of a real one. The powers of all
    /// bins sum to less than 2^63.
    fn bin<R: Record, const N: usize>(points: &[[Self::Part; 2]], k: usize) -> Point;

    /// Whether each of these bins has less than this power. An engine that splits no bins for the answer may return false without need.
    fn is_below<R: Record, const N: usize>(
        points: &[[Self::Part; 2]],
        mut bins: Range<usize>,
        power: u64,
    ) -> bool {
        bins.all(|k| products::power(Self::bin::<R, N>(points, k)) < power)
    }

    /// The bins of a real record from `first` on, one for each of `places`, all within 1..N/2.
    fn window<'a, R: Record, const N: usize>(
        points: &[[Self::Part; 2]],
        first: usize,
        places: &'a mut [MaybeUninit<Point>],
    ) -> &'a [Point] {
        integer::filled(places, (first..).map(|k| Self::bin::<R, N>(points, k)))
    }

    /// The strongest of these bins, of equals the lowest, and the power of all (see `pairs`). [`Engine::bin`] must accept all of them.
    /// `None` if this engine has no faster way than one bin after the other.
    fn search<R: Record, const N: usize>(
        points: &[[Self::Part; 2]],
        bins: RangeInclusive<usize>,
    ) -> Option<Scan>;

    /// [`Engine::search`] by its definition in portable code.
    fn search_portably<R: Record, const N: usize>(
        _points: &[[Self::Part; 2]],
        _bins: RangeInclusive<usize>,
    ) -> Option<Scan> {
        None
    }
}

/// The error of factors of 16 bits, see [`Engine::error`].
const ROUNDED_FACTORS: f32 = 1.6e-6;

/// Bins on each side of a peak that are not part of the floor.
pub(super) const REACH: usize = SKIRT as usize;

/// The default: `i32`, see [`integer`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct I32;

impl Engine for I32 {
    type Part = i32;
    const CENTRED: bool = false;

    #[inline]
    fn error(n: usize, iq: bool) -> f32 {
        match (n, iq) {
            // Transforms of 2,048 points and more have factors of 32 bits.
            (4096, true) => 7.7e-8,
            (4096, false) | (2048, true) => 1.2e-7,
            (2048, false) => 1.85e-6,
            (_, false) => 1.7e-6,
            (_, true) => ROUNDED_FACTORS,
        }
    }

    fn transform<R: Record, const N: usize>(
        pairs: &[Pair],
        codes: Codes,
        points: &mut [Point],
    ) -> i32 {
        by_length!(R, N, fft::transform, (pairs, codes.bits(), points))
    }

    fn transform_portably<R: Record, const N: usize>(
        pairs: &[Pair],
        codes: Codes,
        points: &mut [Point],
    ) -> i32 {
        by_length!(R, N, integer::transform, (pairs, codes.bits(), points))
    }

    fn bin<R: Record, const N: usize>(points: &[Point], k: usize) -> Point {
        if R::IQ {
            return points.get(k).copied().unwrap_or([0; 2]);
        }
        if const { !sines(N).is_empty() } {
            return integer::split_finely(points, const { sines(N) }, k);
        }
        integer::split(points, const { splits(N) }, k)
    }

    #[inline]
    fn is_below<R: Record, const N: usize>(
        points: &[Point],
        bins: Range<usize>,
        power: u64,
    ) -> bool {
        let (end, length) = (bins.end, points.len().wrapping_add(1));
        let mirrored = length.wrapping_sub(end)..length.wrapping_sub(bins.start);
        let Some(own) = points.get(bins) else { return false };
        if R::IQ {
            return own.iter().all(|&x| products::power(x) < power);
        }
        // A pair of points has the power of both of their bins.
        let (Some(others), least) = (points.get(mirrored), scan::worth(power)) else {
            return false;
        };
        let mut pairs = own.iter().zip(others.iter().rev());
        pairs.all(|(&x, &y)| products::plus_power(products::power(x), y) < least)
    }

    #[inline]
    fn window<'a, R: Record, const N: usize>(
        points: &[Point],
        first: usize,
        places: &'a mut [MaybeUninit<Point>],
    ) -> &'a [Point] {
        if const { !sines(N).is_empty() } {
            return fft::window_finely(points, const { sines(N) }, first, places);
        }
        fft::window(points, const { splits(N) }, first, places)
    }

    #[inline]
    fn search<R: Record, const N: usize>(
        points: &[Point],
        bins: RangeInclusive<usize>,
    ) -> Option<Scan> {
        #[cfg(mve)]
        if R::IQ && bins == (0..=N - 1) {
            return Some(fft::kernel_mve::scan_iq(points));
        }
        if R::IQ {
            let first = *bins.start();
            return Some(scan::over(points.get(bins)?, first, identity));
        }
        let pairs = Pairs::new(points.len(), &bins)?;
        let table = const { splits(N) };
        #[cfg(mve)]
        let (add, alone) =
            (fft::kernel_mve::powers, |bins| fft::kernel_mve::alone(points, table, bins));
        #[cfg(all(dsp, not(mve)))]
        let (add, alone) = (power_sum, |bins| fft::kernel_dsp::alone(points, table, bins));
        #[cfg(not(dsp))]
        let (add, alone) = (power_sum, |bins| alone_portably(points, table, bins));
        let last = pairs.outermost();
        let scan = last.map(|last| by_length!(R, N, fft::scan, (points, table, last)));
        Some(pairs.beside(pairs.with_alone(scan, alone), REACH, points, add, alone))
    }

    fn search_portably<R: Record, const N: usize>(
        points: &[Point],
        bins: RangeInclusive<usize>,
    ) -> Option<Scan> {
        if R::IQ {
            let first = *bins.start();
            return Some(scan::over(points.get(bins)?, first, identity));
        }
        let pairs = Pairs::new(points.len(), &bins)?;
        let table = const { splits(N) };
        let alone = |bins| alone_portably(points, table, bins);
        let last = pairs.outermost();
        let scan = last.map(|last| by_length!(R, N, scan::real, (points, table, last)));
        Some(pairs.beside(pairs.with_alone(scan, alone), REACH, points, power_sum, alone))
    }
}

/// Scans a range of bins within 1..M, each split by itself.
#[cfg_attr(not(dsp), inline(never))] // its loops need all registers
fn alone_portably(points: &[Point], table: &[Packed], bins: Range<usize>) -> Scan {
    pairs::alone(bins, |first, places| integer::window(points, table, first, places))
}

/// Floats, by the crate microfft, for a core with an FPU: see [`float`].
///
/// The crate's code contains panics. At opt-level 3 the compiler proves them unreachable; at "z" it
/// does not. So an image that must be free of panics is built for speed.
#[cfg(feature = "microfft")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct F32;

#[cfg(feature = "microfft")]
impl Engine for F32 {
    type Part = f32;
    const CENTRED: bool = true;

    #[inline]
    fn error(_: usize, _: bool) -> f32 {
        7.3e-8
    }

    fn transform<R: Record, const N: usize>(
        pairs: &[Pair],
        codes: Codes,
        points: &mut [float::Float],
    ) -> i32 {
        float::transform::<R, N>(pairs, codes, points)
    }

    #[inline]
    fn bin<R: Record, const N: usize>(points: &[float::Float], k: usize) -> Point {
        float::bin::<R>(points, k)
    }

    fn window<'a, R: Record, const N: usize>(
        points: &[float::Float],
        first: usize,
        places: &'a mut [MaybeUninit<Point>],
    ) -> &'a [Point] {
        let points = points.get(first..).unwrap_or_default();
        integer::filled(places, points.iter().map(|&point| float::whole(point)))
    }

    #[inline]
    fn search<R: Record, const N: usize>(
        points: &[float::Float],
        bins: RangeInclusive<usize>,
    ) -> Option<Scan> {
        let first = *bins.start();
        // All bins are stored unchanged, except bins 0 and N/2 of a real record.
        let stored = R::IQ || first > 0;
        Some(scan::over(points.get(bins).filter(|_| stored)?, first, float::whole))
    }
}
