//! Estimators that evaluate the transform between the bins, from the samples.
//!
//! Offsets are in bins from the peak, positive upwards, -1..=1; 0 where there is no signal. Valid for a single
//! complex tone at any frequency, or a real one far from DC and Nyquist.

use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use crate::methods::samples::Samples;
use crate::spectrum::bins::{Bins, Rectangular};
use crate::tone::within;
use num_complex::Complex;

/// Samples between two fresh phasors. At 16 the rounding of the recurrence stays below 1e-6 in f32.
const STRIDE: usize = 16;

/// The transform of a record at bin `peak + offset`, `sum x[n] exp(-j 2 pi (peak + offset) n / N)`.
///
/// Horner's rule within 16 samples, then a phasor from the sine and cosine. The peak's share of the phase is reduced in integers, so the
/// transform is as exact at bin 4000 as at bin 1. Cost: 4 N multiplications and N/16 sines and cosines.
pub fn at<T: Scalar, R: Record, S: Samples<T, R> + ?Sized>(
    bins: &Bins<T, R, Rectangular>,
    samples: &S,
    offset: T,
) -> Complex<T> {
    let n = bins.n();
    let step = T::unit(turns(bins, 1, offset));
    let mut sum = Complex::new(T::zero(), T::zero());
    let mut samples = samples.from(0).take(n);
    for block in 0..n.div_ceil(STRIDE) {
        let mut part = Complex::new(T::zero(), T::zero());
        let mut last = (block * STRIDE).wrapping_sub(1);
        for x in samples.by_ref().take(STRIDE) {
            part = part * step + x;
            last = last.wrapping_add(1);
        }
        sum = sum + part * T::unit(-turns(bins, last, offset));
    }
    sum
}

/// The turns of a tone at `peak + offset` in `samples` samples, whole ones left out.
fn turns<T: Scalar, R: Record, W>(bins: &Bins<T, R, W>, samples: usize, offset: T) -> T {
    let n = bins.n() as i64;
    let whole = i64::from(bins.peak()).wrapping_mul(samples as i64).checked_rem_euclid(n);
    let whole = whole.unwrap_or(0);
    // In -N/2..N/2: half a turn has the smaller error.
    let whole = if 2 * whole >= n { whole - n } else { whole };
    (T::from_i32(whole as i32) + offset * T::from_i32(samples as i32)) / bins.length()
}

/// Aboutanios and Mulgrew's estimator (2005, algorithm 1), two iterations:
/// `d += Re{(X(+1/2) + X(-1/2)) / (X(+1/2) - X(-1/2))} / 2` about the last offset.
///
/// Cost beyond the FFT: 16 N multiplications, N/4 sines and cosines, the samples kept. On the bound
/// (1.00 to 1.03) for complex tones.
pub fn aboutanios_mulgrew<T: Scalar, R: Record, S: Samples<T, R> + ?Sized>(
    bins: &Bins<T, R, Rectangular>,
    samples: &S,
) -> T {
    half_step(bins, samples, half_step(bins, samples, T::zero()))
}

fn half_step<T: Scalar, R: Record, S: Samples<T, R> + ?Sized>(
    bins: &Bins<T, R, Rectangular>,
    samples: &S,
    from: T,
) -> T {
    let half = T::new(0.5);
    let upper = at(bins, samples, from + half);
    let lower = at(bins, samples, from - half);
    within(from + half * quotient(upper + lower, upper - lower), T::one())
}

/// HAQSE (Serbes 2019): one step of [`aboutanios_mulgrew`], then one of the q-shift estimator with
/// `q = N^(-1/3)`, `d += Re{(X(+q) - X(-q)) / (X(+q) + X(-q))} / c`,
/// `c = (1 - pi q cot(pi q)) / (q cos^2(pi q))`.
///
/// Cost: that of [`aboutanios_mulgrew`]. On the bound (0.98 to 1.02) for complex tones.
pub fn haqse<T: Scalar, R: Record, S: Samples<T, R> + ?Sized>(
    bins: &Bins<T, R, Rectangular>,
    samples: &S,
) -> T {
    let from = half_step(bins, samples, T::zero());
    let q = inverse_cube_root::<T>(bins.n());
    let half_turn = T::unit(T::new(0.5) * q); // of the angle pi q
    let angle = T::new(core::f64::consts::PI) * q;
    let (sin, cos) = (half_turn.im, half_turn.re);
    let slope = (T::one() - angle * cos / sin) / (q * cos * cos);
    let (upper, lower) = (at(bins, samples, from + q), at(bins, samples, from - q));
    within(from + quotient(upper - lower, upper + lower) / slope, T::one())
}

