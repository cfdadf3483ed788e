//! One burst as bytes: little-endian, versioned, the same on every machine.
//!
//! | offset | field |
//! |---|---|
//! | 0 | version: u8 |
//! | 1 | validation: u8, 0 valid, 1 two particles, 2 few cycles, 3 short, 4 long, 5 weak, 6 clipped |
//! | 2 | verdict of the tone: u8 |
//! | 3 | what else holds of it: u8, a bit each |
//! | 4 | number of the burst, from 0 on: u32 |
//! | 8 | arrival, samples since the start: f64 |
//! | 16 | standard deviation of the envelope, samples: f32 |
//! | 20 | frequency: i32, 2^-32 cycles per sample |
//! | 24 | sigma of the frequency: f32, cycles per sample |
//! | 28 | signal-to-noise ratio at the top: f32, a power ratio |
//! | 32 | amplitude at the top: f32, codes |
//! | 36 | outcome: u8, 0 none, 1 velocity |
//! | 37 | verdict of the outcome: u8 |
//! | 38 | zero: 2 bytes |
//! | 40 | velocity: i64, 2^-32 m/s |
//! | 48 | sigma of the velocity: f32, m/s |
//! | 52 | bursts cut since the start: u32 |
//! | 56 | bursts lost while the record of another was not complete: u32 |
//! | 60 | signals that were too long: u32 |
//! | 64 | samples taken, samples in which no burst could begin: 2 u64 |
//! | 80 | blocks lost since the start: u32 |
//! | 84 | faults of the converter's chain since the start: u32 |
//! | 88 | sample rate: f64, Hz |

use super::frame::{self, Frame, Kind};
use super::telemetry::{Health, Telemetry};
use crate::bytes::{Reader, Writer};
use fixed::types::{I0F32, I32F32};
use heapless::Vec;
use picket_dsp::acquire::burst::Counters;
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::burst::{self, Validation};
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_dsp::solve::doppler::Velocity;
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::{Tone, Verdict, Verdicts};

/// The layout's version.
pub const VERSION: u8 = 1;

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

impl Burst {
    /// Length of the layout, bytes.
    const BYTES: usize = 96;

    /// The burst as a frame.
    pub fn to_frame(&self) -> Vec<u8, { frame::WIRE }> {
        let burst::Burst { tone, arrival, deviation, validation } = &self.burst;
        let (outcome, velocity) = match self.result {
            Outcome::Velocity(velocity) => (1, velocity),
            _ => (0, Velocity::default()),
        };
        let Counters { samples, bursts, lost, long, dead } = self.counters;
        let mut payload = [0; Self::BYTES];
        let mut writer = Writer::new(&mut payload);
        writer.put([VERSION, *validation as u8, tone.verdict as u8, tone.also.bits()]);
        writer.u32(self.number);
        writer.f64(*arrival);
        writer.f32(*deviation);
        writer.i32(tone.frequency.0.to_bits());
        for number in [tone.sigma, tone.snr, tone.amplitude] {
            writer.f32(number);
        }
        writer.put([outcome, velocity.verdict as u8, 0, 0]);
        writer.i64(velocity.velocity.to_bits());
        writer.f32(velocity.sigma);
        for count in [bursts, lost, long] {
            writer.u32(count);
        }
        for count in [samples, dead] {
            writer.u64(count);
        }
        for count in [self.health.lost, self.health.faults] {
            writer.u32(count);
        }
        writer.f64(tone.rate_hz);
        frame::encode(Kind::Burst, &payload).unwrap_or_default()
    }

    /// The burst as a record, for readers of records: its sequence is the burst's number, its clock the sample in the middle.
    pub fn record(&self) -> Telemetry {
        let burst::Burst { tone, arrival, .. } = self.burst;
        // The cast saturates.
        let stamp = Stamp { sequence: self.number, clock: arrival as u64, ..Stamp::default() };
        let measurement = Measurement { stamp, clipped: 0, tone, result: self.result };
        Telemetry { measurement, method: Method::LeastSquares, health: self.health, basis: None }
    }

    /// The burst in a frame; `None` for a frame of another kind or version, one that is cut off, or one with an unknown value or one
    /// that its verdict forbids.
    pub fn from_frame(frame: &Frame) -> Option<Self> {
        if frame.kind != Kind::Burst {
            return None;
        }
        let mut reader = Reader(&frame.payload);
        let [VERSION, validation, verdict, also] = reader.take()? else { return None };
        let validation = *Validation::ALL.get(usize::from(validation))?;
        let number = reader.u32()?;
        let (arrival, deviation) = (reader.f64()?, reader.f32()?);
        let mut tone = Tone {
            frequency: Frequency(I0F32::from_bits(reader.i32()?)),
            sigma: reader.f32()?,
            snr: reader.f32()?,
            amplitude: reader.f32()?,
            verdict: Verdict::from_u8(verdict)?,
            also: Verdicts::from_bits(also),
            rate_hz: 0.0,
        };
        let [outcome, verdict, _, _] = reader.take()?;
        let velocity = I32F32::from_bits(reader.i64()?);
        let sigma = reader.f32()?;
        let result = match outcome {
            0 => Outcome::None,
            1 => {
                Outcome::Velocity(Velocity { velocity, sigma, verdict: Verdict::from_u8(verdict)? })
            }
            _ => return None,
        };
        let [bursts, lost, long] = [reader.u32()?, reader.u32()?, reader.u32()?];
        let [samples, dead] = [reader.u64()?, reader.u64()?];
        let health = Health { lost: reader.u32()?, faults: reader.u32()? };
        tone.rate_hz = reader.f64()?;
        let known = tone.rate_hz >= 0.0 && tone.rate_hz.is_finite();
        let placed = arrival.is_finite() && deviation.is_finite() && deviation >= 0.0;
        if !(known && placed && tone.is_consistent() && result.is_consistent()) {
            return None;
        }
        let counters = Counters { samples, bursts, lost, long, dead };
        let burst = burst::Burst { tone, arrival, deviation, validation };
        Some(Self { number, burst, result, counters, health })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn framed(burst: &Burst) -> Frame {
        let mut reader = frame::Reader::default();
        burst.to_frame().iter().find_map(|&byte| reader.push(byte)).unwrap().unwrap()
    }

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
            assert_eq!(Burst::from_frame(&framed(&burst)), Some(burst));
            let plain = Burst { result: Outcome::None, ..burst };
            assert_eq!(Burst::from_frame(&framed(&plain)), Some(plain));
            for (place, value) in [(0, 2), (1, 7), (2, 99), (36, 2), (37, 99)] {
                let mut frame = framed(&burst);
                frame.payload[place] = value;
                assert_eq!(Burst::from_frame(&frame), None, "{place}");
            }
            let mut wrong = [burst; 4];
            wrong[0].burst.tone.sigma = f32::INFINITY;
            wrong[1].burst.arrival = f64::NAN;
            wrong[2].burst.deviation = f32::NAN;
            wrong[3].burst.tone.rate_hz = f64::INFINITY;
            for wrong in wrong {
                assert_eq!(Burst::from_frame(&framed(&wrong)), None, "{wrong:?}");
            }
            let mut cut = framed(&burst);
            cut.payload.truncate(Burst::BYTES - 1);
            assert_eq!(Burst::from_frame(&cut), None);
            assert_eq!(Burst::from_frame(&Frame { kind: Kind::Lines, ..framed(&burst) }), None);
        }
    }
}
