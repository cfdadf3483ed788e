//! The state of an instrument, about once a second: counters, load and memory. Also raw samples.

use super::frame::{self, Frame, Kind, WIRE};
use crate::layout::{Field, Reader, layout, record};
use heapless::Vec;
use picket_dsp::acquire::frontend::Counters;

/// The status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// The front end's counters.
    pub counters: Counters,
    /// Frames dropped because the line had no room.
    pub dropped: u32,
    /// Frames from the host that were damaged or not understood.
    pub refused: u32,
    /// Share of the time since the last status in which the core was awake, in thousandths.
    pub load: u32,
    /// The largest stack so far, bytes.
    pub stack: u32,
    /// The longest time since the last status from taking a block to its measurement, in ticks of
    /// the timers.
    pub longest: u32,
    /// The share of its block's duration that this longest measurement took, in thousandths. Above
    /// 1000 it lived on the spare slots.
    pub peak: u32,
}

layout! {
    /// Counters, load and memory of an instrument, once a second.
    Status {
        /// The front end's counters.
        counters: Counters,
        /// Frames dropped because the line had no room.
        dropped: u32,
        /// Frames from the host that were damaged or not understood.
        refused: u32,
        /// Share of the time since the last status in which the core was awake, in thousandths.
        load: u32,
        /// Largest stack so far, bytes.
        stack: u32,
        /// Longest time since the last status from taking a block to its measurement, ticks.
        longest: u32,
        /// Share of its block's duration that this longest measurement took, in thousandths.
        peak: u32,
    }
}

record!(Status, Status, |_| true);

/// A piece of a block's raw samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raw {
    /// The block's sequence number.
    pub sequence: u32,
    /// Offset of this piece in the block, bytes.
    pub offset: u16,
    /// The samples, little-endian i16, I and Q in turn.
    pub bytes: Vec<u8, { Self::PIECE }>,
}

impl Raw {
    /// The largest piece, bytes.
    pub const PIECE: usize = 192;

    /// The piece as a frame.
    pub fn to_frame(&self) -> Vec<u8, WIRE> {
        let mut payload = Vec::<u8, { 6 + Self::PIECE }>::new();
        let (sequence, offset) = (self.sequence.to_le_bytes(), self.offset.to_le_bytes());
        let parts = [&sequence[..], &offset, &self.bytes];
        let fits = parts.iter().all(|part| payload.extend_from_slice(part).is_ok());
        if fits { frame::encode(Kind::Raw, &payload).unwrap_or_default() } else { Vec::new() }
    }

    /// The piece in a frame; `None` if the frame holds none.
    pub fn from_frame(frame: &Frame) -> Option<Self> {
        let (head, samples) = frame.payload.split_first_chunk::<6>()?;
        let mut reader = Reader::new(head);
        let (sequence, offset) = (u32::take(&mut reader)?, u16::take(&mut reader)?);
        let bytes = Vec::from_slice(samples).ok()?;
        (frame.kind == Kind::Raw).then_some(Self { sequence, offset, bytes })
    }
}
