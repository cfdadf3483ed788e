//! The detection threshold.
//!
//! The power of a bin of noise is exponentially distributed. So the largest of M bins exceeds T times the mean of `m` other bins with the
//! probability `pfa`:
//!
//! ```text
//! pfa = M (1 + T / m)^-m        T = m ((M / pfa)^(1/m) - 1)
//! ```
//!
//! This is the threshold of a detector with a constant false-alarm rate by cell averaging (Finn and Johnson 1968). A noise estimate of F
//! degrees of freedom counts as `m = F / 2` bins. Where several tests must pass together, each may be relaxed ([`Relaxation`]).

use crate::chance::over_mean;
use crate::spectrum::peak::{Peak, SKIRT};
use core::f32::consts::LN_2;

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

    /// The factor for the residual of a fit in a record of `samples`, whose floor is a test, too: as if a single bin had been searched, and
    /// a further 2 in a record that is not short, where a wide ring is another test.
    pub const fn for_residual(samples: usize, short: bool) -> Self {
        let bits = samples.trailing_zeros();
        Self(if short { bits.saturating_sub(1) } else { bits })
    }

    /// A further factor of 8 in a record of more than 2048 samples: over the ring of such a record the noise behind a filter is nearly as
    /// loud everywhere, and more bins need more evidence.
    pub const fn in_record(self, samples: usize) -> Self {
        Self(if samples > 2048 { self.0 + 3 } else { self.0 })
    }
}

/// The detection threshold of a band.
///
/// The power of a bin of noise is exponentially distributed. Its ratio to the mean of `m` other bins exceeds T with probability
/// `(1 + T/m)^-m`; the largest of M bins does so with M times this probability. Hence `T = m ((M / pfa)^(1/m) - 1) = m (exp(L/m) - 1)`,
/// `L = ln(M / pfa)`; L alone would raise 1.5 to 2.5 times as many false alarms at N = 256.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    log: f32,
    /// The logarithm L for the floor alone.
    floor: f32,
    /// The addition to L for a power between the bins, see [`Threshold::of_line`].
    between: f32,
}

impl Threshold {
    /// A threshold that everything passes.
    pub const ZERO: Self = Self { log: 0.0, floor: 0.0, between: 0.0 };

    /// The threshold for a search of `bins` bins with this false-alarm probability, held to 1e-30..=0.5.
    pub const fn new(bins: u32, false_alarm: f64) -> Self {
        // `max` returns the number if the other is NaN.
        let pfa = false_alarm.max(1e-30).min(0.5);
        let bins = if bins == 0 { 1 } else { bins };
        let needed = log(bins as f64 / pfa);
        let crossings = core::f64::consts::FRAC_PI_3 * needed;
        let between = if crossings > 1.0 { 0.5 * log(crossings) as f32 } else { 0.0 };
        let log = needed as f32;
        Self { log, floor: log, between }
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

    /// The threshold for a peak that must also exceed the noise beside it. The ring test rejects 1/7 of the false alarms that the floor
    /// test passes, so the floor test may pass 1/6 more.
    pub const fn with_another(self) -> Self {
        /// `-ln(1 - 1/7)`.
        const REFUSED: f32 = 0.15;
        Self { floor: self.log - REFUSED, ..self }
    }

    /// The threshold for a power that a fit finds between the bins, see [`Threshold::of_line`].
    pub(crate) fn between(self) -> Self {
        let Self { log, floor, between } = self;
        Self { log: log + between, floor: floor + between, between: 0.0 }
    }

    /// The ratio by which a peak must exceed the mean of `floor_bins` other bins; infinite for 0 bins.
    pub fn over(&self, floor_bins: u32) -> f32 {
        if floor_bins == 0 {
            return f32::INFINITY;
        }
        over_mean(self.floor, floor_bins as f32)
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
        over_mean((self.log - less.0 as f32 * LN_2).max(0.0), 0.5 * dof)
    }

    /// Whether a band has enough bins away from its peak to separate noise from tones.
    pub const fn has_floor(peak: &Peak) -> bool {
        peak.floor_bins >= FLOOR
    }

    /// True if the power of a peak's bin alone is so far above the floor, 128 times its mean, that the line's power is not needed. In
    /// integers, because most tones are so strong.
    #[inline(always)]
    pub(crate) fn is_far_above_floor(&self, peak: &Peak) -> bool {
        /// For this L and the fewest bins of a floor the required ratio is 46.
        const USUAL: f32 = 32.0;
        let power = (peak.power[1] >> 16).saturating_mul(peak.floor_bins.into());
        Self::has_floor(peak) && self.floor < USUAL && power > peak.floor >> 9
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
        // m (exp(L/m) - 1) is below L + L^2/m if L is not above m. So most tones need no
        // exponential.
        self.floor <= bins && power * bins > self.floor * (bins + self.floor) * floor
            || power > self.over(peak.floor_bins) * floor
    }
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
    fn logarithms() {
        for x in [1e-30, 0.4, 1.0, 1.999, 2.0, 3.5, 511e6, 4096e30] {
            let error = super::log(x) - libm::log(x);
            assert!(error.abs() <= 1e-9, "{x}: {error:e}");
        }
    }
}
