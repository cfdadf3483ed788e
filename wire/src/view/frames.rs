//! Frames of chirps, ranges by phase, ways and budgets: from the library's answers to views, and from views to what the library is told.

use super::{
    Budget, Calibration, Displacement, FrameTarget, Line, Part, PhaseRange, RangeCandidate, Target,
    Uncertainty,
};
use picket_dsp::fixed::types::I32F32;
use picket_dsp::solve::uncertainty::Source;
use picket_dsp::solve::{displacement, phase_range, uncertainty};
use picket_dsp::{Ambiguity, Candidate, Candidates, ToneWithPhase, Verdict};

impl FrameTarget {
    /// A frame's target.
    pub fn from_found(found: &picket_dsp::frame::FrameTarget) -> Self {
        Self {
            target: Target::from_target(&found.target, 0),
            line: Line::from_phasor(&found.line, 0),
            covariance: found.covariance,
            ln_chance: found.ln_chance,
        }
    }
}

impl Line {
    /// The tone that this line was made of, at its sample rate; `None` for an unknown verdict, a rate that is not positive, or a frequency beyond it.
    pub fn phasor(&self, rate_hz: f64) -> Option<ToneWithPhase> {
        let Self { tone, phase_rad, sigma_phase_rad } = *self;
        let tone = tone.told(rate_hz)?;
        Some(ToneWithPhase { tone, phase: phase_rad, sigma_phase: sigma_phase_rad })
    }
}

impl Target {
    /// The target that this view was made of; `None` for an unknown verdict or ambiguity, or a range that is no number of metres.
    pub fn solved(&self) -> Option<picket_dsp::Target> {
        let fixed = |x: f64| if x.is_finite() { I32F32::checked_from_num(x) } else { None };
        let all = self.candidates.iter().take(usize::from(self.count)).map(|candidate| {
            let range = fixed(candidate.range_m)?;
            let velocity = fixed(candidate.velocity_mps)?;
            Some(Candidate { range, velocity, odds: candidate.odds as f32 })
        });
        let candidates = Candidates::new(all.map(Option::unwrap_or_default));
        Some(picket_dsp::Target {
            range: fixed(self.range_m)?,
            velocity: fixed(self.velocity_mps),
            sigma_range: self.sigma_range_m,
            sigma_velocity: self.sigma_velocity_mps,
            ambiguity: Ambiguity::from_number(self.ambiguity, candidates)?,
            verdict: Verdict::from_u8(self.verdict)?,
        })
    }
}

impl PhaseRange {
    /// A range by phase.
    pub fn from_answer(answer: &phase_range::PhaseRange) -> Self {
        let mut candidates = [RangeCandidate::default(); _];
        let mut count = 0;
        for (place, candidate) in candidates.iter_mut().zip(answer.candidates()) {
            *place = RangeCandidate {
                range_m: candidate.range.to_num(),
                odds: f64::from(candidate.odds),
            };
            count += 1;
        }
        Self {
            range_m: answer.range.to_num(),
            velocity_mps: answer.velocity.map_or(f64::NAN, I32F32::to_num),
            by_frequency_m: answer.by_frequency.to_num(),
            candidates,
            sigma_range_m: answer.sigma,
            uncertainty_range_m: answer.uncertainty,
            sigma_velocity_mps: answer.sigma_velocity,
            sigma_by_frequency_m: answer.sigma_by_frequency,
            sigma_by_phase_m: answer.sigma_by_phase,
            spacing_m: answer.spacing(),
            turn_odds: answer.odds,
            sure: answer.is_sure().into(),
            verdict: answer.verdict as u8,
            count,
            reserved: 0,
        }
    }
}

impl Displacement {
    /// A block's displacement.
    pub fn from_moved(moved: &displacement::Displacement) -> Self {
        Self {
            displacement_m: moved.metres.to_num(),
            sigma_displacement_m: moved.sigma,
            start: moved.start,
            verdict: moved.verdict as u8,
            reserved: [0; 7],
        }
    }
}

impl Budget {
    /// The parts of an error, and all of them together.
    pub fn from_budget(budget: &uncertainty::Budget) -> Self {
        let [range_m, velocity_mps] = budget.total();
        let mut all = Self { uncertainty: Part { range_m, velocity_mps }, ..Self::default() };
        for part in &budget.parts {
            let place = match part.source {
                Source::Noise => &mut all.noise,
                Source::Clock => &mut all.clock,
                Source::Carrier => &mut all.carrier,
                Source::Slope => &mut all.slope,
                Source::Angle => &mut all.angle,
                Source::RangeOffset => &mut all.range_offset,
                Source::Phase => &mut all.phase,
            };
            *place = Part { range_m: part.range, velocity_mps: part.velocity };
        }
        all
    }
}

impl From<&Calibration> for phase_range::Calibration {
    fn from(told: &Calibration) -> Self {
        let &Calibration {
            phase_rad,
            sigma_phase_rad,
            offset_m,
            sigma_offset_m,
            slope_ppm,
            sigma_slope_ppm,
        } = told;
        Self { phase_rad, sigma_phase_rad, offset_m, sigma_offset_m, slope_ppm, sigma_slope_ppm }
    }
}

impl From<&phase_range::Calibration> for Calibration {
    fn from(known: &phase_range::Calibration) -> Self {
        let &phase_range::Calibration {
            phase_rad,
            sigma_phase_rad,
            offset_m,
            sigma_offset_m,
            slope_ppm,
            sigma_slope_ppm,
        } = known;
        Self { phase_rad, sigma_phase_rad, offset_m, sigma_offset_m, slope_ppm, sigma_slope_ppm }
    }
}

impl From<&Uncertainty> for uncertainty::Uncertainty {
    fn from(told: &Uncertainty) -> Self {
        let &Uncertainty {
            clock_ppm,
            carrier_ppm,
            slope_ppm,
            angle_rad,
            range_offset_m,
            phase_rad,
        } = told;
        Self { clock_ppm, carrier_ppm, slope_ppm, angle_rad, range_offset_m, phase_rad }
    }
}
