//! Telemetry: a measurement, its conditions, and the state of the instrument.

use crate::boot::Clock;
use crate::layout::{layout, record};
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::Measurement;
use picket_dsp::solve::uncertainty::Total;

/// By what a record was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Basis {
    /// CRC-32 of the settings in use, as in the boot record.
    pub settings: u32,
    /// The source of the sample clock.
    pub clock: Clock,
    /// The most rounds of the joint fit, see [`Effort`](picket_dsp::Effort).
    pub effort: u8,
}

/// What the front end lost so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Health {
    /// Blocks that were filled and not delivered.
    pub lost: u32,
    /// Spurious interrupts, failed transfers and converter overruns.
    pub faults: u32,
}

/// A measurement, and the state of the instrument that made it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Telemetry {
    /// The measurement.
    pub measurement: Measurement,
    /// The method of estimation.
    pub method: Method,
    /// What was lost so far.
    pub health: Health,
    /// The settings, clock and effort of the measurement, if the program reports them.
    pub basis: Option<Basis>,
    /// The whole error, if the settings tell what is not known of the sensor.
    pub uncertainty: Option<Total>,
}

layout! {
    /// By what a record was measured: a reader sees where settings change in a recording.
    Basis {
        /// CRC-32 of the settings in use, the one that the start (kind 6) reports.
        settings: u32,
        /// Source of the sample clock.
        clock: Clock,
        /// The most rounds of the joint fit.
        effort: u8,
    }

    /// What was lost since the start.
    Health {
        /// Blocks lost.
        lost: u32,
        /// Faults of the converters' chain.
        faults: u32,
    }

    /// A measurement, and the state of the instrument that made it.
    Telemetry {
        /// The measurement.
        measurement: Measurement,
        /// Method of estimation.
        method: Method,
        /// What was lost.
        health: Health,
        /// By what it was measured.
        basis: Option<Basis>,
        /// The whole error, if the settings tell what is not known of the sensor.
        uncertainty: Option<Total> = None,
    }

    /// One standard deviation of each number of an answer by all sources together (k = 1); 0 where the answer has no such number.
    Total {
        /// Of the frequency, cycles per sample.
        frequency: f32,
        /// Of the range, m.
        range: f32,
        /// Of the velocity, m/s.
        velocity: f32,
    }
}

record!(Telemetry, Telemetry, |record| {
    let Measurement { tone, result, .. } = &record.measurement;
    let known = tone.rate_hz >= 0.0 && tone.rate_hz.is_finite();
    known && tone.is_consistent() && result.is_consistent()
});

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame;
    use crate::layout::RecordError;
    use fixed::types::I32F32;
    use picket_dsp::pipeline::Outcome;
    use picket_dsp::solve::candidates::{Ambiguity, CANDIDATES, Candidate, Candidates};
    use picket_dsp::solve::chirp::Target;
    use picket_dsp::solve::doppler::Velocity;
    use picket_dsp::tone::{Tone, Verdict};

    /// What a reader would show as good has numbers.
    #[test]
    fn a_record_that_its_own_verdict_forbids_is_refused() {
        let tone = Tone {
            sigma: 1e-6,
            snr: 10.0,
            amplitude: 1e3,
            rate_hz: 1e5,
            verdict: Verdict::Good,
            ..Tone::default()
        };
        let velocity = Velocity { velocity: I32F32::ONE, sigma: 1e-3, verdict: Verdict::Moving };
        let told = |tone: Tone, velocity: Velocity| {
            let result = Outcome::Velocity(velocity);
            let measurement = Measurement { tone, result, ..Measurement::default() };
            let health = Health::default();
            let record = Telemetry {
                measurement,
                method: Method::default(),
                health,
                basis: None,
                uncertainty: None,
            };
            Telemetry::from_bytes(&record.to_bytes())
        };
        assert!(told(tone, velocity).is_ok());
        let mut wrong = [tone; 7];
        wrong[0].sigma = f32::INFINITY;
        wrong[1].sigma = f32::NAN;
        wrong[2].sigma = -1e-6;
        wrong[3].snr = 0.0;
        wrong[4].amplitude = f32::INFINITY;
        wrong[5].rate_hz = f64::NAN;
        wrong[6].rate_hz = -1.0;
        for tone in wrong {
            assert_eq!(told(tone, velocity), Err(RecordError::Field), "{tone:?}");
        }
        for sigma in [f32::INFINITY, f32::NAN] {
            assert_eq!(told(tone, Velocity { sigma, ..velocity }), Err(RecordError::Field));
        }
        // What nobody may use has any numbers.
        let weak = Tone { sigma: f32::INFINITY, snr: 0.0, verdict: Verdict::NoSignal, ..tone };
        assert!(told(weak, velocity).is_ok());
    }

    #[test]
    fn a_record_comes_back_as_it_was_and_what_is_added_is_passed_over() {
        let candidates = Candidates::new([Candidate::default(); CANDIDATES]);
        let ambiguity = Ambiguity::Several(candidates);
        let target = Target { velocity: Some(I32F32::ONE), ambiguity, ..Target::default() };
        let basis = Basis { settings: 0xDEAD_BEEF, clock: Clock::Internal, effort: 2 };
        let (method, health) = (Method::ZRife, Health::default());
        let total = Total { frequency: 1e-6, range: 0.0, velocity: 2.0 };
        for (basis, ambiguity) in
            [(Some(basis), ambiguity), (None, Ambiguity::Coupled), (None, Ambiguity::None)]
        {
            let result = Outcome::Target(Target { ambiguity, ..target });
            let measurement = Measurement { result, ..Measurement::default() };
            let record = Telemetry { measurement, method, health, basis, uncertainty: None };
            let fewer = record.to_bytes();
            assert_eq!(Telemetry::from_bytes(&fewer), Ok(record));
            let record = Telemetry { uncertainty: Some(Total { range: 0.1, ..total }), ..record };
            let bytes = record.to_bytes();
            assert_eq!(bytes.len(), fewer.len() + 14); // its own length, whether it is there, and itself
            assert_eq!(Telemetry::from_bytes(&bytes), Ok(record));
            let full = bytes.len() == Telemetry::BYTES;
            assert_eq!(full, basis.is_some() && ambiguity.candidates().len() == CANDIDATES);
            assert!(record.to_frame().len() < frame::WIRE);
            // A later program's further field.
            let mut later = [&bytes[..], &[7; 24]].concat();
            later[1] += 24;
            assert_eq!(Telemetry::from_bytes(&later), Ok(record));
            for end in 0..bytes.len() {
                assert!(Telemetry::from_bytes(&bytes[..end]).is_err(), "{end}");
            }
        }
    }
}
