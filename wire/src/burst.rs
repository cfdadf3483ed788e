//! One burst, and the state of the instrument that measured it.

use super::telemetry::{Health, Telemetry};
use crate::layout::{layout, record};
use picket_dsp::acquire::burst::Counters;
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::burst;
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::{Measurement, Outcome};

/// One burst, and the state of the instrument that measured it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Burst {
    /// The number of the burst, from 0 on.
    pub number: u32,
    /// The burst.
    pub burst: burst::Burst,
    /// The velocity computed from its tone, if the scene has one.
    pub result: Outcome,
    /// What the detector counted so far.
    pub counters: Counters,
    /// What the front end lost so far.
    pub health: Health,
}

layout! {
    /// A burst, and the state of the instrument that measured it.
    Burst {
        /// Number of the burst, from 0 on.
        number: u32,
        /// The burst.
        burst: burst::Burst,
        /// The velocity of its tone, if the settings have a scene.
        result: Outcome,
        /// What the detector counted.
        counters: Counters,
        /// What the front end lost.
        health: Health,
    }
}

record!(Burst, Burst, |burst| {
    let burst::Burst { tone, arrival, deviation, .. } = &burst.burst;
    let known = tone.rate_hz >= 0.0 && tone.rate_hz.is_finite();
    let placed = arrival.is_finite() && deviation.is_finite() && *deviation >= 0.0;
    known && placed && tone.is_consistent() && burst.result.is_consistent()
});

impl Burst {
    /// The burst as a record, for readers of records: its sequence is the burst's number, its clock the sample in the middle.
    pub fn record(&self) -> Telemetry {
        let burst::Burst { tone, arrival, .. } = self.burst;
        // The cast saturates.
        let stamp = Stamp { sequence: self.number, clock: arrival as u64, ..Stamp::default() };
        let measurement = Measurement { stamp, clipped: 0, tone, result: self.result };
        Telemetry {
            measurement,
            method: Method::LeastSquares,
            health: self.health,
            basis: None,
            uncertainty: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::RecordError;
    use fixed::types::{I0F32, I32F32};
    use picket_dsp::burst::Validation;
    use picket_dsp::solve::doppler::Velocity;
    use picket_dsp::tone::frequency::Frequency;
    use picket_dsp::tone::{Tone, Verdict};

    #[test]
    fn a_burst_comes_back_as_it_was_and_others_are_refused() {
        let frequency = Frequency(I0F32::from_bits(123_456_789));
        let velocity =
            Velocity { velocity: I32F32::from_num(4.25), sigma: 1e-3, verdict: Verdict::Good };
        let tone = Tone {
            frequency,
            sigma: 1e-5,
            snr: 40.0,
            amplitude: 250.0,
            rate_hz: 1e6,
            verdict: Verdict::Good,
            ..Tone::default()
        };
        for (number, validation) in (0..).zip(Validation::ALL) {
            let burst = burst::Burst { tone, arrival: 1e12 + 0.25, deviation: 128.5, validation };
            let counters = Counters { samples: 1 << 40, bursts: 7, lost: 2, long: 1, dead: 9999 };
            let health = Health { lost: 3, faults: 4 };
            let result = Outcome::Velocity(velocity);
            let burst = Burst { number, burst, result, counters, health };
            assert_eq!(validation as u32, number);
            assert_eq!(Burst::from_bytes(&burst.to_bytes()), Ok(burst));
            let plain = Burst { result: Outcome::None, ..burst };
            assert_eq!(Burst::from_bytes(&plain.to_bytes()), Ok(plain));
            let mut wrong = [burst; 4];
            wrong[0].burst.tone.sigma = f32::INFINITY;
            wrong[1].burst.arrival = f64::NAN;
            wrong[2].burst.deviation = f32::NAN;
            wrong[3].burst.tone.rate_hz = f64::INFINITY;
            for wrong in wrong {
                assert_eq!(
                    Burst::from_bytes(&wrong.to_bytes()),
                    Err(RecordError::Field),
                    "{wrong:?}"
                );
            }
            let bytes = burst.to_bytes();
            assert!(Burst::from_bytes(&bytes[..bytes.len() - 1]).is_err());
        }
    }
}
