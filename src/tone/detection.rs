//! Decides whether a peak is a tone, or the largest of many bins of noise.
//!
//! The power of a bin of noise is exponentially distributed. So the largest of M bins exceeds T times the mean of `m` other bins with the
//! probability `pfa`:
//!
//! ```text
//! pfa = M (1 + T / m)^-m        T = m ((M / pfa)^(1/m) - 1)
//! ```
//!
//! This is the threshold of a detector with a constant false-alarm rate by cell averaging (Finn and Johnson 1968). A noise estimate of F
//! degrees of freedom counts as `m = F / 2` bins.
//!
//! Noise is seldom white, and which bins are as loud as the line's own is not known: [`close_detection`](super::close_detection) weighs
//! how far they reach. Most lines are far above all noise near them or below the threshold in any noise, and need no weighing.

use super::close_detection::{Residual, Shell, WIDTH, beside};
use super::fit::{Fit, Model, take_around};
use super::measure::Options;
use super::noise::ring::LocalNoise;
use super::observer::Observer;
use crate::acquire::sample::Record;
use crate::math::scalar::Scalar as _;
use crate::spectrum::bins::REACH;
use crate::spectrum::neighbourhood::Neighbourhood;
use crate::spectrum::peak::{Peak, SKIRT};
use core::f32::consts::LN_2;
use num_complex::Complex;

/// The probability per block that noise alone passes for a tone.
pub const FALSE_ALARM: f64 = 1e-6;

/// The false-alarm probability at a frequency where a tone is known to be. It is larger, so that a weak tone is not lost early.
pub const HOLD: f64 = 1e-2;

/// The least number of bins away from the peak that make a floor: fewer hold the tone's own leakage. The shortest I/Q record has this
/// number: all bins but the peak with its skirt, and the offset.
const FLOOR: u32 = 64 - (2 * SKIRT as u32 + 1) - 1;

/// log2 of the factor by which the false-alarm probability may rise, because other tests must pass as well.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Relaxation(u32);

impl Relaxation {
    /// A factor of 1.
    pub const NOTHING: Self = Self(0);
    /// A factor of 256.
    pub const SOME: Self = Self(8);
    /// A factor of 1024.
    pub const MOST: Self = Self(10);
}

/// The detection threshold of a band.
///
/// The power of a bin of noise is exponentially distributed. Its ratio to the mean of `m` other bins exceeds T with probability
/// `(1 + T/m)^-m`; the largest of M bins does so with M times this probability. Hence `T = m ((M / pfa)^(1/m) - 1) = m (exp(L/m) - 1)`,
/// `L = ln(M / pfa)`; L alone would raise 1.5 to 2.5 times as many false alarms at N = 256.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// L.
    log: f32,
    /// M.
    bins: f32,
    /// The addition to L for a power between the bins, see [`Threshold::of_line`].
    between: f32,
}

impl Threshold {
    /// A threshold that everything passes.
    pub const ZERO: Self = Self { log: 0.0, bins: 1.0, between: 0.0 };

    /// The threshold for a search of `bins` bins with this false-alarm probability, held to 1e-30..=0.5.
    pub const fn new(bins: u32, false_alarm: f64) -> Self {
        // `max` returns the number if the other is NaN.
        let pfa = false_alarm.max(1e-30).min(0.5);
        let bins = if bins == 0 { 1 } else { bins };
        let needed = log(bins as f64 / pfa);
        let crossings = core::f64::consts::FRAC_PI_3 * needed;
        let between = if crossings > 1.0 { 0.5 * log(crossings) as f32 } else { 0.0 };
        Self { log: needed as f32, bins: bins as f32, between }
    }

    /// The power of a line that a fit found at a peak, in units of the peak's, and the threshold for it. The record has
    /// `n` samples.
    ///
    /// A line half a bin off leaves four tenths of its power in its bin: the fit finds the rest. But the spectrum of noise of power 1 rises
    /// above T `sqrt(pi T / 3) exp(-T)` times a bin (Rice 1945; the variance of the time within a record is a twelfth of its square), where
    /// a bin is above T with probability `exp(-T)`. So the threshold is higher. Near an end of a real spectrum, where noise fits too well,
    /// the power is the bin's.
    #[inline(always)]
    pub fn of_line(self, line: f32, peak: &Peak, n: usize, iq: bool) -> (f32, Self) {
        /// The largest ratio of a line's power to its bin's: half a bin off, `(pi/2)^2`.
        const MOST: f32 = 2.4674;
        let bin = peak.power[1] as f32;
        if !iq && !(4..n as i32 / 2 - 4).contains(&peak.bin) {
            return (bin, self);
        }
        (line.max(bin).min(MOST * bin), self.between())
    }

