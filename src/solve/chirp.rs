//! Range and velocity from the beats of a chirp.
//!
//! An approaching target (V > 0) beats at `f1 = fR - fD` on the rising ramp, at `f2 = fD` on the
//! flat segment and at `f3 = fR + fD` on the falling ramp, with `fR = 2 L B / (c T)` and
//! `fD = 2 V / lambda` (Ye et al. 2022, section 1). Real samples show only magnitudes. The paper's
//! eqs 1 and 2 take these magnitudes for the signed beats, which is wrong wherever the Doppler
//! shift exceeds the range beat. Here the four possible sign patterns are tried.
//!
//! Three beats and two unknowns leave one condition, `a.y = y3 - y1 - 2 y2 = 0`. So weighted least
//! squares needs no normal equations. The sign pattern that violates the condition least has the
//! least residual, whatever the weights. Each beat is then corrected along `a` by its share of the
//! violation, `y_i - v_i a_i (a.y) / (v1 + 4 v2 + v3)`, where `v` are the variances. The choice is
//! made in exact integers.

use crate::acquire::sample::Segment;
use crate::estimate::tone::{Tone, Verdict};
use fixed::types::I32F32;

/// The value of one cycle per sample, in SI units: in fixed point for results, in float for sigmas.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scale {
    /// For results.
    pub fixed: I32F32,
    /// For sigmas.
    pub float: f32,
}

impl Scale {
    /// A scale of `per_cycle` units per cycle per sample; `None` if it does not fit in 31 bits, or is
    /// less than a step of 2^-32: results would be 0, and an infinite sigma times 0 no number.
    pub fn new(per_cycle: f64) -> Option<Self> {
        let fixed = I32F32::checked_from_num(per_cycle).filter(|&fixed| fixed != I32F32::ZERO)?;
        Some(Scale { fixed, float: per_cycle as f32 })
    }
}

/// A frequency in steps of 2^-32 cycles per sample times a scale, rounded down to 2^-32 units. The
/// product saturates. The frequency may be the sum of two.
pub(crate) fn metres(steps: i64, scale: I32F32) -> I32F32 {
    let product = (i128::from(steps) * i128::from(scale.to_bits())) >> 32;
    I32F32::from_bits(product.clamp(i128::from(i64::MIN), i128::from(i64::MAX)) as i64)
}

/// The shape of the frequency ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Shape {
    /// Up, flat, down: range and signed velocity, both unique.
    #[default]
    Trapezoid,
    /// Up, down: with real samples, range and velocity may be exchanged.
    Triangle,
    /// Up only: one beat cannot separate range and velocity.
    Sawtooth,
}

impl Shape {
    /// The segments, in order.
    pub const fn segments(self) -> &'static [Segment] {
        match self {
            Shape::Sawtooth => &[Segment::Up],
            Shape::Triangle => &[Segment::Up, Segment::Down],
            Shape::Trapezoid => &[Segment::Up, Segment::Flat, Segment::Down],
        }
    }
}

/// What the waveform leaves open.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Ambiguity {
    /// Nothing: the answer is unique.
    #[default]
    None,
    /// A triangle with real samples: the same beats fit a second target, with the roles of range
    /// and Doppler exchanged. The order of the beats gives the sign of each velocity.
    Exchange {
        /// Range of the second target, metres.
        #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
        range: I32F32,
        /// Velocity of the second target, metres per second.
        #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
        velocity: I32F32,
    },
    /// A sawtooth: the range is right only for a target at rest, and the velocity is 0.
    Coupled,
}

/// A target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Target {
    /// Range, metres.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub range: I32F32,
    /// Velocity, metres per second; positive when approaching.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub velocity: I32F32,
    /// One standard deviation of the range, metres.
    pub sigma_range: f32,
    /// One standard deviation of the velocity, metres per second.
    pub sigma_velocity: f32,
    /// What the waveform leaves open.
    pub ambiguity: Ambiguity,
    /// The worst verdict of the beats; [`Verdict::Unresolved`] if the beats contradict each other
    /// by more than five standard deviations.
    pub verdict: Verdict,
}

/// The two scales of a waveform.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scales {
    /// Range of one cycle per sample: rate c T / (2 B).
    pub range: Scale,
    /// Velocity of one cycle per sample: rate lambda / 2.
    pub velocity: Scale,
}

/// A beat: signed steps of 2^-32 cycles per sample, and the variance in cycles squared.
#[derive(Clone, Copy)]
struct Beat {
    steps: i64,
    variance: f32,
}

/// The variance of a beat within 1.5 bins of DC or Nyquist is multiplied by this: it counts a
/// hundredth.
const EDGE_VARIANCE: f32 = 100.0;

/// The least variance of a beat, from the step of the frequency's type.
const LEAST_VARIANCE: f32 = (1.0 / 4_294_967_296.0) * (1.0 / 4_294_967_296.0) / 12.0;

fn beat(tone: &Tone) -> Beat {
    let sigma = if tone.sigma.is_finite() { tone.sigma } else { 1.0 };
    let edge = if tone.verdict == Verdict::NearEdge { EDGE_VARIANCE } else { 1.0 };
    Beat {
        steps: i64::from(tone.frequency.0.to_bits()),
        variance: (sigma * sigma).max(LEAST_VARIANCE) * edge,
    }
}

/// The squared contradiction, in variances, from which the beats are not of one target: five
/// standard deviations.
const CONTRADICTION: f32 = 25.0;

