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

/// Whether the line at a peak exceeds the floor of its band, the noise of the louder side, and the fit's residual from 3 bins on.
pub(super) fn stands_out<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: &Peak,
    fit: &Fit<f32>,
    beside: &Beside,
    threshold: Threshold,
    arithmetic: Arithmetic,
) -> bool {
    let line = fit.line.norm_sqr() * f32::two_to(-2 * spectrum.exponent());
    let (power, threshold) = threshold.of_line(line, peak, N, R::IQ);
    if !threshold.detects_line(power, peak) {
        return false;
    }
    let unit = f32::two_to(2 * spectrum.exponent());
    let power = power * unit;
    let ring = beside.loud * N as f32;
    let spread =
        if cfg!(feature = "methods") { Spread::of::<R, N>(fit, peak.bin) } else { Spread::NONE };
    let Spread { least, middle, mean, bins } = spread;
    if const { N < HUMPED } && middle > HUMP * ring {
        // The noise is louder here than in the ring, or other lines are near: the residual alone decides.
        let detects =
            |rest, freedom| threshold.detects_beside(power / rest, freedom, Less::NOTHING);
        return detects(middle, MIDDLE) || detects(least, LEAST);
    }
    if threshold.is_far_above(power / least.max(ring)) {
        return true;
    }
    // The smallest programs use only the ring that they have.
    let wide = if cfg!(feature = "methods") {
        ring::loud(spectrum, peak.bin, fit, beside, arithmetic).unwrap_or(*beside)
    } else {
        *beside
    };
    // The floor is a test of its own where it is as loud as the ring, and in a short record as the residual.
    let short = const { N < HUMPED && ring::has_room(N, R::IQ) } && bins > 0.0;
    let freedom = EACH * bins;
    let floor = peak.floor as f32 * unit / peak.floor_bins.max(1) as f32;
    let tested = Threshold::has_floor(peak)
        && wide.loud * N as f32 <= LOUDER * floor
        && !(short && mean > (1.0 + 2.6 * (2.0 / freedom).root()) * floor);
    let less = if tested { const { Less::SOME.in_record(N) } } else { Less::NOTHING };
    if short && !threshold.detects_beside(power / mean, freedom, less) {
        return false;
    }
    let detects = |beside: &Beside, less| {
        threshold.detects_beside(
            power / least.max(beside.loud * N as f32),
            beside.noise.freedom,
            less,
        )
    };
    detects(&wide, less) && detects(beside, const { Less::MOST.in_record(N) })
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

/// The residual power of a bin near a tone.
pub(super) struct Spread {
    /// The least of those 3 to 4, 5 to 8 and 9 to 16 bins away, because another line may be in one of them.
    pub least: f32,
    /// The middle one of the three.
    middle: f32,
    /// That of all of them, and how many bins they are. A fit of eight bins has none beyond, and at the
    /// spectrum's ends there are fewer.
    mean: f32,
    bins: f32,
}

impl Spread {
    const NONE: Self = Self { least: 0.0, middle: 0.0, mean: 0.0, bins: 0.0 };

    pub(super) fn of<R: Record, const N: usize>(fit: &Fit<f32>, peak: i32) -> Self {
        let [two, four, eight] = fit.rest.within;
        let last = N as i32 / 2 - 1;
        let inside = R::IQ || (17..last - 16).contains(&peak);
        let bins = if inside { [4.0, 8.0, 16.0] } else { beside(peak - 1, last - peak) };
        let powers = [four - two, eight - four, fit.residual - eight];
        let [near, middle, far] = [powers[0] / bins[0], powers[1] / bins[1], powers[2] / bins[2]];
        let (low, high) = (near.min(middle), near.max(middle));
        let (least, middle) =
            if far > 0.0 { (low.min(far), high.min(low.max(far))) } else { (low, high) };
        let bins = bins[0] + bins[1] + if far > 0.0 { bins[2] } else { 0.0 };
        Self { least, middle, mean: (fit.residual - two) / bins, bins }
    }
}

/// How many bins are 3 to 4, 5 to 8 and 9 to 16 away, of so many on each side; at least one.
#[inline(never)]
fn beside(left: i32, right: i32) -> [f32; 3] {
    [(3, 4), (5, 8), (9, 16)].map(|(nearest, farthest): (i32, i32)| {
        let side = |room: i32| (farthest.min(room) - nearest + 1).max(0);
        (side(left) + side(right)).max(1) as f32
    })
}
