//! The targets that the lines of a chirp's ramps may belong to, and the choice between them.
//!
//! A target has a line on every ramp. Two targets have two on each, and nothing in a triangle says which belong together; real samples do not
//! show the signs of beats, either. So every combination of lines and of signs is a hypothesis, with a weight: the likelihood of its
//! beats (a trapezoid's three satisfy one condition), of its levels (the echoes of one target are equally strong), and of the movement from a
//! hypothesis of the last chirp (a ghost is not where its own velocity takes it). Bounds exclude what cannot be. Where one hypothesis is left,
//! except for a probability of [`WRONG`], it is the target; otherwise the answer is [`Verdict::Ambiguous`] and lists them.
//!
//! The knowledge is used in this order: beats, bounds, levels, last chirp. The answer states what decides first.

use super::beats;
use super::candidates::{Ambiguity, Candidate, Candidates, Decision};
use super::equations::Equations;
use super::hypothesis::{Before, Hypothesis, KEPT, Last, Line, Lines, SAME};
use super::target::Target;
use super::waveform::Shape;
use crate::list::first;
use crate::tone::lines::DRIFT;
use crate::tone::{Tone, Usable, Verdict};
use heapless::Vec;

/// The probability of all other hypotheses below which one is taken as right.
pub const WRONG: f32 = 1e-3;

/// The variance of the logarithm of the ratio between the two echoes of one target, in addition to noise: half a decibel squared.
const LEVEL: f32 = 0.057_56 * 0.057_56;

/// Bins around a line's peak within which another is not found: two lines less than two bins apart are one, and a peak is up to half a bin
/// from its bin.
const MERGED: f32 = 2.5;

/// The weights of the hypotheses at each step, and what the step adds.
const STEPS: [Option<Decision>; 4] =
    [None, Some(Decision::Bound), Some(Decision::Levels), Some(Decision::LastChirp)];

