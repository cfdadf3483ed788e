//! From an echo to a target.

use super::echo::Echo;
use super::fit::Fitted;
use super::ghost::Suspect;
use super::map::Map;
use super::plan::ON_BOUND;
use crate::chance::ln_of_map;
use crate::frequency::Frequency;
use crate::math::fixed_point::{in_steps, to_f32};
use crate::math::scalar::{Scalar as _, nearest};
use crate::solve::beats::stretched;
use crate::solve::candidates::{Ambiguity, Candidate, Candidates, Decision};
use crate::solve::chirp::Target;
use crate::solve::waveform::metres;
use crate::tone::judge::judge;
use crate::tone::line_class::{FitTest, LineClass};
use crate::tone::noise::Noise;
use crate::tone::noise::ring::LocalNoise;
use crate::tone::phasor::ToneWithPhase;
use crate::tone::sigma::{CLIPPED, sigma_bins};
use crate::tone::verdict::Reasons;
use crate::tone::{Tone, Verdict};
use core::f32::consts::TAU;
use fixed::types::I32F32;

/// A target of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrameTarget {
    /// Range and velocity in the middle of the frame, their sigmas, the aliases that fit as well, and the verdict.
    pub target: Target,
    /// The covariance of range and velocity, m^2/s: an error of the velocity is a Doppler shift within the chirp, and so an error of
    /// the range.
    pub covariance: f32,
    /// The beat in the middle of the frame: a chirp's tone with the phase of the frame's middle, as [`PhaseRanging::of_target`] and
    /// [`Unwrapper`] take it. Its sigmas are those of the whole frame, its ratio of signal to noise is per sample, and its verdict is without
    /// the ambiguity of the velocity.
    ///
    /// [`PhaseRanging::of_target`]: crate::solve::phase_range::PhaseRanging::of_target
    /// [`Unwrapper`]: crate::solve::displacement::Unwrapper
    pub line: ToneWithPhase,
    /// The natural logarithm of the probability that noise alone shows such a target anywhere in the map.
    pub ln_chance: f32,
}

/// From these odds on the target's own movement during the frame decides an alias.
const SURE: f32 = 1e4;

/// A target is beyond a bound only if it is more than this many sigma beyond.
const WITHIN: f32 = 5.0;

/// Two echoes are too near each other to be distinguished within this many bins in both directions.
const CROWDED: f32 = 2.0;

/// A curve of no more than so many sigma counts as noise.
const NOISY: f32 = 2.0;

/// An end of a real spectrum or the offset of an I/Q one disturbs a beat within this many bins.
const EDGE: f32 = 1.5;

