//! What is known about a device in addition to its records. It holds until the device restarts, or its records have another rate.

use super::settings::from_answer;
use crate::device::{Listener, Said};

/// What a device's settings say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Samples per second.
    pub rate_hz: f64,
    /// Samples in a block.
    pub n: usize,
    /// I/Q records.
    pub iq: bool,
    /// The rate in the first record after them.
    told_hz: Option<f64>,
}

impl Known {
    /// Bytes of a block.
    pub const fn bytes(&self) -> usize {
        self.n * if self.iq { 4 } else { 2 }
    }
}

/// What gives records their units.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scale {
    /// Samples per second as the user states, if the device does not report them.
    given_hz: Option<f64>,
    known: Option<Known>,
}

impl Scale {
    /// Nothing is known but what the user says.
    pub const fn given(given_hz: Option<f64>) -> Self {
        Self { given_hz, known: None }
    }

    /// What the settings say, if they are known.
    pub const fn known(&self) -> Option<&Known> {
        self.known.as_ref()
    }

    /// The settings may have changed.
    pub fn forget(&mut self) {
        self.known = None;
    }

    /// Takes what concerns it. True if the settings have become unknown: they must be asked for.
    pub fn hear(&mut self, said: &Said, listener: &Listener) -> bool {
        match said {
            Said::Boot(_) => {
                self.forget();
                true
            }
            Said::Answer(_, Ok(body)) => {
                if let Some((settings, n)) = from_answer(body) {
                    let (rate_hz, iq) = (settings.config.rate_hz, settings.iq);
                    self.known = Some(Known { rate_hz, n, iq, told_hz: None });
                }
                false
            }
            Said::Telemetry(_) | Said::Burst(_) | Said::ChirpFrame(_) => {
                let (Some(known), Some(rate)) = (&mut self.known, listener.rate_hz()) else {
                    return false;
                };
                let other = *known.told_hz.get_or_insert(rate) != rate;
                if other {
                    self.forget();
                }
                other
            }
            _ => false,
        }
    }

    /// The sample rate of a block: its record's, else the rate of settings or user.
    pub fn rate_of(&self, sequence: u32, listener: &Listener) -> Option<f64> {
        if listener.rate_hz().is_some() {
            return listener.rate_of(sequence);
        }
        self.known.map(|known| known.rate_hz).or(self.given_hz)
    }
}
