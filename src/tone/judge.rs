//! Decides whether a line is one steady tone: tests compare the residual of a fit in its bins with the noise beside them.
//!
//! Another tone, a jump of the phase or a sweep leaves power in the few bins nearest the peak.
//! Something far away leaks into all of them. So there are tests at several scales. One more test
//! looks along the five directions in which a tone's amplitude and frequency change over the
//! record (see [`crate::tone::fit::Rest`]). Noise alone fires one of the tests of the close look in one block of a
//! million.
//!
//! If these directions explain the power, the tone moves; otherwise there are several tones. Sigma grows with the frequency error that such
//! a power brings along. Sigma already grows a little before any test fires, because a disturbance can be suspicious without being
//! improbable.
//!
//! The first look is [`judge`]: four powers of the residual below their limits are a steady tone. `along` has the projections of the
//! residual onto the directions, `within` the powers in the bins up to 2, 4 and 8 from the peak ([`Rest`](crate::tone::fit::Rest)). Any
//! other line gets the close look of `close_judgement`.

use super::close_judgement::judge_closely;
use super::line_class::{FitTest, LineClass, SUSPICIOUS};
use super::noise::ring::LocalNoise;
use super::observer::Tap;
use super::statistic::{Statistic, Test};
use crate::tone::fit::Fit;

/// Above this power in the bins up to 2 and up to 4 from the peak the first look does not call a line steady.
const UNLIKELY: [f32; 2] = [35.0, 50.0];

/// The power of a disturbance along the direction of the frequency, in units of its power in the residual: 3 for a jump of the phase in the
/// middle of a record, 5 for a second tone half a bin away.
pub(super) const HIDDEN: f32 = 5.0;

/// `1 / sum(f^2)` of each function: turns a squared projection onto f into power, largest over the offset.
const PER_SQUARE: [f32; 3] = [3.23, 5.68, 8.40];

/// Bins from a tone at bin `peak` of a record of `n` samples to the nearer end of its spectrum. The spectrum of I/Q has no end: the
/// distance is large.
pub fn from_end(peak: i32, n: usize, iq: bool) -> i32 {
    if iq { i32::MAX } else { peak.min(n as i32 / 2 - peak).max(1) }
}

/// Judges a line among others, whose fit is beside theirs, in a record of `n` samples and at this distance in bins from the nearer end of
/// the spectrum, see [`from_end`]: the first look, then the close look of `close_judgement`. `bends` says that the tone's phase may bend
/// without any change of the frequency in the middle, see [`Segment::bends`](crate::acquire::sample::Segment::bends). Cost: some thirty
/// operations if nothing is suspicious.
#[inline(never)]
pub fn judge(
    fit: &Fit<f32>,
    n: usize,
    from_end: i32,
    beside: &LocalNoise,
    bends: bool,
    observer: impl Tap,
) -> FitTest {
    match first_look(fit, n, beside, observer) {
        FitTest::STEADY => FitTest::STEADY,
        _ => judge_closely(fit, n, from_end, beside, bends, observer),
    }
}

/// The first look: four powers of the residual below their limits are a steady tone. Any other line is unresolved until a joint fit
/// explains it; its variance grows with the largest excess.
#[inline(never)]
pub fn first_look(fit: &Fit<f32>, n: usize, beside: &LocalNoise, observer: impl Tap) -> FitTest {
    let LocalNoise { noise, .. } = beside;
    // In units of half the noise power of a bin, so that each degree of freedom leaves 1.
    let unit = 2.0 / (noise.power * n as f32);
    let rest = &fit.rest;
    let free = fit.dof.max(1) as f32;
    let along: f32 =
        rest.along.iter().zip(PER_SQUARE).map(|(along, per)| along.norm_sqr() * per).sum();
    let [two, four, _] = rest.within;
    let all = fit.residual;
    for (statistic, power, limit) in [
        (Statistic::Changes, along, SUSPICIOUS),
        (Statistic::Within2, two, UNLIKELY[0]),
        (Statistic::Within4, four, UNLIKELY[1]),
        (Statistic::WithinAll, all, 2.0 * free),
    ] {
        observer.hear(|| Test { statistic, value: power * unit, limit });
    }
    // Noise may well leave as much as this, and it widens nothing. Most blocks end here.
    if along * unit < SUSPICIOUS
        && two * unit < UNLIKELY[0]
        && four * unit < UNLIKELY[1]
        && all * unit < 2.0 * free
    {
        return FitTest::STEADY;
    }
    // A disturbance may have as much power along the frequency as in the residual.
    let most = along.max(two).max(four) * unit;
    FitTest { line: LineClass::Unresolved, variance_inflation: 1.0 + HIDDEN * most }
}
