//! Range and velocity from a sequence of sawtooth chirps, by the phase of a target's beat from chirp
//! to chirp.
//!
//! One rising ramp cannot separate the two, see [`super::equations`]. From chirp to chirp the target approaches by `V T`, which turns the
//! phase in the middle of the beat by `-s 2 V T f / c`, where `f` is the carrier of the echo that arrives there. So a line through the
//! phases of some chirps gives the velocity thousands of times as exactly as one beat gives the range, and no second transform is needed.
//! The velocity is ambiguous by multiples of `c / (2 T f)`, a whole turn a chirp. The range itself moves by `-V` a second, which selects
//! the turns if the sequence is long enough; until then all velocities that agree with the range's movement are listed.
//!
//! A real record's beat must be positive: a real record shows a target whose Doppler shift exceeds its range beat with the wrong sign.

use super::beats::stretched;
use super::bounds::Bounds;
use super::candidates::{Ambiguity, Candidate, Candidates, Decision};
use super::equations::Equations;
use super::hypotheses::WRONG;
use super::target::Target;
use super::waveform::{SPEED_OF_LIGHT, Scale, Shape, metres};
use crate::acquire::sample::Stamp;
use crate::math::fixed_point::{in_steps, to_f32};
use crate::math::scalar::Scalar as _;
use crate::tone::phasor::ToneWithPhase;
use crate::tone::{Tone, Verdict};
use core::f32::consts::TAU;
use heapless::Vec;

/// The most targets that are listed.
pub const LISTED: usize = 8;

/// The most whole turns that are tried.
const TRIED: i32 = 1024;

/// The fewest and the most chirps that a line goes through. After the most it restarts.
const FEWEST: f32 = 3.0;
const LONGEST: f32 = 256.0;

/// A chirp continues the line if its phase is within this many standard deviations of the line, and a velocity is listed if it is within
/// this many of the range's own movement.
const SURE: f32 = 6.0;

/// Sums over the chirps of a sequence for a straight line through one value each.
#[derive(Clone, Copy, Debug, Default)]
struct PhaseLine {
    count: f32,
    /// Sums of the values, of the values times the chirp's place, and of their variances.
    sum: f32,
    moment: f32,
    variance: f32,
}

impl PhaseLine {
    fn push(&mut self, value: f32, sigma: f32) {
        self.sum += value;
        self.moment += value * self.count;
        self.variance += sigma * sigma;
        self.count += 1.0;
    }

    /// The slope per chirp and its standard deviation, for two chirps or more.
    fn slope(&self) -> (f32, f32) {
        let n = self.count;
        let spread = n * (n * n - 1.0) / 12.0;
        let slope = (self.moment - 0.5 * (n - 1.0) * self.sum) / spread;
        (slope, (self.variance / (n * spread)).root())
    }
}

/// Follows one target from chirp to chirp.
#[derive(Clone, Debug)]
pub struct Sequence {
    range: Scale,
    velocity: Scale,
    bounds: Bounds,
    /// Samples from chirp to chirp.
    period: f32,
    /// The first and the last chirp of the line, if there is one.
    ends: Option<[(u64, ToneWithPhase); 2]>,
    /// The turn from the first chirp to the second, up to unknown whole turns. The values of the lines: the turns beyond the
    /// multiples of this turn, and the beats less the first beat.
    turn: f32,
    turns: f32,
    phases: PhaseLine,
    beats: PhaseLine,
}

impl Sequence {
    /// A sequence of sawtooth chirps that begin `period` samples apart. `None` if the period is 0 or the shape is another.
    pub fn new(equations: &Equations, period: u32) -> Option<Self> {
        let (phases, beats) = (PhaseLine::default(), PhaseLine::default());
        let ([range, _], [velocity, _]) = (equations.range, equations.velocity);
        let usable = period > 0 && equations.shape == Shape::Sawtooth;
        let period = period as f32;
        let ends = None;
        let bounds = equations.bounds;
        let sequence =
            Self { range, velocity, bounds, period, ends, turn: 0.0, turns: 0.0, phases, beats };
        usable.then_some(sequence)
    }

    /// Takes the target's tone of the next chirp, with its sample rate. Returns the targets that the sequence agrees with so far, the one
    /// nearest to the range's own movement first; none before the third chirp. Their ranges belong to this chirp.
    ///
    /// The verdict of a single target is its beat's. If several targets are listed, one of their velocities is the true one, each is
    /// [`Verdict::Ambiguous`], and each has the first of them as its candidates. The bounds of the equations exclude some. A single target
    /// that contradicts the range's movement is [`Verdict::Unresolved`].
    ///
    /// A target's own motion moves its beat within a chirp: such a beat is [`Verdict::Moving`], and continues the sequence. A gap, any
    /// other tone that is not good, or a phase off the line starts the sequence again.
    ///
    /// Cost: about a hundred operations, and thirty for each target.
    pub fn push(&mut self, stamp: &Stamp, phasor: &ToneWithPhase) -> Vec<Target, LISTED> {
        if phasor.tone.verdict > Verdict::Moving {
            self.ends = None;
            return Vec::new();
        }
        let here = (stamp.clock, *phasor);
        let ends = self.ends;
        match ends {
            Some([first, last]) if !stamp.gap && self.continues(&first.1, &last, &here) => {
                self.ends = Some([first, here]);
            }
            _ => {
                (self.ends, self.turns) = (Some([here; 2]), 0.0);
                (self.phases, self.beats) = (PhaseLine::default(), PhaseLine::default());
                self.phases.push(0.0, phasor.sigma_phase / TAU);
                self.beats.push(0.0, phasor.tone.sigma);
            }
        }
        if self.phases.count < FEWEST { Vec::new() } else { self.targets(&phasor.tone) }
    }

