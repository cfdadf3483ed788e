//! From a spectrum and its peak to a tone with sigma and verdict.

use super::detection::Threshold;
use super::frequency::Frequency;
use super::least_squares::fixed::quantised;
use super::least_squares::{self, Course, Fit, Reach};
use super::method::Method;
use super::noise::{self, NOISE_BINS};
use super::noise_fixed;
use super::returns::Part;
use super::tone::{Tone, Verdict};
use super::uncertainty::{self, CLIPPED, bound_bins, sigma_bins};
use super::unclipped::Unclipped;
use crate::acquire::codes::Codes;
use crate::acquire::sample::{Record, Stamp};
use crate::math::scalar::Scalar;
use crate::spectrum::Spectrum;
use crate::spectrum::engine::Engine;
use crate::spectrum::peak::Peak;
use fixed::types::I2F30;

/// The arithmetic of least squares and of the noise estimate, after the integer FFT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Arithmetic {
    /// `f32` throughout.
    Float,
    /// Integers in every loop over bins, `f32` once a step.
    Fixed,
}

impl Arithmetic {
    /// Fixed on microcontrollers without a floating-point unit, else float. Each gives the same bits on
    /// every machine; the two differ by less than a tenth of the Cramer-Rao bound.
    pub const fn of_core() -> Self {
        if cfg!(all(target_os = "none", not(target_abi = "eabihf"))) {
            Arithmetic::Fixed
        } else {
            Arithmetic::Float
        }
    }
}

impl Default for Arithmetic {
    /// [`Arithmetic::of_core`].
    fn default() -> Self {
        Self::of_core()
    }
}

/// What the measurement of a tone needs to know besides the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The method of estimation.
    pub method: Method,
    /// How many bins least squares reads.
    pub reach: Reach,
    /// The arithmetic of least squares.
    pub arithmetic: Arithmetic,
    /// How far a peak must stand out.
    pub threshold: Threshold,
}

/// Measures the tone at `peak`, in a record of which `clipped` samples touch a rail of `codes`.
///
/// Least squares gives offset, amplitude and sigma from one fit. Any other method gives the offset alone:
/// the amplitude at that offset follows linearly from nine bins, and sigma is the Cramer-Rao bound of the
/// estimated signal-to-noise ratio times the method's own efficiency, which says nothing of its bias on real
/// samples. The noise estimate is the same for all.
///
/// Where more than 1 % of the samples clip, noise and sigma come from the others (see [`Unclipped`]), whatever the method. Cost
/// beyond that of another record: one pass over the samples.
pub fn measure<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    samples: &[R::Sample; N],
    peak: &Peak,
    codes: Codes,
    clipped: u32,
    stamp: &Stamp,
    options: &Options,
) -> Tone {
    let arithmetic =
        if cfg!(feature = "methods") { options.arithmetic } else { Arithmetic::of_core() };
    let fit = |reach, course| match arithmetic {
        Arithmetic::Float => least_squares::fit_at(spectrum, peak.bin, reach, course),
        Arithmetic::Fixed => least_squares::fixed::fit(spectrum, peak.bin, reach, course),
    };
    let method = options.method;
    let own = method.is_least_squares() || !cfg!(feature = "methods");
    let fit = if own {
        fit(options.reach, Course::Usual)
    } else {
        // A checked plan has no method unfit for its records; a tone of a plan that was not has no offset.
        let offset = method.offset_target(spectrum, samples, peak.bin).unwrap_or_default();
        fit(Reach::Four, Course::From(offset.to_num(), 0))
    };
    let Some(fit) = fit else {
        return Tone::default();
    };
    let noise = match arithmetic {
        Arithmetic::Float => noise::power::<f32, R, N, NOISE_BINS>(spectrum, peak.bin, &fit),
        Arithmetic::Fixed => noise_fixed::power::<R, N, NOISE_BINS>(spectrum, peak.bin, &fit),
    };
    let excess = if own {
        excess_over(&fit, N, noise, noise::freedom::<R, N, NOISE_BINS>() as usize / 2)
    } else {
        1.0
    };
    let clipped = clipped as f32 / N as f32;
    let mut near = noise * excess;
    let mut free = None;
    // The smallest programs do without: their sigma has the coarse allowance.
    if cfg!(feature = "methods") && clipped > CLIPPED {
        free = Unclipped::of_fit(Part::first::<R>(samples), codes, peak.bin, &fit);
        // Where the line is not a single tone, what is left of it in its bins counts.
        if excess == 1.0 {
            near = near_of(&free, &fit, N, clipped, near);
        }
    }
    let sigma = if own {
        sigma_bins(&fit, N, near)
    } else {
        let snr = noise::ratio::<f32, R>(N, fit.amplitude_squared::<R>(N), near);
        method.efficiency() * bound_bins::<R>(N, snr)
    };
    let sigma = if clipped > CLIPPED { widened(&free, sigma, near, clipped) } else { sigma };
    let seen = Seen {
        noise: free.map_or(noise, |free| free.noise),
        excess,
        clipped,
        unresolved: false,
        gap: stamp.gap,
        weak: !options.threshold.detects(peak),
        sigma,
    };
    seen.tone::<R, N>(peak.bin, &fit).unwrap_or_default()
}

