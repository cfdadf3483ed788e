//! Is a peak a tone, by the noise beside it? Noise seldom is white: the floor of a band tells little of the noise at
//! one place in it.

use super::detection::{Less, Threshold};
use super::least_squares::Fit;
use super::measure::Arithmetic;
use super::noise::ring::{self, Beside};
use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use crate::spectrum::Spectrum;
use crate::spectrum::engine::Engine;
use crate::spectrum::peak::Peak;

/// Whether the line at a peak exceeds the floor of its band, the noise of the louder side, and the fit's residual from 3 bins on:
/// the factor by which it is then less exact than its power says, `None` if it does not.
pub(super) fn stands_out<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: &Peak,
    fit: &Fit<f32>,
    beside: &Beside,
    threshold: Threshold,
    arithmetic: Arithmetic,
) -> Option<f32> {
    let exponent = spectrum.exponent();
    let evidence = Evidence::of(N, R::IQ, peak, fit, exponent, threshold)?;
    if let Some(decided) = evidence.decided(beside) {
        return decided.then_some(1.0);
    }
    // The smallest programs use only the ring that they have.
    let wide = if cfg!(feature = "methods") {
        ring::loud(spectrum, peak.bin, fit, beside, arithmetic).unwrap_or(*beside)
    } else {
        *beside
    };
    let floor = peak.floor as f32 * f32::two_to(2 * exponent) / peak.floor_bins.max(1) as f32;
    let exceeds = evidence.exceeds(beside, &wide, Threshold::has_floor(peak).then_some(floor));
    exceeds.then(|| evidence.selection(beside.noise.power))
}

/// A line that exceeds the floor of its band, and what is near it. Compiled once for all kinds and lengths of records.
struct Evidence {
    /// The samples of a record, and whether it is so short that a ring is as wide as what a filter leaves of the spectrum.
    n: usize,
    short: bool,
    threshold: Threshold,
    /// The line's power, and the residual's near it.
    power: f32,
    spread: Spread,
}

impl Evidence {
    #[cfg_attr(target_arch = "wasm32", inline(never))]
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn of(
        n: usize,
        iq: bool,
        peak: &Peak,
        fit: &Fit<f32>,
        exponent: i32,
        threshold: Threshold,
    ) -> Option<Self> {
        let far_above = cfg!(feature = "methods") && threshold.is_far_above_floor(peak);
        let (power, threshold) = if far_above {
            (peak.power[1] as f32, threshold)
        } else {
            let line = fit.line.norm_sqr() * f32::two_to(-2 * exponent);
            let (power, threshold) = threshold.of_line(line, peak, n, iq);
            if !threshold.detects_line(power, peak) {
                return None;
            }
            (power, threshold)
        };
        let unit = f32::two_to(2 * exponent);
        let spread =
            if cfg!(feature = "methods") { Spread::of(fit, peak.bin, n, iq) } else { Spread::NONE };
        Some(Self { n, short: n < HUMPED, threshold, power: power * unit, spread })
    }

    /// Whether the ring of this noise is enough to decide, and how.
    #[cfg_attr(target_arch = "wasm32", inline(never))]
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn decided(&self, beside: &Beside) -> Option<bool> {
        let Spread { least, middle, .. } = self.spread;
        let ring = beside.loud * self.n as f32;
        if cfg!(feature = "methods") && self.short && middle > HUMP * ring {
            // The noise is louder here than in the ring, or other lines are near: the residual alone decides.
            let detects = |rest: f32, freedom| self.detects(rest, freedom, Less::NOTHING);
            return Some(detects(middle, MIDDLE) || detects(least, LEAST));
        }
        let (_, most) = ordered(least, ring);
        self.threshold.is_far_above(self.power / most).then_some(true)
    }

