//! SigMF, the signal metadata format: a description in JSON and the samples beside it, or an archive of both.

use super::input::Input;
use super::number::{Kind, Number};
use super::scaling::Unit;
use super::source::Packed;
use super::{Opened, Options, RecordingError, pick};
use serde_json::Value;
use std::io::Read;
use std::path::{Path, PathBuf};

/// What the description says.
#[derive(Debug, PartialEq)]
struct Description {
    number: Number,
    complex: bool,
    unit: Unit,
    channels: usize,
    rate_hz: Option<f64>,
    /// Bytes before the first sample.
    header: u64,
    /// The name of the file with the samples, where it is not the description's own.
    dataset: Option<String>,
}

fn description(text: &[u8]) -> Result<Description, String> {
    let json: Value =
        serde_json::from_slice(text).map_err(|_| "its description is not JSON".to_owned())?;
    let global = &json["global"];
    let datatype = global["core:datatype"].as_str().ok_or("it has no core:datatype")?;
    let unknown = || format!("numbers of the kind \"{datatype}\"");
    let (kind, complex) = match datatype.split_at_checked(1) {
        Some(("c", kind)) => (kind, true),
        Some(("r", kind)) => (kind, false),
        _ => return Err(unknown()),
    };
    let (kind, big) = match kind.split_once('_') {
        Some((kind, "be")) => (kind, true),
        Some((kind, "le")) => (kind, false),
        None if kind.ends_with('8') => (kind, false),
        _ => return Err(unknown()),
    };
    let (kind, unit) = match kind {
        "i8" => (Kind::I8, Unit::eight_bits(0.0)),
        "u8" => (Kind::U8, Unit::eight_bits(128.0)),
        "i16" => (Kind::I16, Unit::CODES),
        "u16" => (Kind::U16, Unit::OFFSET_16),
        "i32" => (Kind::I32, Unit::bits(32)),
        "u32" => (Kind::U32, Unit::FREE),
        "f32" => (Kind::F32, Unit::SHARE),
        "f64" => (Kind::F64, Unit::SHARE),
        _ => return Err(unknown()),
    };
    let channels = global["core:num_channels"].as_u64().unwrap_or(1);
    let first = json["captures"].get(0);
    Ok(Description {
        number: Number { kind, big },
        complex,
        unit,
        channels: usize::try_from(channels)
            .ok()
            .filter(|&it| (1..=256).contains(&it))
            .ok_or("its channels cannot be counted")?,
        rate_hz: global["core:sample_rate"].as_f64().filter(|rate| *rate > 0.0),
        header: first.and_then(|it| it["core:header_bytes"].as_u64()).unwrap_or(0),
        dataset: global["core:dataset"].as_str().map(str::to_owned),
    })
}

pub(super) fn open(path: &Path, input: Input, options: &Options) -> Result<Opened, RecordingError> {
    let wrong = |what: String| RecordingError::Sigmf(path.into(), what);
    if input.head.get(257..).is_some_and(|rest| rest.starts_with(b"ustar")) {
        return archive(path, input, options);
    }
    let begins = String::from_utf8_lossy(&input.head[..input.head.len().min(64)]).into_owned();
    let (text, data, bytes): (_, Box<dyn Read + Send>, _) = if begins.trim_start().starts_with('{')
    {
        let text = input.all(path)?;
        let name = description(&text).map_err(wrong)?.dataset;
        let data = match name.as_deref().map(Path::new).and_then(Path::file_name) {
            Some(name) => path.with_file_name(name),
            None => path.with_extension("sigmf-data"),
        };
        let data = Input::open(&data)?;
        let bytes = data.bytes;
        (text, Box::new(data.from(path, 0)?), bytes)
    } else {
        let beside: PathBuf = path.with_extension("sigmf-meta");
        let text = Input::open(&beside)?.all(&beside)?;
        let bytes = input.bytes;
        (text, Box::new(input.from(path, 0)?), bytes)
    };
    let description = description(&text).map_err(wrong)?;
    described(path, description, data, bytes, options)
}

