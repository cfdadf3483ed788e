//! Range and velocity from the beats of a chirp.
//!
//! The beats `y` of the rising ramp, of the flat segment and of the falling ramp are linear in range and velocity, see
//! [`super::equations`]. Three beats and two unknowns leave one condition, `n . y = 0`. So weighted least squares needs
//! no normal equations: each beat is corrected along `n` by its share of the violation, `y_i - v_i n_i (n . y) / (n . v n)`,
//! where `v` are the variances. Both ramps then give range and velocity.
//!
//! I/Q samples show the signs of the beats. Real samples show only magnitudes: of the four possible sign patterns the one that violates the
//! condition least is chosen, whatever the weights. Ye et al. 2022 (eqs 1 and 2) use the magnitudes as the signed beats, which is wrong
//! wherever the Doppler shift exceeds the range beat.
//!
//! A negative range is never good. I/Q records show a negative range if I and Q are exchanged, or if [`Mixing`] is set the wrong way round.

use super::equations::Equations;
use crate::acquire::sample::Segment;
use crate::config::SPEED_OF_LIGHT;
use crate::math::scalar::Scalar as _;
use crate::tone::verdict::Usable;
use crate::tone::{Tone, Verdict};
use fixed::types::I32F32;

/// The value of one cycle per sample, in SI units: in fixed point for results, in float for sigmas.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scale {
    /// The scale for results.
    pub fixed: I32F32,
    /// The scale for sigmas.
    pub float: f32,
}

impl Scale {
    /// A scale of `per_cycle` units per cycle per sample; `None` if it does not fit in 31 bits, or is less than a step of 2^-32: results
    /// would be 0, and an infinite sigma times 0 would be NaN.
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
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

/// The signal that an I/Q receiver conjugates before it multiplies the two: it sets the sign of every beat.
///
/// Exchanging I and Q exchanges the variants. Real samples are equal for both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Mixing {
    /// Transmitted times the conjugate of received: an echo from a target at rest beats at a positive frequency while the ramp rises,
    /// and an approaching target's Doppler shift is negative.
    #[default]
    TxConjRx = 0,
    /// Received times the conjugate of transmitted: an approaching target's Doppler shift is positive.
    RxConjTx = 1,
}

impl Mixing {
    /// Both variants.
    pub const ALL: [Mixing; 2] = [Mixing::TxConjRx, Mixing::RxConjTx];

    /// The name that settings and flags use.
    pub const fn name(self) -> &'static str {
        match self {
            Mixing::TxConjRx => "tx-conj-rx",
            Mixing::RxConjTx => "rx-conj-tx",
        }
    }

    /// The mixing with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mixing| mixing.name() == name)
    }

    /// The sign of a beat: of the transmitter's phase now less its phase when the echo left.
    pub const fn sign(self) -> i8 {
        match self {
            Mixing::TxConjRx => 1,
            Mixing::RxConjTx => -1,
        }
    }
}

/// The ambiguity that the waveform leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Ambiguity {
    /// The answer is unique.
    #[default]
    None,
    /// A triangle with real samples: the beats also fit a second target, with the roles of range and Doppler exchanged. The order of the
    /// beats gives the sign of each velocity.
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
    /// Range, metres, at the mean of the middles of the chirp's records.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub range: I32F32,
    /// Velocity, metres per second; positive when approaching.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub velocity: I32F32,
    /// One standard deviation of the range, metres.
    pub sigma_range: f32,
    /// One standard deviation of the velocity, metres per second.
    pub sigma_velocity: f32,
    /// The ambiguity that the waveform leaves.
    pub ambiguity: Ambiguity,
    /// The worst verdict of the beats, but for a trapezoid's flat beat beside 0 Hz; at least [`Verdict::Unresolved`] if the range is
    /// negative, or if the beats contradict each other by more than five standard deviations.
    pub verdict: Verdict,
}

impl Target {
    /// The likely cause of a negative range, in a text of one line; `None` for other ranges.
    pub const fn caution(&self) -> Option<&'static str> {
        if self.range.to_bits() < 0 {
            Some("negative range: I and Q are exchanged, or mixing is the other one")
        } else {
            None
        }
    }
}

/// A beat: signed steps of 2^-32 cycles per sample, and the variance in cycles squared.
#[derive(Clone, Copy)]
struct Beat {
    steps: i64,
    variance: f32,
}

/// The least variance of a beat, from the step of the frequency's type.
const LEAST_VARIANCE: f32 = (1.0 / 4_294_967_296.0) * (1.0 / 4_294_967_296.0) / 12.0;

fn beat(tone: &Tone, equations: &Equations) -> Beat {
    let sigma = if tone.sigma.is_finite() { tone.sigma } else { 1.0 };
    let edge = if tone.verdict == Verdict::NearEdge { equations.edge } else { 0.0 };
    Beat {
        steps: i64::from(tone.frequency.0.to_bits()),
        variance: (sigma * sigma).max(LEAST_VARIANCE).max(edge),
    }
}

