//! Frames: a kind, a payload and a CRC-32, stuffed by COBS and closed by a zero.
//!
//! ```text
//! COBS( kind: u8 | payload: 0..=PAYLOAD bytes | CRC-32/ISO-HDLC of both, little-endian ) | 0x00
//! ```
//!
//! A reader that joins in the middle, or meets noise, loses frames up to the next zero and no
//! further.

use super::cobs;
use crc::{CRC_32_ISO_HDLC, Crc};
use heapless::Vec;

/// The largest payload, bytes.
pub const PAYLOAD: usize = 240;
/// The largest frame before stuffing, bytes.
const PLAIN: usize = 1 + PAYLOAD + 4;
/// The largest frame on the wire, bytes.
pub const WIRE: usize = cobs::encoded_len(PLAIN) + 1;

/// How the checksum is computed: a frame has only some hundred bytes.
#[cfg(not(feature = "table"))]
type Way = crc::NoTable;
/// By a table of 1 KB: 10 cycles a byte, not 70, on a core that sends a frame for every block.
#[cfg(feature = "table")]
type Way = crc::Table<1>;

/// The polynomial of Ethernet and zlib.
static CRC: Crc<u32, Way> = Crc::<u32, Way>::new(&CRC_32_ISO_HDLC);

/// What a frame carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Kind {
    /// Telemetry: a measurement ([`super::telemetry::Telemetry`]).
    Telemetry = 1,
    /// The last frame of a run: the front end's counters.
    End = 2,
    /// A host's request ([`super::command::Request`]).
    Command = 3,
    /// The answer to a request.
    Reply = 4,
    /// The refusal of a request.
    Refusal = 5,
    /// The boot record ([`super::boot::Boot`]).
    Boot = 6,
    /// The status ([`super::status::Status`]).
    Status = 7,
    /// Raw samples ([`super::status::Raw`]).
    Raw = 8,
    /// Tracks and targets ([`super::follow::Follow`]).
    Follow = 9,
    /// All tones of a block ([`super::lines::Lines`]).
    Lines = 10,
    /// The fundamental of a block's harmonics ([`super::fundamental::Fundamental`]).
    Fundamental = 11,
    /// A burst ([`super::burst::Burst`]).
    Burst = 12,
    /// The sum of blocks that a record is of ([`super::sum::Sum`]).
    Sum = 13,
    /// A frame of chirps ([`super::chirp_frame::ChirpFrame`]).
    ChirpFrame = 14,
    /// A target of a frame of chirps ([`super::chirp_frame::Found`]).
    Found = 15,
}

impl Kind {
    /// The kind with this number on the wire; `None` for an unknown number.
    pub const fn from_u8(code: u8) -> Option<Self> {
        match code {
            1 => Some(Kind::Telemetry),
            2 => Some(Kind::End),
            3 => Some(Kind::Command),
            4 => Some(Kind::Reply),
            5 => Some(Kind::Refusal),
            6 => Some(Kind::Boot),
            7 => Some(Kind::Status),
            8 => Some(Kind::Raw),
            9 => Some(Kind::Follow),
            10 => Some(Kind::Lines),
            11 => Some(Kind::Fundamental),
            12 => Some(Kind::Burst),
            13 => Some(Kind::Sum),
            14 => Some(Kind::ChirpFrame),
            15 => Some(Kind::Found),
            _ => None,
        }
    }
}

/// Why the bytes between two zeros are not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FrameError {
    /// The bytes end within a group, or are too few for a kind and a checksum.
    Truncated,
    /// The bytes are more than a frame holds.
    TooLong,
    /// The checksum does not match.
    Checksum,
    /// The checksum matches but the kind is unknown: the sender is newer.
    Kind(u8),
}

impl core::fmt::Display for FrameError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            FrameError::Truncated => f.write_str("a frame is cut off"),
            FrameError::TooLong => f.write_str("a frame is too long"),
            FrameError::Checksum => f.write_str("a frame's checksum does not match"),
            FrameError::Kind(kind) => write!(f, "a frame is of unknown kind {kind}"),
        }
    }
}

impl core::error::Error for FrameError {}

/// A complete frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The kind of the payload.
    pub kind: Kind,
    /// The payload.
    pub payload: Vec<u8, PLAIN>,
}

/// The bytes of a frame, with the closing zero.
///
/// # Errors
/// The payload is longer than [`PAYLOAD`].
pub fn encode(kind: Kind, payload: &[u8]) -> Result<Vec<u8, WIRE>, cobs::Full> {
    let mut plain = Vec::<u8, PLAIN>::new();
    plain.push(kind as u8).map_err(|_| cobs::Full)?;
    plain.extend_from_slice(payload).map_err(|_| cobs::Full)?;
    let checksum = CRC.checksum(&plain);
    plain.extend_from_slice(&checksum.to_le_bytes()).map_err(|_| cobs::Full)?;
    let mut wire = Vec::new();
    cobs::encode(&plain, &mut wire)?;
    wire.push(0).map_err(|_| cobs::Full)?;
    Ok(wire)
}

/// Finds frames in a stream of bytes.
#[derive(Clone, Debug, Default)]
pub struct Reader {
    stuffing: cobs::Decoder,
    plain: Vec<u8, PLAIN>,
    begun: bool,
    overlong: bool,
}

impl Reader {
    /// Takes a byte. A closing zero yields the frame before it, or why there is none. Zeros in a
    /// row are idle.
    pub fn push(&mut self, byte: u8) -> Option<Result<Frame, FrameError>> {
        if byte != 0 {
            self.begun = true;
            if let Some(data) = self.stuffing.push(byte) {
                self.overlong |= self.plain.push(data).is_err();
            }
            return None;
        }
        let frame = self.begun.then(|| self.finish());
        // In place: a flood of zeros would have the core move a whole frame at each.
        self.stuffing = cobs::Decoder::default();
        self.plain.clear();
        (self.begun, self.overlong) = (false, false);
        frame
    }

    fn finish(&self) -> Result<Frame, FrameError> {
        if self.overlong {
            return Err(FrameError::TooLong);
        }
        if !self.stuffing.complete() {
            return Err(FrameError::Truncated);
        }
        let Some((body, &checksum)) = self.plain.split_last_chunk::<4>() else {
            return Err(FrameError::Truncated);
        };
        let Some((&kind, payload)) = body.split_first() else {
            return Err(FrameError::Truncated);
        };
        if CRC.checksum(body) != u32::from_le_bytes(checksum) {
            return Err(FrameError::Checksum);
        }
        let kind = Kind::from_u8(kind).ok_or(FrameError::Kind(kind))?;
        let payload = Vec::from_slice(payload).map_err(|_| FrameError::TooLong)?;
        Ok(Frame { kind, payload })
    }
}
