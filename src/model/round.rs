//! One round: every cause is weighed on the residual, and the best joins the fit if its odds are high.
//!
//! With even odds for `nothing more` and the rest shared equally among the causes, a cause's weight is its prior times its likelihood over
//! all its sizes. The best cause joins the fit if its odds over `nothing more` exceed [`KEPT_AT`]. The mixture of all hypotheses gives mean
//! and variance of the offset.

use super::belief::Belief;
use super::changes::{Moments, PLACES, SMOOTHS, level, swing};
use super::constants::{CAUSES, EDGE, KEPT_AT, NOTHING_MORE, ORDERS, WALK};
use super::envelope::{Envelope, Near, Term};
use super::far::{self, FARS, INTERVAL, Place, Reach, Sidebands, place_prior};
use super::joint::{Far, Joint};
use super::leftover::Leftover;
use super::logarithm::{exp, ln};
use super::size::{Direction, Ground, Weighed, energy};
use super::window::Window;
use crate::math::scalar::{Scalar as _, larger};
use core::f32::consts::LN_2;
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
    /// Another line.
    Line,
    /// Two lines at equal distances below and above the tone: the sidebands of a modulation.
    Sidebands,
}

impl Cause {
    /// All causes, in the order of [`Answer::kept`](super::Answer::kept).
    pub const ALL: [Self; CAUSES] =
        [Self::Level, Self::Bend, Self::Wander, Self::Line, Self::Sidebands];

    /// The name in outputs.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Level => "level",
            Self::Bend => "bend",
            Self::Wander => "wander",
            Self::Line => "line",
            Self::Sidebands => "sidebands",
        }
    }
}

/// Nothing more, each cause, and lines elsewhere than the best one.
pub const HYPOTHESES: usize = CAUSES + 2;

/// The number of times that each cause was kept.
pub type Kept = [u8; CAUSES];

/// A cause as it joins the fit.
#[derive(Clone, Copy, Debug)]
pub enum Joins {
    /// A level of this variance and smoothness.
    Level(f32, usize),
    /// A bend.
    Bend,
    /// A phase that wanders, of this variance.
    Wander(f32),
    /// A line close to the tone, at this distance.
    Near(f32, Complex<f32>),
    /// A line with columns of its own.
    Far(f32, Complex<f32>, Reach),
    /// Two such lines, at opposite distances.
    Sidebands(f32, [Complex<f32>; 2]),
}

/// The result of a round.
#[derive(Debug)]
pub struct Round {
    /// The residual's moments.
    pub moments: Moments,
    /// Nothing more, each cause, and lines elsewhere: the offset is in bins from the tone.
    pub beliefs: [Belief; HYPOTHESES],
    /// The cause that stays, the logarithm of its odds over nothing more, and how it joins.
    pub stays: Option<(Cause, f32, Joins)>,
    /// The evidence of the residual.
    pub leftover: Leftover,
    /// The noise's power over the ring's if nothing more is there.
    pub scale: f32,
}

/// A cause whose gain is this far below the best one's is not weighed.
const BEHIND: f32 = 14.0;