    /// Whether the line exceeds this noise and that of a wider ring. The `floor` is its band's, where that tells noise from
    /// tones.
    #[inline(never)]
    fn exceeds(&self, beside: &Beside, wide: &Beside, floor: Option<f32>) -> bool {
        let Self { n, ref spread, .. } = *self;
        let (least, (mean, freedom)) = (spread.least, spread.mean());
        // A short record without a ring has nothing else beside its tone.
        let residual =
            cfg!(feature = "methods") && self.short && freedom > 0.0 && beside.has_sides();
        // The floor is a test of its own where it is as loud as the ring, and in a short record as the residual.
        let tested = floor.is_some_and(|floor| {
            let likely = 1.0 + RESIDUAL * (2.0 / freedom).root();
            wide.loud * n as f32 <= LOUDER * floor && !(residual && mean > likely * floor)
        });
        let less = if tested { Less::SOME.in_record(n) } else { Less::NOTHING };
        let detects = |beside: &Beside, less| {
            self.detects(least.max(beside.loud * n as f32), beside.noise.freedom, less)
        };
        (!residual || self.detects(mean, freedom, less))
            && detects(wide, less)
            && detects(beside, Less::MOST.in_record(n))
    }

    /// The factor on sigma of a line that is found in noise of this power per sample.
    ///
    /// Lines near the threshold are found where noise has raised them, and so look more exact than they are. Measured: the
    /// factor falls with the fourth power of the line's.
    #[inline(never)]
    fn selection(&self, noise: f32) -> f32 {
        /// That of a line at the threshold.
        const MOST: f32 = 0.5;
        let least = self.threshold.least_power() * noise * self.n as f32;
        let share = least / self.power;
        1.0 + MOST * (share * share) * (share * share)
    }

    fn detects(&self, noise: f32, freedom: f32, less: Less) -> bool {
        self.threshold.detects_beside(self.power / noise, freedom, less)
    }
}

/// Shorter records have rings as wide as what a filter leaves of the spectrum.
const HUMPED: usize = 512;
/// The middle one of the three residuals over the ring's noise, above which the ring does not tell the noise
/// here. White noise hardly ever exceeds it.
const HUMP: f32 = 3.0;
/// The independent real numbers that the middle one and the least are as accurate as.
const MIDDLE: f32 = 14.0;
const LEAST: f32 = 8.0;
/// The same for each bin of their mean.
const EACH: f32 = 1.8;
/// The ring's noise over the floor's, above which the floor is that of another part of the spectrum.
const LOUDER: f32 = 1.4;
/// The same for the mean residual, in its standard deviations above the floor.
const RESIDUAL: f32 = 2.6;

/// The residual power of a bin near a tone.
pub(super) struct Spread {
    /// The least of those 3 to 4, 5 to 8 and 9 to 16 bins away, because another line may be in one of them.
    pub least: f32,
    /// The middle one of the three.
    middle: f32,
    /// What is not in these bins, and in them and these.
    sums: [f32; 2],
    /// How many bins they are. A fit of eight bins has none beyond, and at the spectrum's ends there are fewer.
    bins: [f32; 3],
}

impl Spread {
    const NONE: Self = Self { least: 0.0, middle: 0.0, sums: [0.0; 2], bins: [0.0; 3] };

    /// Of the fit at a peak of a record of `n` samples.
    #[cfg_attr(target_arch = "wasm32", inline(never))]
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(super) fn of(fit: &Fit<f32>, peak: i32, n: usize, iq: bool) -> Self {
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

    /// That of all of them, and the independent real numbers that it is as accurate as.
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

/// How many bins are 3 to 4, 5 to 8 and 9 to 16 away, of so many on each side; at least one.
#[inline(never)]
fn beside(left: i32, right: i32) -> [f32; 3] {
    [(3, 4), (5, 8), (9, 16)].map(|(nearest, farthest): (i32, i32)| {
        let side = |room: i32| (farthest.min(room) - nearest + 1).max(0);
        (side(left) + side(right)).max(1) as f32
    })
}
