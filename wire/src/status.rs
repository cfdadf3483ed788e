//! How an instrument is: counters, load and memory, about once a second; and blocks as they are.

use super::frame::{self, Frame, Kind, WIRE};
use crate::bytes::{Reader, Writer};
use heapless::Vec;
use picket::acquire::frontend::Counters;

/// The record: a version, then thirteen words, little-endian, in the order of the fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// What became of the blocks.
    pub counters: Counters,
    /// Records that found no room on the line.
    pub dropped: u32,
    /// Frames from the host that were damaged or not understood.
    pub refused: u32,
    /// The share of the time that the core was not asleep, in thousandths, since the last status.
    pub load: u32,
    /// Bytes of stack that were ever in use.
    pub stack: u32,
    /// The longest time from taking a block to having measured it since the last status, in ticks of the timers.
    pub longest: u32,
}

const VERSION: u8 = 1;
const WORDS: usize = 13;

impl Status {
    /// As a frame.
    pub fn to_frame(&self) -> Vec<u8, WIRE> {
        let Counters { blocks, overruns, missed, late, broken, spurious, dma_errors, adc_overruns } =
            self.counters;
        let words: [u32; WORDS] = [
            blocks,
            overruns,
            missed,
            late,
            broken,
            spurious,
            dma_errors,
            adc_overruns,
            self.dropped,
            self.refused,
            self.load,
            self.stack,
            self.longest,
        ];
        let mut bytes = [0; 1 + 4 * WORDS];
        let mut writer = Writer::new(&mut bytes);
        writer.put([VERSION]);
        for word in words {
            writer.u32(word);
        }
        frame::encode(Kind::Status, &bytes).unwrap_or_default()
    }

    /// The record a frame carries; what a later version appends is passed over.
    pub fn of_frame(frame: &Frame) -> Option<Self> {
        let (&VERSION, rest) = frame.payload.split_first()? else { return None };
        if frame.kind != Kind::Status {
            return None;
        }
        let words = rest.as_chunks().0.first_chunk::<WORDS>()?.map(u32::from_le_bytes);
        let [
            blocks,
            overruns,
            missed,
            late,
            broken,
            spurious,
            dma_errors,
            adc_overruns,
            dropped,
            refused,
            load,
            stack,
            longest,
        ] = words;
        let counters =
            Counters { blocks, overruns, missed, late, broken, spurious, dma_errors, adc_overruns };
        Some(Self { counters, dropped, refused, load, stack, longest })
    }
}

/// A piece of a block's samples as the converter gave them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raw {
    /// The block's sequence number.
    pub sequence: u32,
    /// Bytes of the block before this piece.
    pub offset: u16,
    /// The piece: little-endian i16, I/Q in turn.
    pub bytes: Vec<u8, { Self::PIECE }>,
}

impl Raw {
    /// The most bytes in a piece.
    pub const PIECE: usize = 192;

    /// As a frame.
    pub fn to_frame(&self) -> Vec<u8, WIRE> {
        let mut payload = Vec::<u8, { 6 + Self::PIECE }>::new();
        let (sequence, offset) = (self.sequence.to_le_bytes(), self.offset.to_le_bytes());
        let parts = [&sequence[..], &offset, &self.bytes];
        let fits = parts.iter().all(|part| payload.extend_from_slice(part).is_ok());
        if fits { frame::encode(Kind::Raw, &payload).unwrap_or_default() } else { Vec::new() }
    }

    /// The piece a frame carries.
    pub fn of_frame(frame: &Frame) -> Option<Self> {
        let mut reader = Reader(&frame.payload);
        let (sequence, offset) = (reader.u32()?, reader.u16()?);
        let bytes = Vec::from_slice(reader.0).ok()?;
        (frame.kind == Kind::Raw).then_some(Self { sequence, offset, bytes })
    }
}
