//! The close look at a line that the first look does not call steady: tests by Fisher's distribution, the parts of the power along the
//! directions, and the class and the variance that follow.

use super::FrequencyDrift;
use super::fit::Fit;
use super::judge::HIDDEN;
use super::line_class::{FitTest, LineClass, SUSPICIOUS};
use super::noise::ring::LocalNoise;
use super::observer::Tap;
use super::statistic::{Statistic, Test};
use crate::chance::ratio;
use crate::math::scalar::Scalar as _;
use crate::spectrum::engine::RESIDUE;

/// The share of a line that the integer transform itself leaves.
const TRANSFORM: f32 = RESIDUE as f32;

/// The threshold of four tests in normal deviations: each fires by chance in 2.5e-7 of all blocks.
const FIRES: f32 = 5.026;

/// What the five directions leave unexplained counts as noise if both tests have p > 5e-4.
const CLEAN: f32 = 3.291;

/// A noise estimate with fewer degrees of freedom comes from [`LocalNoise::on_an_edge`].
const FEW: f32 = 20.0;

/// A tone still moves if the residual beyond the directions is less than this share of the power along them. A tone that wanders, or swings
/// once or twice within the record, mostly leaves less; two lines 1.5 bins apart leave more.
const SHARE: f32 = 0.5;

/// The largest ratio that two lines make of the power along changes of the phase to that along
/// changes of the amplitude.
const PAIRED: f32 = 12.0;

/// Noise alone exceeds `ODD` (in two directions) in 1 % of blocks, and `LIKELY` in 0.25 %.
const ODD: f32 = 9.0;
const LIKELY: f32 = 12.0;

/// Degrees of freedom in the bins up to 2, 4 and 8 from the peak, and the number of directions of change.
const SCALES: [f32; 3] = [7.0, 15.0, 31.0];
const DIRECTIONS: f32 = 5.0;

/// The share of the squares of the three functions (see [`crate::tone::fit::Rest`]) in bins beyond 8 from the peak, divided by the square
/// of a sine or cosine; then the share beyond 4.
const BEYOND: [f32; 2] = [0.0238, 0.045];

/// The part of the first share in bins up to 16.
const OUTSIDE: f32 = 0.485;

/// Frequency bias from an amplitude change, as variance in squared bins per unit of projected power, times the information of one unit of
/// power, which is `pi^2 / 3`. The mirror image of a real tone changes, too, and the fit's own image does not: the bias falls with the
/// square of the distance from the nearer end of the spectrum. The rest is beyond the bins of the fit. Both were measured with levels that
/// fall by half, and that swing once or less.
const MIRROR: f32 = 0.066;
const CUT: f32 = 6.6e-5;

/// The share of the amplitude's power that shows as changes of the phase, beside the mirror image's share.
const LEAK: f32 = 5e-4;

