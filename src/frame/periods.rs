//! The velocity of a target from two frames of different periods, such as 5 to 6: their aliases agree only at the true velocity.

use super::plan::FramePlan;
use super::target::FrameTarget;
use crate::list::insert;
use crate::math::fixed_point::{in_steps, to_f32};
use crate::solve::candidates::{Ambiguity, CANDIDATES, Candidate, Candidates};
use crate::tone::Verdict;
use heapless::Vec;

/// From these odds on a velocity is decided.
const SURE: f32 = 1e4;

/// Two velocities of one target differ by no more than this many standard deviations.
const AGREES: f32 = 6.0;

/// The most aliases that are compared on each side of the slowest.
const ALIASES: i32 = 64;

/// A velocity that both frames allow.
#[derive(Clone, Copy)]
struct Agreed {
    /// Aliases of the first frame beyond its own answer.
    alias: i32,
    weight: f32,
}

/// The target of the first frame with the velocity on which both frames agree, each a target and the plan of its frame. `changed_mps` is one standard
/// deviation of the change of the velocity from the middle of one frame to that of the other. The bounds of the first plan hold.
///
/// Where the two agree on one velocity, by odds of 10 000 to 1, the verdict is as if the velocity had not been ambiguous. Where they agree on
/// several it is [`Verdict::Ambiguous`] and lists them; where they agree on none, [`Verdict::Unresolved`]: the targets are not the same one.
/// Cost: some ten operations for each alias of either frame.
pub fn settle(
    first: (&FrameTarget, &FramePlan),
    second: (&FrameTarget, &FramePlan),
    changed_mps: f32,
) -> FrameTarget {
    let ((one, plan), (other, other_plan)) = (first, second);
    let [velocity, other_velocity]: [f32; 2] =
        [one, other].map(|found| to_f32(found.target.velocity.unwrap_or_default()));
    let variance = [one.target.sigma_velocity, other.target.sigma_velocity, changed_mps];
    let variance: f32 = variance.iter().map(|sigma| sigma * sigma).sum();
    let [step, other_step] = [plan.alias_mps(), other_plan.alias_mps()];
    let [low, high] = if plan.bounds.limit_velocity() {
        let margin = AGREES * one.target.sigma_velocity;
        [plan.bounds.velocity[0] - margin, plan.bounds.velocity[1] + margin]
    } else {
        [f32::NEG_INFINITY, f32::INFINITY]
    };
    let slowest = -libm::roundf(velocity / step) as i32;
    let mut agreed = Vec::<Agreed, CANDIDATES>::new();
    let mut total = 0.0;
    for place in -ALIASES..=ALIASES {
        let alias = slowest.saturating_add(place);
        let here = velocity + alias as f32 * step;
        if !(low <= here && here <= high) {
            continue;
        }
        let off = here - other_velocity;
        let off = off - other_step * libm::roundf(off / other_step);
        let square = off * off / variance.max(f32::MIN_POSITIVE);
        if square > AGREES * AGREES {
            continue;
        }
        let weight = libm::expf(-0.5 * square);
        total += weight;
        let at = agreed.iter().position(|known| weight > known.weight).unwrap_or(agreed.len());
        insert(&mut agreed, at, Agreed { alias, weight });
    }
    let verdict = one.line.tone.verdict;
    let place = |alias: i32| {
        let more = alias as f32 * step;
        let farther = more * plan.range.float / plan.shift.float;
        let range = one.target.range.saturating_add(in_steps(farther));
        (range, one.target.velocity.unwrap_or_default().saturating_add(in_steps(more)))
    };
    let Some(best) = agreed.first() else {
        let mut target = one.target;
        target.verdict = target.verdict.max(Verdict::Unresolved);
        return FrameTarget { target, ..*one };
    };
    let (range, velocity) = place(best.alias);
    let mut target = one.target;
    (target.range, target.velocity, target.verdict) = (range, Some(velocity), verdict);
    target.ambiguity = Ambiguity::None;
    if (total - best.weight) * SURE > best.weight {
        let all = agreed.iter().map(|Agreed { alias, weight }| {
            let (range, velocity) = place(*alias);
            Candidate { range, velocity, odds: weight / total }
        });
        target.ambiguity = Ambiguity::Several(Candidates::new(all));
        target.verdict = verdict.max(Verdict::Ambiguous);
    }
    FrameTarget { target, ..*one }
}
