//! The phase of the autocorrelation, and FESA, which chooses between it and Quinn's estimator.
//!
//! All of them need complex samples. On real records they are wrong by 0.2 to 0.5 bin, so they
//! take [`Iq`] only.
//!
//! ```compile_fail,E0308
//! use picket_dsp::acquire::sample::{Real, Iq};
//! use picket_dsp::methods::{autocorrelation::autocorrelation, samples::Raw};
//! use picket_dsp::spectrum::bins::{Bins, Rectangular};
//! fn real(bins: &Bins<f32, Real, Rectangular>, samples: &[i16]) -> f32 {
//!     autocorrelation(bins, &Raw::<Real>(samples))
//! }
//! ```
//!
//! Offsets are in bins from the peak, positive upwards. Without noise the estimators find any offset within half a period of the phase,
//! `N / (2 m)` bins for lag `m`.

use super::quinn::quinn2;
use crate::acquire::sample::Iq;
use crate::math::scalar::Scalar;
use crate::methods::samples::Samples;
use crate::spectrum::bins::{Bins, Rectangular};
use core::f64::consts::PI;
use num_complex::Complex;

/// The autocorrelation's phase at a third of the record (Yang et al. 2011, eq 6 with lag N/3).
///
/// Cost beyond the FFT: 2.7 N multiplications, 1 arc tangent, a sine and cosine, the samples kept. 1.06 times
/// the bound from 20 dB on, 1.5 at 0 dB, 3.8 at -10 dB.
pub fn autocorrelation<T: Scalar, S: Samples<T, Iq> + ?Sized>(
    bins: &Bins<T, Iq, Rectangular>,
    samples: &S,
) -> T {
    let n = bins.n();
    phase(bins, samples, n / 3 + usize::from(n % 3 == 2))
}

/// The autocorrelation's phase at the lag that is best for the signal-to-noise ratio (Yang et al. 2011, eqs 6 and 9, see [`best_lag`]); the
/// ratio comes from [`parseval`](crate::methods::snr::parseval).
///
/// Cost: like [`autocorrelation`], 2 N to 2.7 N multiplications, plus the ratio's 2 N. 1.06 times the bound from 20 dB on, 1.4 at 0 dB, 3.1
/// at -10 dB.
pub fn improved_autocorrelation<T: Scalar, S: Samples<T, Iq> + ?Sized>(
    bins: &Bins<T, Iq, Rectangular>,
    samples: &S,
    snr: T,
) -> T {
    phase(bins, samples, best_lag(snr, bins.n()))
}

/// The lag of least variance by Yang et al. 2011, eq 9: `N (2 S - 5 + sqrt(4 S^2 + 28 S + 1)) / (6 (2 S - 1))`,
/// `N/2` at `S = 0.5`, at most `N/2`, rounded.
///
/// Kept as printed. The formula follows from eq 7, which holds for lags up to N/2 only; over all lags 2N/3 is best at every ratio (see
/// [`fesa_corrected`]).
pub fn best_lag<T: Scalar>(snr: T, n: usize) -> usize {
    let two = T::new(2.0);
    let root = (T::new(4.0) * snr * snr + T::new(28.0) * snr + T::one()).root();
    let below = T::new(6.0) * (two * snr - T::one());
    let length = T::from_i32(n as i32);
    let most = length / two;
    let lag = length * (two * snr - T::new(5.0) + root) / below;
    // Near 0.5 the quotient is 0/0; eq 9 gives its limit.
    let near = (snr - T::new(0.5)).abs() < T::new(1e-9).max(T::epsilon());
    let lag = if near { most } else { lag.min(most) };
    lag.round().to_usize().unwrap_or(1).max(1).min(n.saturating_sub(1).max(1))
}