/// The recording of a description and its bytes.
fn described(
    path: &Path,
    description: Description,
    mut data: Box<dyn Read + Send>,
    bytes: Option<u64>,
    options: &Options,
) -> Result<Opened, RecordingError> {
    let Description { number, complex, unit, channels, rate_hz, header, .. } = description;
    let picked = match complex || (options.iq && channels == 1) {
        true => pick::complex(path, channels, options)?,
        false => pick::real(path, channels, options)?,
    };
    let parts = if complex || (options.iq && channels == 1) { 2 } else { 1 };
    let frame = (channels * parts * number.width()) as u64;
    let length = bytes.map(|bytes| bytes.saturating_sub(header) / frame);
    if length == Some(0) {
        return Err(RecordingError::Empty(path.into()));
    }
    let skipped = std::io::copy(&mut data.by_ref().take(header), &mut std::io::sink());
    skipped.map_err(|error| RecordingError::Io(path.into(), error))?;
    let source = Box::new(Packed {
        path: path.into(),
        reader: data,
        number,
        channels: channels * parts,
        picked,
        left: length.unwrap_or(u64::MAX),
        buffer: Vec::new(),
    });
    Ok(Opened { rate_hz, iq: picked.1.is_some(), length, ..Opened::new(unit, source) })
}

/// The first recording of an archive, as `sigmf` of Python writes it.
fn archive(path: &Path, input: Input, options: &Options) -> Result<Opened, RecordingError> {
    let wrong = |what: String| RecordingError::Sigmf(path.into(), what);
    let bytes = input.all(path)?;
    let mut tape = tar::Archive::new(&bytes[..]);
    let (mut text, mut data) = (None, None::<(PathBuf, usize, usize)>);
    let entries = tape.entries().map_err(|error| wrong(error.to_string()))?;
    for entry in entries {
        let mut entry = entry.map_err(|error| wrong(error.to_string()))?;
        let name = entry.path().map_err(|error| wrong(error.to_string()))?.into_owned();
        let suffix = name.extension().and_then(|it| it.to_str()).unwrap_or_default().to_owned();
        let place = || name.with_extension("");
        match suffix.as_str() {
            "sigmf-meta" if text.is_none() => {
                let mut json = Vec::new();
                entry.read_to_end(&mut json).map_err(|error| wrong(error.to_string()))?;
                text = Some((place(), json));
            }
            "sigmf-data" if data.as_ref().is_none_or(|(other, ..)| *other != place()) => {
                let start = entry.raw_file_position() as usize;
                let length = entry.size() as usize;
                let known = text.as_ref().is_none_or(|(own, _)| *own == place());
                if data.is_none() || known {
                    data = Some((place(), start, length));
                }
            }
            _ => {}
        }
    }
    let ((_, text), (_, start, length)) =
        text.zip(data).ok_or_else(|| wrong("it has no description with samples".into()))?;
    let own = start.checked_add(length).and_then(|end| bytes.get(start..end));
    let own = own.ok_or_else(|| wrong("it is cut off".into()))?.to_vec();
    let description = description(&text).map_err(wrong)?;
    described(path, description, Box::new(std::io::Cursor::new(own)), Some(length as u64), options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptions() {
        let of = |kind: &str| {
            description(format!(r#"{{"global": {{"core:datatype": "{kind}", "core:sample_rate": 2.5e6}}, "captures": [{{"core:sample_start": 0}}]}}"#).as_bytes())
        };
        let floats = of("cf32_le").unwrap();
        assert_eq!((floats.number, floats.complex), (Kind::F32.little(), true));
        assert_eq!((floats.rate_hz, floats.channels, floats.header), (Some(2.5e6), 1, 0));
        assert!(of("ri16_be").unwrap().number.big && !of("ru8").unwrap().complex);
        assert!(of("cf16_le").is_err() && of("").is_err() && of("ci16").is_err());
        assert!(description(b"{}").is_err() && description(b"x").is_err());
    }
}
