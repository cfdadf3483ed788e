//! One round: every cause is weighed on the residual, and the best joins the fit if its odds are high.
//!
//! With even odds for `nothing more` and the rest shared equally among the causes, a cause's weight is its prior times its likelihood over
//! all its sizes. The best cause joins the fit if its odds over `nothing more` exceed [`KEPT_AT`]. The mixture of all hypotheses gives mean
//! and variance of the offset.

use super::belief::Belief;
use super::beside::Pair;
use super::causes::{self, Best, Ground, Place};
use super::chance;
use super::constants::{
    CAUSES, CHANCE, EDGE, KEPT_AT, LENGTHS, LINES, NEAR, NOTHING_MORE, REACH, SMOOTH, WALK,
};
use super::joint::{Joint, Other, Solution};
use super::leftover::{Leftover, exponential};
use super::moments::Moments;
use super::window::Window;
use super::{beside, slow};
use crate::math::scalar::Scalar as _;
use core::iter::once;
use num_complex::Complex;

/// A signal that may be there beside a steady tone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Cause {
    /// The level changes.
    Level,
    /// The phase bends, as in a sweep.
    Bend,
    /// The phase wanders or jumps.
    Wander,
    /// A drift, or hum of less than two cycles in the record.
    Slow,
    /// Leakage of lines beyond the window.
    Leak,
    /// Another line.
    Line,
    /// Two lines at equal distances below and above the tone: the sidebands of a modulation.
    Sidebands,
}

impl Cause {
    /// All causes, in the order of [`Answer::kept`](super::Answer::kept).
    pub const ALL: [Self; CAUSES] = [
        Self::Level,
        Self::Bend,
        Self::Wander,
        Self::Slow,
        Self::Leak,
        Self::Line,
        Self::Sidebands,
    ];

    /// The name in outputs.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Level => "level",
            Self::Bend => "bend",
            Self::Wander => "wander",
            Self::Slow => "slow",
            Self::Leak => "leak",
            Self::Line => "line",
            Self::Sidebands => "sidebands",
        }
    }
}

/// Nothing more, each cause, and lines elsewhere than the best one.
pub const HYPOTHESES: usize = CAUSES + 2;

/// The number of times that each cause was kept.
pub type Kept = [u8; CAUSES];

/// The result of a round.
pub struct Round {
    /// The residual's moments.
    pub moments: Moments,

    /// Nothing more, each cause, and lines elsewhere: the offset is in bins from the peak.
    pub beliefs: [Belief; HYPOTHESES],
    /// The cause that stays, and the logarithm of its odds over nothing more.
    pub stays: Option<(Cause, f32)>,
    /// The residual is larger near the tone than away from it.
    pub lumpy: bool,
    /// The evidence of the residual.
    pub leftover: Leftover,
    /// The noise's power over the ring's if nothing more is there.
    pub scale: f32,
    /// The degrees of freedom that the residual adds to the ring's noise estimate.
    pub free: f32,
    found: Found,
}

/// The causes as they join the fit.
struct Found {
    level: [(Best, [f32; SMOOTH]); 3],
    wander: Best,
    line: Place,
    close: bool,
    sidebands: Pair,
    /// The variance of the offset.
    spread: f32,
}

/// The logarithm of the prior of a line in an interval of this width at this distance: even within a bin, log-uniform beyond.
fn place_prior(width: f32, distance: f32) -> f32 {
    /// Both sides: the first bin, and the logarithm of the 16.5 bins beyond which the window ends.
    const ALL: f32 = 2.0 * (1.0 + 2.803_360_4);
    (width / (distance.abs().max(1.0) * ALL)).log_e()
}

