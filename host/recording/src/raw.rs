//! Headerless numbers, little-endian.

use super::input::Input;
use super::{Format, Options, Recording, RecordingError, Sample};
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

/// A kind of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    F32,
    F64,
}

impl Number {
    pub const fn of(format: Format) -> Self {
        match format {
            Format::U16 => Number::U16,
            Format::I32 => Number::I32,
            Format::F32 => Number::F32,
            _ => Number::I16,
        }
    }

    /// Bytes.
    pub const fn width(self) -> usize {
        match self {
            Number::I8 | Number::U8 => 1,
            Number::I16 | Number::U16 => 2,
            Number::I32 | Number::F32 => 4,
            Number::F64 => 8,
        }
    }

    /// The number in these bytes, as it is.
    pub fn read(self, bytes: [u8; 8]) -> f64 {
        let [a, b, c, d, ..] = bytes;
        match self {
            Number::I8 => f64::from(a as i8),
            Number::U8 => f64::from(a),
            Number::I16 => f64::from(i16::from_le_bytes([a, b])),
            Number::U16 => f64::from(u16::from_le_bytes([a, b])),
            Number::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Number::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Number::F64 => f64::from_le_bytes(bytes),
        }
    }

    /// The same in codes of 16 bits: the middle of unsigned ones is 0, the ends of floats are -1 and 1.
    fn codes(self, bytes: [u8; 8]) -> f64 {
        let number = self.read(bytes);
        match self {
            Number::U16 => number - 32768.0,
            Number::I32 => number / 65536.0,
            Number::F32 => number * 32768.0,
            _ => number,
        }
    }
}

/// The numbers of a reader, one after the other; what is left at the end and is no whole number is dropped.
pub(super) fn numbers(
    path: PathBuf,
    mut reader: BufReader<impl Read>,
    width: usize,
) -> impl Iterator<Item = Result<[u8; 8], RecordingError>> {
    std::iter::from_fn(move || {
        let mut bytes = [0; 8];
        match reader.read_exact(&mut bytes[..width]) {
            Ok(()) => Some(Ok(bytes)),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => None,
            Err(error) => Some(Err(RecordingError::Io(path.clone(), error))),
        }
    })
}

pub(super) fn open(
    path: &Path,
    input: Input,
    format: Format,
    options: Options,
) -> Result<Recording, RecordingError> {
    let number = Number::of(format);
    let frame = (if options.iq { 2 } else { 1 }) * number.width() as u64;
    if let Some(bytes) = input.bytes.filter(|bytes| bytes % frame != 0) {
        return Err(RecordingError::OddSize(path.into(), bytes, frame));
    }
    if options.channel.is_some() {
        return Err(RecordingError::NoChannels(path.into()));
    }
    let rate_hz = options.rate_hz.ok_or_else(|| RecordingError::RateMissing(path.into()))?;
    let length = input.bytes.map(|bytes| bytes / frame);
    let (owned, scale) = (path.to_path_buf(), options.scale);
    let values = numbers(path.into(), input.reader(), number.width()).map(move |bytes| {
        let value = number.codes(bytes?) * scale;
        let wrong = || RecordingError::NotANumber(owned.clone(), value);
        value.is_finite().then_some(value).ok_or_else(wrong)
    });
    let stream = Box::new(super::pairs(values, options.iq));
    Ok(Recording { path: path.into(), rate_hz, iq: options.iq, length, stream })
}

impl Sample {
    /// A sample of one number, or of two.
    pub(super) fn of(re: f64, im: Option<f64>) -> Self {
        Sample::new(re, im.unwrap_or(0.0))
    }
}
