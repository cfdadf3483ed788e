//! What the length and the kind of a record fix: the tables of its bins and of the fits. A program links the tables of the layouts it names.

use super::fft::twiddle::{self, Packed, sin_cos};
use crate::acquire::sample::Record;
use core::f64::consts::{PI, TAU};

/// The largest number of bins on each side of the peak.
pub const REACH: usize = 16;

/// The length and the kind of a record, with their tables.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// The number of samples.
    pub n: usize,
    /// Whether the samples are I/Q pairs.
    pub iq: bool,
    /// [`twiddle::splits`].
    pub(super) splits: &'static [Packed],
    /// [`twiddle::sines`].
    pub(super) sines: &'static [i32],
    /// The constants of the fit in floats, of every distance from the peak up to the reach.
    pub(crate) distances: &'static [Distance<f32>; REACH + 1],
    /// The constants of the fit in integers, of the distances 1 up to the reach: of a real record.
    pub(crate) real: &'static [RealDistance],
    /// The same of an I/Q record.
    pub(crate) quadrature: &'static [IqDistance],
}

struct Of<R, const N: usize>(core::marker::PhantomData<R>);

impl<R: Record, const N: usize> Of<R, N> {
    const LAYOUT: Layout = {
        assert!(twiddle::supported(N), "N must be 64, 128, ... 4096");
        Layout {
            n: N,
            iq: R::IQ,
            splits: if R::IQ { &[] } else { twiddle::splits(N) },
            sines: if R::IQ { &[] } else { twiddle::sines(N) },
            distances: const { &distances::<N>() },
            real: if R::IQ { &[] } else { const { &real_distances::<N>() } },
            quadrature: if R::IQ { const { &iq_distances::<N>() } } else { &[] },
        }
    };
}

impl Layout {
    /// The layout of a record of kind `R` and `N` samples. It compiles only for the lengths that the transform supports.
    pub const fn of<R: Record, const N: usize>() -> &'static Self {
        &Of::<R, N>::LAYOUT
    }

    /// The number of bins: `n/2 + 1` for real records, `n` for I/Q.
    #[inline]
    pub const fn bins(&self) -> usize {
        if self.iq { self.n } else { self.n / 2 + 1 }
    }

    /// The binary logarithm of the number of samples.
    #[inline(always)]
    pub(crate) const fn bits(&self) -> u32 {
        self.n.trailing_zeros()
    }

    /// Bins from one to another, round the circle for I/Q.
    #[inline(always)] // a hunt for lines asks it of every bin
    pub(crate) const fn apart(&self, a: i32, b: i32) -> i32 {
        let apart = a.wrapping_sub(b);
        if !self.iq {
            return apart.wrapping_abs();
        }
        let n = self.n as i32;
        let apart = apart & (n - 1);
        if apart < n - apart { apart } else { n - apart }
    }

    /// Bin `k` as one of `0..n`.
    #[inline(always)]
    pub(crate) const fn wrapped(&self, k: i32) -> usize {
        k as usize & (self.n - 1)
    }
}

/// The constants of a bin i bins from the peak for the fit of a real tone, with `e = 2 pi / N`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Distance<T> {
    /// `sin(e i)`
    pub sine: T,
    /// `1 - cos(e i)`
    pub versine: T,
}

/// The constants of a bin `i` bins from the peak of a real record, with `e = 2 pi/N`: `sin(e i)/e` in Q23, `(1 - cos e i)/e^2` in Q22 and
/// `1 - cos e i` in Q26.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RealDistance {
    pub near: i32,
    pub bend: i32,
    pub versine: i32,
}

/// The constants of a distance i of 1..=16 bins of an I/Q record, with `e = pi/N`: `tan(e i)/e` in Q23, `tan(e i)` in Q29, its square in Q29
/// and `cos^2(e i)` in Q26.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IqDistance {
    pub u: i32,
    pub tangent: i32,
    pub square: i32,
    pub inverse_m: i32,
}

/// `x` with this many fractional bits, rounded.
pub(crate) const fn nearest(x: f64, bits: u32) -> i32 {
    (x * (1u64 << bits) as f64 + 0.5) as i32
}

// The compiler evaluates these functions: an index out of range would not compile.

#[allow(clippy::indexing_slicing)]
const fn distances<const N: usize>() -> [Distance<f32>; REACH + 1] {
    let mut table = [Distance { sine: 0.0, versine: 0.0 }; REACH + 1];
    let mut i = 1;
    while i <= REACH {
        // By half the angle, so that 1 - cos does not cancel.
        let (sin, cos) = sin_cos(i, 2 * N);
        table[i] = Distance { sine: (2.0 * sin * cos) as f32, versine: (2.0 * sin * sin) as f32 };
        i += 1;
    }
    table
}

#[allow(clippy::indexing_slicing)]
const fn real_distances<const N: usize>() -> [RealDistance; REACH] {
    let mut table = [RealDistance { near: 0, bend: 0, versine: 0 }; REACH];
    let e = TAU / N as f64;
    let mut i = 1;
    while i <= REACH {
        let (sin, cos) = sin_cos(i, 2 * N);
        let versine = 2.0 * sin * sin;
        table[i - 1] = RealDistance {
            near: nearest(2.0 * sin * cos / e, 23),
            bend: nearest(versine / (e * e), 22),
            versine: nearest(versine, 26),
        };
        i += 1;
    }
    table
}

#[allow(clippy::indexing_slicing)]
const fn iq_distances<const N: usize>() -> [IqDistance; REACH] {
    let mut table = [IqDistance { u: 0, tangent: 0, square: 0, inverse_m: 0 }; REACH];
    let mut i = 1;
    while i <= REACH {
        let (sin, cos) = sin_cos(i, 2 * N);
        let tangent = sin / cos;
        table[i - 1] = IqDistance {
            u: nearest(tangent / (PI / N as f64), 23),
            tangent: nearest(tangent, 29),
            square: nearest(tangent * tangent, 29),
            inverse_m: nearest(cos * cos, 26),
        };
        i += 1;
    }
    table
}
