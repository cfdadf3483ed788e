//! RIFF WAVE files, and those with lengths of 64 bits (RF64).
//!
//! Chunks are read here rather than by a crate, so that damaged and streamed files are distinguished, and 64-bit floats are read.

use super::input::Input;
use super::number::{Kind, Number};
use super::scaling::Unit;
use super::source::Packed;
use super::{Opened, Options, RecordingError, pick};
use std::path::Path;

/// Lengths from here on, and 0, are what programs write that do not know it: they stream.
const UNKNOWN: u64 = 0x7FFF_0000;

/// The kinds of coding (RFC 2361). An extensible header has its own kind in its first bytes of another place.
const PCM: u16 = 1;
const FLOAT: u16 = 3;
const EXTENSIBLE: u16 = 0xFFFE;

/// What the header says.
#[derive(Debug, PartialEq)]
struct Header {
    number: Number,
    bits: u32,
    channels: usize,
    rate_hz: f64,
    /// Where the samples begin.
    start: u64,
    /// Bytes of samples, where the header knows.
    length: Option<u64>,
}

fn bytes<const W: usize>(head: &[u8], at: usize) -> Result<[u8; W], String> {
    let found = head.get(at..).and_then(|rest| rest.first_chunk());
    found.copied().ok_or_else(|| "its header is cut off".into())
}

fn header(head: &[u8]) -> Result<Header, String> {
    let id: [u8; 4] = bytes(head, 0)?;
    let big = &id == b"RIFX";
    let word = |at: usize| bytes(head, at).map(u32::from_le_bytes);
    if big || !matches!(&id, b"RIFF" | b"RF64") || &bytes::<4>(head, 8)? != b"WAVE" {
        return Err("it does not begin as one".into());
    }
    let (mut at, mut format, mut long) = (12usize, None, None);
    loop {
        let (id, length): ([u8; 4], _) = (bytes(head, at)?, word(at + 4)?);
        let body = at + 8;
        match &id {
            b"ds64" => long = Some(u64::from_le_bytes(bytes(head, body + 8)?)),
            b"fmt " => format = Some(body),
            b"data" => {
                let format = format.ok_or("its samples come before their format")?;
                let length = match long {
                    Some(long) if length == u32::MAX => long,
                    _ => u64::from(length),
                };
                let known = (1..UNKNOWN).contains(&length) || long == Some(length) && length > 0;
                return fmt(head, format, body as u64, known.then_some(length));
            }
            _ => {}
        }
        // Chunks begin at even places. Where addresses have 32 bits, a length may end beyond them.
        let length = length as usize;
        at = body.saturating_add(length).saturating_add(length % 2);
        if at > head.len() {
            return Err("its header is cut off".into());
        }
    }
}

/// The format's chunk.
fn fmt(head: &[u8], at: usize, start: u64, length: Option<u64>) -> Result<Header, String> {
    let short = |place: usize| bytes(head, at + place).map(u16::from_le_bytes);
    let (channels, frame, bits) = (short(2)?, short(12)?, short(14)?);
    let rate_hz = f64::from(u32::from_le_bytes(bytes(head, at + 4)?));
    let kind = match short(0)? {
        EXTENSIBLE => short(24)?,
        kind => kind,
    };
    let kind = match (kind, bits) {
        (PCM, 1..=8) => Kind::U8,
        (PCM, 9..=16) => Kind::I16,
        (PCM, 17..=24) => Kind::I24,
        (PCM, 25..=32) => Kind::I32,
        (FLOAT, 32) => Kind::F32,
        (FLOAT, 64) => Kind::F64,
        (PCM | FLOAT, bits) => return Err(format!("samples of {bits} bits")),
        (6 | 7, _) => return Err("its samples are of a telephone's kind: save it as PCM".into()),
        (other, _) => {
            return Err(format!("its samples are coded (kind {other}): save it as PCM"));
        }
    };
    if channels == 0 || usize::from(frame) != usize::from(channels) * kind.width() {
        return Err(format!("{channels} channels in {frame} bytes"));
    }
    let number = kind.little();
    let (bits, channels) = (8 * kind.width() as u32, channels.into());
    Ok(Header { number, bits, channels, rate_hz, start, length })
}

pub(super) fn open(path: &Path, input: Input, options: &Options) -> Result<Opened, RecordingError> {
    let Header { number, bits, channels, rate_hz, start, length } =
        header(&input.head).map_err(|what| RecordingError::Wav(path.into(), what))?;
    let held = input.bytes.map(|bytes| bytes.saturating_sub(start));
    if let (Some(said), Some(held)) = (length, held)
        && said > held
    {
        return Err(RecordingError::Truncated(path.into(), said, held));
    }
    let frame = (channels * number.width()) as u64;
    let frames = length.or(held).map(|bytes| bytes / frame);
    if frames == Some(0) {
        return Err(RecordingError::Empty(path.into()));
    }
    let picked = pick::real(path, channels, options)?;
    if rate_hz == 0.0 && options.rate_hz.is_none() {
        return Err(RecordingError::Rate(0.0));
    }
    let unit = match number.kind {
        Kind::U8 => Unit::eight_bits(128.0),
        Kind::F32 | Kind::F64 => Unit::SHARE,
        _ => Unit::bits(bits),
    };
    let source = Box::new(Packed {
        path: path.into(),
        reader: input.from(path, start)?,
        number,
        channels,
        picked,
        left: frames.unwrap_or(u64::MAX),
        buffer: Vec::new(),
    });
    Ok(Opened {
        rate_hz: Some(rate_hz),
        iq: picked.1.is_some(),
        length: frames,
        ..Opened::new(unit, source)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(kind: u16, channels: u16, bits: u16, length: u32) -> Vec<u8> {
        let frame = channels * bits.div_ceil(8);
        let mut head = b"RIFF\0\0\0\0WAVEfmt \x10\0\0\0".to_vec();
        head.extend([kind, channels].into_iter().flat_map(u16::to_le_bytes));
        head.extend([48_000u32, 48_000 * u32::from(frame)].into_iter().flat_map(u32::to_le_bytes));
        head.extend([frame, bits].into_iter().flat_map(u16::to_le_bytes));
        head.extend(b"data");
        head.extend(length.to_le_bytes());
        head
    }

    #[test]
    fn headers() {
        let whole = header(&of(PCM, 2, 24, 600)).unwrap();
        assert_eq!((whole.number.kind, whole.channels, whole.start), (Kind::I24, 2, 44));
        assert_eq!((whole.rate_hz, whole.length), (48e3, Some(600)));
        assert_eq!(header(&of(FLOAT, 1, 64, 8)).unwrap().number.kind, Kind::F64);
        for length in [0, u32::MAX, 0x7FFF_F000] {
            assert_eq!(header(&of(PCM, 1, 16, length)).unwrap().length, None);
        }
        assert!(header(&of(7, 1, 8, 8)).unwrap_err().contains("telephone"));
        assert!(header(&of(PCM, 0, 16, 8)).is_err() && header(&of(2, 1, 4, 8)).is_err());
        assert!(header(&of(PCM, 1, 16, 8)[..40]).unwrap_err().contains("cut off"));
        assert!(header(b"RIFX\0\0\0\0WAVE").is_err() && header(b"RI").is_err());
    }
}
