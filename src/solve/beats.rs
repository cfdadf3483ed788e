//! The beats of a chirp of one target: what each pattern of signs means.

pub use super::candidates::Ambiguity;
use super::candidates::Decision;
use super::equations::Equations;
use super::hypothesis::{Hypothesis, Lines, SAME};
use super::target::Target;
use super::waveform::{SPEED_OF_LIGHT, Scale, metres};
use crate::math::fixed_point::{in_steps, to_f32};
use crate::math::scalar::Scalar as _;
use crate::tone::evidence::EDGE_BINS;
use crate::tone::verdict::Usable;
use crate::tone::{Tone, Verdict};
use fixed::types::I32F32;

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
    let agree = |beats: &[Beat; 3], told| least_excess(beats, told, signed, equations) <= 1.0;
    let [_, own, _] = beats;
    let [rising, flat, falling] = *tones;
    let slow = vague_flat(&[rising, Tone::ZERO, falling], EDGE_BINS, equations);
    let verdict = flat.verdict;
    // The variance is a third of the square of 1.5 bins.
    let beside = squared(own.steps) < 3.0 * equations.edge;
    let unseen = matches!(verdict, Verdict::Weak | Verdict::NoSignal);
    if verdict.usable() > Usable::WithinSigma && beside
        || unseen && !agree(&beats, true) && agree(&slow, false)
    {
        (slow, false)
    } else {
        (beats, true)
    }
}

/// The beats, if the flat one is only known within some bins.
fn vague_flat([up, flat, down]: &[Tone; 3], bins: f32, equations: &Equations) -> [Beat; 3] {
    let wider = bins / EDGE_BINS;
    let variance = wider * wider * equations.edge;
    [beat(up, equations), Beat { variance, ..beat(flat, equations) }, beat(down, equations)]
}

/// The sign patterns of real beats (up, flat, down): approaching, receding, and either so fast that the Doppler shift
/// exceeds the range beat. All others have a negative range.
const PATTERNS: [[i64; 3]; 4] = [[1, -1, -1], [1, 1, -1], [-1, -1, -1], [1, 1, 1]];

/// The condition's weights of the three beats.
fn weights(equations: &Equations) -> [f32; 3] {
    let [flat, down] = equations.condition;
    [1.0, flat.float, down.float]
}

/// Returns the targets that three beats may belong to: one for each pattern of signs. A `vague` flat beat is only known to lie within that many bins of
/// the flat tone's frequency.
#[inline(never)] // once in an image, not for each that is told
pub(crate) fn segments(
    tones: &[Tone; 3],
    vague: Option<f32>,
    signed: bool,
    equations: &Equations,
    tell: &mut dyn FnMut(Hypothesis),
) {
    let [rising, _, falling] = tones;
    let (beats, told) = match vague {
        Some(bins) => (vague_flat(tones, bins, equations), false),
        None => beats(tones, signed, equations),
    };
    let seen = if told { &tones[..] } else { &[*rising, *falling] };
    let [up, flat, down] = weights(equations);
    let total = total(&beats, equations);
    let [v1, v2, v3] = beats.map(|b| b.variance / total);
    let sigma = |scales: &[Scale; 2]| {
        let [m1, m3] = scales.map(|scale| scale.float);
        let across = m1 * down - m3 * up;
        let alone = v1 * v3 * across * across;
        root(total * (alone + flat * flat * v2 * (m1 * m1 * v1 + m3 * m3 * v3)))
    };
    for Signed { signs, violation, y } in patterns(&beats, signed, equations) {
        let error = violation as f32;
        // The share of each ramp. Its rounding to a step of 2^-32 is far below any sigma.
        let ramps = [y[0] - (error * (up * v1)) as i64, y[2] - (error * (down * v3)) as i64];
        let (range, velocity) = place(ramps, equations);
        let squares = SAME * excess(violation, &beats, told, equations);
        tell(Hypothesis {
            range,
            velocity,
            sigma_range: sigma(&equations.range),
            sigma_velocity: sigma(&equations.velocity),
            signs,
            verdict: worst(seen, squares > SAME),
            beats: -0.5 * (squares + libm::logf(total)),
            levels: 0.0,
            last: 0.0,
        });
    }
}

/// Range and velocity from the signed beats of both ramps.
#[inline(never)] // once in an image, not for each waveform
fn place(ramps: [i64; 2], equations: &Equations) -> (I32F32, I32F32) {
    let sum = |[up, down]: [Scale; 2]| {
        metres(ramps[0], up.fixed).saturating_add(metres(ramps[1], down.fixed))
    };
    let velocity = sum(equations.velocity);
    (stretched(sum(equations.range), velocity), velocity)
}

