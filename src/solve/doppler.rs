//! Velocity from a Doppler shift.

use super::waveform::{Scale, metres};
use crate::tone::{Tone, Verdict};
use fixed::types::I32F32;

/// A velocity along the beam.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Velocity {
    /// Velocity, m/s. I/Q samples give its sign, positive when approaching. Real samples carry no sign,
    /// so this is the speed.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::quantity"))]
    pub velocity: I32F32,
    /// One standard deviation of the velocity, m/s.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::sigma"))]
    pub sigma: f32,
    /// The verdict of the tone.
    pub verdict: Verdict,
}

/// The velocity `V = f lambda / (2 cos phi)` (Yang et al. 2011, eq 1). `scale` is the velocity of one cycle per sample; for I/Q records it
/// has the sign that [`Mixing`](super::chirp::Mixing) gives a shift.
pub fn velocity(tone: &Tone, scale: Scale) -> Velocity {
    Velocity {
        velocity: metres(i64::from(tone.frequency.0.to_bits()), scale.fixed),
        sigma: (tone.sigma * scale.float).abs(),
        verdict: tone.verdict,
    }
}
