//! One model of a tone and of the other signals that may be in its bins.
//!
//! ```text
//! bins = tone(f, a) + kept causes + noise
//! ```
//!
//! A fit gives the tone, a ring of bins beside it the noise. Where the fit leaves more than one steady tone would, a few [causes](Cause)
//! are tried on the residual. Each is a set of directions with normal priors of unknown size, and its evidence is weighed against `nothing more`.
//! A cause with high odds joins the fit, and the new residual is tried again, at most three times. Causes that lose keep their weight:
//! frequency and sigma are mean and deviation of the mixture. The causes that joined the fit decide the verdict.

pub mod belief;
mod bessel;
pub mod block;
mod changes;
mod columns;
pub mod constants;
mod elimination;
mod envelope;
mod factor;
mod far;
mod joint;
mod leftover;
mod logarithm;
mod pair;
mod round;
mod shape;
mod size;
mod window;

pub use round::{Cause, HYPOTHESES, Kept};
pub use window::Window;

use crate::math::scalar::Scalar as _;
use crate::tone::noise::louder::louder;
use belief::Belief;
use constants::{CAUSES, NOTHING_MORE, ROUNDS, UNLIKELY};
use envelope::{Envelope, Near};
use far::place_prior;
use joint::Joint;
use leftover::Leftover;
use logarithm::ln;
use num_complex::Complex;
use round::{Joins, Round};

/// The noise of a bin, as estimated from bins beside the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// The power of a bin, in squared codes.
    pub power: f32,
    /// The estimate's degrees of freedom.
    pub dof: f32,
}

/// A cause that joined the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joined {
    /// Which one.
    pub cause: Cause,
    /// The logarithm of its odds over `nothing more`.
    pub odds: f32,
    /// Sigma of the offset before the cause joined, bins.
    pub sigma: f32,
}

/// The model's answer for a tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// The tone's distance from the peak, bins.
    pub offset: f32,
    /// The variance of the offset, bins squared.
    pub variance: f32,
    /// The tone's line in the middle of the record: its amplitude and phase there times N/2 (I/Q: N), in codes.
    pub line: Complex<f32>,
    /// The noise's power over the ring's.
    pub scale: f32,
    /// Degrees of freedom of the noise.
    pub dof: f32,
    /// The residual power in a bin of the louder half of the bins beside the tone, over the ring's noise.
    pub louder: f32,
    /// The number of times that each cause joined the fit.
    pub kept: Kept,
    /// The causes that joined, round by round.
    pub joined: [Option<Joined>; ROUNDS as usize],
    /// The weights in the last round: of `nothing more`, of each cause, and of lines at other places than the best one.
    pub weights: [f32; HYPOTHESES],
    /// The tone changes, or another line is so near that it looks like a change.
    pub moves: bool,
    /// The effort was not enough to explain the residual, or the residual is neither noise nor any of the causes.
    pub unresolved: bool,
}

/// Fits the tone in a window, in this noise, with at most `most` causes. `offset` is where an interpolation or a fit has the tone. `bends`
/// says that the phase may bend without any change of the tone, see [`Segment::bends`](crate::acquire::sample::Segment::bends).
#[inline(never)]
pub fn measure(window: &Window, noise: &Noise, offset: f32, most: usize, bends: bool) -> Answer {
    let scale = (2.0 / noise.power).root();
    let joint = &mut Joint::new(window, scale, offset, most);
    joint.begin();
    let mut answer = Answer {
        offset,
        variance: 0.0,
        line: Complex::new(0.0, 0.0),
        scale: 1.0,
        dof: noise.dof,
        louder: 0.0,
        kept: [0; CAUSES],
        joined: [None; ROUNDS as usize],
        weights: [0.0; HYPOTHESES],
        moves: false,
        unresolved: false,
    };
    let mut rivals = Belief::NEVER;
    for number in 0..=most {
        let middle = joint.offset();
        let [level, bend, wander, ..] = answer.kept;
        answer.moves = level + wander > 0 || (bend > 0 && !bends) || joint.is_near();
        answer.dof = noise.dof + joint.free;
        answer.line = joint.envelope.value() * (1.0 / scale);
        if number > 0 && !joint.is_odd(noise.dof) {
            answer.scale = Leftover::new(joint.energy, joint.free, noise.dof).scale();
            let variance = joint.envelope.variance * answer.scale;
            let nothing = Belief { log: 0.0, offset: middle, variance };
            let Belief { offset, variance, .. } = Belief::any(&[nothing, rivals]);
            (answer.offset, answer.variance, answer.unresolved) = (offset, variance, false);
            break;
        }
        joint.widen();
        let round = Round::new(window, joint, noise.dof, &answer.kept);
        let at = |belief: Belief| Belief { offset: belief.offset + middle, ..belief };
        let all = Belief { log: 0.0, ..at(Belief::any(&round.beliefs)) };
        let Belief { offset, variance, .. } = Belief::any(&[all, rivals]);
        (answer.offset, answer.variance) = (offset, variance);
        (answer.scale, answer.weights) = (round.scale, round.weights());
        // Much more than noise is left, noise is an improbable cause of it, and no other cause stands out.
        let [nothing, ..] = answer.weights;
        let unlikely = if number == 0 { NOTHING_MORE } else { UNLIKELY };
        let doubtful = nothing < unlikely && joint.is_loud(noise.dof);
        answer.unresolved = round.stays.is_some() || doubtful || joint.is_lumpy();
        let Some((cause, odds, joins)) = round.stays else { break };
        let needed = match joins {
            Joins::Sidebands(..) => 2,
            Joins::Far(..) => 1,
            _ => 0,
        };
        if number == most || needed > joint.vacant() {
            break;
        }
        rivals = Belief::any(&[rivals.times(-odds), at(round.rivals(cause))]);
        let cause = if needed == 0 {
            change(joint, &round, cause, joins, !answer.moves, &mut rivals)
        } else {
            joint.join(joins);
            joint.settle(4, 3, true);
            cause
        };
        if let Some(count) = answer.kept.get_mut(cause as usize) {
            *count += 1;
        }
        if let Some(joined) = answer.joined.get_mut(number) {
            *joined = Some(Joined { cause, odds, sigma: answer.variance.root() });
        }
    }
    // Each part of a bin has noise of power 1, so a bin has 2.
    answer.louder = 0.5 * louder(&joint.left, window.iq, window.n, window.peak);
    answer
}