/// `n^(-1/3)` by Newton's iteration without divisions, from a power of two at most a factor 2 below it.
fn inverse_cube_root<T: Scalar>(n: usize) -> T {
    let n = n.max(1);
    let mut q = T::one() / T::from_i32(1i32.wrapping_shl(n.ilog2() / 3 + 1));
    for _ in 0..8 {
        q = q * (T::new(4.0) - T::from_i32(n as i32) * q * q * q) * T::new(1.0 / 3.0);
    }
    q
}

/// `Re{a / b}`; 0 where the quotient has no value.
fn quotient<T: Scalar>(a: Complex<T>, b: Complex<T>) -> T {
    let power = b.norm_sqr();
    if power > T::zero() { (a * b.conj()).re / power } else { T::zero() }
}

/// I-Rife (after Deng and Liu 2007; a reconstruction, because the papers do not print it whole): the direction from
/// `|X(+1/2)| > |X(-1/2)|`, and where the ratio's offset is below 1/3, the ratio again on a spectrum shifted by 1/3 bin, where the two
/// lines are nearly equal.
///
/// Cost beyond the FFT: 8 N to 16 N multiplications, 2 divisions, 4 roots, the samples kept. 1.01 to 1.06 times
/// the bound on complex tones.
pub fn i_rife<T: Scalar, R: Record, S: Samples<T, R> + ?Sized>(
    bins: &Bins<T, R, Rectangular>,
    samples: &S,
) -> T {
    let [left, centre, right] = bins.three();
    let up = half_bins_say_up(bins, samples);
    let offset = super::rife::ratio(left, centre, right, up);
    if offset.abs() >= third() { offset } else { shifted(bins, samples, up) }
}

/// Dual-threshold Rife (a reconstruction: thresholds 0.15 and 1/3): [`rife`](super::rife::rife) where its offset is at least 1/3; below
/// that the shifted ratio of [`i_rife`], and below 0.15 the direction from the half bins, too.
///
/// Cost beyond the FFT: none to 16 N multiplications, the samples kept. 1.01 to 1.11 times the bound on
/// complex tones.
pub fn dual_threshold_rife<T: Scalar, R: Record, S: Samples<T, R> + ?Sized>(
    bins: &Bins<T, R, Rectangular>,
    samples: &S,
) -> T {
    let offset = super::rife::rife(bins);
    if offset.abs() >= third() {
        return offset;
    }
    let clear = offset.abs() >= T::new(0.15);
    let up = if clear { offset > T::zero() } else { half_bins_say_up(bins, samples) };
    shifted(bins, samples, up)
}

fn third<T: Scalar>() -> T {
    T::new(1.0 / 3.0)
}

fn half_bins_say_up<T: Scalar, R: Record, S: Samples<T, R> + ?Sized>(
    bins: &Bins<T, R, Rectangular>,
    samples: &S,
) -> bool {
    let half = T::new(0.5);
    at(bins, samples, half).norm_sqr() > at(bins, samples, -half).norm_sqr()
}

/// Rife's ratio between the lines at -1/3 and +2/3 bin of the direction.
fn shifted<T: Scalar, R: Record, S: Samples<T, R> + ?Sized>(
    bins: &Bins<T, R, Rectangular>,
    samples: &S,
    up: bool,
) -> T {
    let sign = if up { T::one() } else { -T::one() };
    let near = at(bins, samples, -sign * third()).norm_sqr().root();
    let far = at(bins, samples, sign * (T::one() - third())).norm_sqr().root();
    let sum = near + far;
    if sum <= T::zero() {
        return T::zero();
    }
    sign * (far / sum - third())
}