/// The beats of a trapezoid, and whether the flat beat's verdict counts for the target.
///
/// A slow target's flat beat is within 1.5 bins of 0 Hz, where no line can be distinguished from an offset or from its image: it counts as
/// 0 then. No line is looked for there, either. So a flat segment without a line belongs to a slow target if the beat found in it
/// contradicts the ramps and a slow target's beat does not.
fn beats(tones: &[Tone; 3], signed: bool, equations: &Equations) -> ([Beat; 3], bool) {
    let beats = tones.each_ref().map(|tone| beat(tone, equations));
    let agree = |beats: &[Beat; 3]| {
        excess(signs(beats, signed, equations).0, total(beats, equations)) <= 1.0
    };
    let [up, own, down] = beats;
    let slow = [up, Beat { steps: 0, variance: equations.edge }, down];
    let [_, Tone { verdict, .. }, _] = *tones;
    // The variance is a third of the square of 1.5 bins.
    let beside = squared(own.steps) < 3.0 * equations.edge;
    let unseen = matches!(verdict, Verdict::Weak | Verdict::NoSignal);
    if verdict.usable() > Usable::WithinSigma && beside || unseen && !agree(&beats) && agree(&slow)
    {
        (slow, false)
    } else {
        (beats, true)
    }
}

/// The squared contradiction, in variances, from which the beats do not belong to one target: five standard deviations.
const CONTRADICTION: f32 = 25.0;

/// The sign patterns of real beats (up, flat, down): approaching, receding, and either so fast that the Doppler shift
/// exceeds the range beat. All others have a negative range.
const PATTERNS: [[i64; 3]; 4] = [[1, -1, -1], [1, 1, -1], [-1, -1, -1], [1, 1, 1]];

/// The condition's weights of the three beats.
fn weights(equations: &Equations) -> [f32; 3] {
    let [flat, down] = equations.condition;
    [1.0, flat.float, down.float]
}

/// Solves a trapezoid from its three tones. `signed` is true for I/Q beats, whose signs are known.
///
/// A slow target's flat beat is beside 0 Hz, where a line is `near-edge` or not seen at all. Then both ramps give range and velocity, and
/// the flat segment only excludes a larger Doppler shift.
///
/// Cost: six products of 64 bits, and some forty operations of 32-bit floats.
pub fn trapezoid(tones: &[Tone; 3], signed: bool, equations: &Equations) -> Target {
    let (beats, told) = beats(tones, signed, equations);
    let [rising, _, falling] = tones;
    let seen = if told { &tones[..] } else { &[*rising, *falling] };
    let (violation, y) = signs(&beats, signed, equations);
    let error = violation as f32;
    let [up, flat, down] = weights(equations);
    let total = total(&beats, equations);
    let [v1, v2, v3] = beats.map(|b| b.variance / total);
    // The share of each ramp. Its rounding to a step of 2^-32 is far below any sigma.
    let ramps = [y[0] - (error * (up * v1)) as i64, y[2] - (error * (down * v3)) as i64];
    let sigma = |scales: &[Scale; 2]| {
        let [m1, m3] = scales.map(|scale| scale.float);
        let across = m1 * down - m3 * up;
        let alone = v1 * v3 * across * across;
        root(total * (alone + flat * flat * v2 * (m1 * m1 * v1 + m3 * m3 * v3)))
    };
    let target = Target {
        sigma_range: sigma(&equations.range),
        sigma_velocity: sigma(&equations.velocity),
        ambiguity: Ambiguity::None,
        verdict: worst(seen, excess(violation, total) > 1.0),
        ..place(ramps, equations)
    };
    judged(target)
}

/// Range and velocity from the signed beats of both ramps.
fn place(ramps: [i64; 2], equations: &Equations) -> Target {
    let sum = |[up, down]: [Scale; 2]| {
        metres(ramps[0], up.fixed).saturating_add(metres(ramps[1], down.fixed))
    };
    let velocity = sum(equations.velocity);
    let range = stretched(sum(equations.range), velocity);
    Target { range, velocity, ..Target::default() }
}

/// The range without the share `2 V / c` by which its beat grows while the echo is under way.
pub(crate) fn stretched(range: I32F32, velocity: I32F32) -> I32F32 {
    const SHARE: f32 = (2.0 / SPEED_OF_LIGHT) as f32;
    let longer = range.to_num::<f32>() * velocity.to_num::<f32>() * SHARE;
    range.saturating_sub(in_steps(longer))
}

/// A number in steps of 2^-32, rounded towards 0. The cast saturates and turns NaN into 0: unlike a conversion of the crate `fixed`, it
/// cannot panic.
pub(crate) fn in_steps(x: f32) -> I32F32 {
    I32F32::from_bits((x * 4_294_967_296.0) as i64)
}

/// Marks a target with a negative range as not good.
fn judged(target: Target) -> Target {
    let least = if target.range < 0 { Verdict::Unresolved } else { Verdict::Good };
    Target { verdict: target.verdict.max(least), ..target }
}

/// The variance of the condition.
fn total(beats: &[Beat; 3], equations: &Equations) -> f32 {
    let weights = weights(equations);
    beats.iter().zip(weights).map(|(beat, weight)| beat.variance * weight * weight).sum()
}