/// Adds a change of the tone, or a close line, to the fit. If `alone`, also tries two strong lines in its place: the more probable fit
/// stays, and the other becomes a rival. Returns the cause that stays.
#[inline(never)]
fn change(
    joint: &mut Joint,
    round: &Round,
    mut cause: Cause,
    joins: Joins,
    alone: bool,
    rivals: &mut Belief,
) -> Cause {
    let (value, delta) = (joint.envelope.value(), joint.envelope.delta);
    let before = if alone { joint.energy_of(&joint.envelope) } else { 0.0 };
    joint.join(joins);
    joint.fit(3, false);
    if alone
        && !joint.lines.is_full()
        && let Some([near, far]) = pair::places(value.norm_sqr().root(), &round.moments)
    {
        let apart = far - near;
        let half = value * 0.5;
        let mut two = Envelope::new(half);
        two.delta = delta + near;
        let priors = [1.0 / value.norm_sqr().max(1e-30), 4.0 / (apart * apart)];
        two.near = Some(Near { at: delta + far, value: half, priors });
        core::mem::swap(&mut joint.envelope, &mut two);
        joint.fit(1, true);
        let other = joint.energy_of(&two);
        let mut energy = joint.energy_of(&joint.envelope);
        // Go on only if a fit of both strengths alone comes close.
        if energy < 4.0 * other + 40.0 {
            joint.fit(4, false);
            energy = joint.energy_of(&joint.envelope);
        }
        let reference = joint.offset() - joint.envelope.delta;
        let belief = |envelope: &Envelope, energy: f32, prior: f32| {
            let (gain, scale) = round.leftover.less(before - energy);
            Belief {
                log: gain - envelope.cost + prior,
                offset: reference + envelope.delta,
                variance: envelope.variance * scale,
            }
        };
        let prior = if let Joins::Near(distance, _) = joins { density(distance) } else { 0.0 };
        let mut one = belief(&two, other, prior);
        let pair = belief(&joint.envelope, energy, density(apart));
        if pair.log > one.log && cause == Cause::Level {
            // A level that swings slowly looks like two lines at a fraction of a bin.
            core::mem::swap(&mut joint.envelope, &mut two);
            joint.envelope.swings();
            joint.fit(2, false);
            let energy = joint.energy_of(&joint.envelope);
            core::mem::swap(&mut joint.envelope, &mut two);
            let swing = belief(&two, energy, 0.0);
            if swing.log > one.log {
                one = swing;
            }
        }
        if pair.log > one.log {
            *rivals = Belief::any(&[*rivals, one.times(-pair.log)]);
            cause = Cause::Line;
        } else {
            *rivals = Belief::any(&[*rivals, pair.times(-one.log)]);
            joint.envelope = two;
        }
    }
    let converted = joint.convert();
    joint.resettle(converted);
    cause
}

/// The logarithm of the prior density of a line's distance over that of its prior in a fit.
fn density(distance: f32) -> f32 {
    place_prior(1.0, 1.0) - 0.5 * ln(4.0 / (distance * distance * core::f32::consts::TAU))
}
