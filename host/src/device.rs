//! The messages of an instrument on its serial port, sorted and counted.

use picket_wire::boot::Boot;
use picket_wire::burst::Burst;
use picket_wire::chirp_frame::{ChirpFrame, Found};
use picket_wire::command::{Answer, Refusal};
use picket_wire::follow::Follow;
use picket_wire::frame::{Frame, Kind, Reader};
use picket_wire::fundamental::Fundamental;
use picket_wire::layout::VERSION;
use picket_wire::lines::Lines;
use picket_wire::schema::RECORDS;
use picket_wire::status::{Raw, Status};
use picket_wire::sum::Sum;
use picket_wire::telemetry::Telemetry;
use std::ops::RangeInclusive;

/// One thing that was said.
#[expect(clippy::large_enum_variant, reason = "one is read at a time")]
#[derive(Clone, Debug, PartialEq)]
pub enum Said {
    /// A measurement.
    Telemetry(Telemetry),
    /// The device has started.
    Boot(Boot),
    /// How it is.
    Status(Status),
    /// What is followed.
    Follow(Follow),
    /// All tones of the block of the last measurement.
    Lines(Lines),
    /// The fundamental of the harmonics in the block of the last measurement.
    Fundamental(Fundamental),
    /// A burst.
    Burst(Burst),
    /// The blocks that the last measurement is of.
    Sum(Sum),
    /// A frame of chirps.
    ChirpFrame(ChirpFrame),
    /// A target of the last frame.
    Found(Found),
    /// A piece of a block's samples.
    Raw(Raw),
    /// The answer to a command.
    Answer(Answer, Result<Vec<u8>, Refusal>),
}

/// Listens to a device.
#[derive(Debug, Default)]
pub struct Listener {
    reader: Reader,
    last: Option<u32>,
    /// The block of the last measurement, and its sample rate if it reports one.
    told: Option<(u32, Option<f64>)>,
    /// Measurements.
    pub records: u64,
    /// Blocks between them without a record: lost by the device, left out by its settings or by a full line, or lost on the
    /// line.
    pub missing: u64,
    /// Missing blocks that the device itself has lost, as its records say.
    pub lost: u64,
    /// The losses in the last record.
    losses: Option<u32>,
    /// Missing blocks before the last measurement.
    skipped: u64,
    /// Frames that were damaged or of a kind or version unknown here.
    pub bad: u64,
    /// The version of the last record whose version is unknown here.
    pub version: Option<u8>,
}

impl Listener {
    /// Takes a byte; gives what it completes.
    pub fn push(&mut self, byte: u8) -> Option<Said> {
        let frame = self.reader.push(byte)?.ok();
        let said = frame.as_ref().and_then(Said::of);
        if said.is_none() {
            self.version = frame.as_ref().and_then(version).or(self.version);
        }
        match &said {
            Some(Said::Telemetry(record)) => {
                let sequence = record.measurement.stamp.sequence;
                self.told = Some((sequence, rate_hz(record)));
                self.count(sequence);
                // Counts that have become fewer were reset.
                let losses = record.health.lost;
                let before = self.losses.replace(losses).unwrap_or(losses);
                let since = losses.checked_sub(before).unwrap_or(losses);
                self.lost += self.skipped.min(since.into());
            }
            Some(Said::Burst(burst)) => {
                self.told = Some((burst.number, rate_hz(&burst.record())));
                self.count(burst.number);
            }
            Some(Said::ChirpFrame(frame)) => {
                self.told = Some((frame.number, Some(frame.rate_hz)));
                self.count(frame.number);
            }
            // A sum leaves none of its blocks out.
            Some(Said::Sum(sum)) => {
                let own = u64::from(sum.blocks.saturating_sub(1)).min(self.skipped);
                self.missing = self.missing.saturating_sub(own);
                self.skipped = 0;
            }
            // It counts from 0 again, perhaps at another rate.
            Some(Said::Boot(_)) => (self.last, self.told, self.losses) = (None, None, None),
            Some(_) => {}
            None => self.bad += 1,
        }
        said
    }

