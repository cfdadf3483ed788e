//! Decides whether a peak is a tone, by comparing it with the noise next to it. Noise seldom is white: the floor of a band tells little
//! about the noise at one place in the band.
//!
//! So a line must pass several tests at once. Each compares the ratio of the line's power to one noise power with the threshold for the
//! degrees of freedom of this noise (see [`super::detection`]): the floor of the band, the louder side of the ring, a ring twice as wide,
//! the fit's mean residual, and in short records the louder half of the residual. Because all must pass, each threshold is relaxed a
//! little. Most lines are so far above the loudest of these powers that the first comparison ends the tests.

use super::detection::{Relaxation, Threshold};
use super::measure::Options;
use super::noise::ring::{self, LocalNoise};
use super::observer::{Observer, Statistic, Test};
use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use crate::spectrum::Spectrum;
use crate::spectrum::bins::REACH;
use crate::spectrum::engine::Engine;
use crate::spectrum::neighbourhood::{Neighbourhood, has_ring};
use crate::spectrum::peak::Peak;
use crate::tone::fit::{Fit, Model, take_around};
use num_complex::Complex;

/// Tests whether the line at a peak exceeds the floor of its band, the noise of the louder side, and the fit's residual from 3 bins on.
/// Returns the factor by which sigma must grow because noise may have raised the line, or `None` if the line is not detected.
pub(super) fn stands_out<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    near: &Neighbourhood,
    peak: &Peak,
    fit: &Fit<f32>,
    beside: &LocalNoise,
    options: &Options,
    observer: impl Observer,
) -> Option<f32> {
    let (exponent, threshold) = (near.exponent, options.threshold);
    let arithmetic = options.arithmetic.available();
    let detector = Detector::from_peak(N, R::IQ, peak, fit, exponent, threshold, observer)?;
    if let Some(decided) = detector.decided(beside, observer) {
        return decided.then_some(1.0);
    }
    let wide = ring::loud(spectrum, near, fit, beside, arithmetic).unwrap_or(*beside);
    let floor = peak.floor as f32 * f32::two_to(2 * exponent) / peak.floor_bins.max(1) as f32;
    let tested = detector.tested(&wide, Threshold::has_floor(peak).then_some(floor));
    let exceeds = detector.exceeds(beside, &wide, tested, observer)
        && (!const { N < HUMPED && has_ring(N, R::IQ) }
            || !beside.has_sides()
            || detector.exceeds_half(
                louder_half::<R, N>(near, fit),
                tested.then_some(floor),
                observer,
            ));
    exceeds.then(|| detector.selection(beside.noise.power))
}

/// The residual of the louder half of the bins 3 to 16 away, which form four groups, two on each side.
///
/// A band of noise may end within the bins of the fit. The bins beyond its end have no noise, so the mean of all bins is too low.
#[inline(never)]
fn louder_half<R: Record, const N: usize>(near: &Neighbourhood, fit: &Fit<f32>) -> f32 {
    let (peak, unit) = (near.peak, near.unit());
    let mut bins = [Complex::new(0.0, 0.0); WIDTH];
    for (bin, &[re, im]) in bins.iter_mut().zip(near.within(REACH)) {
        *bin = Complex::new(re as f32 * unit, im as f32 * unit);
    }
    take_around::<R, N>(&Model::new(fit, peak, N as i32), peak, &mut bins);
    louder(&bins, R::IQ, N, peak)
}

/// The mean power of the louder half of the residual in the bins around a peak, 3 to 16 away on each side. The ends of a real spectrum may
/// leave out some of these bins.
#[inline(never)]
pub(crate) fn louder(bins: &[Complex<f32>; WIDTH], iq: bool, n: usize, peak: i32) -> f32 {
    /// With fewer bins the residual decides nothing.
    const FEWEST: usize = 4;
    /// Bins 9 to 16 and 3 to 8 below the peak, and above it.
    const STRETCHES: [(usize, usize); 4] =
        [(0, REACH - 8), (REACH - 8, REACH - 2), (REACH + 3, REACH + 9), (REACH + 9, WIDTH)];
    let last = n as i32 / 2 - 1;
    let room = if iq { [i32::MAX; 2] } else { [peak.wrapping_sub(1), last.wrapping_sub(peak)] };
    let [below, above] = room.map(|room| room.max(0).min(REACH as i32) as usize);
    let (first, end) = (REACH - below, REACH + 1 + above);
    let (mut loudest, mut second) = (0.0, 0.0);
    for (from, to) in STRETCHES {
        let bins = bins.get(from.max(first)..to.min(end)).unwrap_or_default();
        if bins.len() < FEWEST {
            continue;
        }
        let mean = bins.iter().map(Complex::norm_sqr).sum::<f32>() / bins.len() as f32;
        if mean > loudest {
            (second, loudest) = (loudest, mean);
        } else if mean > second {
            second = mean;
        }
    }
    0.5 * (loudest + second)
}

/// A line that exceeds the floor of its band, with the noise near it. Compiled once for all kinds and lengths of records.
struct Detector {
    /// The samples of a record, and whether the record is so short that a ring is as wide as the part of the spectrum that a filter leaves.
    n: usize,
    short: bool,
    threshold: Threshold,
    /// The line's power, and the residual power near the line.
    power: f32,
    spread: Spread,
}

