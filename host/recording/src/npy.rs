//! NumPy's arrays (npy, versions 1 to 3): one dimension, or two of which the second is I and Q; complex numbers are I/Q.

use super::input::Input;
use super::raw::{Number, numbers};
use super::{Options, Recording, RecordingError};
use std::io::Read;
use std::path::Path;

pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

/// What the header says.
#[derive(Debug, PartialEq)]
struct Header {
    number: Number,
    iq: bool,
    length: u64,
    /// Where the numbers begin.
    start: usize,
}

fn header(head: &[u8]) -> Result<Header, String> {
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
    let (number, complex) = match kind {
        "|i1" => (Number::I8, false),
        "|u1" => (Number::U8, false),
        "<i2" => (Number::I16, false),
        "<u2" => (Number::U16, false),
        "<i4" => (Number::I32, false),
        "<f4" => (Number::F32, false),
        "<f8" => (Number::F64, false),
        "<c8" => (Number::F32, true),
        "<c16" => (Number::F64, true),
        other => {
            return Err(format!(
                "numbers of kind \"{other}\": save it as float32, int16 or complex64"
            ));
        }
    };
    let shape = after("'shape'").and_then(|rest| rest.split(['(', ')']).nth(1)).unwrap_or_default();
    let sides: Option<Vec<u64>> = shape
        .split(',')
        .map(str::trim)
        .filter(|side| !side.is_empty())
        .map(|side| side.parse().ok())
        .collect();
    let rows = after("'fortran_order'").is_some_and(|rest| rest.starts_with("False"));
    let (length, pairs) = match sides.as_deref() {
        Some(&[length] | &[length, 1]) => (length, false),
        Some(&[length, 2]) if rows && !complex => (length, true),
        _ => {
            return Err(format!("an array of shape ({shape}): save one column, or two of I and Q"));
        }
    };
    Ok(Header { number, iq: complex || pairs, length, start })
}

pub(super) fn open(
    path: &Path,
    input: Input,
    options: Options,
) -> Result<Recording, RecordingError> {
    let wrong = |what| RecordingError::Npy(path.into(), what);
    let Header { number, iq, length, start } = header(&input.head).map_err(wrong)?;
    let rate_hz = options.rate_hz.ok_or_else(|| RecordingError::RateMissing(path.into()))?;
    if options.channel.is_some() {
        return Err(RecordingError::NoChannels(path.into()));
    }
    if options.iq && !iq {
        return Err(RecordingError::Channels(path.into(), 1, true));
    }
    if length == 0 {
        return Err(RecordingError::Empty(path.into()));
    }
    let mut reader = input.reader();
    let skipped = std::io::copy(&mut reader.by_ref().take(start as u64), &mut std::io::sink());
    skipped.map_err(|error| RecordingError::Io(path.into(), error))?;
    let (owned, scale) = (path.to_path_buf(), options.scale);
    let values = numbers(path.into(), reader, number.width()).map(move |bytes| {
        let value = number.read(bytes?) * scale;
        let wrong = || RecordingError::NotANumber(owned.clone(), value);
        value.is_finite().then_some(value).ok_or_else(wrong)
    });
    let stream = Box::new(super::pairs(values, iq).take(length as usize));
    Ok(Recording { path: path.into(), rate_hz, iq, length: Some(length), stream })
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
        let real = of("{'descr': '<i2', 'fortran_order': False, 'shape': (5000,), }\n").unwrap();
        assert_eq!((real.number, real.iq, real.length), (Number::I16, false, 5000));
        let iq = of("{'descr': '<c8', 'fortran_order': False, 'shape': (7,), }\n").unwrap();
        assert_eq!((iq.number, iq.iq, iq.length), (Number::F32, true, 7));
        let two = of("{'descr': '<f8', 'fortran_order': False, 'shape': (9, 2), }\n").unwrap();
        assert_eq!((two.iq, two.length), (true, 9));
        assert!(of("{'descr': '>i2', 'shape': (5,)}").unwrap_err().contains(">i2"));
        assert!(of("{'descr': '<i2', 'fortran_order': False, 'shape': (5, 3)}").is_err());
        assert!(header(b"\x93NUMPY\x01\x00\xff\xff").is_err() && header(MAGIC).is_err());
    }
}
