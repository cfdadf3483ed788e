//! A measurement as bytes: little-endian, versioned, the same on every machine.
//!
//! | offset | field |
//! |---|---|
//! | 0 | version: u8 |
//! | 1 | segment: u8 |
//! | 2 | flags: u8, bit 0 a gap before this block |
//! | 3 | verdict of the tone: u8 |
//! | 4 | sequence: u32 |
//! | 8 | sample clock: u64 |
//! | 16 | clipped samples: u32 |
//! | 20 | frequency: i32, 2^-32 cycles per sample |
//! | 24 | sigma of the frequency: f32, cycles per sample |
//! | 28 | signal-to-noise ratio: f32, a power ratio |
//! | 32 | amplitude: f32, codes |
//! | 36 | blocks lost since the start: u32 |
//! | 40 | faults of the converter's chain since the start: u32 |
//! | 44 | outcome: u8, 0 none, 1 velocity, 2 target |
//! | 45 | verdict of the outcome: u8 |
//! | 46 | ambiguity: u8, 0 none, 1 exchange, 2 coupled |
//! | 47 | method: u8 |
//! | 48 | range: i64, 2^-32 m |
//! | 56 | velocity: i64, 2^-32 m/s |
//! | 64 | sigma of the range: f32, m |
//! | 68 | sigma of the velocity: f32, m/s |
//! | 72 | the other range of an exchange: i64 |
//! | 80 | the other velocity of an exchange: i64 |
//!
//! A later version of the same number may append fields: readers ignore what follows byte 88.

use super::frame::{self, Frame, Kind};
use crate::acquire::sample::{Segment, Stamp};
use crate::estimate::frequency::Frequency;
use crate::estimate::method::Method;
use crate::estimate::tone::{Tone, Verdict};
use crate::pipeline::{Measurement, Outcome};
use crate::solve::chirp::{Ambiguity, Target};
use crate::solve::doppler::Velocity;
use fixed::types::{I0F32, I32F32};
use heapless::Vec;

/// The layout's version.
pub const VERSION: u8 = 1;

/// Bytes of a record.
pub const LENGTH: usize = 88;

/// What the front end lost until a record was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Health {
    /// Blocks that were filled but not delivered.
    pub lost: u32,
    /// Interrupts and transfers that were not as they should be.
    pub faults: u32,
}

/// A measurement and the state of the device that made it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Record {
    /// What was measured.
    pub measurement: Measurement,
    /// By which method.
    pub method: Method,
    /// What was lost.
    pub health: Health,
}

/// Why a frame is no record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RecordError {
    /// It is of another kind.
    Kind(Kind),
    /// It is of another version.
    Version(u8),
    /// It is shorter than [`LENGTH`].
    Short,
    /// A field holds a number without a meaning.
    Field,
}

impl core::fmt::Display for RecordError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            RecordError::Kind(_) => f.write_str("the frame carries no record"),
            RecordError::Version(version) => {
                write!(f, "the record is of version {version}, this reader knows {VERSION}")
            }
            RecordError::Short => f.write_str("the record is too short"),
            RecordError::Field => f.write_str("a field of the record has no meaning"),
        }
    }
}

impl core::error::Error for RecordError {}

/// The outcome in the record's own fields.
#[derive(Default)]
struct Flat {
    outcome: u8,
    verdict: u8,
    ambiguity: u8,
    range: i64,
    velocity: i64,
    sigma_range: f32,
    sigma_velocity: f32,
    other_range: i64,
    other_velocity: i64,
}

impl Flat {
    fn of(outcome: &Outcome) -> Self {
        match outcome {
            Outcome::None => Self::default(),
            Outcome::Velocity(v) => Self {
                outcome: 1,
                verdict: v.verdict as u8,
                velocity: v.velocity.to_bits(),
                sigma_velocity: v.sigma,
                ..Self::default()
            },
            Outcome::Target(t) => {
                let (ambiguity, other_range, other_velocity) = match t.ambiguity {
                    Ambiguity::None => (0, 0, 0),
                    Ambiguity::Exchange { range, velocity } => {
                        (1, range.to_bits(), velocity.to_bits())
                    }
                    Ambiguity::Coupled => (2, 0, 0),
                };
                Self {
                    outcome: 2,
                    verdict: t.verdict as u8,
                    ambiguity,
                    range: t.range.to_bits(),
                    velocity: t.velocity.to_bits(),
                    sigma_range: t.sigma_range,
                    sigma_velocity: t.sigma_velocity,
                    other_range,
                    other_velocity,
                }
            }
        }
    }

    fn outcome(self) -> Option<Outcome> {
        let velocity = I32F32::from_bits(self.velocity);
        let verdict = Verdict::from_u8(self.verdict)?;
        Some(match self.outcome {
            0 => Outcome::None,
            1 => Outcome::Velocity(Velocity { velocity, sigma: self.sigma_velocity, verdict }),
            2 => Outcome::Target(Target {
                range: I32F32::from_bits(self.range),
                velocity,
                sigma_range: self.sigma_range,
                sigma_velocity: self.sigma_velocity,
                ambiguity: match self.ambiguity {
                    0 => Ambiguity::None,
                    1 => Ambiguity::Exchange {
                        range: I32F32::from_bits(self.other_range),
                        velocity: I32F32::from_bits(self.other_velocity),
                    },
                    2 => Ambiguity::Coupled,
                    _ => return None,
                },
                verdict,
            }),
            _ => return None,
        })
    }
}