/// The offset from the phase of `r(m) = sum x[n] conj(x[n - m])`. The peak's own phase, `2 pi peak m / N`, is subtracted in exact integers.
/// The subtraction is the paper's coarse demodulation, without a pass over the samples.
fn phase<T: Scalar, S: Samples<T, Iq> + ?Sized>(
    bins: &Bins<T, Iq, Rectangular>,
    samples: &S,
    lag: usize,
) -> T {
    let zero = Complex::new(T::zero(), T::zero());
    let mut pairs = samples.from(lag).zip(samples.from(0)).take(bins.n());
    let mut sum = zero;
    // Sums of sums: a single f32 sum would lose digits at N = 4096.
    for _ in 0..bins.n().div_ceil(64) {
        sum = sum
            + pairs.by_ref().take(64).fold(zero, |part, (late, early)| part + late * early.conj());
    }
    if sum == zero {
        return T::zero();
    }
    let n = bins.n() as i64;
    let whole = i64::from(bins.peak()).wrapping_mul(lag as i64).checked_rem_euclid(n);
    let turns = T::from_i32(whole.unwrap_or(0) as i32) / bins.length();
    let angle = T::angle(sum * T::unit(-turns));
    bins.length() * angle / (T::new(2.0 * PI) * T::from_i32(lag as i32))
}

/// FESA (Yang et al. 2011, section 3) with the thresholds as printed: below -3.1 dB Quinn's second
/// estimator; up to 16.9 dB Quinn's where its offset is at least 0.2, above that where it is at
/// least 0.4; else [`improved_autocorrelation`].
///
/// Cost: both estimators together, at most 4.7 N multiplications with the ratio's 2 N. 1.06 times the bound at 20 dB, 1.23 at 0 dB, 1.17
/// below. The paper compares a variance ratio with an RMSE ratio (eqs 5 and 10), hence the bump at 0 dB; see [`fesa_corrected`].
///
/// ```compile_fail,E0308
/// use picket_dsp::acquire::sample::{Real, Iq};
/// use picket_dsp::methods::{autocorrelation::fesa, samples::Raw};
/// use picket_dsp::spectrum::bins::{Bins, Rectangular};
/// fn real(bins: &Bins<f32, Real, Rectangular>, samples: &[i16]) -> f32 {
///     fesa(bins, &Raw::<Real>(samples), 1.0)
/// }
/// ```
pub fn fesa<T: Scalar, S: Samples<T, Iq> + ?Sized>(
    bins: &Bins<T, Iq, Rectangular>,
    samples: &S,
    snr: T,
) -> T {
    const LOW: f64 = 0.489_778_819_368_446_14; // -3.1 dB
    const HIGH: f64 = 48.977_881_936_844_61; // 16.9 dB
    let quinn = quinn2(bins);
    let limit = if snr < T::new(LOW) {
        T::zero()
    } else if snr > T::new(HIGH) {
        T::new(0.4)
    } else {
        T::new(0.2)
    };
    if quinn.abs() >= limit { quinn } else { improved_autocorrelation(bins, samples, snr) }
}

/// FESA corrected: lag 2N/3, best at every ratio, and the choice by comparing two variance ratios, the autocorrelation's
/// `1.125 (1 + 1/(2 S))` and Quinn's (eq 5) at its own offset.
///
/// Cost: 1.3 N multiplications and the ratio's 2 N. 1.05 times the bound at 20 dB, 1.16 at 0 dB, 1.17 below.
pub fn fesa_corrected<T: Scalar, S: Samples<T, Iq> + ?Sized>(
    bins: &Bins<T, Iq, Rectangular>,
    samples: &S,
    snr: T,
) -> T {
    let quinn = quinn2(bins);
    let half = T::new(0.5);
    let ours = T::new(1.125) * (T::one() + half / snr);
    if ours < quinn_variance(quinn.max(-half).min(half)) {
        let n = bins.n();
        phase(bins, samples, (2 * n + 1) / 3)
    } else {
        quinn
    }
}

/// Quinn's variance over the bound's at offset `d` (Yang et al. 2011, eq 5, printed there as an RMSE ratio):
/// `pi^4 d^2 (d^2 - 1)^2 (3 d^4 + 1) / (6 (3 d^4 + 6 d^2 + 1) sin^2(pi d))`.
fn quinn_variance<T: Scalar>(d: T) -> T {
    let d = if d.abs() < T::new(1e-4) { T::new(1e-4) } else { d };
    let (d2, one) = (d * d, T::one());
    let d4 = T::new(3.0) * d2 * d2;
    let sin = T::unit(d * T::new(0.5)).im;
    let above = T::new(PI * PI * PI * PI) * d2 * (d2 - one) * (d2 - one) * (d4 + one);
    above / (T::new(6.0) * (d4 + T::new(6.0) * d2 + one) * sin * sin)
}