impl Detector {
    #[inline(always)]
    fn from_peak(
        n: usize,
        iq: bool,
        peak: &Peak,
        fit: &Fit<f32>,
        exponent: i32,
        threshold: Threshold,
        observer: impl Observer,
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

    /// Whether the ring of this noise is enough to decide, and the decision.
    #[inline(always)]
    fn decided(&self, beside: &LocalNoise, observer: impl Observer) -> Option<bool> {
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

    /// Whether the floor of the line's band, if it separates noise from tones, is a test of its own: where the floor is as loud as the wide
    /// ring and the residual.
    #[inline(never)]
    fn tested(&self, wide: &LocalNoise, floor: Option<f32>) -> bool {
        let (mean, dof) = self.spread.mean();
        let residual = dof > 0.0 && wide.has_sides();
        floor.is_some_and(|floor| {
            let likely = 1.0 + RESIDUAL * (2.0 / dof).root();
            wide.loud * self.n as f32 <= LOUDER * floor && !(residual && mean > likely * floor)
        })
    }

    /// Whether the line exceeds this noise, the noise of a wider ring, and the mean residual.
    #[inline(never)]
    fn exceeds(
        &self,
        beside: &LocalNoise,
        wide: &LocalNoise,
        tested: bool,
        observer: impl Observer,
    ) -> bool {
        let Self { n, ref spread, .. } = *self;
        let (least, (mean, dof)) = (spread.least, spread.mean());
        // A short record without a ring has nothing else beside its tone.
        let residual = beside.has_sides() && dof > if self.short { 0.0 } else { WHOLE };
        // In a short record the wide ring is most of the spectrum, and the floor once more.
        let less = match (tested, self.short) {
            (true, true) => Relaxation::MOST,
            (true, false) => Relaxation::SOME.in_record(n),
            (false, _) => Relaxation::NOTHING,
        };
        let less_residual = if self.short && !tested {
            Relaxation::NOTHING
        } else {
            Relaxation::for_residual(n, self.short)
        };
        let detects = |statistic, beside: &LocalNoise, less| {
            let noise = least.max(beside.loud * n as f32);
            self.detects(statistic, noise, beside.noise.dof, less, observer)
        };
        let over_mean =
            || self.detects(Statistic::MeanResidual, mean, dof, less_residual, observer);
        (!residual || over_mean())
            && detects(Statistic::WideRing, wide, less)
            && detects(Statistic::Ring, beside, Relaxation::MOST.in_record(n))
    }

    /// Whether the line exceeds this mean of the louder half of the residual, or a floor that is a test of its own is as loud as the floor
    /// of white noise.
    #[inline(never)]
    fn exceeds_half(&self, louder: f32, floor: Option<f32>, observer: impl Observer) -> bool {
        /// Effective degrees of freedom of this mean, as if it were not a maximum.
        const DOF: f32 = 72.0;
        /// In white noise the louder half has 1.25 times the floor's power, and exceeds this factor four times in a thousand.
        const LIKELY: f32 = 2.0;
        floor.is_some_and(|floor| {
            observer.hear(|| Test::new(Statistic::LouderHalf, louder / floor, LIKELY));
            louder <= LIKELY * floor
        }) || self.detects(Statistic::OverLouderHalf, louder, DOF, Relaxation::NOTHING, observer)
    }

    /// The factor on sigma of a line that is found in noise of this power per sample.
    ///
    /// Lines near the threshold are found where noise has raised them, and so look more exact than they are. Measured: the excess of the
    /// factor over 1 falls with the fourth power of the line's power.
    #[inline(never)]
    fn selection(&self, noise: f32) -> f32 {
        /// The excess of a line at the threshold.
        const MOST: f32 = 0.5;
        let least = self.threshold.least_power() * noise * self.n as f32;
        let share = least / self.power;
        1.0 + MOST * (share * share) * (share * share)
    }

    fn detects(
        &self,
        statistic: Statistic,
        noise: f32,
        dof: f32,
        less: Relaxation,
        observer: impl Observer,
    ) -> bool {
        observer.exceeds(statistic, self.power / noise, self.threshold.beside(dof, less))
    }
}

/// Shorter records have rings as wide as what a filter leaves of the spectrum.
const HUMPED: usize = 512;
/// The median of the three residuals over the ring's noise, above which the ring says nothing about the noise here. White noise hardly ever
/// exceeds this ratio.
const HUMP: f32 = 3.0;
/// Degrees of freedom per bin of the median and of the minimum residual: for each bin of the median group, and of the nearest group.
const MIDDLE: f32 = 1.75;
const LEAST: f32 = 2.0;
/// Degrees of freedom per bin of the mean residual.
const EACH: f32 = 1.8;
/// Minimum degrees of freedom for the residual to be tested beside a ring that is narrow in the spectrum: most of the degrees of freedom of
/// 28 bins.
const WHOLE: f32 = 45.0;
/// The ring's noise over the floor, above which the floor belongs to another part of the spectrum.
const LOUDER: f32 = 1.4;
/// The limit of the mean residual, in its standard deviations above the floor, from which the floor belongs to another part of the
/// spectrum.
const RESIDUAL: f32 = 2.6;

/// All bins that a fit reads.
const WIDTH: usize = 2 * REACH + 1;

/// The residual power of a bin near a tone.
pub(super) struct Spread {
    /// The least of the residuals 3 to 4, 5 to 8 and 9 to 16 bins away, because another line may be in one of the groups.
    pub least: f32,
    /// The median of the three groups.
    middle: f32,
    /// Residual power within two bins of the peak, and in all bins of the fit.
    sums: [f32; 2],
    /// The number of bins in each group. A fit of eight bins has none in the last group, and at the spectrum's ends there are fewer.
    bins: [f32; 3],
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

    /// The mean residual of a bin over all groups, with its degrees of freedom.
    fn mean(&self) -> (f32, f32) {
        let ([inside, all], [nearest, next, last]) = (self.sums, self.bins);
        let bins = nearest + next + last;
        ((all - inside) / bins, EACH * bins)
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