/// The target of the line `of` of the rising ramp. `last` is the chirp that began `time_s` seconds before; the chirp takes its place.
///
/// Cost: six products of 64 bits and some sixty operations of 32-bit floats for each hypothesis: one for an I/Q triangle of one target, two
/// for a real one, up to four for a trapezoid; two targets have four times as many, or eight times for a trapezoid.
pub(crate) fn solve(
    lines: &Lines,
    of: usize,
    signed: bool,
    equations: &Equations,
    before: Option<(&mut Last, Option<f32>)>,
) -> Target {
    let [ups, _, downs] = lines;
    let (mut own, mut others) = (Vec::<Hypothesis, KEPT>::new(), Vec::<Hypothesis, KEPT>::new());
    for (index, up) in ups.iter().enumerate() {
        let kept = if index == of { &mut own } else { &mut others };
        each(up, lines, signed, equations, &mut |hypothesis| keep(kept, hypothesis));
    }
    let mut last = before;
    let mut led = false;
    if let Some((Last { kept }, Some(time_s))) = &last {
        for hypothesis in own.iter_mut().chain(&mut others) {
            let ways = kept.iter().map(|old| (hypothesis.away(old, *time_s), old.weight));
            // Two values, each within five deviations.
            led |= ways.clone().any(|(away, _)| away <= 2.0 * SAME);
            let ways = ways.map(|(away, weight)| weight - 0.5 * away);
            hypothesis.last = ways.fold(f32::NEG_INFINITY, f32::max);
        }
    }
    // If no hypothesis leads here from the last chirp, these are other targets.
    let weight = |step: usize, hypothesis: &Hypothesis| {
        let Hypothesis { beats, levels, last, .. } = *hypothesis;
        if step >= 1 && !hypothesis.is_within(equations) {
            return f32::NEG_INFINITY;
        }
        let levels = if step >= 2 { levels } else { 0.0 };
        let last = if step >= 3 && led { last } else { 0.0 };
        beats + levels + last
    };
    let ahead = own.iter().any(Hypothesis::is_ahead);
    if ahead {
        own.retain(Hypothesis::is_ahead);
    }
    others.retain(Hypothesis::is_ahead);
    // A falling beat may belong to another rising one, if some target's falling beat is not seen.
    let hidden = downs.len() < ups.len();
    let rivals = if hidden { others.as_slice() } else { &[] };
    let within = own.iter().any(|hypothesis| hypothesis.is_within(equations));
    let last_step = match (within, led) {
        (false, _) => 0,
        (true, false) => 2,
        (true, true) => 3,
    };
    let mut choice: Option<Choice> = None;
    let mut decided = None;
    for (step, by) in STEPS.into_iter().enumerate().take(last_step + 1) {
        let ranks = |hypothesis: &Hypothesis| weight(last_step, hypothesis);
        let found = Choice::new(&own, rivals, &|hypothesis| weight(step, hypothesis), &ranks);
        // Levels that contradict each other decide nothing.
        let equal = |best: &Hypothesis| -2.0 * best.levels <= SAME;
        let sure = found.as_ref().filter(|found| found.wrong <= WRONG);
        decided = sure.filter(|found| step < 2 || equal(&found.best)).map(|_| by);
        choice = found.or(choice);
        if decided.is_some() {
            break;
        }
    }
    let Some(Choice { best, wrong }) = choice else {
        return beats::unseen(lines);
    };
    let least = if within && best.range >= 0 { Verdict::Good } else { Verdict::Unresolved };
    let mut target = best.target();
    target.verdict = target.verdict.max(least);
    if let Some(by) = decided {
        target.ambiguity = by.map_or(Ambiguity::None, Ambiguity::Decided);
    } else {
        let listed = listed(&own, &best, wrong, &|hypothesis| weight(last_step, hypothesis));
        target.ambiguity = Ambiguity::Several(listed);
        if target.verdict.usable() < Usable::No {
            target.verdict = target.verdict.max(Verdict::Ambiguous);
        }
    }
    if let Some((Last { kept }, _)) = &mut last {
        kept.clear();
        for group in [own.as_slice(), others.as_slice()] {
            let most = group.iter().map(|h| weight(3, h)).fold(f32::NEG_INFINITY, f32::max);
            for hypothesis in group.iter().filter(|h| weight(3, h) > most - SAME) {
                let Hypothesis { range, velocity, sigma_range, sigma_velocity, .. } = *hypothesis;
                let weight = weight(3, hypothesis) - most;
                // Without room the target of another line is found again.
                let _ = kept.push(Before { range, velocity, sigma_range, sigma_velocity, weight });
            }
        }
    }
    target
}

/// The best hypothesis of a step.
struct Choice {
    best: Hypothesis,
    /// The probability of all that are not the same target.
    wrong: f32,
}

impl Choice {
    /// The best of a line's own hypotheses, against the rest of them and against `others`, which give its beats to other lines. Of equals
    /// it is the one of the higher rank.
    #[inline(never)] // not once more where it is repeated
    fn new(
        own: &[Hypothesis],
        others: &[Hypothesis],
        weight: &dyn Fn(&Hypothesis) -> f32,
        rank: &dyn Fn(&Hypothesis) -> f32,
    ) -> Option<Self> {
        let heavier = |a: &&Hypothesis, b: &&Hypothesis| {
            weight(a).total_cmp(&weight(b)).then(rank(a).total_cmp(&rank(b)))
        };
        let best = *own.iter().max_by(heavier)?;
        let most = weight(&best);
        if most == f32::NEG_INFINITY {
            return None;
        }
        let share = |hypothesis: &Hypothesis| libm::expf((weight(hypothesis) - most).min(80.0));
        let (mut same, mut rest) = (0.0, 0.0);
        for hypothesis in own {
            let part = if hypothesis.is(&best) { &mut same } else { &mut rest };
            *part += share(hypothesis);
        }
        rest += others.iter().map(share).fold(0.0, f32::max);
        Some(Self { best, wrong: rest / (same + rest) })
    }
}

