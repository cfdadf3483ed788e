//! Velocity from a Doppler shift.

use super::chirp::{Scale, metres};
use crate::estimate::tone::{Tone, Verdict};
use fixed::types::I32F32;

/// A velocity along the beam, in m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Velocity {
    /// Metres per second. From I/Q samples positive is a positive Doppler shift (approaching); real
    /// samples carry no sign and the speed is given.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub velocity: I32F32,
    /// One standard deviation, m/s.
    pub sigma: f32,
    /// The tone's verdict.
    pub verdict: Verdict,
}

/// `V = f lambda / (2 cos phi)` (Yang et al. 2011, eq 1): `scale` is the velocity of one cycle per
/// sample.
pub fn velocity(tone: &Tone, scale: Scale) -> Velocity {
    Velocity {
        velocity: metres(i64::from(tone.frequency.0.to_bits()), scale.fixed),
        sigma: tone.sigma * scale.float,
        verdict: tone.verdict,
    }
}