impl Round {
    /// Weighs every cause that may still join, beside a ring with `dof` degrees of freedom.
    #[inline(never)]
    pub fn new(window: &Window, joint: &Joint, solution: &Solution, dof: f32, kept: &Kept) -> Self {
        let leftover = Leftover::new(solution.energy, solution.free, dof);
        let strength = joint.tone.value.norm_sqr();
        let ground = Ground { leftover, variance: solution.variance(), strength };
        let [_, _, step, ..] = solution.values;
        let middle = joint.tone.offset + step;
        let moments = Moments::from_residual(window, &joint.tone, &solution.left);
        let count = |cause: Cause| kept.get(cause as usize).copied().unwrap_or(0);
        let inside = window.from_end() >= EDGE;
        let moved = |cause| inside && count(cause) == 0;
        let never = Belief::NEVER;
        let (level, levels) = causes::level(&ground, &moments);
        let (bend, _) = causes::bend(&ground, &moments);
        let (wander, wandering) = causes::wander(&ground, &moments);
        let slow = if slow::matter(window) && count(Cause::Slow) == 0 {
            beside::slow(&ground, window, solution)
        } else {
            never
        };
        let leak =
            if count(Cause::Leak) == 0 { beside::leak(&ground, window, solution) } else { never };
        let (line, elsewhere, place, close) = if joint.count < LINES {
            lines(&ground, window, joint, solution, &moments, inside)
        } else {
            (never, never, Place::NONE, false)
        };
        let sidebands = if joint.count + 2 <= LINES && !close && place.distance.is_finite() {
            let prior = place_prior(0.5, place.distance);
            beside::sidebands(&ground, window, joint, solution, place.distance.abs(), prior)
        } else {
            Pair::NONE
        };
        let share = ((1.0 - NOTHING_MORE) / CAUSES as f32).log_e();
        let only = |condition, belief: Belief| if condition { belief.times(share) } else { never };
        let nothing = ground.belief(0.0, 0.0, 0.0, 0.0).times(NOTHING_MORE.log_e());
        let beliefs = [
            nothing,
            only(moved(Cause::Level), level),
            only(moved(Cause::Bend), bend),
            only(moved(Cause::Wander), wander),
            slow.times(share),
            leak.times(share),
            line.times(share),
            sidebands.belief.times(share),
            elsewhere.times(share),
        ]
        .map(|belief| Belief { offset: belief.offset + middle, ..belief });
        let mut stays = None;
        let [nothing, rest @ ..] = &beliefs;
        let mut most = nothing.log + KEPT_AT.log_e();
        for (belief, cause) in rest.iter().zip(Cause::ALL) {
            if belief.log > most {
                most = belief.log;
                stays = Some((cause, belief.log - nothing.log));
            }
        }
        let (_, scale) = leftover.less(0.0);
        Self {
            moments,
            beliefs,
            stays,
            lumpy: lumpy(window, solution),
            leftover,
            scale,
            free: solution.free,
            found: Found {
                level: levels,
                wander: wandering,
                line: place,
                close,
                sidebands,
                spread: ground.variance,
            },
        }
    }

    /// The mixture of all hypotheses, with the weights' sum as unit.
    pub fn all(&self) -> Belief {
        let all = self.beliefs.into_iter().fold(Belief::NEVER, Belief::or);
        Belief { log: 0.0, ..all }
    }

    /// The weight of each hypothesis, as a share of all.
    pub fn weights(&self) -> [f32; HYPOTHESES] {
        let all = self.beliefs.into_iter().fold(Belief::NEVER, Belief::or).log;
        self.beliefs.map(|belief| exponential(belief.log - all))
    }

    /// The hypotheses that lost against a cause, with the cause's weight as unit. A pair of sidebands includes the line: whichever of the
    /// two joins, the other is not a rival.
    pub fn rivals(&self, cause: Cause) -> Belief {
        let unit = self.beliefs.get(cause as usize + 1).map_or(0.0, |belief| belief.log);
        let is_rival = |other: Option<Cause>| match cause {
            Cause::Line | Cause::Sidebands => {
                !matches!(other, Some(Cause::Line | Cause::Sidebands))
            }
            _ => other != Some(cause),
        };
        // Nothing more, the causes, and lines elsewhere.
        let names = once(None).chain(Cause::ALL.map(Some)).chain(once(None));
        let others = self.beliefs.iter().zip(names).filter(|(_, name)| is_rival(*name));
        others.fold(Belief::NEVER, |all, (belief, _)| all.or(belief.times(-unit)))
    }