/// The range without the share `2 V / c` by which its beat grows while the echo is under way.
pub(crate) fn stretched(range: I32F32, velocity: I32F32) -> I32F32 {
    const SHARE: f32 = (2.0 / SPEED_OF_LIGHT) as f32;
    let longer = to_f32(range) * to_f32(velocity) * SHARE;
    range.saturating_sub(in_steps(longer))
}

/// The variance of the condition.
fn total(beats: &[Beat; 3], equations: &Equations) -> f32 {
    let weights = weights(equations);
    beats.iter().zip(weights).map(|(beat, weight)| beat.variance * weight * weight).sum()
}

/// A violation squared, over its variance, with 1 at five standard deviations. A flat beat that is not `told` may be anywhere within some bins:
/// only a distance beyond them is a violation, and its variance is that of the ramps.
fn excess(violation: i64, beats: &[Beat; 3], told: bool, equations: &Equations) -> f32 {
    let total = total(beats, equations);
    if told {
        return squared(violation) / (SAME * total);
    }
    let ([_, flat, _], [_, weight, _]) = (weights(equations), beats.map(|beat| beat.variance));
    let place = flat * flat * weight;
    // The variance is a third of the square.
    let beyond = (root(squared(violation)) - root(3.0 * place)).max(0.0);
    beyond * beyond / (SAME * (total - place).max(LEAST_VARIANCE))
}

/// Steps of 2^-32 as cycles, squared.
fn squared(steps: i64) -> f32 {
    let cycles = steps as f32 / 4_294_967_296.0;
    cycles * cycles
}

/// The beats with signs, and how they violate the condition.
struct Signed {
    /// The signs of both ramps.
    signs: [i8; 2],
    violation: i64,
    /// Corrected to straight ramps.
    y: [i64; 3],
}

/// The signed beats for each pattern of signs: one for I/Q beats, up to four for real ones.
fn patterns(
    beats: &[Beat; 3],
    signed: bool,
    equations: &Equations,
) -> impl Iterator<Item = Signed> {
    let [flat, down] = equations.condition;
    let [_, _, weight] = weights(equations);
    let [y1, y2, y3] = beats.map(|beat| beat.steps);
    let (w2, w3) = (metres(y2, flat.fixed).to_bits(), metres(y3, down.fixed).to_bits());
    let all: &[[i64; 3]] = if signed { &[[1; 3]] } else { &PATTERNS };
    let possible = all.iter().filter(move |[s1, _, s3]| signed || s1 * y1 >= s3 * y3);
    possible.map(move |[s1, s2, s3]| {
        let violation =
            (s1 * y1).saturating_add(s2.saturating_mul(w2)).saturating_add(s3.saturating_mul(w3));
        let warp = warp([s1 * y1, s3 * y3], equations);
        let error = warp as f32 * (1.0 + weight);
        Signed {
            signs: [*s1 as i8, *s3 as i8],
            violation: violation.saturating_add(error as i64),
            y: [s1 * y1 + warp, s2 * y2, s3 * y3 + warp],
        }
    })
}

/// The least contradiction among all patterns of signs, squared, with 1 at five standard deviations.
fn least_excess(beats: &[Beat; 3], told: bool, signed: bool, equations: &Equations) -> f32 {
    let all = patterns(beats, signed, equations);
    let all = all.map(|Signed { violation, .. }| excess(violation, beats, told, equations));
    all.fold(f32::INFINITY, f32::min)
}

/// The reduction of both beats by bent ramps, steps of 2^-32 cycles per sample.
fn warp(ramps: [i64; 2], equations: &Equations) -> i64 {
    if equations.warp == 0.0 {
        return 0;
    }
    let range = to_f32(place(ramps, equations).0);
    (equations.warp * range * range * 4_294_967_296.0) as i64
}

/// The contradiction between the three beats of a trapezoid, squared, with 1 at five standard deviations. Above 1, [`trapezoid`](super::chirp::trapezoid) calls them
/// unresolved.
pub fn contradiction(tones: &[Tone; 3], signed: bool, equations: &Equations) -> f32 {
    let (beats, told) = beats(tones, signed, equations);
    least_excess(&beats, told, signed, equations)
}

