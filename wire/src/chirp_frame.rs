//! A frame of chirps, and its targets, each in a record of its own behind it.

use super::telemetry::{Basis, Health};
use crate::layout::{layout, record};
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::frame::{FrameTarget, TARGETS};
use picket_dsp::solve::chirp::Target;
use picket_dsp::tone::phasor::ToneWithPhase;

/// A frame of chirps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChirpFrame {
    /// The number of the frame, from 0 on.
    pub number: u32,
    /// Its first chirp.
    pub stamp: Stamp,
    /// Its chirps.
    pub chirps: u16,
    /// The chirps before it that are in no frame: those that passed while the targets of the frame before were computed, lost ones, and those
    /// of a frame that began again after a gap.
    pub passed: u32,
    /// Samples of its chirps that touch a rail.
    pub clipped: u32,
    /// The number of its targets; each follows in a record.
    pub targets: u8,
    /// How long the board sought them, s: chirps pass meanwhile.
    pub search_s: f32,
    /// The sample rate, Hz.
    pub rate_hz: f64,
    /// From one chirp to the next, s.
    pub period_s: f64,
    /// What the front end lost so far.
    pub health: Health,
    /// The settings, clock and effort of the measurement.
    pub basis: Option<Basis>,
}

/// A target of the frame before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Found {
    /// The number of the frame.
    pub frame: u32,
    /// The target's place among those of the frame, from 0 on: the strongest first.
    pub place: u8,
    /// The target.
    pub found: FrameTarget,
}

layout! {
    /// A frame of chirps: its targets follow, each in a record of kind 15.
    ChirpFrame {
        /// Number of the frame, from 0 on.
        number: u32,
        /// The first chirp.
        stamp: Stamp,
        /// Chirps of the frame.
        chirps: u16,
        /// Chirps before it that are in no frame: they passed while targets were computed, were lost, or are of a frame that began again after a gap.
        passed: u32,
        /// Samples that touch a rail.
        clipped: u32,
        /// Targets that follow.
        targets: u8,
        /// How long the targets were sought, s: chirps pass meanwhile.
        search_s: f32,
        /// Sample rate, Hz.
        rate_hz: f64,
        /// From one chirp to the next, s.
        period_s: f64,
        /// What was lost.
        health: Health,
        /// By what it was measured.
        basis: Option<Basis>,
    }

    /// A target of the frame before.
    Found {
        /// Number of the frame.
        frame: u32,
        /// Place among the frame's targets, from 0 on: the strongest first.
        place: u8,
        /// The target.
        found: FrameTarget,
    }

    /// A target of a frame of chirps.
    FrameTarget {
        /// Range and velocity in the middle of the frame; its candidates are aliases of the velocity.
        target: Target,
        /// The beat in the middle of the frame; its verdict is without the aliases.
        line: ToneWithPhase,
        /// Covariance of range and velocity, m^2/s.
        covariance: f32,
        /// Natural logarithm of the probability that noise alone shows such a target anywhere in the map.
        ln_chance: f32,
    }
}

record!(ChirpFrame, ChirpFrame, |frame| {
    let known = |number: f64| number > 0.0 && number.is_finite();
    let counted = usize::from(frame.targets) <= TARGETS && frame.search_s >= 0.0;
    counted && known(frame.rate_hz) && known(frame.period_s)
});

record!(Found, Found, |it| {
    let FrameTarget { target, line, covariance, ln_chance } = &it.found;
    let admitted = target.verdict.admits(target.sigma_range)
        && target.verdict.admits(target.sigma_velocity)
        && line.tone.is_consistent();
    usize::from(it.place) < TARGETS && admitted && !covariance.is_nan() && *ln_chance <= 0.0
});

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::RecordError;
    use fixed::types::I32F32;
    use picket_dsp::acquire::sample::Segment;
    use picket_dsp::solve::candidates::{Ambiguity, CANDIDATES, Candidate, Candidates};
    use picket_dsp::tone::{Tone, Verdict};

    #[test]
    fn a_frame_comes_back_as_it_was_and_others_are_refused() {
        let stamp = Stamp { sequence: 64, segment: Segment::Up, clock: 9 << 32, gap: true };
        let frame = ChirpFrame {
            number: 7,
            stamp,
            chirps: 64,
            passed: 35,
            clipped: 2,
            targets: 8,
            search_s: 0.75,
            rate_hz: 5e5,
            period_s: 2.176e-3,
            health: Health { lost: 3, faults: 4 },
            basis: Some(Basis::default()),
        };
        assert_eq!(ChirpFrame::from_bytes(&frame.to_bytes()), Ok(frame));
        let wrong = [
            ChirpFrame { targets: 9, ..frame },
            ChirpFrame { rate_hz: 0.0, ..frame },
            ChirpFrame { search_s: f32::NAN, ..frame },
            ChirpFrame { period_s: f64::NAN, ..frame },
        ];
        for wrong in wrong {
            assert_eq!(ChirpFrame::from_bytes(&wrong.to_bytes()), Err(RecordError::Field));
        }
        let bytes = frame.to_bytes();
        assert!(ChirpFrame::from_bytes(&bytes[..bytes.len() - 1]).is_err());
    }

    #[test]
    fn a_target_with_all_its_candidates_fits_and_comes_back_as_it_was() {
        let candidate = Candidate {
            range: I32F32::from_num(12.25),
            velocity: I32F32::from_num(-16.0),
            odds: 0.25,
        };
        let target = Target {
            range: I32F32::from_num(12.5),
            velocity: Some(I32F32::from_num(-3.25)),
            sigma_range: 0.01,
            sigma_velocity: 0.002,
            ambiguity: Ambiguity::Several(Candidates::new([candidate; CANDIDATES])),
            verdict: Verdict::Ambiguous,
        };
        let tone = Tone { sigma: 1e-6, snr: 0.04, rate_hz: 5e5, ..Tone::default() };
        let line = ToneWithPhase { tone, phase: -1.5, sigma_phase: 0.01 };
        let found = FrameTarget { target, covariance: -1e-6, line, ln_chance: -40.0 };
        let told = Found { frame: 7, place: 3, found };
        let bytes = told.to_bytes();
        assert_eq!(bytes.len(), Found::BYTES);
        assert_eq!(Found::from_bytes(&bytes), Ok(told));
        let mut wrong = [told; 5];
        wrong[0].place = 8;
        wrong[1].found.target.verdict = Verdict::Good;
        wrong[1].found.target.sigma_range = f32::NAN;
        wrong[2].found.line.tone.verdict = Verdict::Good;
        wrong[2].found.line.tone.sigma = f32::INFINITY;
        wrong[3].found.covariance = f32::NAN;
        wrong[4].found.ln_chance = 1.0;
        for wrong in wrong {
            assert_eq!(Found::from_bytes(&wrong.to_bytes()), Err(RecordError::Field), "{wrong:?}");
        }
    }
}