    /// Adds a chirp to the lines, if it continues them.
    fn continues(
        &mut self,
        first: &ToneWithPhase,
        last: &(u64, ToneWithPhase),
        here: &(u64, ToneWithPhase),
    ) -> bool {
        let ((before, last), (clock, phasor)) = (last, here);
        if clock.wrapping_sub(*before) as f32 != self.period || self.phases.count >= LONGEST {
            return false;
        }
        let seen = (phasor.phase - last.phase) / TAU;
        let sigma_phase = phasor.sigma_phase / TAU;
        if self.phases.count < 2.0 {
            self.turn = seen;
        } else {
            let (slope, sigma) = self.phases.slope();
            let rest = seen - self.turn - slope;
            let rest = rest - libm::roundf(rest);
            if rest.abs() > SURE * libm::hypotf(sigma, libm::hypotf(sigma_phase, sigma_phase)) {
                return false;
            }
            self.turns += slope + rest;
        }
        self.phases.push(self.turns, sigma_phase);
        self.beats.push(phasor.tone.frequency.beyond(first.tone.frequency), phasor.tone.sigma);
        true
    }

    /// The targets whose velocities agree with the phases and with the range's movement.
    fn targets(&self, tone: &Tone) -> Vec<Target, LISTED> {
        let Self { range, velocity, .. } = *self;
        // A turn a chirp is 1/period cycles a sample of Doppler shift, and turns backwards.
        let step = velocity.float / self.period;
        let (slope, sigma_turns) = self.phases.slope();
        let turns = self.turn + slope;
        // The range moves by -V a second. Without a rate the length of a second is not known.
        let rate = range.float * tone.rate_hz as f32 / self.period;
        let (moved, sigma_moved) = self.beats.slope();
        let coarse = -rate * moved / step;
        let sigma = if rate != 0.0 { (rate * sigma_moved / step).abs() } else { f32::INFINITY };
        let nearest = libm::roundf(coarse + turns);
        let both = libm::hypotf(sigma, sigma_turns);
        let mut targets: Vec<Target, LISTED> = Vec::new();
        let mut odds: Vec<f32, LISTED> = Vec::new();
        let mut excluded = false;
        for place in 0..TRIED {
            // 0, 1, -1, 2, -2, ...
            let away = if place & 1 == 0 { -place / 2 } else { (place + 1) / 2 };
            let whole = nearest + away as f32 - turns;
            let off = (whole - coarse).abs();
            let agrees = off <= SURE * both;
            if place > 1 && !agrees {
                // The other side may agree by one more.
                continue;
            }
            if place == 0 || agrees {
                let target = self.target(tone, whole, sigma_turns);
                let verdict = if agrees { target.verdict } else { Verdict::Unresolved };
                if !self.holds(&target) {
                    excluded = true;
                    continue;
                }
                if targets.push(Target { verdict, ..target }).is_err() {
                    break;
                }
                let deviations = off / both;
                let _ = odds.push(libm::expf(-0.5 * deviations * deviations).max(WRONG * WRONG));
            }
        }
        if targets.is_empty() {
            // The bounds exclude all.
            let target = self.target(tone, nearest - turns, sigma_turns);
            let _ =
                targets.push(Target { verdict: target.verdict.max(Verdict::Unresolved), ..target });
        } else if targets.len() > 1 {
            let sum: f32 = odds.iter().sum();
            let all = targets.iter().zip(&odds).map(|(target, odds)| Candidate {
                range: target.range,
                velocity: target.velocity.unwrap_or_default(),
                odds: odds / sum,
            });
            let ambiguity = Ambiguity::Several(Candidates::new(all));
            for target in &mut targets {
                (target.ambiguity, target.verdict) =
                    (ambiguity, target.verdict.max(Verdict::Ambiguous));
            }
        } else if let [target] = targets.as_mut_slice()
            && excluded
        {
            target.ambiguity = Ambiguity::Decided(Decision::Bound);
        }
        targets
    }

    /// Whether a target is within the bounds.
    fn holds(&self, target: &Target) -> bool {
        let Target { range, velocity, sigma_range, sigma_velocity, .. } = *target;
        let velocity = to_f32(velocity.unwrap_or_default());
        self.bounds.hold([to_f32(range), SURE * sigma_range], [velocity, SURE * sigma_velocity])
    }

    /// The target that approaches by this Doppler shift, in turns a chirp.
    fn target(&self, tone: &Tone, turns: f32, sigma_turns: f32) -> Target {
        const SHARE: f32 = (2.0 / SPEED_OF_LIGHT) as f32;
        let Self { range, velocity, .. } = *self;
        let steps = |cycles: f32| (cycles * 4_294_967_296.0) as i64;
        let (shift, sigma_shift) = (turns / self.period, sigma_turns / self.period);
        let beat = i64::from(tone.frequency.0.to_bits()).saturating_add(steps(shift));
        let of = |cycles: f32, scale: Scale| (cycles * scale.float).abs();
        // The echo's carrier is lower than the transmitter's by the range's beat.
        let lower = SHARE * velocity.float * (beat as f32 / 4_294_967_296.0);
        let approach = shift * velocity.float;
        let approach = in_steps(approach + approach * lower);
        let range_m = stretched(metres(beat, range.fixed), approach);
        let least = if range_m < 0 { Verdict::Unresolved } else { Verdict::Good };
        Target {
            range: range_m,
            velocity: Some(approach),
            sigma_range: of(libm::hypotf(tone.sigma, sigma_shift), range),
            sigma_velocity: of(sigma_shift, velocity),
            ambiguity: Ambiguity::None,
            verdict: tone.verdict.max(least),
        }
    }
}