impl Round {
    /// Weighs every cause that may still join, beside a ring with `dof` degrees of freedom.
    #[inline(never)]
    pub fn new(window: &Window, joint: &Joint, dof: f32, kept: &Kept) -> Self {
        let leftover = Leftover::new(joint.energy, joint.free, dof);
        let strength = joint.envelope.size() * joint.envelope.size();
        let ground = Ground { leftover, variance: joint.envelope.variance, strength };
        let moments = Moments::of(joint);
        let inside = window.from_end() >= EDGE;
        let open = |cause: Cause| inside && kept.get(cause as usize) == Some(&0);
        // The most energy that each change can explain.
        let deviation = ground.variance.root();
        let levels = moments.levels();
        let [level, ..] = &levels;
        let (bend, wander) = (moments.bend(), moments.wander(deviation));
        let close = moments.close(deviation);
        let energies = [energy(level), energy(&bend), energy(&wander)];
        let close_energies = close.map(|(_, directions)| energy(&directions));
        let largest = energies.iter().chain(&close_energies).fold(0.0, |a, b| larger(a, *b));
        // A cause that explains far less than the best one cannot win.
        let least = 0.3 * if largest < 200.0 / 0.3 { largest } else { 200.0 / 0.3 };
        let gain = |energy: f32| if energy > least { ground.gain(energy) } else { 0.0 };
        let gains = energies.map(gain);
        let close_gains = close_energies.map(gain);
        let (far, pair) = far::lines(window, joint, &ground);
        let most = gains.into_iter().chain(close_gains).chain(far.map(|place| place.best));
        let margin = most.fold(pair.best, larger) - BEHIND;
        // The causes that might win are weighed in full.
        let weigh = |cause, gain: f32, directions: &[Direction], most| {
            if open(cause) && gain > margin {
                ground.weigh(directions, most)
            } else {
                Weighed::NEVER
            }
        };
        let [level_gain, bend_gain, wander_gain] = gains;
        let levels = levels.map(|level| weigh(Cause::Level, level_gain, &level, 2.0 * strength));
        let bent = weigh(Cause::Bend, bend_gain, &bend, 8.0 * strength);
        let wandered = weigh(Cause::Wander, wander_gain, &wander, 8.0 * strength);
        let mut places = [Place::NONE; PLACES + FARS];
        if inside && joint.vacant() > 0 && joint.envelope.near.is_none() {
            let unit = joint.envelope.unit;
            for (place, ((distance, directions), gain)) in
                places.iter_mut().zip(close.iter().zip(close_gains))
            {
                if gain > margin {
                    let prior = place_prior(INTERVAL, *distance);
                    *place =
                        Place::weighed(&ground, *distance, directions, unit, prior, Reach::Close);
                }
            }
        }
        places.iter_mut().skip(PLACES).zip(far).for_each(|(place, far)| *place = far);
        let (here, elsewhere, best) = together(&places);
        Self::choose(ground, moments, &levels, &bent, &wandered, [here, elsewhere], &best, &pair)
    }

    /// The weights of all hypotheses, and the cause that stays.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "one for each cause")]
    fn choose(
        ground: Ground,
        moments: Moments,
        levels: &[Weighed; SMOOTHS],
        bent: &Weighed,
        wandered: &Weighed,
        [here, elsewhere]: [Belief; 2],
        line: &Place,
        pair: &Sidebands,
    ) -> Self {
        let level = Belief::any(&levels.map(|level| level.belief.times(-LN_2)));
        let mut smooth = 0;
        let mut best = Weighed::NEVER;
        for (number, level) in levels.iter().enumerate() {
            if level.best > best.best {
                (best, smooth) = (*level, number);
            }
        }
        let share = ln((1.0 - NOTHING_MORE) / CAUSES as f32);
        let scale = ground.leftover.scale();
        let nothing =
            Belief { log: ln(NOTHING_MORE), offset: 0.0, variance: ground.variance * scale };
        let others = [level, bent.belief, wandered.belief, here, pair.belief, elsewhere];
        let [level, bend, wander, here, sidebands, elsewhere] =
            others.map(|belief| belief.times(share));
        let beliefs = [nothing, level, bend, wander, here, sidebands, elsewhere];
        let joins = [
            Joins::Level(best.variance, smooth),
            Joins::Bend,
            Joins::Wander(wandered.variance),
            match line.reach {
                Reach::Close => Joins::Near(line.distance, line.value),
                reach => Joins::Far(line.distance, line.value, reach),
            },
            Joins::Sidebands(pair.distance, pair.values),
        ];
        let mut stays = None;
        let mut most = nothing.log + ln(KEPT_AT);
        let causes = beliefs.iter().skip(1).zip(Cause::ALL).zip(joins);
        for ((belief, cause), joins) in causes {
            if belief.log > most {
                most = belief.log;
                stays = Some((cause, belief.log - nothing.log, joins));
            }
        }
        Self { moments, beliefs, stays, leftover: ground.leftover, scale }
    }