/// [`judge`](super::judge::judge) by all tests.
#[inline(never)]
pub(super) fn judge_closely(
    fit: &Fit<f32>,
    n: usize,
    from_end: i32,
    beside: &LocalNoise,
    bends: bool,
    observer: impl Tap,
) -> FitTest {
    let LocalNoise { noise, loud, .. } = beside;
    let unit = 2.0 / (noise.power * n as f32);
    let size = fit.line.norm_sqr();
    let transform = TRANSFORM * size;
    let rest = |power: f32| (power - transform).max(0.0) * unit;
    let [two, four, eight] = fit.rest.within.map(rest);
    let all = rest(fit.residual);
    let free = fit.dof.max(1) as f32;
    let [free2, free4, free8] = SCALES;
    let Changes { amplitude: [a1, a2, a3], phase: [p2, p3], outside, fourth, .. } =
        Changes::from_fit(fit, bends);
    let [a1, a2, a3, p2, p3] = [a1, a2, a3, p2, p3].map(|power| power * unit);
    let moved = (a1 + a2 + a3 + p2 + p3 - transform * unit).max(0.0);
    let explained = moved + fourth * unit;
    let outside = if free > 2.0 * free8 { outside * unit } else { 0.0 };
    let left = free - DIRECTIONS;
    let tail = |deviations| Tail { deviations, noise: noise.dof };
    let from_end = from_end as f32;
    let mirror = MIRROR / (from_end * from_end);
    let strange = |deviations: f32| {
        let beyond =
            |statistic, power, free| tail(deviations).is_exceeded(statistic, power, free, observer);
        beyond(Statistic::Unexplained8, eight - explained, free8 - DIRECTIONS)
            || beyond(Statistic::Unexplained, all - explained - outside, left)
    };
    for (statistic, value) in
        [(Statistic::Level, a1 + a2 + a3), (Statistic::Bend, p2), (Statistic::Twist, p3)]
    {
        observer.hear(|| Test { statistic, value, limit: f32::INFINITY });
    }
    let fires = |statistic, power, free| tail(FIRES).is_exceeded(statistic, power, free, observer);
    if bends {
        // The motion makes the bend; the mirror image's bend pulls the frequency. The remaining power must be as small as beside a steady
        // tone.
        let others = (moved - p2).max(0.0);
        let soft = 1.0 + HIDDEN * (others - SUSPICIOUS).max(0.0) + p2 * mirror;
        if !(fires(Statistic::Moves, others, DIRECTIONS - 1.0) || strange(FIRES)) {
            return FitTest { line: LineClass::Steady, variance_inflation: soft };
        }
    }
    let soft = 1.0 + HIDDEN * (moved - SUSPICIOUS).max(0.0);
    // On an edge the noise is the fit's residual five bins off. It may rise towards the tone.
    let soft = if noise.dof < FEW { soft.max(four / free4).max(two / free2) } else { soft };
    // The widest scale is as wide as the ring. At an edge of the noise it takes the noise of the louder side.
    if !(fires(Statistic::Moves, moved, DIRECTIONS)
        || fires(Statistic::Near2, two, free2)
        || fires(Statistic::Near4, four, free4)
        || fires(Statistic::All, all * (noise.power / loud), free))
    {
        return FitTest { line: LineClass::Steady, variance_inflation: soft };
    }
    let beyond = (all - explained - outside - left).max(0.0);
    if strange(CLEAN) && {
        observer.hear(|| Test { statistic: Statistic::Share, value: beyond / moved, limit: SHARE });
        beyond > SHARE * moved
    } {
        let most = (moved - DIRECTIONS).max(four - free4).max(0.0);
        return FitTest { line: LineClass::Unresolved, variance_inflation: 1.0 + HIDDEN * most };
    }
    // A wrong frequency of two lines comes with changes of the amplitude of order 2 and of the
    // phase of order 3. A tone of changing level has the one without the other.
    let odd = (a2 + p3 - ODD).max(0.0);
    let odd = if beyond > 3.0 * (2.0 * left).root() { odd + beyond } else { odd };
    let level = a1 + a2 + a3;
    let odd = odd.min(PAIRED * (p2 + p3 - LIKELY - level * (mirror + LEAK)).max(0.0));
    FitTest {
        line: LineClass::Moving,
        variance_inflation: 1.0 + HIDDEN * odd + level * (mirror + CUT),
    }
}

/// The powers that a line leaves along the directions of a tone's change.
struct Changes {
    /// Powers of amplitude changes of order 1 to 3.
    amplitude: [f32; 3],
    /// Powers of phase changes of order 2 and 3.
    phase: [f32; 2],
    /// The part of these powers in bins 9 to 16 from the peak.
    outside: f32,
    /// The contribution of a phase of order 2 to amplitudes of order 4, see [`Changes::from_fit`].
    fourth: f32,
    /// The phase of order 2, in radians, and the power of one radian.
    bent: f32,
    second: f32,
}