    /// Adds the cause to the fit; returns whether it is a change of the tone, or a line that looks like one.
    pub fn keep(&self, cause: Cause, joint: &mut Joint) -> bool {
        let strength = joint.tone.value.norm_sqr();
        // A column of order p has a (2 p + 1)th of the tone's energy.
        let priors = |variance: f32, sizes: &[f32]| {
            let mut priors = [0.0; SMOOTH];
            let orders = sizes.iter().zip(LENGTHS.iter().skip(1));
            for (prior, (size, length)) in priors.iter_mut().zip(orders) {
                *prior = strength / (variance * size * length * length).max(1e-9);
            }
            priors
        };
        match cause {
            Cause::Level => {
                let [mut best, rest @ ..] = self.found.level;
                for other in rest {
                    if other.0.log > best.0.log {
                        best = other;
                    }
                }
                joint.level = priors(best.0.variance, &best.1).map(Some);
            }
            Cause::Wander => {
                let priors = priors(self.found.wander.variance, &WALK);
                // Order 1 is the frequency itself.
                joint.hidden = self.found.wander.variance * self.found.spread;
                for (order, prior) in joint.phase.iter_mut().zip(priors).skip(1) {
                    *order = Some(order.unwrap_or(prior));
                }
            }
            Cause::Bend => {
                let [_, second, ..] = &mut joint.phase;
                *second = Some(0.0);
            }
            Cause::Slow => joint.slow = true,
            Cause::Leak => joint.leak = true,
            Cause::Line => {
                let Place { distance, value: [re, im], .. } = self.found.line;
                let value = Complex::new(re, im);
                let unit = joint.tone.value * (1.0 / strength.root().max(1e-30));
                joint.add(distance, if self.found.close { value * unit } else { value });
            }
            Cause::Sidebands => {
                let Pair { distance, values: [re, im, other, turned], .. } = self.found.sidebands;
                joint.add(-distance, Complex::new(re, im));
                joint.add(distance, Complex::new(other, turned));
            }
        }
        match cause {
            Cause::Level | Cause::Bend | Cause::Wander => true,
            Cause::Slow | Cause::Leak | Cause::Sidebands => false,
            Cause::Line => self.found.close,
        }
    }
}

/// The belief in a line at the most probable distance, in lines elsewhere, the line, and whether it is a close one.
fn lines(
    ground: &Ground,
    window: &Window,
    joint: &Joint,
    solution: &Solution,
    moments: &Moments,
    inside: bool,
) -> (Belief, Belief, Place, bool) {
    /// Distances within this many bins belong to one line.
    const SAME: f32 = 0.6;
    let mut close = causes::close(ground, moments, |distance| place_prior(0.25, distance));
    if !inside {
        close = [[Place::NONE; 2]; 6];
    }
    let prior = |distance| place_prior(0.5, distance);
    let far = beside::lines(ground, window, joint, solution, prior);
    let (close, far) = (close.as_flattened(), far.as_flattened());
    let mut best = (Place::NONE, false);
    for (place, near) in
        close.iter().map(|place| (place, true)).chain(far.iter().map(|place| (place, false)))
    {
        if place.best.log > best.0.best.log {
            best = (*place, near);
        }
    }
    let (mut here, mut elsewhere) = (Belief::NEVER, Belief::NEVER);
    for place in close.iter().chain(far) {
        let group = if (place.distance - best.0.distance).abs() < SAME {
            &mut here
        } else {
            &mut elsewhere
        };
        *group = group.or(place.belief);
    }
    (here, elsewhere, best.0, best.1)
}

/// The belief in a whole fit, for comparing fits to a window, with its solution's offset.
pub fn belief_in(joint: &Joint, solution: &Solution, leftover: &Leftover) -> Belief {
    let [_, _, step, ..] = solution.values;
    let (log, power) = leftover.less(leftover.energy() - solution.energy);
    Belief {
        log: log - solution.cost(),
        offset: joint.tone.offset + step,
        variance: power * solution.variance(),
    }
}

/// The logarithm of the prior density of a line's distance over the density of its prior in a fit, near the tone.
pub fn density(other: &Other) -> f32 {
    let [_, precision] = other.precision;
    place_prior(1.0, 1.0) - 0.5 * (precision / core::f32::consts::TAU).log_e()
}

/// Whether the residual is larger near the tone than noise would leave there, given the residual away from it.
fn lumpy(window: &Window, solution: &Solution) -> bool {
    /// The inner bins on each side of the peak.
    const INNER: i32 = 4;
    /// The fewest degrees of freedom of each part.
    const FEWEST: f32 = 4.0;
    let (mut inner, mut outer) = ([0.0; 2], [0.0; 2]);
    for ((i, left), used) in (-(REACH as i32)..).zip(&solution.left).zip(&window.used) {
        let [energy, numbers] = if i.abs() <= INNER { &mut inner } else { &mut outer };
        *energy += left.norm_sqr();
        *numbers += 2.0 * used;
    }
    let free = (inner[1] - solution.fitted(window)).max(FEWEST);
    let others = outer[1].max(FEWEST);
    inner[0] * others > outer[0] * free * chance::ratio(CHANCE, free, others)
}

/// Whether a cause that joined is a change of the tone, or a line so near that it looks like one. The bend of a chirp is not a change.
pub fn is_near(joint: &Joint, kept: &Kept, bends: bool) -> bool {
    let [level, bend, wander, ..] = kept;
    let bend = if bends { &0 } else { bend };
    let near = |other: &Other| (other.line.offset - joint.tone.offset).abs() < NEAR;
    level + bend + wander > 0 || joint.lines().iter().any(near)
}
