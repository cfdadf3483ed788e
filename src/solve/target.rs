//! A target.

use super::candidates::Ambiguity;
use crate::tone::Verdict;
use fixed::types::I32F32;

/// A target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Target {
    /// Range, metres, at the mean of the middles of the chirp's records.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::quantity"))]
    pub range: I32F32,
    /// Velocity, metres per second; positive when approaching. `None` where it is not known: a sawtooth does not show it.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::quantity_or_none"))]
    pub velocity: Option<I32F32>,
    /// One standard deviation of the range, metres.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::sigma"))]
    pub sigma_range: f32,
    /// One standard deviation of the velocity, metres per second.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::sigma"))]
    pub sigma_velocity: f32,
    /// The ambiguity that waveform and lines leave, or what decided it.
    pub ambiguity: Ambiguity,
    /// The worst verdict of the beats, except for a trapezoid's flat beat next to 0 Hz; at least [`Verdict::Unresolved`] if the range is
    /// negative or out of its bound, or if the beats contradict each other by more than five standard deviations; at least
    /// [`Verdict::Ambiguous`] if nothing decides between several targets.
    pub verdict: Verdict,
}

impl Target {
    /// The likely cause of a negative range, in a text of one line; `None` for other ranges.
    pub const fn caution(&self) -> Option<&'static str> {
        if self.range.to_bits() < 0 {
            Some("negative range: I and Q are exchanged, or mixing is the other one")
        } else {
            None
        }
    }
}
