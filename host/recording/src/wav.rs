//! RIFF WAVE files.

use super::input::Input;
use super::{Options, Recording, RecordingError};
use std::path::Path;

pub(super) fn open(
    path: &Path,
    mut input: Input,
    options: Options,
) -> Result<Recording, RecordingError> {
    let bad = |what: String| RecordingError::Wav(path.into(), what);
    let bytes = input.bytes;
    let streamed = mend(&mut input.head, bytes);
    let reader = hound::WavReader::new(input.reader()).map_err(|error| match error {
        hound::Error::IoError(_) => bad("its header is cut off".into()),
        hound::Error::Unsupported => bad("only integer and 32-bit float samples are read".into()),
        other => bad(other.to_string()),
    })?;
    let spec = reader.spec();
    let width = u64::from(spec.bits_per_sample.div_ceil(8));
    let announced = u64::from(reader.len()) * width;
    if let Some(held) = bytes.map(|bytes| bytes.saturating_sub(SHORTEST_HEADER))
        && announced > held
        && !streamed
    {
        return Err(RecordingError::Truncated(path.into(), announced, held));
    }
    if announced == 0 {
        return Err(RecordingError::Empty(path.into()));
    }
    let channels = usize::from(spec.channels);
    let picked = match options.channel {
        Some((first, second)) => {
            let wrong =
                [Some(first), second].into_iter().flatten().find(|c| !(1..=channels).contains(c));
            if let Some(wrong) = wrong {
                return Err(RecordingError::Channel(path.into(), wrong, channels));
            }
            (first, second)
        }
        None if channels == if options.iq { 2 } else { 1 } => (1, options.iq.then_some(2)),
        None => return Err(RecordingError::Channels(path.into(), channels, options.iq)),
    };
    let rate_hz = f64::from(spec.sample_rate);
    if rate_hz == 0.0 && options.rate_hz.is_none() {
        return Err(RecordingError::Rate(0.0));
    }
    let length = (!streamed || bytes.is_some()).then_some(u64::from(reader.duration()));
    let values: Box<dyn Iterator<Item = hound::Result<f64>> + Send> = match spec.sample_format {
        hound::SampleFormat::Float => {
            let codes = options.scale * 32768.0;
            Box::new(reader.into_samples::<f32>().map(move |x| x.map(|x| f64::from(x) * codes)))
        }
        hound::SampleFormat::Int => {
            // Eight bits have their middle between -1 and 0.
            let (codes, middle) = match spec.bits_per_sample {
                8 => (257.0, 128.0),
                bits => (1.0 / f64::from(bits.saturating_sub(16)).exp2(), 0.0),
            };
            let code = move |x| (f64::from(x) * codes + middle) * options.scale;
            Box::new(reader.into_samples::<i32>().map(move |x| x.map(code)))
        }
    };
    let owned = path.to_path_buf();
    let mut values = values.map_while(move |x| match x {
        Ok(x) if x.is_finite() => Some(Ok(x)),
        Ok(x) => Some(Err(RecordingError::Wav(owned.clone(), format!("a sample is {x}")))),
        // Nobody knew beforehand where it would end.
        Err(_) if streamed => None,
        Err(error) => Some(Err(RecordingError::Wav(owned.clone(), error.to_string()))),
    });
    let mut frame = vec![0.0; channels];
    let wanted = std::iter::from_fn(move || {
        for value in &mut frame {
            match values.next()? {
                Ok(number) => *value = number,
                Err(error) => return Some(Err(error)),
            }
        }
        let (first, second) = picked;
        let part = |channel: usize| frame.get(channel - 1).copied();
        Some(Ok(super::Sample::of(part(first)?, second.and_then(part))))
    });
    Ok(Recording {
        path: path.into(),
        rate_hz: options.rate_hz.unwrap_or(rate_hz),
        iq: picked.1.is_some(),
        length,
        stream: Box::new(wanted),
    })
}

/// The bytes of a wav file that has nothing but a format and its samples.
const SHORTEST_HEADER: u64 = 44;

/// Lengths from here on, and 0, are what programs write that do not know it: they stream.
const UNKNOWN: u32 = 0x7FFF_0000;

/// Writes the length of the samples into a header that does not know it: what the file holds, or more than will come. True if it did.
fn mend(head: &mut [u8], bytes: Option<u64>) -> bool {
    if head.starts_with(b"RF64") {
        // Its true length has 64 bits and stands elsewhere; the one looked at here is unknown.
        head[..4].copy_from_slice(b"RIFF");
    }
    let word = |head: &[u8], at: usize| {
        Some(u32::from_le_bytes(head.get(at..at.checked_add(4)?)?.try_into().ok()?))
    };
    let (mut at, mut frame) = (12usize, 1);
    // Where addresses have 32 bits, a length may end beyond them.
    while let Some(length) = at.checked_add(4).and_then(|at| word(head, at)) {
        let id = &head[at..at + 4];
        if id == b"fmt " {
            frame = word(head, at + 8 + 12).map_or(1, |word| u64::from(word & 0xFFFF)).max(1);
        }
        if id == b"data" {
            if (1..UNKNOWN).contains(&length) {
                return false;
            }
            let held =
                bytes.map_or(u64::from(u32::MAX), |bytes| bytes.saturating_sub(at as u64 + 8));
            let whole = held.min(u32::MAX.into()) / frame * frame;
            head[at + 4..at + 8].copy_from_slice(&(whole as u32).to_le_bytes());
            return true;
        }
        // Chunks begin at even places.
        at = at
            .saturating_add(8)
            .saturating_add(length as usize)
            .saturating_add(length as usize % 2);
    }
    false
}
