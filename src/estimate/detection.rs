//! Is a peak a tone, or the largest of many bins of noise?

use crate::scalar::Scalar;
use crate::spectrum::peak::Peak;

/// The probability, for each block, that noise alone passes for a tone.
pub const FALSE_ALARM: f64 = 1e-6;

/// The same for a place where a tone is known to be: it is lost rather late than early.
pub const HOLD: f64 = 1e-2;

/// The detection threshold of a band.
///
/// The power of a bin of noise is exponentially distributed. Its ratio to the mean of `m` other
/// bins exceeds T with probability `(1 + T/m)^-m`; the largest of M bins does so with M times that.
/// Hence `T = m ((M / pfa)^(1/m) - 1) = m (exp(L/m) - 1)`, `L = ln(M / pfa)`; L alone would raise
/// 1.5 to 2.5 times as many false alarms at N = 256.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    log: f32,
}

impl Threshold {
    /// Nothing passes.
    pub const NEVER: Self = Self { log: f32::INFINITY };

    /// For a search of `bins` bins and a false-alarm probability within 1e-30..=0.5 (a value beyond is
    /// brought there).
    pub fn new(bins: u32, false_alarm: f64) -> Self {
        let pfa = if false_alarm >= 1e-30 { false_alarm.min(0.5) } else { 1e-30 };
        Self { log: f64::from(bins.max(1)).log_e() as f32 - pfa.log_e() as f32 }
    }

    /// By how much a peak must exceed the mean of `floor_bins` other bins. Infinite without them.
    pub fn over(&self, floor_bins: u32) -> f32 {
        if floor_bins == 0 {
            return f32::INFINITY;
        }
        let m = floor_bins as f32;
        m * libm::expm1f(self.log / m)
    }

    /// True when the peak is a tone. A floor of zero, as of a signal without any noise, detects.
    ///
    /// The floor includes the leakage of a strong tone: right for this decision, not for sigma.
    pub fn detects(&self, peak: &Peak) -> bool {
        peak.power[1] as f32 * peak.floor_bins as f32
            > self.over(peak.floor_bins) * peak.floor as f32
    }
}
