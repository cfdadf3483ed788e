//! The state of an instrument, about once a second: counters, load and memory. Also raw samples.

use super::frame::{self, Frame, Kind, WIRE};
use crate::bytes::{Reader, Writer};
use heapless::Vec;
use picket_dsp::acquire::frontend::Counters;

/// The status. On the wire it is a version and then fourteen words, little-endian, in the order of
/// the fields. The last word is missing in the first programs' statuses, and is then 0.
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

const VERSION: u8 = 1;
const WORDS: usize = 14;

impl Status {
    /// The words, in the order of the wire.
    fn words(&mut self) -> [&mut u32; WORDS] {
        let Self { counters, dropped, refused, load, stack, longest, peak } = self;
        let Counters { blocks, overruns, missed, late, broken, spurious, dma_errors, adc_overruns } =
            counters;
        [
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
            peak,
        ]
    }

    /// The status as a frame.
    pub fn to_frame(&self) -> Vec<u8, WIRE> {
        let mut bytes = [0; 1 + 4 * WORDS];
        let mut writer = Writer::new(&mut bytes);
        writer.put([VERSION]);
        for word in { *self }.words() {
            writer.u32(*word);
        }
        frame::encode(Kind::Status, &bytes).unwrap_or_default()
    }

    /// The status in a frame; `None` if the frame holds none. Bytes appended by a later version are
    /// ignored.
    pub fn from_frame(frame: &Frame) -> Option<Self> {
        let (&VERSION, rest) = frame.payload.split_first()? else { return None };
        let (words, _) = rest.as_chunks();
        if frame.kind != Kind::Status || words.len() < WORDS - 1 {
            return None;
        }
        let mut status = Self::default();
        for (place, &word) in status.words().into_iter().zip(words) {
            *place = u32::from_le_bytes(word);
        }
        Some(status)
    }
}

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
        let mut reader = Reader(&frame.payload);
        let (sequence, offset) = (reader.u32()?, reader.u16()?);
        let bytes = Vec::from_slice(reader.0).ok()?;
        (frame.kind == Kind::Raw).then_some(Self { sequence, offset, bytes })
    }
}
