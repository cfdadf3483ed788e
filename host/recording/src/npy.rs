//! NumPy's arrays (npy, versions 1 to 3): one dimension, or two of which one counts the channels; complex numbers are I/Q.

use super::arrays::{Array, Channels};
use super::input::Input;
use super::number::{Kind, Number};
use super::scaling::Unit;
use super::source::Packed;
use super::{Opened, Options, RecordingError, pick};
use std::io::Read;
use std::path::Path;

pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

/// What the header says.
#[derive(Debug, PartialEq)]
pub(super) struct Header {
    pub number: Number,
    pub complex: bool,
    pub channels: Channels,
    /// Where the numbers begin.
    pub start: usize,
}

pub(super) fn header(head: &[u8]) -> Result<Header, String> {
    let cut = || "its header is cut off".to_string();
    if !head.starts_with(MAGIC) {
        return Err("it does not begin as one".into());
    }
    let version = *head.get(6).ok_or_else(cut)?;
    let (size, text) = match version {
        1 => (head.get(8..10).ok_or_else(cut)?, 10),
        _ => (head.get(8..12).ok_or_else(cut)?, 12),
    };
    let size = size.iter().rev().fold(0, |sum, &byte| sum * 256 + usize::from(byte));
    let start = text + size;
    let text = String::from_utf8_lossy(head.get(text..start).ok_or_else(cut)?).into_owned();
    let after =
        |key: &str| text.split_once(key).map(|(_, rest)| rest.trim_start_matches([':', ' ']));
    let kind = after("'descr'").and_then(|rest| rest.split('\'').nth(1)).unwrap_or_default();
    let (order, name) = kind.split_at_checked(1).unwrap_or_default();
    let (number, complex) = match name {
        "i1" => (Kind::I8, false),
        "u1" => (Kind::U8, false),
        "i2" => (Kind::I16, false),
        "u2" => (Kind::U16, false),
        "i4" => (Kind::I32, false),
        "u4" => (Kind::U32, false),
        "i8" => (Kind::I64, false),
        "u8" => (Kind::U64, false),
        "f4" => (Kind::F32, false),
        "f8" => (Kind::F64, false),
        "c8" => (Kind::F32, true),
        "c16" => (Kind::F64, true),
        _ => {
            return Err(format!(
                "numbers of kind \"{kind}\": save it as float32, int16 or complex64"
            ));
        }
    };
    let number = Number { kind: number, big: order == ">" };
    let shape = after("'shape'").and_then(|rest| rest.split(['(', ')']).nth(1)).unwrap_or_default();
    let sides: Option<Vec<u64>> = shape
        .split(',')
        .map(str::trim)
        .filter(|side| !side.is_empty())
        .map(|side| side.parse().ok())
        .collect();
    let rows_first = after("'fortran_order'").is_none_or(|rest| rest.starts_with("False"));
    let channels = sides.and_then(|sides| Channels::of(&sides, rows_first));
    let channels =
        channels.ok_or_else(|| format!("an array of shape ({shape}): save a column a channel"))?;
    Ok(Header { number, complex, channels, start })
}

/// The array in these bytes.
pub(super) fn array(name: &str, bytes: &[u8]) -> Result<Array, String> {
    let Header { number, complex, channels, start } = header(bytes)?;
    let mut numbers = Vec::new();
    number.samples(bytes.get(start..).unwrap_or_default(), 1, (0, None), &mut numbers);
    let numbers = numbers.into_iter().map(|sample| sample.value.re).collect();
    Array::packed(name, numbers, complex, channels).ok_or_else(|| "it is cut off".into())
}

pub(super) fn open(path: &Path, input: Input, options: &Options) -> Result<Opened, RecordingError> {
    let wrong = |what: String| RecordingError::Npy(path.into(), what);
    let Header { number, complex, channels, start } = header(&input.head).map_err(wrong)?;
    if channels.length == 0 {
        return Err(RecordingError::Empty(path.into()));
    }
    if !channels.together && channels.count > 1 {
        // Channels lie one behind the other.
        let bytes = input.all(path)?;
        let array = array("", &bytes).map_err(wrong)?;
        return super::arrays::opened(path, vec![array], options);
    }
    let parts = if complex { 2 } else { 1 };
    // Two columns of numbers are I and Q, and one side of the array counts them.
    let pairs = !complex && channels.count == 2 && options.channel.is_none();
    let picked = match (complex, pairs) {
        (true, _) => pick::complex(path, channels.count, options)?,
        (false, true) => (0, Some(1)),
        (false, false) => pick::real(path, channels.count, options)?,
    };
    let frame = (channels.count * parts * number.width()) as u64;
    let held = input.bytes.map(|bytes| bytes.saturating_sub(start as u64) / frame);
    if held.is_some_and(|held| held < channels.length) {
        return Err(wrong(format!(
            "it is cut off: {} of {} samples are there",
            held.unwrap_or(0),
            channels.length
        )));
    }
    Ok(Opened {
        rate_hz: None,
        iq: picked.1.is_some(),
        length: Some(channels.length),
        unit: Unit::FREE,
        source: Box::new(Packed {
            path: path.into(),
            reader: input.from(path, start as u64)?.take(frame.saturating_mul(channels.length)),
            number,
            channels: channels.count * parts,
            picked,
            left: channels.length,
            buffer: Vec::new(),
        }),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers() {
        let of = |text: &str| {
            let size = (text.len() as u16).to_le_bytes();
            header(&[MAGIC, &[1, 0], &size, text.as_bytes()].concat())
        };
        let shape = |header: &Header| (header.channels.count, header.channels.length);
        let real = of("{'descr': '<i2', 'fortran_order': False, 'shape': (5000,), }\n").unwrap();
        assert_eq!((real.number.kind, real.complex, shape(&real)), (Kind::I16, false, (1, 5000)));
        let iq = of("{'descr': '<c8', 'fortran_order': False, 'shape': (7,), }\n").unwrap();
        assert_eq!((iq.number.kind, iq.complex, shape(&iq)), (Kind::F32, true, (1, 7)));
        let two = of("{'descr': '<f8', 'fortran_order': False, 'shape': (9, 2), }\n").unwrap();
        assert_eq!((shape(&two), two.channels.together), ((2, 9), true));
        let rows = of("{'descr': '>i2', 'fortran_order': False, 'shape': (3, 500)}").unwrap();
        assert!(rows.number.big && shape(&rows) == (3, 500) && !rows.channels.together);
        assert!(of("{'descr': '<U8', 'shape': (5,)}").unwrap_err().contains("<U8"));
        assert!(of("{'descr': '<i2', 'shape': (5, 3, 2)}").is_err());
        assert!(header(b"\x93NUMPY\x01\x00\xff\xff").is_err() && header(MAGIC).is_err());
    }
}
