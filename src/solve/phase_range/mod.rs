//! Absolute range from the phase of a beat: micrometres, where its frequency shows a millimetre.
//!
//! While a target stands, the phase of its beat at a time `t` into a ramp of slope `S` that starts at the carrier `f0` is
//!
//! ```text
//! phase(R) = 2 pi ((f0 + S t) tau - S tau^2 / 2) + phase0,    tau = 2 R / c
//! ```
//!
//! which grows evenly with the range, by one turn every half wavelength. So the phase gives the place within a turn, a hundred times as
//! exactly as the frequency gives the range, and the frequency must pick the turn. [`PhaseRanging`] lists every turn that agrees with the
//! frequency, each with its probability, and answers by the phase only where one turn has odds of [`SURE`] against all others. Elsewhere the
//! answer is the range by the frequency, as exact as it is, with the candidates.
//!
//! A fit's phase belongs to the middle of the record, where it is independent of the fit's frequency. Sigma of the frequency is an estimate
//! itself, with [`DOF`] degrees of freedom: the odds are those of Student's distribution, whose tails are the wider ones.
//!
//! Both ramps of a triangle or a trapezoid give the range of a target that moves: their phases give the ranges at two times, and their
//! difference a velocity as well.
//!
//! Cycles are counted in fixed point, in steps of 2^-32: 30 m are five thousand turns at 24 GHz, and a float would leave a thousandth of a
//! turn.
//!
//! `phase0` is the phase of a target at 0 m: of cables, mixer, antenna and reflector. It comes from a measurement at one known distance, see
//! [`PhaseRanging::calibrate`]. A second echo in the same cell turns the phase. What the fit sees of it widens sigma, which lowers the odds;
//! what it calls [`Verdict::Unresolved`] has no answer by phase.
//!
//! Sources: Brennan, Lok, Nicholls and Corr 2014 (doi:10.1049/iet-rsn.2013.0053) have the equation; Scherr et al. 2015
//! (doi:10.1109/TIM.2014.2381354) reach 5 um in the laboratory. The odds are this project's own.

mod calibration;
mod comb;
mod cycles;
mod ranging;

pub use calibration::Calibration;
pub use comb::{CandidateRange, DOF, SURE};
pub use ranging::PhaseRanging;

use crate::tone::Verdict;
use comb::Comb;
use fixed::types::I32F32;

/// A range by phase, or by frequency where the phase does not decide.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PhaseRange {
    /// Range, metres: by the phase if [`PhaseRange::is_sure`], else by the frequency.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub range: I32F32,
    /// One standard deviation of the range by this block's noise, metres.
    pub sigma: f32,
    /// One standard deviation of the range by the noise and by the calibration together, metres.
    pub uncertainty: f32,
    /// Velocity, metres per second; positive when approaching. `None` for a target that was said to rest.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub velocity: Option<I32F32>,
    /// One standard deviation of the velocity, metres per second.
    pub sigma_velocity: f32,
    /// The range by the frequency alone, metres.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub by_frequency: I32F32,
    /// One standard deviation of the range by the frequency alone, metres.
    pub sigma_by_frequency: f32,
    /// One standard deviation of the range by the phase within its turn, of the noise, metres: of each candidate.
    pub sigma_by_phase: f32,
    /// The odds of the most probable turn: its probability over that of all others together. 0 where no turn can be determined.
    pub odds: f32,
    /// The worst verdict of the tones.
    pub verdict: Verdict,
    comb: Comb,
}

impl PhaseRange {
    /// Whether the range is the one by the phase.
    pub fn is_sure(&self) -> bool {
        self.odds >= SURE
    }

    /// Every range that agrees with the phase, within 4.5 standard deviations of the range by the frequency, the most probable first. Far
    /// from the first one they are exact to a micrometre. None where the tone may not be used.
    pub fn candidates(&self) -> impl Iterator<Item = CandidateRange> + use<> {
        self.comb.candidates()
    }

    /// The distance between neighbouring candidates, metres: half a wavelength.
    pub const fn spacing(&self) -> f32 {
        self.comb.spacing
    }
}
