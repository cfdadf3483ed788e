//! One target that the lines of a chirp's ramps may belong to.

use super::equations::Equations;
use super::target::Target;
use crate::math::fixed_point::to_f32;
use crate::math::scalar::Scalar as _;
use crate::tone::lines::MOST;
use crate::tone::{FrequencyDrift, Tone, Verdict};
use fixed::types::I32F32;
use heapless::Vec;

/// Deviations within which two values are the same, squared: five.
pub(crate) const SAME: f32 = 25.0;

/// One standard deviation of a target's acceleration between two chirps, m/s^2: that of a fall, or of a car that brakes.
const ACCELERATION: f32 = 9.81;

/// The most hypotheses kept.
pub(super) const KEPT: usize = 8;

/// A line of a segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub tone: Tone,
    /// How its frequency rises within the record, where that is known.
    pub drift: Option<FrequencyDrift>,
}

impl From<Tone> for Line {
    fn from(tone: Tone) -> Self {
        Self { tone, drift: None }
    }
}

impl Line {
    /// Whether a line rises within the record by `expected` cycles per sample. Of a line that moves this must be enough to be seen.
    pub(super) fn rises_by(&self, expected: f32) -> bool {
        let Some(FrequencyDrift { cycles, sigma }) = self.drift else { return true };
        let (off, variance) = (cycles - expected, sigma * sigma);
        let steady = self.tone.verdict < Verdict::Moving;
        let seen = 4.0 * expected * expected >= SAME * variance;
        (steady || seen) && off * off <= SAME * (variance + RISE * RISE * expected * expected)
    }

    /// Whether the line is not steady.
    pub(super) fn is_smeared(&self) -> bool {
        matches!(self.tone.verdict, Verdict::Moving | Verdict::Unresolved)
    }
}

/// The relative error of a line's measured rise.
const RISE: f32 = 0.02;

/// The lines of a chirp's segments, up, flat and down; the strongest first.
pub(crate) type Lines = [Vec<Line, MOST>; 3];

/// A target that some lines may belong to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hypothesis {
    pub range: I32F32,
    pub velocity: I32F32,
    pub sigma_range: f32,
    pub sigma_velocity: f32,
    /// The signs of the ramps' beats; 1 for I/Q records, whose tones have them already.
    pub signs: [i8; 2],
    /// The worst verdict of the beats.
    pub verdict: Verdict,
    /// Logarithms of the likelihoods of the beats, of the levels, and of the movement since the last chirp.
    pub beats: f32,
    pub levels: f32,
    pub last: f32,
}

impl Hypothesis {
    pub(super) fn target(&self) -> Target {
        let Self { range, velocity, sigma_range, sigma_velocity, verdict, .. } = *self;
        let velocity = Some(velocity);
        Target { range, velocity, sigma_range, sigma_velocity, verdict, ..Target::default() }
    }

    /// Whether range and velocity are those of `best`, within five of its deviations.
    pub(super) fn is(&self, best: &Self) -> bool {
        let within = |a: I32F32, b: I32F32, sigma: f32| {
            let off = to_f32(a.saturating_sub(b));
            off * off <= SAME * sigma * sigma
        };
        within(self.range, best.range, best.sigma_range)
            && within(self.velocity, best.velocity, best.sigma_velocity)
    }

    /// The hypothesis with the verdict [`Verdict::Unresolved`] if a line does not rise as velocity and range predict: it belongs to more than one
    /// target, or the ramp is not bent as the configuration states.
    pub(super) fn with_rises(
        mut self,
        [rising, falling]: [&Line; 2],
        equations: &Equations,
    ) -> Self {
        let [range, velocity] = [self.range, self.velocity].map(to_f32);
        let [moved, bent] = [equations.rise * velocity, equations.bent * range];
        // The magnitude of a negative beat falls where the beat rises.
        let [up, down] = self.signs.map(f32::from);
        if !(rising.rises_by(up * (bent + moved)) && falling.rises_by(down * (bent - moved))) {
            self.verdict = self.verdict.max(Verdict::Unresolved);
        }
        self
    }

    /// The hypothesis with the verdict [`Verdict::Unresolved`] if its flat line moves, which no velocity explains.
    pub(super) fn with_flat(mut self, flat: &Line) -> Self {
        if !flat.rises_by(0.0) {
            self.verdict = self.verdict.max(Verdict::Unresolved);
        }
        self
    }

    /// The squared distance, in variances, from where the hypothesis `before` was led in `time_s` seconds by its own velocity.
    pub(super) fn away(&self, before: &Before, time_s: f32) -> f32 {
        let of = |new: I32F32, old: I32F32| to_f32(new.saturating_sub(old));
        let velocity = of(self.velocity, before.velocity);
        let mean = to_f32(before.velocity) + 0.5 * velocity;
        let range = of(self.range, before.range) + mean * time_s;
        let both = |a: f32, b: f32| a * a + b * b;
        let speed = both(self.sigma_velocity, before.sigma_velocity);
        let gain = ACCELERATION * time_s;
        let place = both(self.sigma_range, before.sigma_range) + 0.25 * speed * time_s * time_s;
        range * range / (place + 0.25 * gain * gain * time_s * time_s)
            + velocity * velocity / (speed + gain * gain)
    }

    /// Whether the range is 0 or more, within five deviations.
    pub(super) fn is_ahead(&self) -> bool {
        let range = to_f32(self.range);
        range >= 0.0 || range * range <= SAME * self.sigma_range * self.sigma_range
    }

    #[inline(never)] // once in an image, not in each closure
    pub(super) fn is_within(&self, equations: &Equations) -> bool {
        let margin = SAME.root();
        equations.bounds.hold(
            [to_f32(self.range), margin * self.sigma_range],
            [to_f32(self.velocity), margin * self.sigma_velocity],
        )
    }
}

/// A hypothesis of the last chirp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Before {
    pub range: I32F32,
    pub velocity: I32F32,
    pub sigma_range: f32,
    pub sigma_velocity: f32,
    /// The logarithm of its probability, over that of the most probable one of its line.
    pub weight: f32,
}

/// The hypotheses of a chirp, for the next one.
#[derive(Clone, Debug)]
pub(crate) struct Last {
    pub(super) kept: Vec<Before, KEPT>,
}

impl Last {
    pub const fn new() -> Self {
        Self { kept: Vec::new() }
    }

    /// Forgets all hypotheses.
    pub fn forget(&mut self) {
        self.kept.clear();
    }
}
