//! Headerless numbers, little-endian.

use super::input::Input;
use super::source::Packed;
use super::{Format, Opened, Options, RecordingError, pick};
use std::path::Path;

pub(super) fn open(
    path: &Path,
    input: Input,
    format: Format,
    options: &Options,
) -> Result<Opened, RecordingError> {
    let raw = format.raw().ok_or_else(|| RecordingError::Unclear(path.into(), &[]))?;
    let pairs = raw.complex || options.iq || matches!(options.channel, Some((_, Some(_))));
    let picked = match (raw.complex || options.iq, pairs) {
        (true, _) => pick::complex(path, 1, options)?,
        (false, true) => pick::real(path, 2, options)?,
        (false, false) => pick::real(path, 1, options)?,
    };
    let channels = if pairs { 2 } else { 1 };
    let frame = channels as u64 * raw.number.width() as u64;
    if let Some(bytes) = input.bytes.filter(|bytes| bytes % frame != 0) {
        return Err(RecordingError::OddSize(path.into(), bytes, frame));
    }
    let length = input.bytes.map(|bytes| bytes / frame);
    Ok(Opened {
        rate_hz: None,
        iq: picked.1.is_some(),
        length,
        unit: raw.unit,
        source: Box::new(Packed {
            path: path.into(),
            reader: input.from(path, 0)?,
            number: raw.number,
            channels,
            picked,
            left: length.unwrap_or(u64::MAX),
            buffer: Vec::new(),
        }),
    })
}
