//! One model of a tone and of the other signals that may be in its bins.
//!
//! ```text
//! bins = tone(f, a) + kept causes + noise
//! ```
//!
//! A fit gives the tone, a ring of bins beside it the noise. Where the fit leaves more than one steady tone would, a few [causes](Cause)
//! are tried on the residual, each a set of directions with normal priors of unknown size, and each has an evidence against `nothing more`.
//! A cause with high odds joins the fit, and the new residual is tried again, at most three times. Causes that lose keep their weight:
//! frequency and sigma are mean and deviation of the mixture. The causes that joined the fit decide the verdict.

pub mod belief;
mod beside;
mod bessel;
pub mod block;
mod causes;
mod chance;
pub mod constants;
mod factor;
mod joint;
mod leak;
mod leftover;
mod line;
mod moments;
mod pair;
mod round;
mod shape;
mod slow;
mod window;

pub use round::{Cause, HYPOTHESES, Kept};
pub use window::Window;

use crate::math::scalar::Scalar as _;
use crate::tone::noise::louder::louder;
use belief::Belief;
use constants::CAUSES;
use joint::{Joint, Solution};
use num_complex::Complex;
use round::{Round, belief_in, density, is_near};

/// The noise of a bin, as estimated from bins beside the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// The power of a bin, in squared codes.
    pub power: f32,
    /// The estimate's degrees of freedom.
    pub dof: f32,
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
    /// The weights of `nothing more`, of each cause, and of lines elsewhere than the best one, in the last round.
    pub weights: [f32; HYPOTHESES],
    /// The tone changes, or another line is so near that it looks like a change.
    pub moves: bool,
    /// The effort was not enough to explain the residual, or the residual is neither noise nor any of the causes.
    pub unresolved: bool,
}

/// Measures the tone in a window, in this noise, from its offset as interpolated or fitted. At most `most` causes join the fit. `bends`
/// says that the phase may bend without any change of the tone, see [`Segment::bends`](crate::acquire::sample::Segment::bends).
pub fn measure(window: &Window, noise: &Noise, offset: f32, most: usize, bends: bool) -> Answer {
    let scale = (2.0 / noise.power).root();
    let mut joint = Joint::at(offset);
    let mut solution = Solution::new();
    joint.fit(window, scale, 3, &mut solution);
    let mut answer = Answer {
        offset: joint.tone.offset,
        variance: 0.0,
        line: joint.tone.value * (1.0 / scale),
        scale: 1.0,
        dof: noise.dof,
        louder: 0.0,
        kept: [0; CAUSES],
        weights: [0.0; HYPOTHESES],
        moves: false,
        unresolved: false,
    };
    let mut rivals = Belief::NEVER;
    for number in 0..=most {
        let round = Round::new(window, &joint, &solution, noise.dof, &answer.kept);
        let Belief { offset, variance, .. } = round.all().or(rivals);
        (answer.offset, answer.variance) = (offset, variance);
        answer.weights = round.weights();
        answer.moves = is_near(&joint, &answer.kept, bends);
        answer.unresolved = round.stays.is_some() || round.lumpy;
        (answer.scale, answer.dof) = (round.scale, noise.dof + round.free);
        // A part of the ring's noise is 1, so a bin of it has 2.
        answer.louder = 0.5 * louder(&solution.left, window.iq, window.n, window.peak);
        answer.line = joint.tone.value * (1.0 / scale);
        let Some((cause, odds)) = round.stays else { break };
        if number == most {
            break;
        }
        rivals = rivals.times(-odds).or(round.rivals(cause));
        let before = joint.clone();
        let place = round.keep(cause, &mut joint);
        if !joint.has_room() {
            break;
        }
        joint.fit(window, scale, constants::STEPS, &mut solution);
        let mut cause = cause;
        if place && !answer.moves {
            let other = second(window, scale, &round, &before, &mut joint, &mut solution);
            rivals = rivals.or(other.0);
            if other.1 {
                cause = Cause::Line;
            }
        }
        if let Some(count) = answer.kept.get_mut(cause as usize) {
            *count += 1;
        }
    }
    answer
}

/// Tries two strong lines in place of a tone with the change that is kept. The more probable fit stays. Returns the belief in the other
/// fit, in units of the weight of the fit that stays, and whether two lines are more probable.
#[inline(never)]
fn second(
    window: &Window,
    scale: f32,
    round: &Round,
    before: &Joint,
    joint: &mut Joint,
    solution: &mut Solution,
) -> (Belief, bool) {
    let belief = |joint: &Joint, solution: &Solution| {
        let belief = belief_in(joint, solution, &round.leftover);
        belief.times(joint.lines().last().map_or(0.0, density))
    };
    let change = belief(joint, solution);
    let Some(pair) = pair::fitted(window, scale, before, &round.moments, solution) else {
        return (Belief::NEVER, false);
    };
    let two = belief(&pair, solution);
    if two.log > change.log {
        *joint = pair;
        return (change.times(-two.log), true);
    }
    joint.solve(window, scale, solution);
    (two.times(-change.log), false)
}