    /// All that is said in these bytes.
    pub fn read(&mut self, bytes: &[u8]) -> Vec<Said> {
        bytes.iter().filter_map(|&byte| self.push(byte)).collect()
    }

    /// The sample rate of the last measurement, if it reports one.
    pub fn rate_hz(&self) -> Option<f64> {
        self.told.and_then(|(_, rate)| rate)
    }

    /// The sample rate of a block: that of its measurement, the only message with a rate.
    pub fn rate_of(&self, sequence: u32) -> Option<f64> {
        self.told.filter(|&(block, _)| block == sequence).and_then(|(_, rate)| rate)
    }

    fn count(&mut self, sequence: u32) {
        self.records += 1;
        let step = self.last.map_or(1, |last| sequence.wrapping_sub(last));
        // A step back is a device that restarted.
        self.skipped = if step < u32::MAX / 2 { step.saturating_sub(1).into() } else { 0 };
        self.missing += self.skipped;
        self.last = Some(sequence);
    }
}

/// The version of a record, where it is not the one that is known here.
fn version(frame: &Frame) -> Option<u8> {
    let is_record = RECORDS.iter().any(|(kind, _)| *kind == frame.kind);
    frame.payload.first().copied().filter(|version| is_record && *version != VERSION)
}

/// The sample rate of a measurement, if it reports one.
fn rate_hz(record: &Telemetry) -> Option<f64> {
    Some(record.measurement.tone.rate_hz).filter(|rate| RATES_HZ.contains(rate))
}

/// The sample rates that a device may have.
const RATES_HZ: RangeInclusive<f64> = 1e-3..=1e12;

impl Said {
    fn of(frame: &Frame) -> Option<Self> {
        Some(match frame.kind {
            Kind::Telemetry => Said::Telemetry(Telemetry::from_frame(frame).ok()?),
            Kind::Boot => Said::Boot(Boot::from_frame(frame).ok()?),
            Kind::Status => Said::Status(Status::from_frame(frame).ok()?),
            Kind::Follow => Said::Follow(Follow::from_frame(frame).ok()?),
            Kind::Lines => Said::Lines(Lines::from_frame(frame).ok()?),
            Kind::Fundamental => Said::Fundamental(Fundamental::from_frame(frame).ok()?),
            Kind::Burst => Said::Burst(Burst::from_frame(frame).ok()?),
            Kind::Sum => Said::Sum(Sum::from_frame(frame).ok()?),
            Kind::ChirpFrame => Said::ChirpFrame(ChirpFrame::from_frame(frame).ok()?),
            Kind::Found => Said::Found(Found::from_frame(frame).ok()?),
            Kind::Raw => Said::Raw(Raw::from_frame(frame)?),
            Kind::Reply | Kind::Refusal => {
                let (answer, said) = Answer::from_frame(frame)?;
                Said::Answer(answer, said.map(<[u8]>::to_vec))
            }
            Kind::End | Kind::Command => return None,
        })
    }
}

/// Puts blocks together from their pieces, which come in order.
#[derive(Debug, Default)]
pub struct Blocks {
    sequence: u32,
    bytes: Vec<u8>,
}

impl Blocks {
    /// Takes a piece; gives the block that it completes: its sequence and its `length` bytes. A block with a hole is given up.
    pub fn push(&mut self, raw: &Raw, length: usize) -> Option<(u32, Vec<u8>)> {
        if raw.offset == 0 {
            self.sequence = raw.sequence;
            self.bytes.clear();
        }
        let follows = raw.sequence == self.sequence && usize::from(raw.offset) == self.bytes.len();
        if !follows {
            self.bytes.clear();
            return None;
        }
        self.bytes.extend_from_slice(&raw.bytes);
        (self.bytes.len() == length).then(|| (self.sequence, std::mem::take(&mut self.bytes)))
    }
}