impl Record {
    /// The record's bytes.
    pub fn to_bytes(&self) -> Vec<u8, LENGTH> {
        let Measurement { stamp, clipped, tone, result } = &self.measurement;
        let flat = Flat::of(result);
        let mut bytes = Vec::new();
        // The fields sum to LENGTH, which a test asserts: nothing is refused.
        let mut put = |field: &[u8]| {
            let _ = bytes.extend_from_slice(field);
        };
        put(&[VERSION, stamp.segment as u8, u8::from(stamp.gap), tone.verdict as u8]);
        put(&stamp.sequence.to_le_bytes());
        put(&stamp.clock.to_le_bytes());
        put(&clipped.to_le_bytes());
        put(&tone.frequency.0.to_bits().to_le_bytes());
        put(&tone.sigma.to_le_bytes());
        put(&tone.snr.to_le_bytes());
        put(&tone.amplitude.to_le_bytes());
        put(&self.health.lost.to_le_bytes());
        put(&self.health.faults.to_le_bytes());
        put(&[flat.outcome, flat.verdict, flat.ambiguity, self.method.id()]);
        put(&flat.range.to_le_bytes());
        put(&flat.velocity.to_le_bytes());
        put(&flat.sigma_range.to_le_bytes());
        put(&flat.sigma_velocity.to_le_bytes());
        put(&flat.other_range.to_le_bytes());
        put(&flat.other_velocity.to_le_bytes());
        bytes
    }

    /// The record as a frame, ready to send.
    pub fn to_frame(&self) -> Vec<u8, { frame::WIRE }> {
        // A record is shorter than the largest payload.
        frame::encode(Kind::Record, &self.to_bytes()).unwrap_or_default()
    }

    /// The record a frame carries.
    pub fn of_frame(frame: &Frame) -> Result<Self, RecordError> {
        match frame.kind {
            Kind::Record => Self::of_bytes(&frame.payload),
            kind => Err(RecordError::Kind(kind)),
        }
    }

    /// The record that `bytes` hold.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, RecordError> {
        match bytes.first() {
            None => return Err(RecordError::Short),
            Some(&VERSION) => {}
            Some(&version) => return Err(RecordError::Version(version)),
        }
        let mut fields = Fields(bytes);
        let [_, segment, flags, verdict] = fields.take()?;
        let stamp = Stamp {
            segment: Segment::from_u8(segment).ok_or(RecordError::Field)?,
            gap: flags & 1 != 0,
            sequence: u32::from_le_bytes(fields.take()?),
            clock: u64::from_le_bytes(fields.take()?),
        };
        let clipped = u32::from_le_bytes(fields.take()?);
        let tone = Tone {
            verdict: Verdict::from_u8(verdict).ok_or(RecordError::Field)?,
            frequency: Frequency(I0F32::from_bits(i32::from_le_bytes(fields.take()?))),
            sigma: f32::from_le_bytes(fields.take()?),
            snr: f32::from_le_bytes(fields.take()?),
            amplitude: f32::from_le_bytes(fields.take()?),
        };
        let health = Health {
            lost: u32::from_le_bytes(fields.take()?),
            faults: u32::from_le_bytes(fields.take()?),
        };
        let [outcome, outcome_verdict, ambiguity, method] = fields.take()?;
        let flat = Flat {
            outcome,
            verdict: outcome_verdict,
            ambiguity,
            range: i64::from_le_bytes(fields.take()?),
            velocity: i64::from_le_bytes(fields.take()?),
            sigma_range: f32::from_le_bytes(fields.take()?),
            sigma_velocity: f32::from_le_bytes(fields.take()?),
            other_range: i64::from_le_bytes(fields.take()?),
            other_velocity: i64::from_le_bytes(fields.take()?),
        };
        let result = flat.outcome().ok_or(RecordError::Field)?;
        Ok(Self {
            measurement: Measurement { stamp, clipped, tone, result },
            method: Method::from_u8(method).ok_or(RecordError::Field)?,
            health,
        })
    }
}

/// Bytes that are taken from the front.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take<const M: usize>(&mut self) -> Result<[u8; M], RecordError> {
        let (&field, rest) = self.0.split_first_chunk().ok_or(RecordError::Short)?;
        self.0 = rest;
        Ok(field)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_fills_its_length_and_fits_a_frame() {
        let record = Record {
            measurement: Measurement::default(),
            method: Method::ZRife,
            health: Health::default(),
        };
        assert_eq!(record.to_bytes().len(), LENGTH);
        const { assert!(LENGTH <= frame::PAYLOAD) };
        assert!(!record.to_frame().is_empty());
    }
}