/// Reports the targets that the beats of two ramps may belong to: one for I/Q beats, two for real ones.
#[inline(never)] // once in an image, not for each that is told
pub(crate) fn ramps(
    tones: &[Tone; 2],
    signed: bool,
    equations: &Equations,
    tell: &mut dyn FnMut(Hypothesis),
) {
    let [up, down] = tones.each_ref().map(|tone| beat(tone, equations));
    let sigma = |[m1, m3]: [Scale; 2]| {
        root(m1.float * m1.float * up.variance + m3.float * m3.float * down.variance)
    };
    let (sigma_range, sigma_velocity) = (sigma(equations.range), sigma(equations.velocity));
    // Slower than its range beat: the beats have different signs. Faster: both have the sign of the Doppler shift.
    let sign = if down.steps < up.steps { 1 } else { -1 };
    let signs: &[[i64; 2]] = if signed { &[[1, 1]] } else { &[[1, -1], [sign, sign]] };
    for &[s1, s3] in signs {
        let beats = [s1 * up.steps, s3 * down.steps];
        let warp = warp(beats, equations);
        let (range, velocity) = place(beats.map(|beat| beat + warp), equations);
        let verdict = worst(tones, false);
        let (beats, levels, last) = (0.0, 0.0, 0.0);
        tell(Hypothesis {
            range,
            velocity,
            sigma_range,
            sigma_velocity,
            signs: [s1 as i8, s3 as i8],
            verdict,
            beats,
            levels,
            last,
        });
    }
}

/// The answer to a chirp without any line on one of its ramps.
pub(crate) fn unseen(lines: &Lines) -> Target {
    let tones = lines.iter().flatten().map(|line| line.tone.verdict);
    Target {
        velocity: None,
        sigma_range: f32::INFINITY,
        sigma_velocity: f32::INFINITY,
        verdict: tones.fold(Verdict::NoSignal, Verdict::max),
        ..Target::default()
    }
}

/// Solves a sawtooth from its single tone. `signed` is true for an I/Q beat, whose sign is known.
///
/// The beat couples range and velocity: without a bound of the velocity the range is that of a target at rest, the velocity is not known,
/// and the answer is [`Verdict::Ambiguous`]. A bound of the velocity decides: the range is the mean over the velocities that the bounds
/// allow, and its sigma covers them, as a uniform distribution.
pub fn sawtooth(tone: &Tone, signed: bool, equations: &Equations) -> Target {
    let up = beat(tone, equations);
    let ([scale, _], [speed, _]) = (equations.range, equations.velocity);
    let warp = warp([up.steps, 0], equations);
    let range = metres(up.steps.saturating_add(warp), scale.fixed);
    let sigma_range = scale.float.abs() * root(up.variance);
    let mut target = Target {
        range,
        velocity: None,
        sigma_range,
        sigma_velocity: f32::INFINITY,
        ambiguity: Ambiguity::Coupled,
        verdict: tone.verdict,
    };
    // Metres of range for one metre per second.
    let coupling = scale.float / speed.float;
    let resting = to_f32(range);
    let bounds = &equations.bounds;
    let [nearest, farthest] = [bounds.range[0].max(0.0), bounds.range[1]];
    let [slowest, fastest] = bounds.velocity;
    // A real beat may be that of a target so fast that its Doppler shift exceeds the range's beat.
    let fast = !signed && coupling * fastest - resting.abs() >= nearest;
    if bounds.limit_velocity() && coupling > 0.0 && !fast {
        // The velocities that the bounds of the range allow, too.
        let low = slowest.max((nearest - resting) / coupling);
        let high = fastest.min((farthest - resting) / coupling);
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low).max(0.0));
        let possible = (low - high) * coupling <= root(SAME) * sigma_range;
        let least = if possible { Verdict::Good } else { Verdict::Unresolved };
        target.range =
            stretched(range.saturating_add(in_steps(coupling * middle)), in_steps(middle));
        target.sigma_range =
            root(up.variance * scale.float * scale.float + coupling * coupling * half * half / 3.0);
        target.ambiguity = Ambiguity::Decided(Decision::Bound);
        target.verdict = target.verdict.max(least);
    } else if target.verdict.usable() < Usable::No {
        target.verdict = target.verdict.max(Verdict::Ambiguous);
    }
    let least = if target.range < 0 { Verdict::Unresolved } else { Verdict::Good };
    Target { verdict: target.verdict.max(least), ..target }
}

fn worst(tones: &[Tone], contradiction: bool) -> Verdict {
    let least = if contradiction { Verdict::Unresolved } else { Verdict::Good };
    tones.iter().map(|t| t.verdict).fold(least, Verdict::max)
}

fn root(x: f32) -> f32 {
    x.max(0.0).root()
}
