//! How strong the noise is: the power that the fitted tone leaves in bins all over the spectrum.
//!
//! Every bin of a tone is a constant (I/Q), or a constant and a turning one (real), over a factor
//! that vanishes at the tone. Multiplied by that factor the residual needs no division, and a bin near
//! the tone, where any misfit would show, hardly counts:
//!
//! ```text
//! I/Q   w_k = 1 - exp(j 2 pi (f - k)/N)             noise N = sum |X_k w_k - G|^2 / sum |w_k|^2
//! real  w_k = cos(2 pi k/N) - cos(2 pi f/N)         noise N = sum |X_k w_k - U - V exp(j 2 pi k/N)|^2 / sum w_k^2
//! ```
//!
//! over every s-th bin, DC left out. The sums of weights are known: `2 N' - 2 + 2 cos(2 pi f/N)`
//! and `N'/4 - 1 + (N'/2 - 1) cos^2(2 pi f/N)` with N' = N/s. Total power less the tone's does not
//! work (33 dB off at 60 dB), nor does the rest of the fit's own bins (few, and worst where the fit is).
//!
//! Measured at 255 bins: standard deviation 0.38 dB, no bias; 127 bins 0.54 dB.
//!
//! # Long records
//!
//! From 512 points on (see [`Spectrum::points`]) there is a way with a tenth of the operations and none
//! of the fit: second differences of the points, `Z[k-1] - 2 Z[k] + Z[k+1]`. That is Hann's window, under which a
//! line falls by 18 dB an octave: further than an eighth of the record from the tone and its mirror
//! image, where they are taken, it is below -120 dB. White noise of power P for each bin gives them a power
//! of 6 P, and every second one is nearly independent: 128 of them spread 0.39 dB. Integers
//! throughout, so the same for both arithmetics.
//!
//! There may be other lines, an interferer outside the searched band or another target: they are not noise. So the differences are
//! summed stretch by stretch of the spectrum, mostly four or five, and one is left out while it is more than twice as loud as the mean
//! of the others: lines in two of four are. Weak ones stay, for they may be what a converter makes of the tone itself, and that leaks
//! into the fit's bins, too.

use super::least_squares::Fit;
use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use crate::math::series::circle;
use crate::spectrum::Spectrum;
use crate::spectrum::engine::Engine;
use heapless::Vec;
use num_complex::Complex;

/// How many bins the default noise estimate reads, at most. Half as many cost half the time and spread
/// 1.4 times as far.
pub const NOISE_BINS: usize = 255;

/// The least noise a converter has: its own rounding, one twelfth of a squared code for each part.
pub(crate) const ROUNDING: f64 = 1.0 / 12.0;

/// The noise power per sample (I/Q: of both parts together), in squared codes, from at most `BINS` bins.
/// Not below the rounding of the converter. Cost: about 12 multiplications a bin.
pub fn power<T: Scalar, R: Record, const N: usize, const BINS: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: i32,
    fit: &Fit<T>,
) -> T {
    if long::<R, N>() {
        return differences::<T, R, N, BINS>(spectrum, peak);
    }
    let unit = T::two_to(spectrum.exponent());
    let stride = stride::<R, N, BINS>() as i32;
    let (residual, weight) = if R::IQ {
        iq(spectrum, peak, fit, stride, unit)
    } else {
        real(spectrum, peak, fit, stride, unit)
    };
    let n = T::of_i32(N as i32);
    let parts = if R::IQ { 2.0 } else { 1.0 };
    (residual / weight / n * unit * unit).max(T::of(ROUNDING * parts))
}

/// Every how manieth bin the estimate reads: a power of two.
pub(crate) const fn stride<R: Record, const N: usize, const BINS: usize>() -> usize {
    let (bins, wanted) = (if R::IQ { N } else { N / 2 }, BINS.saturating_add(1));
    let mut stride = 1;
    while bins > stride * wanted && stride < N {
        stride *= 2;
    }
    stride
}

