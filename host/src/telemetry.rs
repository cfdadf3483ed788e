//! Reads a device's bytes: finds frames, checks them, counts what was lost.

use picket::report::follow::Follow;
use picket::report::frame::{FrameError, Reader};
use picket::report::record::{Record, RecordError};
use std::fmt;

/// Why some bytes gave no record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TelemetryError {
    /// No frame.
    Frame(FrameError),
    /// A frame, but no record this reader knows.
    Record(RecordError),
}

impl fmt::Display for TelemetryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TelemetryError::Frame(error) => error.fmt(f),
            TelemetryError::Record(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for TelemetryError {}

/// A stream of records.
#[derive(Debug, Default)]
pub struct Telemetry {
    reader: Reader,
    last: Option<u32>,
    /// Records read.
    pub records: u64,
    /// What was followed, in the order it came.
    pub follows: Vec<Follow>,
    /// Frames that were damaged or unknown.
    pub bad: u64,
    /// Holes in the sequence: blocks of which no record arrived.
    pub lost: u64,
}

impl Telemetry {
    /// Takes a byte; gives what a frame that it closes holds.
    pub fn push(&mut self, byte: u8) -> Option<Result<Record, TelemetryError>> {
        let read = self.reader.push(byte)?;
        if let Ok(frame) = &read
            && let Ok(follow) = Follow::of_frame(frame)
        {
            self.follows.push(follow);
            return None;
        }
        let record = read
            .map_err(TelemetryError::Frame)
            .and_then(|frame| Record::of_frame(&frame).map_err(TelemetryError::Record));
        match &record {
            Ok(record) => self.count(record.measurement.stamp.sequence),
            Err(_) => self.bad += 1,
        }
        Some(record)
    }

    /// All records in `bytes`; damage is counted and passed over.
    pub fn read(&mut self, bytes: &[u8]) -> Vec<Record> {
        bytes.iter().filter_map(|&byte| self.push(byte)?.ok()).collect()
    }

    fn count(&mut self, sequence: u32) {
        self.records += 1;
        if let Some(last) = self.last {
            let step = sequence.wrapping_sub(last);
            // A step back is a device that started anew, not a loss of four thousand million.
            if step < u32::MAX / 2 {
                self.lost += u64::from(step.saturating_sub(1));
            }
        }
        self.last = Some(sequence);
    }
}