impl Map<'_> {
    /// The evidence for an alias of an echo, a power. All other echoes are subtracted from the cells.
    pub fn evidence(&self, echo: &Echo, alias: i32) -> f32 {
        let mut other = Echo { alias, ..*echo };
        other.move_on(self.plan);
        self.along(&other)
    }

    /// Range and velocity of an echo.
    pub fn place(&self, echo: &Echo) -> [I32F32; 2] {
        let plan = self.plan;
        let offset = echo.middle(plan);
        let beat = (echo.peak as f32 + offset) / plan.n as f32;
        let far = beat * plan.range.float;
        // In fixed point: whole bins are exact, and a float holds the rest.
        let steps = |whole: i32, rest: f32, of: usize| {
            let bits = of.trailing_zeros();
            (i64::from(whole) << 32 >> bits) + (rest * f32::two_to(32 - bits as i32)) as i64
        };
        let chirps = steps(echo.row, echo.turn, plan.chirps) + (i64::from(echo.alias) << 32);
        let velocity = metres(chirps, plan.velocity.fixed);
        let rough = to_f32(velocity);
        let shift = rough / plan.shift.float;
        let resting = far + shift * plan.range.float;
        let velocity = velocity.saturating_add(in_steps(rough * plan.lower * resting));
        let faster = to_f32(velocity);
        let beat = steps(echo.peak, offset, plan.n);
        let shift = (faster / plan.shift.float * 4_294_967_296.0) as i64;
        [stretched(metres(beat.saturating_add(shift), plan.range.fixed), velocity), velocity]
    }

    /// The target of a fitted echo in this noise. The map holds all other echoes.
    pub fn target(
        &self,
        fitted: &Fitted,
        beside: &Noise,
        aliases: &[(i32, f32)],
        nearest: f32,
    ) -> FrameTarget {
        let plan = self.plan;
        let (n, chirps) = (plan.n as f32, plan.chirps as f32);
        let echo = &fitted.echo;
        let power = echo.amplitude.norm_sqr();
        let [excess, excess_turn] = self.excess(echo);
        let ratio = power * fitted.energy / (beside.power * excess);
        // The noise of a sample of each record.
        let beat_noise = beside.power * excess / (n * chirps);
        let turn_noise = beside.power * chirps / fitted.energy;
        let class = |fit, length: usize, noise| {
            let beside = LocalNoise::from_noise(Noise { power: noise, dof: beside.dof });
            judge(fit, length, i32::MAX, &beside, false, ())
        };
        let FitTest { line: first, variance_inflation: wider } =
            class(&fitted.beat, plan.n, beat_noise);
        let FitTest { line: second, variance_inflation: wider_turn } =
            class(&fitted.turn, plan.chirps, turn_noise);
        let sigma_beat = sigma_bins(&fitted.beat, plan.n, beat_noise * wider) / n;
        let sigma_turn =
            sigma_bins(&fitted.turn, plan.chirps, turn_noise * wider_turn * excess_turn) / chirps;
        let [range, velocity] = self.place(echo);
        let sigma_velocity = (sigma_turn * plan.velocity.float).abs();
        // Metres of range for a metre per second.
        let coupling = plan.range.float / plan.shift.float;
        let across = coupling * sigma_velocity;
        let sigma_range = libm::hypotf(sigma_beat * plan.range.float, across);
        let ln_chance = ln_of_map(ratio, self.tried(), chirps, beside.dof);
        let mut reasons = Reasons::NONE;
        match first.max(second) {
            LineClass::Steady => {}
            LineClass::Moving => reasons = reasons.with(Verdict::Moving),
            LineClass::Unresolved => reasons = reasons.with(Verdict::Unresolved),
        }
        if nearest < CROWDED {
            reasons = reasons.with(Verdict::Unresolved);
        }
        let sigma = [sigma_beat * n, sigma_turn * chirps, sigma_range];
        if self.is_ghost(&Suspect { echo, energy: fitted.energy, ratio, sigma }) {
            reasons = reasons.with(Verdict::Unresolved);
        }
        if self.store.filled.clipped as f32 > CLIPPED * n * chirps {
            reasons = reasons.with(Verdict::Clipped);
        }
        if ln_chance > plan.false_alarm.log_e() {
            reasons = reasons.with(Verdict::Weak);
        }
        let bins = (echo.peak as f32 + echo.offset).abs();
        let from_end = if plan.iq { bins } else { bins.min(0.5 * n - bins) };
        if from_end < EDGE || !(self.keeps(echo.peak - 1) && self.keeps(echo.peak + 1)) {
            reasons = reasons.with(Verdict::NearEdge);
        }
        // No alias may be within the bounds, and an alias within them may still have its range beyond.
        let held = plan.bounds.hold(
            [to_f32(range), WITHIN * sigma_range],
            [to_f32(velocity), WITHIN * sigma_velocity + ON_BOUND * plan.alias_mps()],
        );
        if range < 0 || !held {
            reasons = reasons.with(Verdict::Unresolved);
        }
        let ambiguity = self.ambiguity(echo, aliases);
        let verdict = match ambiguity {
            Ambiguity::Several(_) => reasons.verdict().max(Verdict::Ambiguous),
            _ => reasons.verdict(),
        };
        let per_sample = if plan.iq { n } else { 2.0 * n };
        // A real tone of amplitude A has A/2 at each of its frequencies.
        let amplitude = echo.amplitude.norm_sqr().root() * if plan.iq { 1.0 } else { 2.0 };
        let tone = Tone {
            frequency: Frequency::from_bins(echo.peak, echo.middle(plan), plan.n)
                .unwrap_or_default(),
            sigma: sigma_beat,
            snr: power * per_sample / beside.power,
            amplitude,
            ..Tone::with_reasons(reasons, plan.rate_hz)
        };
        // The phase of a record belongs to the sample after its middle, and is that of a line through a phase that bends.
        let later = 0.5 * (echo.peak as f32 + echo.offset) / n + echo.bend / 24.0;
        // The phase of the fit is the mean over the chirps. As far as the curve exceeds its own noise, the middle is known from it: the
        // curve's variance is 180 of the phase's, in radians, and a twelfth of the curve is between the two.
        let variance = 0.5 * wider.max(wider_turn) / ratio.max(f32::MIN_POSITIVE);
        let curve = TAU * echo.curve;
        let known = 1.0 - NOISY * NOISY * 180.0 * variance / (curve * curve).max(f32::MIN_POSITIVE);
        let known = known.max(0.0);
        let phase = f32::angle(echo.amplitude * f32::unit(later - known * echo.curve / 12.0));
        let sigma_phase = (variance * (1.0 + known * 180.0 / 144.0)).root();
        let velocity = Some(velocity);
        FrameTarget {
            target: Target { range, velocity, sigma_range, sigma_velocity, ambiguity, verdict },
            covariance: coupling * sigma_velocity * sigma_velocity,
            line: ToneWithPhase { tone, phase, sigma_phase },
            ln_chance,
        }
    }

    /// The independent cells of the map: those of each velocity with a walk of its own.
    pub fn tried(&self) -> f32 {
        let plan = self.plan;
        let walks = self.walks();
        let zone = (plan.walk * plan.alias_mps()).abs() * plan.chirps as f32;
        (plan.cells() as f32) * (1.0 + (walks.last - walks.first - zone).max(0.0))
    }

    fn ambiguity(&self, echo: &Echo, aliases: &[(i32, f32)]) -> Ambiguity {
        let Some(&(_, most)) = aliases.first() else { return Ambiguity::None };
        if aliases.len() == 1 {
            return Ambiguity::Decided(Decision::Bound);
        }
        let weigh = |power: f32| libm::expf((power - most).max(-80.0));
        let others: f32 = aliases.iter().skip(1).map(|&(_, power)| weigh(power)).sum();
        if others * SURE < 1.0 {
            return Ambiguity::None;
        }
        Ambiguity::Several(Candidates::new(aliases.iter().map(|&(alias, power)| {
            let [range, velocity] = self.place(&Echo { alias, ..*echo });
            Candidate { range, velocity, odds: weigh(power) / (1.0 + others) }
        })))
    }
}

/// The distance between two echoes in cells: the larger of both directions.
pub(super) fn apart(a: &Echo, b: &Echo, chirps: usize) -> f32 {
    let bins = (a.peak - b.peak) as f32 + a.offset - b.offset;
    let rows = (a.row - b.row) as f32 + a.turn - b.turn;
    let chirps = chirps as f32;
    let rows = rows - chirps * nearest(rows / chirps);
    bins.abs().max(rows.abs())
}