// Both once for all kinds and lengths of records.
#[inline(never)]
fn near_of(free: &Option<Unclipped>, fit: &Fit<f32>, n: usize, clipped: f32, noise: f32) -> f32 {
    free.map_or(noise, |free| free.near(residual(fit, n), clipped))
}

#[inline(never)]
fn widened(free: &Option<Unclipped>, sigma: f32, near: f32, clipped: f32) -> f32 {
    match free {
        Some(free) => free.widened(sigma, near),
        None => uncertainty::widened(sigma, clipped),
    }
}

/// What is known of a tone besides its fit.
pub(super) struct Seen {
    /// Noise power per sample.
    pub noise: f32,
    /// See [`excess`].
    pub excess: f32,
    /// The share of the samples that touch a rail.
    pub clipped: f32,
    /// Another tone is too near.
    pub unresolved: bool,
    /// Samples are missing.
    pub gap: bool,
    /// The peak is below the threshold.
    pub weak: bool,
    /// Sigma in bins.
    pub sigma: f32,
}

impl Seen {
    /// The tone with its verdict; `None` where the offset is not a number.
    pub(super) fn tone<R: Record, const N: usize>(
        &self,
        peak: i32,
        fit: &Fit<f32>,
    ) -> Option<Tone> {
        let verdicts = [
            (!R::IQ && near_edge::<N>(peak, fit.offset), Verdict::NearEdge),
            (self.clipped > CLIPPED, Verdict::Clipped),
            (self.excess > 1.0 || self.unresolved, Verdict::Unresolved),
            (self.gap, Verdict::Gap),
            (self.weak, Verdict::Weak),
        ];
        let verdict = verdicts.iter().filter(|v| v.0).map(|v| v.1).max();
        let power = fit.amplitude_squared::<R>(N);
        Some(Tone {
            frequency: Frequency::of_fixed(peak, fixed(fit.offset)?, N),
            sigma: self.sigma / N as f32,
            snr: noise::ratio::<f32, R>(N, power, self.noise),
            amplitude: power.root(),
            verdict: verdict.unwrap_or(Verdict::Good),
            ..Tone::ZERO
        })
    }
}

/// An offset in fixed point; `None` where it is not a number. A fit's is below 1.
fn fixed(offset: f32) -> Option<I2F30> {
    (offset.abs() < 2.0).then(|| I2F30::from_bits(quantised(offset, 30)))
}

/// Within 1.5 bins of DC or Nyquist the mirror image cannot be told from the tone.
fn near_edge<const N: usize>(peak: i32, offset: f32) -> bool {
    if (4..N as i32 / 2 - 4).contains(&peak) {
        return false;
    }
    let f = peak as f32 + offset;
    f < 1.5 || f > (N / 2) as f32 - 1.5
}

/// The noise power per sample that a fit leaves in its own bins.
pub fn residual<T: Scalar>(fit: &Fit<T>, n: usize) -> T {
    fit.residual / expected(fit, n)
}

/// What noise of power 1 per sample leaves in a fit's bins: half its freedom times the power of a bin, `n`.
fn expected<T: Scalar>(fit: &Fit<T>, n: usize) -> T {
    T::of_i32((n as i32 / 2).wrapping_mul(fit.freedom.max(1) as i32))
}

/// How many times the noise power the fit leaves in its own bins, where that is more than one record
/// in 10^6 shows by chance; else 1. Then the line is not a single tone: another is near, or its frequency
/// moves.
pub(super) fn excess<R: Record, const N: usize>(fit: &Fit<f32>, noise: f32) -> f32 {
    excess_over(fit, N, noise, noise::count::<R, N, NOISE_BINS>())
}

/// The same for a record of `n` samples whose noise power per sample comes from `noise_bins` bins.
///
/// The ratio of two estimates of the noise follows Fisher's distribution; its cube root is nearly
/// normal (Wilson and Hilferty 1931). The integer FFT leaves a share of the line itself.
pub fn excess_over<T: Scalar>(fit: &Fit<T>, n: usize, noise: T, noise_bins: usize) -> T {
    const DEVIATIONS: f32 = 5.0;
    const TRANSFORM: f64 = 1e-9;
    let expected = noise * expected(fit, n);
    // No fit has the freedom to make twice the noise improbable.
    if fit.residual <= expected + expected {
        return T::one();
    }
    let rest = fit.residual - T::of(TRANSFORM) * fit.line.norm_sqr();
    let freedom = fit.freedom.max(1) as f32;
    let others = 2.0 * noise_bins as f32;
    let deviation = (2.0 / 9.0 * (1.0 / freedom + 1.0 / others)).root();
    let root = 1.0 + DEVIATIONS * deviation;
    let ratio = rest / expected;
    if ratio > T::of((root * root * root).into()) { ratio } else { T::one() }
}