/// True where the noise comes from second differences.
pub(crate) const fn long<R: Record, const N: usize>() -> bool {
    N >= if R::IQ { 512 } else { 1024 }
}

/// How many real numbers the estimate is an average of, or as good as.
pub const fn freedom<R: Record, const N: usize, const BINS: usize>() -> u32 {
    // Neighbours among every second difference have a correlation of 1/6, their powers of 1/36.
    if long::<R, N>() { BINS as u32 * 36 / 38 } else { 2 * count::<R, N, BINS>() as u32 }
}

/// The noise power from about `BINS / 2` second differences, see the module.
pub(crate) fn differences<T: Scalar, R: Record, const N: usize, const BINS: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: i32,
) -> T {
    /// Bins on each side of DC that a slow drift may have reached.
    const DRIFT: usize = 4;
    let points = spectrum.points();
    let length = points.len();
    let apart = length / 8;
    // What is 42 dB weaker than the tone and less may be its own distortion.
    let least = spectrum.power(peak) >> 14;
    let peak = (peak.rem_euclid(N as i32) as usize).min(length);
    let (first, last) = (DRIFT, length - DRIFT);
    let ranges = if R::IQ {
        // The spectrum is a circle: the tone is near again one turn on.
        [
            (first.max((peak + apart).saturating_sub(length)), peak.saturating_sub(apart)),
            (peak + apart, last.min(length + peak - apart)),
            (last, last),
        ]
    } else {
        let (near, far) = (peak.min(length - peak), peak.max(length - peak));
        [
            (first, near.saturating_sub(apart)),
            (near + apart, far.saturating_sub(apart)),
            (far + apart, last),
        ]
    };
    let ranges = ranges.map(|(low, high)| points.get(low..high).unwrap_or(&[]));
    let available: usize = ranges.iter().map(|range| range.len()).sum();
    // Not fewer than the accuracy wants, but where there are more of them not many more.
    let stride = (available / (BINS / 2 - BINS / 32).max(1)).max(2);
    let mut stretches = Vec::new();
    let all =
        sums(ranges, stride, BINS.div_ceil(8), |part| spectrum.bend(part, stride), &mut stretches);
    let (sum, count) = without_lines(&mut stretches, all, least);
    // Halves were summed: of 6 P a quarter, and P is N times the power of a sample.
    let scale = T::two_to(2 * spectrum.exponent() + 1 - N.trailing_zeros() as i32);
    let parts = if R::IQ { 2.0 } else { 1.0 };
    (T::of_u64(sum) / T::of_i32(3 * count.max(1) as i32) * scale).max(T::of(ROUNDING * parts))
}

/// A sum of second differences, and of how many.
type Stretch = (u64, usize);

/// What `bend` sums over every `stride`-th second difference of these ranges, in stretches of `each` differences or up to twice
/// as many; the sum of all.
#[inline(always)]
fn sums<P>(
    ranges: [&[P]; 3],
    stride: usize,
    each: usize,
    bend: impl Fn(&[P]) -> u64,
    stretches: &mut Vec<Stretch, 12>,
) -> Stretch {
    let (mut total, mut count) = (0u64, 0);
    for range in &ranges {
        let mut left = range.len().saturating_sub(2).div_ceil(stride.max(1));
        let mut rest = *range;
        while left > 0 {
            // The last one takes what is over.
            let taken = if left < 2 * each { left } else { each };
            let sum = bend(rest.get(..(taken - 1) * stride + 3).unwrap_or(rest));
            rest = rest.get(taken * stride..).unwrap_or(&[]);
            (total, count, left) = (total.wrapping_add(sum), count + taken, left - taken);
            // There is room: no more than eight are wanted, and one more in each range.
            let _ = stretches.push((sum, taken));
        }
    }
    (total, count)
}

/// How many stretches are left out at most.
const MOST: usize = 4;