impl FrequencyDrift {
    /// The changes in a fit to a record of `n` samples, in this noise power per sample.
    pub(super) fn from_fit(fit: &Fit<f32>, n: usize, power: f32) -> Self {
        let Changes { bent, second, .. } = Changes::from_fit(fit, false);
        // A rise of r bins is a phase of order 2 of pi/6 r.
        let cycles = 6.0 / core::f32::consts::PI / n as f32;
        Self { cycles: cycles * bent, sigma: cycles * (0.5 * power * n as f32 / second).root() }
    }
}

impl Changes {
    /// A phase that is not small has a square. A phase of b times Legendre's second polynomial P2
    /// has `P2^2 = 1/5 + 2/7 P2 + 18/35 P4`. So it makes an amplitude of order 2 of -b^2/7, which
    /// is not a change of the tone's level, and one of order 4 of -9/35 b^2.
    fn from_fit(fit: &Fit<f32>, bends: bool) -> Self {
        let cosine2 = fit.rest.cosine_squared;
        let sine2 = 1.0 - cosine2;
        let [narrow, wide] = BEYOND;
        let beyond = if fit.dof > 2 * 9 { narrow } else { wide };
        let size = fit.line.norm_sqr();
        let [n1, n2, n3] = [
            1.0 / 3.0 - beyond * cosine2,
            1.0 / 5.0 - beyond * sine2,
            1.0 / 7.0 - beyond * cosine2,
        ];
        // Components are shares of the line. The ones of order 1 and 3 are a quarter turn on.
        let back = fit.line.conj() / size;
        let [a1, a2, a3] = fit.rest.along.map(|along| back * along);
        // All bins of a function of order p have 1/(2p + 1) of power. Far from the line the functions are `tails` over pi times the
        // distance, so the part missing beyond the bins has one shape, and Sherman and Morrison's formula inverts the functions' products.
        // Where a bend is not evidence it is thousands of times as strong as the evidence, and only this inversion separates the two; the
        // limits of the tests were measured with the functions taken one by one.
        let [w1, w2, w3] = if bends {
            let half = f32::unit(0.5 * fit.offset);
            let tails = [-half.re, -half.im, half.re];
            let common = (a3 * 7.0 - a1 * 3.0) * half.re - a2 * (5.0 * half.im);
            let common = common * (beyond / (1.0 - beyond * (10.0 * cosine2 + 5.0 * sine2)));
            [
                (a1 + common * tails[0]) * 3.0,
                (a2 + common * tails[1]) * 5.0,
                (a3 + common * tails[2]) * 7.0,
            ]
        } else {
            [a1 / n1, a2 / n2, a3 / n3]
        };
        let bent = w2.im * w2.im;
        let level = bent * (1.0 / 7.0) - w2.re;
        let [s1, s2, s3] = [n1, n2, n3].map(|n| n * size);
        let odd = w1.im * w1.im + w3.norm_sqr();
        Self {
            amplitude: [w1.im * w1.im * s1, level * level * s2, w3.im * w3.im * s3],
            phase: [bent * s2, w3.re * w3.re * s3],
            outside: OUTSIDE * beyond * size * (odd * cosine2 + (bent + level * level) * sine2),
            fourth: bent * bent * size * (81.0 / 1225.0 / 9.0),
            bent: -w2.im,
            second: s2,
        }
    }
}

/// The limit of the improbable, against a noise estimate with this many degrees of freedom.
struct Tail {
    deviations: f32,
    noise: f32,
}

impl Tail {
    /// Whether a power in this many degrees of freedom is improbable, reported to an observer. The mean, which is below any limit, ends most
    /// tests.
    #[inline]
    fn is_exceeded(&self, statistic: Statistic, power: f32, free: f32, observer: impl Tap) -> bool {
        let limit = || free * ratio(self.deviations, free, self.noise);
        observer.hear(|| Test { statistic, value: power, limit: limit() });
        power > free && power > limit()
    }
}
