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

/// Whether a peak exceeds the floor of its band, the noise of the louder side, and the fit's residual from 3 bins on.
pub(super) fn stands_out<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: &Peak,
    fit: &Fit<f32>,
    beside: &Beside,
    threshold: Threshold,
    arithmetic: Arithmetic,
) -> bool {
    if !threshold.detects(peak) {
        return false;
    }
    let unit = f32::two_to(2 * spectrum.exponent());
    let power = peak.power[1] as f32 * unit;
    let ring = beside.loud * N as f32;
    let [least, middle] =
        if cfg!(feature = "methods") { spread::<R, N>(fit, peak.bin) } else { [0.0; 2] };
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
    // The floor is a test of its own where it is as loud as the ring.
    let floor = peak.floor as f32 * unit;
    let tested = Threshold::has_floor(peak)
        && wide.loud * N as f32 * peak.floor_bins as f32 <= LOUDER * floor;
    let less = if tested { const { Less::SOME.in_record(N) } } else { Less::NOTHING };
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
/// The ring's noise over the floor's, above which the floor is that of another part of the spectrum.
const LOUDER: f32 = 1.4;

/// The residual power of a bin 3 to 4, 5 to 8 and 9 to 16 bins away: the least of the three, because another
/// line may be in one of them, and the middle one. A fit of eight bins has no bins beyond, and at the
/// spectrum's ends there are fewer.
pub(super) fn spread<R: Record, const N: usize>(fit: &Fit<f32>, peak: i32) -> [f32; 2] {
    let [two, four, eight] = fit.rest.within;
    let last = N as i32 / 2 - 1;
    let inside = R::IQ || (17..last - 16).contains(&peak);
    let shares = if inside { [0.25, 0.125, 0.0625] } else { shares(peak - 1, last - peak) };
    let [near, middle, far] = [four - two, eight - four, fit.residual - eight];
    let [near, middle, far] = [near * shares[0], middle * shares[1], far * shares[2]];
    let (low, high) = (near.min(middle), near.max(middle));
    if far > 0.0 { [low.min(far), high.min(low.max(far))] } else { [low, high] }
}

/// One over the number of bins 3 to 4, 5 to 8 and 9 to 16 away, of so many on each side.
#[inline(never)]
fn shares(left: i32, right: i32) -> [f32; 3] {
    [(3, 4), (5, 8), (9, 16)].map(|(nearest, farthest): (i32, i32)| {
        let side = |room: i32| (farthest.min(room) - nearest + 1).max(0);
        1.0 / (side(left) + side(right)).max(1) as f32
    })
}
