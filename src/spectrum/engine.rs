//! Engines. An engine transforms a record in its own numbers.
//!
//! | engine | numbers | memory for N real samples | signal to error at least, N = 1024: real at 0 / -40 dBFS | I/Q |
//! |---|---|---|---|---|
//! | [`I32`] | `i32`, Q15 factors | 4 N bytes | 90 / 90 dB | 90 / 90 dB |
//! | `F32` | `f32`, by the crate microfft (feature `microfft`) | 4 N bytes | 136 / 115 dB | 136 / 112 dB |
//!
//! A [`Spectrum`](super::Spectrum) names its engine in its type. Code that reads a spectrum reads a [`View`](super::view::View), which is the
//! same type for both engines.

use super::fft;
#[cfg(feature = "microfft")]
use super::fft::float;
use super::fft::integer::{Pair, Point};
use super::view::Points;
use crate::acquire::codes::Codes;
use crate::acquire::sample::{Part, Record};

/// The share of a line's power that the integer transform leaves in other bins: -90 dB.
pub const RESIDUE: f64 = 1e-9;

/// An engine. `points` are the N points of an I/Q record of N samples, which are its bins, or the N/2 points of a real record, from which
/// its bins are read.
pub trait Engine: Copy + core::fmt::Debug + Send + Sync + 'static {
    /// The type of a stored part.
    type Part: Part;

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

    /// The points of a transform by this engine, to read bins from.
    fn points(points: &[[Self::Part; 2]]) -> Points<'_>;
}

/// The default: `i32`, see [`integer`](fft::integer).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct I32;

impl Engine for I32 {
    type Part = i32;
    const CENTRED: bool = false;

    #[inline]
    fn transform<R: Record, const N: usize>(
        pairs: &[Pair],
        codes: Codes,
        points: &mut [Point],
    ) -> i32 {
        fft::transform(const { if R::IQ { N } else { N / 2 } }, pairs, codes.bits(), points)
    }

    #[inline]
    fn transform_portably<R: Record, const N: usize>(
        pairs: &[Pair],
        codes: Codes,
        points: &mut [Point],
    ) -> i32 {
        let length = const { if R::IQ { N } else { N / 2 } };
        fft::transform_portably(length, pairs, codes.bits(), points)
    }

    #[inline]
    fn points(points: &[Point]) -> Points<'_> {
        Points::Integer(points)
    }
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

    fn transform<R: Record, const N: usize>(
        pairs: &[Pair],
        codes: Codes,
        points: &mut [float::Float],
    ) -> i32 {
        float::transform::<R, N>(pairs, codes, points)
    }

    #[inline]
    fn points(points: &[float::Float]) -> Points<'_> {
        Points::Float(points)
    }
}