/// The sign patterns of real beats (up, flat, down). A fifth one has fR < 0 and does not occur.
const PATTERNS: [[i64; 3]; 4] = [[1, 1, 1], [1, -1, 1], [-1, 1, 1], [1, -1, -1]];

/// Solves a trapezoid from its three tones. `signed` is true for I/Q beats, whose signs are known.
///
/// Cost: four integer residuals, two divisions.
pub fn trapezoid(tones: &[Tone; 3], signed: bool, scales: &Scales) -> Target {
    let beats = tones.each_ref().map(beat);
    let (violation, y) = signs(&beats, signed);
    let [v1, v2, v3] = beats.map(|b| b.variance);
    let total = v1 + 4.0 * v2 + v3;
    let error = violation as f32;
    // The share of each ramp. Its rounding to a step of 2^-32 is far below any sigma.
    let rising = y[0] + (error * (v1 / total)) as i64;
    let falling = y[2] - (error * (v3 / total)) as i64;
    let cycles = error / 4_294_967_296.0;
    let contradiction = cycles * cycles > CONTRADICTION * total;
    let mean = (v1 + v3) / 4.0;
    let skew = (v3 - v1) / 2.0;
    let both = (v1 + v3) / 2.0;
    Target {
        range: metres(rising + falling, scales.range.fixed) / 2,
        velocity: metres(falling - rising, scales.velocity.fixed) / 2,
        sigma_range: scales.range.float * root(mean - skew * skew / total),
        sigma_velocity: scales.velocity.float * root(mean - both * both / total),
        ambiguity: Ambiguity::None,
        verdict: worst(tones, contradiction),
    }
}

/// The violation of the condition and the signed beats, for the sign pattern that violates it
/// least.
fn signs(beats: &[Beat; 3], signed: bool) -> (i64, [i64; 3]) {
    let patterns = if signed { &PATTERNS[..1] } else { &PATTERNS[..] };
    let mut best: Option<(i64, [i64; 3])> = None;
    for signs in patterns {
        let y = [signs[0] * beats[0].steps, signs[1] * beats[1].steps, signs[2] * beats[2].steps];
        let violation = y[2] - y[0] - 2 * y[1];
        let first = best.is_none_or(|(least, _)| violation.abs() < least.abs());
        if first && (y[0] + y[2] >= 0 || signed) {
            best = Some((violation, y));
        }
    }
    best.unwrap_or((0, beats.map(|b| b.steps)))
}

/// How much the three beats of a trapezoid contradict each other, squared, with 1 at five standard
/// deviations. Above 1, [`trapezoid`] calls them unresolved.
pub fn contradiction(tones: &[Tone; 3], signed: bool) -> f32 {
    let beats = tones.each_ref().map(beat);
    let (violation, _) = signs(&beats, signed);
    let [v1, v2, v3] = beats.map(|b| b.variance);
    let cycles = violation as f32 / 4_294_967_296.0;
    cycles * cycles / (CONTRADICTION * (v1 + 4.0 * v2 + v3))
}

/// Solves a triangle from its two tones (up, down).
///
/// Real beats fit two targets: `fR = (f1 + f3)/2, fD = (f3 - f1)/2`, and the same with fR and fD
/// exchanged. The answer is the target with the larger range beat; the other target is its
/// ambiguity.
pub fn triangle(tones: &[Tone; 2], signed: bool, scales: &Scales) -> Target {
    let [up, down] = tones.each_ref().map(beat);
    let (sum, difference) = (up.steps + down.steps, down.steps - up.steps);
    let (range, velocity) = (scales.range.fixed, scales.velocity.fixed);
    let sigma = root((up.variance + down.variance) / 4.0);
    let ambiguity = if signed {
        Ambiguity::None
    } else {
        Ambiguity::Exchange {
            range: metres(difference.abs(), range) / 2,
            velocity: metres(if difference < 0 { -sum } else { sum }, velocity) / 2,
        }
    };
    Target {
        range: metres(sum, range) / 2,
        velocity: metres(difference, velocity) / 2,
        sigma_range: scales.range.float * sigma,
        sigma_velocity: scales.velocity.float * sigma,
        ambiguity,
        verdict: worst(tones, false),
    }
}

/// Solves a sawtooth from its one tone: the range of a target at rest.
pub fn sawtooth(tone: &Tone, scales: &Scales) -> Target {
    let up = beat(tone);
    Target {
        range: metres(up.steps, scales.range.fixed),
        velocity: I32F32::ZERO,
        sigma_range: scales.range.float * root(up.variance),
        sigma_velocity: f32::INFINITY,
        ambiguity: Ambiguity::Coupled,
        verdict: tone.verdict,
    }
}

fn worst(tones: &[Tone], contradiction: bool) -> Verdict {
    let least = if contradiction { Verdict::Unresolved } else { Verdict::Good };
    tones.iter().map(|t| t.verdict).fold(least, Verdict::max)
}

fn root(x: f32) -> f32 {
    libm::sqrtf(x.max(0.0))
}

/// The beats of a target, [up, flat, down], in signed cycles per sample, for simulators and tests.
/// I/Q samples show the signs, real samples only the magnitudes.
pub fn beats(range_m: f64, velocity_mps: f64, range_scale: f64, velocity_scale: f64) -> [f64; 3] {
    let (range, doppler) = (range_m / range_scale, velocity_mps / velocity_scale);
    [range - doppler, doppler, range + doppler]
}