/// A violation squared, over its variance, with 1 at five standard deviations.
fn excess(violation: i64, total: f32) -> f32 {
    squared(violation) / (CONTRADICTION * total)
}

/// Steps of 2^-32 as cycles, squared.
fn squared(steps: i64) -> f32 {
    let cycles = steps as f32 / 4_294_967_296.0;
    cycles * cycles
}

/// The violation of the condition and the signed beats, for the sign pattern that violates it
/// least.
fn signs(beats: &[Beat; 3], signed: bool, equations: &Equations) -> (i64, [i64; 3]) {
    let [flat, down] = equations.condition;
    let [y1, y2, y3] = beats.map(|beat| beat.steps);
    let (w2, w3) = (metres(y2, flat.fixed).to_bits(), metres(y3, down.fixed).to_bits());
    let violation = |[s1, s2, s3]: [i64; 3]| {
        (s1 * y1).saturating_add(s2.saturating_mul(w2)).saturating_add(s3.saturating_mul(w3))
    };
    let mut best = (violation([1; 3]), [y1, y2, y3]);
    let mut least = i64::MAX;
    if signed {
        return unwarped(best, equations);
    }
    for signs in PATTERNS {
        let [s1, s2, s3] = signs;
        let error = violation(signs);
        if s1 * y1 >= s3 * y3 && error.saturating_abs() < least {
            least = error.saturating_abs();
            best = (error, [s1 * y1, s2 * y2, s3 * y3]);
        }
    }
    unwarped(best, equations)
}

/// The violation and the beats, corrected to straight ramps.
fn unwarped((violation, y): (i64, [i64; 3]), equations: &Equations) -> (i64, [i64; 3]) {
    let [_, _, weight] = weights(equations);
    let warp = warp([y[0], y[2]], equations);
    let error = warp as f32 * (1.0 + weight);
    (violation.saturating_add(error as i64), [y[0] + warp, y[1], y[2] + warp])
}

/// The reduction of both beats by bent ramps, steps of 2^-32 cycles per sample.
fn warp(ramps: [i64; 2], equations: &Equations) -> i64 {
    if equations.warp == 0.0 {
        return 0;
    }
    let range: f32 = place(ramps, equations).range.to_num();
    (equations.warp * range * range * 4_294_967_296.0) as i64
}

/// The contradiction between the three beats of a trapezoid, squared, with 1 at five standard deviations. Above 1, [`trapezoid`] calls them
/// unresolved.
pub fn contradiction(tones: &[Tone; 3], signed: bool, equations: &Equations) -> f32 {
    let (beats, _) = beats(tones, signed, equations);
    let (violation, _) = signs(&beats, signed, equations);
    excess(violation, total(&beats, equations))
}

/// Solves a triangle, or the two ramps of a trapezoid, from two tones (up, down).
///
/// Real beats fit two targets, with the roles of range and Doppler exchanged. The answer is the
/// target with the larger range beat; the other target is its ambiguity.
///
/// Cost: four products of 64 bits, eight for real beats.
pub fn triangle(tones: &[Tone; 2], signed: bool, equations: &Equations) -> Target {
    let [up, down] = tones.each_ref().map(|tone| beat(tone, equations));
    let sigma = |[m1, m3]: [Scale; 2]| {
        root(m1.float * m1.float * up.variance + m3.float * m3.float * down.variance)
    };
    let place = |ramps: [i64; 2]| {
        let warp = warp(ramps, equations);
        place(ramps.map(|beat| beat + warp), equations)
    };
    let (target, ambiguity) = if signed {
        (place([up.steps, down.steps]), Ambiguity::None)
    } else {
        // Faster than its range beat: both beats have the sign of the Doppler shift.
        let sign = if down.steps < up.steps { 1 } else { -1 };
        let other = place([sign * up.steps, sign * down.steps]);
        let Target { range, velocity, .. } = other;
        (place([up.steps, -down.steps]), Ambiguity::Exchange { range, velocity })
    };
    judged(Target {
        sigma_range: sigma(equations.range),
        sigma_velocity: sigma(equations.velocity),
        ambiguity,
        verdict: worst(tones, false),
        ..target
    })
}

/// Solves a sawtooth from its single tone: the range of a target at rest.
pub fn sawtooth(tone: &Tone, equations: &Equations) -> Target {
    let up = beat(tone, equations);
    let [scale, _] = equations.range;
    let warp = warp([up.steps, 0], equations);
    judged(Target {
        range: metres(up.steps.saturating_add(warp), scale.fixed),
        velocity: I32F32::ZERO,
        sigma_range: scale.float.abs() * root(up.variance),
        sigma_velocity: f32::INFINITY,
        ambiguity: Ambiguity::Coupled,
        verdict: tone.verdict,
    })
}

fn worst(tones: &[Tone], contradiction: bool) -> Verdict {
    let least = if contradiction { Verdict::Unresolved } else { Verdict::Good };
    tones.iter().map(|t| t.verdict).fold(least, Verdict::max)
}

fn root(x: f32) -> f32 {
    x.max(0.0).root()
}