    /// The weight of each hypothesis, as a share of all.
    pub fn weights(&self) -> [f32; HYPOTHESES] {
        let all = Belief::any(&self.beliefs).log;
        self.beliefs.map(|belief| exp(belief.log - all))
    }

    /// The hypotheses that lost against a cause, with the cause's weight as unit. A pair of sidebands includes the line: whichever of the
    /// two joins, the other is not a rival.
    pub fn rivals(&self, cause: Cause) -> Belief {
        let mut others = self.beliefs;
        let unit = others.get(cause as usize + 1).map_or(0.0, |belief| belief.log);
        let is_line = |cause| matches!(cause, Cause::Line | Cause::Sidebands);
        for (belief, other) in others.iter_mut().skip(1).zip(Cause::ALL) {
            if other == cause || is_line(other) && is_line(cause) {
                *belief = Belief::NEVER;
            }
        }
        Belief::any(&others).times(-unit)
    }
}

/// The belief in a line at the most probable distance, the belief in lines elsewhere, and the most probable line.
fn together(places: &[Place; PLACES + FARS]) -> (Belief, Belief, Place) {
    /// Distances within this many bins belong to one line.
    const SAME: f32 = 0.6;
    let mut best = Place::NONE;
    for place in places {
        if place.best > best.best {
            best = *place;
        }
    }
    let [mut here, mut elsewhere] = [[Belief::NEVER; PLACES + FARS]; 2];
    for ((place, here), elsewhere) in places.iter().zip(&mut here).zip(&mut elsewhere) {
        let group = if (place.distance - best.distance).abs() < SAME { here } else { elsewhere };
        *group = place.belief;
    }
    (Belief::any(&here), Belief::any(&elsewhere), best)
}

impl Envelope {
    /// Gives the level the priors of a slow swing of the same size.
    pub fn swings(&mut self) {
        let levels = |term: &&mut Term| term.order > 0 && term.quarter == 0;
        let sizes = self.terms.iter_mut().filter(levels).map(|term| term.size * term.size);
        let variance = sizes.fold(1.0, larger);
        for (term, size) in self.terms.iter_mut().filter(levels).zip(swing()) {
            term.prior = 1.0 / larger(variance * size, 1e-9);
        }
    }
}

impl Joint<'_> {
    /// A cause joins the fit.
    pub fn join(&mut self, joins: Joins) {
        let strength = self.envelope.size() * self.envelope.size();
        let offset = self.offset();
        let envelope = &mut self.envelope;
        match joins {
            Joins::Level(variance, smooth) => {
                for (size, order) in level(smooth).into_iter().zip(1..) {
                    let prior = 1.0 / larger(variance * size, 1e-9);
                    let _ = envelope.terms.push(Term { order, quarter: 0, size: 0.0, prior });
                }
            }
            Joins::Bend => {
                let _ = envelope.terms.push(Term { order: 2, quarter: 1, size: 0.0, prior: 0.0 });
            }
            Joins::Wander(variance) => {
                let bends = |term: &Term| term.quarter == 1;
                let bent = envelope.terms.iter().any(bends);
                for (walk, order) in WALK.into_iter().zip(1..=ORDERS).skip(1) {
                    if order == 2 && bent {
                        continue;
                    }
                    let prior = 1.0 / larger(variance * walk, 1e-9);
                    let _ = envelope.terms.push(Term { order, quarter: 1, size: 0.0, prior });
                }
                // Order 1 is the frequency itself.
                envelope.hidden = variance * envelope.variance;
            }
            Joins::Near(distance, value) => {
                let priors = [1.0 / larger(strength, 1e-30), 4.0 / (distance * distance)];
                envelope.near = Some(Near { at: envelope.delta + distance, value, priors });
            }
            Joins::Far(distance, value, reach) => {
                let _ = self.lines.push(Far { at: offset + distance, value, reach });
            }
            Joins::Sidebands(distance, [value, other]) => {
                for (at, value) in [(offset + distance, value), (offset - distance, other)] {
                    let _ = self.lines.push(Far { at, value, reach: Reach::Inside });
                }
            }
        }
    }
}