/// The sum of all stretches but those beyond `least` that are more than twice as loud as the mean of the others: so is one of
/// noise in a record of fifty.
fn without_lines(stretches: &mut [Stretch], all: Stretch, least: u64) -> Stretch {
    let (mut total, mut count) = all;
    // In 24 bits, so that a product with a count is in 32.
    let shift = 40u32.saturating_sub(total.leading_zeros());
    for _ in 0..MOST {
        let loudness = (total >> shift) as u32;
        let stands_out = |&(sum, taken): &Stretch| {
            let own = (sum >> shift) as u32;
            let (rest, others) = (loudness.wrapping_sub(own), count.wrapping_sub(taken));
            sum > least && own.wrapping_mul(others as u32) > rest.wrapping_mul(2 * taken as u32)
        };
        let Some(stretch) = stretches.iter_mut().find(|stretch| stands_out(stretch)) else { break };
        (total, count) = (total.wrapping_sub(stretch.0), count.wrapping_sub(stretch.1));
        *stretch = (0, 0);
    }
    (total, count)
}

/// How many bins the estimate reads, but for second differences.
pub const fn count<R: Record, const N: usize, const BINS: usize>() -> usize {
    (if R::IQ { N } else { N / 2 }) / stride::<R, N, BINS>() - 1
}

/// The signal-to-noise ratio per sample, freed of the noise within the fitted amplitude; not negative.
pub fn ratio<T: Scalar, R: Record>(n: usize, amplitude_squared: T, noise: T) -> T {
    let ratio = amplitude_squared / noise;
    let n = T::of_i32(n.max(1) as i32);
    let ratio = if R::IQ { ratio - n.recip() } else { ratio * T::of(0.5) - T::of(2.0) * n.recip() };
    ratio.max(T::zero())
}

/// Residual in stored units and weight of an I/Q record.
fn iq<T: Scalar, R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: i32,
    fit: &Fit<T>,
    stride: i32,
    unit: T,
) -> (T, T) {
    let n = N as i32;
    let z = fit.lever;
    let constant = fit.peak * z * unit.recip();
    // exp(j 2 pi (f - k) / N) = turn.
    let one = Complex::new(T::one(), T::zero());
    let start = (one - z) * circle::<T>(peak, n);
    let back = circle::<T>(-stride, n);
    let mut turn = start * back;
    let mut residual = T::zero();
    let mut k = stride;
    while k < n {
        let x = spectrum.bin(k);
        let rest = Complex::new(T::of_i32(x.re), T::of_i32(x.im)) * (one - turn) - constant;
        residual = residual + rest.norm_sqr();
        turn = turn * back;
        k += stride;
    }
    (residual, T::of_i32(2 * n / stride - 2) + T::of(2.0) * start.re)
}

/// Residual in stored units and weight of a real record.
fn real<T: Scalar, R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: i32,
    fit: &Fit<T>,
    stride: i32,
    unit: T,
) -> (T, T) {
    let n = N as i32;
    let p = fit.lever.re;
    let e = T::of(core::f64::consts::TAU) / T::of_i32(n);
    let Complex { re: cos, im: sin } = circle::<T>(peak, n);
    let cf = cos - sin * e * p;
    let tone = fit.peak * (p * e / unit);
    let (still, turning) = (sin * tone.re - cos * tone.im, tone.im);
    let forward = circle::<T>(stride, n);
    let mut turn = forward;
    let mut residual = T::zero();
    let mut k = stride;
    while k < n / 2 {
        let x = spectrum.bin(k);
        let weight = turn.re - cf;
        let re = T::of_i32(x.re) * weight - still - turning * turn.re;
        let im = T::of_i32(x.im) * weight - turning * turn.im;
        residual = residual + re * re + im * im;
        turn = turn * forward;
        k += stride;
    }
    let half = T::of_i32(n / 2 / stride);
    (residual, half * T::of(0.5) - T::one() + (half - T::one()) * cf * cf)
}