    /// The threshold for a power that a fit finds between the bins, see [`Threshold::of_line`].
    pub(crate) fn between(self) -> Self {
        Self { log: self.log + self.between, between: 0.0, ..self }
    }

    /// The ratio by which a peak must exceed the mean of `floor_bins` other bins; infinite for 0 bins.
    pub fn over(&self, floor_bins: u32) -> f32 {
        if floor_bins == 0 {
            return f32::INFINITY;
        }
        let m = floor_bins as f32;
        m * raised(self.log / m)
    }

    /// True if a peak with this ratio to the noise near it is a tone by far, so that no
    /// exponential is needed.
    pub fn is_far_above(&self, ratio: f32) -> bool {
        ratio > self.far_above()
    }

    /// The limit of [`Threshold::is_far_above`].
    pub(crate) fn far_above(&self) -> f32 {
        4.0 * self.log
    }

    /// The ratio to exactly known noise below which no search of so many bins or more finds a tone.
    pub(super) fn least_of(&self, bins: f32) -> f32 {
        self.log - (self.bins / bins).max(1.0).log_e()
    }

    /// The natural logarithm of the false-alarm probability, and the number of bins searched.
    pub(super) fn parts(&self) -> (f32, f32) {
        (self.bins.log_e() - self.log, self.bins)
    }

    /// The ratio to exactly known noise above which a peak is a tone.
    pub(crate) fn least_power(&self) -> f32 {
        self.log
    }

    /// True if a peak with this ratio to the noise near it is a tone. `dof`: degrees of freedom of the noise estimate. `less` relaxes
    /// the threshold.
    pub fn detects_beside(&self, ratio: f32, dof: f32, less: Relaxation) -> bool {
        ratio > self.beside(dof, less)
    }

    /// The limit of [`Threshold::detects_beside`].
    #[inline(always)]
    pub fn beside(&self, dof: f32, less: Relaxation) -> f32 {
        let m = dof * 0.5;
        m * raised((self.log - less.0 as f32 * LN_2).max(0.0) / m)
    }

    /// Whether a band has enough bins away from its peak to separate noise from tones.
    pub const fn has_floor(peak: &Peak) -> bool {
        peak.floor_bins >= FLOOR
    }

    /// True if the peak is a tone. A floor of zero, as of a signal without any noise, detects.
    ///
    /// The floor includes the leakage of a strong tone. It belongs in this decision, but not in sigma.
    ///
    /// A band too narrow for a floor leaves the decision to [`Threshold::detects_beside`].
    pub fn detects(&self, peak: &Peak) -> bool {
        self.detects_line(peak.power[1] as f32, peak)
    }

    /// True if a line of this power, in units of the peak's, is a tone, see [`Threshold::of_line`].
    #[inline(always)]
    pub fn detects_line(&self, power: f32, peak: &Peak) -> bool {
        if !Self::has_floor(peak) {
            return true;
        }
        let (bins, floor) = (peak.floor_bins as f32, peak.floor as f32);
        let power = power * bins;
        power > self.over(peak.floor_bins) * floor
    }
}

/// Tests whether the line at a peak is more than noise. Returns the factor by which sigma must grow because noise may have raised the line,
/// or `None` if the line is not detected.
pub(super) fn stands_out<R: Record, const N: usize>(
    near: &Neighbourhood,
    peak: &Peak,
    fit: &Fit<f32>,
    beside: &LocalNoise,
    options: &Options,
    observer: impl Observer,
) -> Option<f32> {
    let unit = f32::two_to(2 * near.exponent);
    let (line, threshold) = (fit.line.norm_sqr() / unit, options.threshold);
    let (power, threshold) = threshold.of_line(line, peak, N, R::IQ);
    let spread = Spread::from_fit(fit, peak.bin, N, R::IQ);
    let detector =
        Detector { n: N, iq: R::IQ, peak: peak.bin, threshold, power: power * unit, spread };
    let floor = if Threshold::has_floor(peak) {
        Shell::floor(peak.floor as f32 * unit / peak.floor_bins.max(1) as f32, peak.floor_bins)
    } else {
        Shell::NONE
    };
    if let Some(decided) = detector.decided(beside, &floor, observer) {
        return decided.then_some(1.0);
    }
    let residual = residual_beside::<R, N>(near, fit);
    let detects = detector.is_improbable(&residual, beside, floor, observer);
    detects.then(|| detector.selection(beside.noise.power))
}