/// The candidates, the most probable first.
#[inline(never)] // its room on the stack is not beside the search's
fn listed(
    own: &[Hypothesis],
    best: &Hypothesis,
    wrong: f32,
    weight: &dyn Fn(&Hypothesis) -> f32,
) -> Candidates {
    let most = weight(best);
    let same = own.iter().filter(|h| h.is(best)).map(|h| libm::expf(weight(h) - most));
    let unit = (1.0 - wrong) / same.sum::<f32>().max(f32::MIN_POSITIVE);
    let mut left: Vec<Hypothesis, KEPT> = first(own.iter().copied());
    let mut next = Some(*best);
    Candidates::new(core::iter::from_fn(|| {
        let likely = next.take().or_else(|| {
            let heavier = |a: &&Hypothesis, b: &&Hypothesis| weight(a).total_cmp(&weight(b));
            left.iter().max_by(heavier).copied()
        })?;
        let shares = left.iter().filter(|h| h.is(&likely));
        let odds = unit * shares.map(|h| libm::expf(weight(h) - most)).sum::<f32>();
        left.retain(|h| !h.is(&likely));
        let Hypothesis { range, velocity, .. } = likely;
        (odds > WRONG).then_some(Candidate { range, velocity, odds })
    }))
}

/// Keeps a hypothesis, in the place of the least likely if there is no room.
fn keep(kept: &mut Vec<Hypothesis, KEPT>, hypothesis: Hypothesis) {
    let Err(hypothesis) = kept.push(hypothesis) else { return };
    let likelihood = |h: &Hypothesis| h.beats + h.levels;
    let least = kept.iter_mut().min_by(|a, b| likelihood(a).total_cmp(&likelihood(b)));
    if let Some(least) = least.filter(|least| likelihood(least) < likelihood(&hypothesis)) {
        *least = hypothesis;
    }
}

/// Each hypothesis of one line of the rising ramp.
#[inline(never)] // once in an image, not for each line
fn each(
    up: &Line,
    [ups, flats, downs]: &Lines,
    signed: bool,
    equations: &Equations,
    tell: &mut dyn FnMut(Hypothesis),
) {
    let several = ups.len().max(flats.len()).max(downs.len()) > 1;
    let fewer = flats.len() < ups.len().max(downs.len());
    for down in downs {
        let mut tell = |levels: f32, hypothesis: Hypothesis| {
            let hypothesis = Hypothesis { levels, ..hypothesis };
            tell(hypothesis.with_rises([up, down], equations));
        };
        let (rising, falling) = (&up.tone, &down.tone);
        let both = levels([rising, falling].into_iter(), equations);
        if equations.shape != Shape::Trapezoid {
            let tones = [*rising, *falling];
            beats::ramps(&tones, signed, equations, &mut |hypothesis| tell(both, hypothesis));
            continue;
        }
        for flat in flats {
            let tones = [*rising, flat.tone, *falling];
            if !(fewer && flat.is_smeared()) {
                let levels = levels(tones.iter(), equations);
                let tell = &mut |hypothesis: Hypothesis| tell(levels, hypothesis.with_flat(flat));
                beats::segments(&tones, None, signed, equations, tell);
            }
            if fewer {
                // The line may be several targets' whose velocities are nearly equal.
                let tell = &mut |hypothesis| tell(both, hypothesis);
                beats::segments(&tones, Some(MERGED), signed, equations, tell);
            }
        }
        if several {
            // The flat lines are of other targets, and this one is slow: its flat beat is where no further line is sought.
            let tones = [*rising, Tone::ZERO, *falling];
            let tell = &mut |hypothesis| tell(both, hypothesis);
            beats::segments(&tones, Some(DRIFT as f32), signed, equations, tell);
        }
    }
}

/// The logarithm of the likelihood of equal levels: minus half of the squared distances from their mean, in variances. A relative error of an
/// amplitude has the variance `1 / (n snr)`, or half of that for I/Q records.
fn levels<'a>(lines: impl Iterator<Item = &'a Tone>, equations: &Equations) -> f32 {
    let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
    for Tone { amplitude, snr, .. } in lines {
        let weight = 1.0 / (0.5 * LEVEL + 1.0 / (equations.samples * snr));
        if weight > 0.0 && *amplitude > 0.0 {
            let level = libm::logf(*amplitude);
            sum += weight;
            first += weight * level;
            second += weight * level * level;
        }
    }
    if sum > 0.0 { -0.5 * (second - first * first / sum).max(0.0) } else { 0.0 }
}
