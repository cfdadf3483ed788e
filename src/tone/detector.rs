//! A line beside the noise near it: the comparisons of a detection.

use super::fit::Fit;
use super::noise::ring::LocalNoise;
use super::observer::Tap;
use super::statistic::{Statistic, Test};
use super::threshold::{Relaxation, Threshold};
use crate::math::scalar::Scalar as _;
use crate::spectrum::peak::Peak;

/// A line that exceeds the floor of its band, with the noise near it. Compiled once for all kinds and lengths of records.
pub(super) struct Detector {
    /// The samples of a record, and whether the record is so short that a ring is as wide as the part of the spectrum that a filter leaves.
    pub n: usize,
    pub short: bool,
    pub threshold: Threshold,
    /// The line's power, and the residual power near the line.
    pub power: f32,
    pub spread: Spread,
}

impl Detector {
    /// The line at a peak; `None` if it does not exceed the floor of its band. A bin far above the floor needs no line's power.
    #[inline(always)]
    pub(super) fn from_peak(
        n: usize,
        iq: bool,
        peak: &Peak,
        fit: &Fit<f32>,
        exponent: i32,
        threshold: Threshold,
        observer: impl Tap,
    ) -> Option<Self> {
        let over_floor = |power: f32, threshold: &Threshold| {
            if Threshold::has_floor(peak) {
                observer.hear(|| {
                    let ratio = power * peak.floor_bins as f32 / peak.floor as f32;
                    Test::new(Statistic::Floor, ratio, threshold.over(peak.floor_bins))
                });
            }
        };
        let (power, threshold) = if threshold.is_far_above_floor(peak) {
            let power = peak.power[1] as f32;
            over_floor(power, &threshold);
            (power, threshold)
        } else {
            let line = fit.line.norm_sqr() * f32::two_to(-2 * exponent);
            let (power, threshold) = threshold.of_line(line, peak, n, iq);
            over_floor(power, &threshold);
            if !threshold.detects_line(power, peak) {
                return None;
            }
            (power, threshold)
        };
        let unit = f32::two_to(2 * exponent);
        let spread = Spread::from_fit(fit, peak.bin, n, iq);
        Some(Self { n, short: n < HUMPED, threshold, power: power * unit, spread })
    }

    /// Whether the ring of this noise is enough to decide, and the decision: most lines are far above it, and end here.
    #[inline(always)]
    pub(super) fn decided(&self, beside: &LocalNoise, observer: impl Tap) -> Option<bool> {
        let Spread { least, middle, bins: [nearest, next, _], .. } = self.spread;
        let ring = beside.loud * self.n as f32;
        let (_, mut most) = ordered(least, ring);
        if self.short {
            observer.hear(|| Test::new(Statistic::Hump, middle / ring, HUMP));
            if middle > HUMP * ring {
                // The noise is louder here than in the ring, or other lines are near: the residual alone decides.
                let detects = |statistic, rest: f32, dof| {
                    self.detects(statistic, rest, dof, Relaxation::NOTHING, observer)
                };
                return Some(
                    detects(Statistic::MiddleResidual, middle, MIDDLE * next)
                        || detects(Statistic::LeastResidual, least, LEAST * nearest),
                );
            }
            (_, most) = ordered(most, middle);
        }
        let (statistic, limit) = (Statistic::FarAbove, self.threshold.far_above());
        observer.exceeds(statistic, self.power / most, limit).then_some(true)
    }

    pub fn detects(
        &self,
        statistic: Statistic,
        noise: f32,
        dof: f32,
        less: Relaxation,
        observer: impl Tap,
    ) -> bool {
        observer.exceeds(statistic, self.power / noise, self.threshold.beside(dof, less))
    }
}

/// Shorter records have rings as wide as what a filter leaves of the spectrum.
pub(super) const HUMPED: usize = 512;
/// The median of the three residuals over the ring's noise, above which the ring says nothing about the noise here. White noise hardly ever
/// exceeds this ratio.
const HUMP: f32 = 3.0;
/// Degrees of freedom per bin of the median and of the minimum residual: for each bin of the median group, and of the nearest group.
const MIDDLE: f32 = 1.75;
const LEAST: f32 = 2.0;

/// The residual power of a bin near a tone.
pub(super) struct Spread {
    /// The least of the residuals 3 to 4, 5 to 8 and 9 to 16 bins away, because another line may be in one of the groups.
    pub least: f32,
    /// The median of the three groups.
    pub middle: f32,
    /// Residual power within two bins of the peak, and in all bins of the fit.
    pub sums: [f32; 2],
    /// The number of bins in each group. A fit of eight bins has none in the last group, and at the spectrum's ends there are fewer.
    pub bins: [f32; 3],
}

impl Spread {
    /// The residuals of the fit at a peak of a record of `n` samples.
    #[inline(always)]
    pub(super) fn from_fit(fit: &Fit<f32>, peak: i32, n: usize, iq: bool) -> Self {
        let [two, four, eight] = fit.rest.within;
        let last = n as i32 / 2 - 1;
        let inside = iq || (17..last - 16).contains(&peak);
        let (bins, shares) = if inside {
            ([4.0, 8.0, 16.0], [0.25, 0.125, 0.0625])
        } else {
            let bins = beside(peak - 1, last - peak);
            (bins, bins.map(|bins| 1.0 / bins))
        };
        let [near, middle, far] = [four - two, eight - four, fit.residual - eight];
        let [near, middle, far] = [near * shares[0], middle * shares[1], far * shares[2]];
        let (low, high) = ordered(near, middle);
        let (least, middle) = if far > 0.0 {
            let (between, _) = ordered(high, far);
            ordered(low, between)
        } else {
            (low, high)
        };
        let [nearest, next, last] = bins;
        let bins = [nearest, next, if far > 0.0 { last } else { 0.0 }];
        Self { least, middle, sums: [two, fit.residual], bins }
    }
}

/// Two numbers, the smaller one first. `min` and `max` would test for NaN as well.
fn ordered(a: f32, b: f32) -> (f32, f32) {
    if a < b { (a, b) } else { (b, a) }
}

/// The numbers of bins that are 3 to 4, 5 to 8 and 9 to 16 away, with this many bins to the left and to the right; at least one in each
/// group.
#[inline(never)]
fn beside(left: i32, right: i32) -> [f32; 3] {
    [(3, 4), (5, 8), (9, 16)].map(|(nearest, farthest): (i32, i32)| {
        let side = |room: i32| (farthest.min(room) - nearest + 1).max(0);
        (side(left) + side(right)).max(1) as f32
    })
}