/// The residual of a fit 3 to 16 bins from its peak.
#[inline(never)]
fn residual_beside<R: Record, const N: usize>(near: &Neighbourhood, fit: &Fit<f32>) -> Residual {
    let (peak, unit) = (near.peak, near.unit());
    let mut bins = [Complex::new(0.0, 0.0); WIDTH];
    for (bin, &[re, im]) in bins.iter_mut().zip(near.within(REACH)) {
        *bin = Complex::new(re as f32 * unit, im as f32 * unit);
    }
    take_around::<R, N>(&Model::new(fit, peak, N as i32), peak, &mut bins);
    Residual::from_bins(&bins, R::IQ, N, peak)
}

/// A line, with the noise near it. Compiled once for all kinds and lengths of records.
pub(super) struct Detector {
    /// The samples of a record.
    pub n: usize,
    pub iq: bool,
    /// The line's bin.
    pub peak: i32,
    pub threshold: Threshold,
    /// The line's power, and the residual power near the line.
    pub power: f32,
    pub spread: Spread,
}

/// The residual power near a tone.
pub(super) struct Spread {
    /// The least of the mean residuals 3 to 4, 5 to 8 and 9 to 16 bins away.
    pub least: f32,
    /// The median of the mean residuals 3 to 4, 5 to 8 and 9 to 16 bins away, because another line may be in one of the groups.
    pub middle: f32,
}

impl Spread {
    /// The residuals of the fit at a peak of a record of `n` samples.
    #[inline(always)]
    pub(super) fn from_fit(fit: &Fit<f32>, peak: i32, n: usize, iq: bool) -> Self {
        let [two, four, eight] = fit.rest.within;
        let last = n as i32 / 2 - 1;
        let inside = iq || (17..last - 16).contains(&peak);
        let shares = if inside {
            [0.25, 0.125, 0.0625]
        } else {
            beside(peak - 1, last - peak).map(|bins| 1.0 / bins)
        };
        let [near, middle, far] = [four - two, eight - four, fit.residual - eight];
        let [a, b, c] = [near * shares[0], middle * shares[1], far * shares[2]];
        let (least, most) = ordered(a, b);
        let (least, middle) = if c > 0.0 {
            (ordered(least, c).0, ordered(ordered(most, c).0, least).1)
        } else {
            (least, most)
        };
        Self { least, middle }
    }
}

/// Two numbers, the smaller one first. `min` and `max` would test for NaN as well.
fn ordered(a: f32, b: f32) -> (f32, f32) {
    if a < b { (a, b) } else { (b, a) }
}

/// `exp(x) - 1` for x >= 0: by the series up to 1/8, by squaring above.
fn raised(x: f32) -> f32 {
    let (mut small, mut squarings) = (x.min(100.0), 0);
    while small > 0.125 {
        small *= 0.5;
        squarings += 1;
    }
    let series = 1.0 + small * (0.25 + small * (1.0 / 20.0));
    let mut y = small * (1.0 + small * (0.5 + small * (1.0 / 6.0) * series));
    for _ in 0..squarings {
        y *= y + 2.0;
    }
    y
}

/// The natural logarithm of a positive, normal number, within 1e-9. It can run at compile time.
const fn log(x: f64) -> f64 {
    // x = 2^power m with m within 1..2; ln m = 2 artanh((m - 1)/(m + 1)), whose argument is below 1/3.
    let power = (x.to_bits() >> 52) as i32 - 1023;
    let m = f64::from_bits(x.to_bits() & 0xf_ffff_ffff_ffff | 1023 << 52);
    let z = (m - 1.0) / (m + 1.0);
    let (mut series, mut k) = (0.0, 17);
    while k > 0 {
        series = series * z * z + 1.0 / k as f64;
        k -= 2;
    }
    power as f64 * core::f64::consts::LN_2 + 2.0 * z * series
}

#[cfg(test)]
mod tests {
    #[test]
    fn exponentials() {
        for x in [0.0, 1e-4, 0.02, 0.124, 0.126, 0.5, 1.0, 3.0, 20.0, 80.0] {
            let ratio = super::raised(x) / libm::expm1f(x);
            assert!(x == 0.0 || (ratio - 1.0).abs() < 2e-5, "{x}: {ratio}");
        }
        assert_eq!(super::raised(f32::INFINITY), f32::INFINITY);
    }

    #[test]
    fn logarithms() {
        for x in [1e-30, 0.4, 1.0, 1.999, 2.0, 3.5, 511e6, 4096e30] {
            let error = super::log(x) - libm::log(x);
            assert!(error.abs() <= 1e-9, "{x}: {error:e}");
        }
    }
}
