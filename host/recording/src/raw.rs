//! Headerless numbers, little-endian.

use super::input::Input;
use super::source::{Packed, Source};
use super::{Format, Opened, Options, RecordingError, Sample, pick};
use std::path::Path;

/// Channels in turn, at most.
const CHANNELS: usize = 256;

pub(super) fn open(
    path: &Path,
    input: Input,
    format: Format,
    options: &Options,
) -> Result<Opened, RecordingError> {
    let raw = format.raw().ok_or_else(|| RecordingError::Unclear(path.into(), &[]))?;
    let several = options.channels.unwrap_or(1).clamp(1, CHANNELS);
    let fours = format == Format::Iiqq;
    let pairs = raw.complex || options.iq && several == 1;
    let picked = match pairs {
        _ if fours => (0, None),
        true => pick::complex(path, several, options)?,
        // Two numbers that are chosen are a pair.
        false if several == 1 && matches!(options.channel, Some((_, Some(_)))) => {
            pick::real(path, 2, options)?
        }
        false => pick::real(path, several, options)?,
    };
    let channels = match () {
        () if fours => 1,
        () if pairs => 2 * several,
        () if several == 1 && picked.1.is_some() => 2,
        () => several,
    };
    let frame = (if fours { 4 } else { channels } * raw.number.width()) as u64;
    if let Some(bytes) = input.bytes.filter(|bytes| bytes % frame != 0) {
        return Err(RecordingError::OddSize(path.into(), bytes, frame));
    }
    let frames = input.bytes.map(|bytes| bytes / frame);
    let source = Packed {
        path: path.into(),
        reader: input.from(path, 0)?,
        number: raw.number,
        channels,
        picked,
        left: frames.map_or(u64::MAX, |frames| if fours { 4 * frames } else { frames }),
        buffer: Vec::new(),
    };
    let source: Box<dyn Source> = match fours {
        true => Box::new(Fours { numbers: Box::new(source), second: None }),
        false => Box::new(source),
    };
    Ok(Opened {
        iq: fours || picked.1.is_some(),
        length: frames.map(|frames| if fours { 2 * frames } else { frames }),
        ..Opened::new(raw.unit, source)
    })
}

/// Two samples in four numbers: I I Q Q.
struct Fours {
    numbers: Box<dyn Source>,
    second: Option<Sample>,
}

impl Source for Fours {
    fn read(&mut self, into: &mut Vec<Sample>, count: usize) -> Result<(), RecordingError> {
        let wanted = into.len() + count;
        into.extend(self.second.take().filter(|_| count > 0));
        let mut numbers = Vec::new();
        self.numbers.read(&mut numbers, 4 * wanted.saturating_sub(into.len()).div_ceil(2))?;
        for four in numbers.chunks_exact(4) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| four[k].value.re);
            into.push(Sample::of(a, Some(c)));
            into.push(Sample::of(b, Some(d)));
        }
        if into.len() > wanted {
            self.second = into.pop();
        }
        Ok(())
    }
}
