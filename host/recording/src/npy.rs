//! NumPy's arrays (npy, versions 1 to 3): one dimension, or two, one for the channels; complex numbers are I/Q.

use super::arrays::{Array, Channels};
use super::axes::Cube;
use super::input::Input;
use super::number::{Kind, Number};
use super::scaling::Unit;
use super::source::{Held, Packed};
use super::{Opened, Options, RecordingError, pick};
use std::io::Read;
use std::path::Path;

pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

/// What the header says.
#[derive(Debug, PartialEq)]
pub(super) struct Header {
    pub number: Number,
    pub complex: bool,
    pub sides: Vec<u64>,
    /// The last index runs fastest.
    pub rows_first: bool,
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
    let sides = sides.ok_or_else(|| format!("an array of shape ({shape})"))?;
    Ok(Header { number, complex, sides, rows_first, start })
}

/// The array in these bytes.
pub(super) fn array(name: &str, bytes: &[u8]) -> Result<Array, String> {
    let Header { number, complex, sides, rows_first, start } = header(bytes)?;
    let mut numbers = Vec::new();
    number.samples(bytes.get(start..).unwrap_or_default(), 1, (0, None), &mut numbers);
    let numbers = numbers.into_iter().map(|sample| sample.value.re).collect();
    Array::new(name, numbers, complex, sides, rows_first).ok_or_else(|| "it is cut off".into())
}

pub(super) fn open(path: &Path, input: Input, options: &Options) -> Result<Opened, RecordingError> {
    let wrong = |what: String| RecordingError::Npy(path.into(), what);
    let Header { number, complex, sides, rows_first, start } =
        header(&input.head).map_err(wrong)?;
    if sides.contains(&0) {
        return Err(RecordingError::Empty(path.into()));
    }
    if let Some(cube) = Cube::of(path, &sides, rows_first, complex, options)? {
        return records(path, input, number, start as u64, &cube, &sides, complex);
    }
    let channels = Channels::of(&sides, rows_first)
        .ok_or_else(|| wrong("say what its sides count: --axes".into()))?;
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
    let source = Packed {
        path: path.into(),
        reader: input.from(path, start as u64)?.take(frame.saturating_mul(channels.length)),
        number,
        channels: channels.count * parts,
        picked,
        left: channels.length,
        buffer: Vec::new(),
    };
    Ok(Opened {
        iq: picked.1.is_some(),
        length: Some(channels.length),
        ..Opened::new(Unit::FREE, Box::new(source))
    })
}

/// The records of an array, read as they lie where they are in order.
fn records(
    path: &Path,
    input: Input,
    number: Number,
    start: u64,
    cube: &Cube,
    sides: &[u64],
    complex: bool,
) -> Result<Opened, RecordingError> {
    let wrong = |what: &str| RecordingError::Npy(path.into(), what.into());
    let parts = if complex { 2 } else { 1 };
    let all = sides.iter().try_fold(parts, |all: u64, side| all.checked_mul(*side));
    let all = all.ok_or_else(|| wrong("its sides are too long"))?;
    let needed = all.saturating_mul(number.width() as u64);
    if input.bytes.is_some_and(|bytes| bytes.saturating_sub(start) < needed) {
        return Err(wrong("it is cut off"));
    }
    let opened = Opened {
        iq: cube.complex,
        length: Some(cube.length()),
        row: Some(cube.samples),
        frame: cube.frame(),
        axes: Some(cube.axes),
        notes: vec![cube.note.clone()],
        ..Opened::new(Unit::FREE, Box::new(Held { samples: Vec::new().into_iter() }))
    };
    if cube.is_in_order() {
        let channels = if cube.complex { 2 } else { 1 };
        let source = Packed {
            path: path.into(),
            reader: input.from(path, start)?.take(needed),
            number,
            channels,
            picked: (0, cube.complex.then_some(1)),
            left: all / channels as u64,
            buffer: Vec::new(),
        };
        return Ok(Opened { source: cube.chosen(Box::new(source)), ..opened });
    }
    let bytes = input.all(path)?;
    let mut numbers = Vec::new();
    let own = bytes.get(start as usize..).unwrap_or_default();
    number.samples(own, 1, (0, None), &mut numbers);
    let numbers: Vec<f64> = numbers.into_iter().map(|sample| sample.value.re).collect();
    let source = Held { samples: cube.samples(&numbers).into_iter() };
    Ok(Opened { source: Box::new(source), ..opened })
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
        let channels = |header: &Header| Channels::of(&header.sides, header.rows_first).unwrap();
        let shape = |header: &Header| (channels(header).count, channels(header).length);
        let real = of("{'descr': '<i2', 'fortran_order': False, 'shape': (5000,), }\n").unwrap();
        assert_eq!((real.number.kind, real.complex, shape(&real)), (Kind::I16, false, (1, 5000)));
        let iq = of("{'descr': '<c8', 'fortran_order': False, 'shape': (7,), }\n").unwrap();
        assert_eq!((iq.number.kind, iq.complex, shape(&iq)), (Kind::F32, true, (1, 7)));
        let two = of("{'descr': '<f8', 'fortran_order': False, 'shape': (9, 2), }\n").unwrap();
        assert_eq!((shape(&two), channels(&two).together), ((2, 9), true));
        let rows = of("{'descr': '>i2', 'fortran_order': False, 'shape': (3, 500)}").unwrap();
        assert!(rows.number.big && shape(&rows) == (3, 500) && !channels(&rows).together);
        assert!(of("{'descr': '<U8', 'shape': (5,)}").unwrap_err().contains("<U8"));
        assert_eq!(of("{'descr': '<i2', 'shape': (5, 3, 2)}").unwrap().sides, [5, 3, 2]);
        assert!(of("{'descr': '<i2', 'shape': (5, x)}").is_err());
        assert!(header(b"\x93NUMPY\x01\x00\xff\xff").is_err() && header(MAGIC).is_err());
    }
}
