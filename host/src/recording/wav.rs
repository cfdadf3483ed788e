//! RIFF WAVE files.

use super::{Options, Recording, RecordingError, Sample, open_file};
use std::io::BufReader;
use std::path::Path;

pub(super) fn open(path: &Path, options: Options) -> Result<Recording, RecordingError> {
    let (file, bytes) = open_file(path)?;
    let bad = |what: String| RecordingError::Wav(path.into(), what);
    let reader = hound::WavReader::new(BufReader::new(file)).map_err(|error| match error {
        hound::Error::IoError(_) => bad("its header is cut off".into()),
        hound::Error::Unsupported => bad("only integer and 32-bit float samples are read".into()),
        other => bad(other.to_string()),
    })?;
    let spec = reader.spec();
    let width = u64::from(spec.bits_per_sample.div_ceil(8));
    let announced = u64::from(reader.len()) * width;
    let held = bytes.saturating_sub(SHORTEST_HEADER);
    if announced > held {
        return Err(RecordingError::Truncated(path.into(), announced, held));
    }
    if announced == 0 {
        return Err(RecordingError::Empty(path.into()));
    }
    let channels = usize::from(spec.channels);
    if channels != if options.iq { 2 } else { 1 } {
        return Err(RecordingError::Channels(path.into(), channels, options.iq));
    }
    let rate_hz = f64::from(spec.sample_rate);
    if rate_hz == 0.0 && options.rate_hz.is_none() {
        return Err(RecordingError::Rate(0.0));
    }
    let length = u64::from(reader.duration());
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
    let values = values.map(move |x| match x {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(x) => Err(RecordingError::Wav(owned.clone(), format!("a sample is {x}"))),
        Err(error) => Err(RecordingError::Wav(owned.clone(), error.to_string())),
    });
    Ok(Recording {
        path: path.into(),
        rate_hz: options.rate_hz.unwrap_or(rate_hz),
        iq: options.iq,
        length: Some(length),
        stream: Box::new(Frames { values, iq: options.iq }),
    })
}

/// The bytes of a wav file that has nothing but a format and its samples.
const SHORTEST_HEADER: u64 = 44;

/// Interleaved values as samples.
struct Frames<I> {
    values: I,
    iq: bool,
}

impl<I: Iterator<Item = Result<f64, RecordingError>>> Iterator for Frames<I> {
    type Item = Result<Sample, RecordingError>;

    fn next(&mut self) -> Option<Self::Item> {
        let re = self.values.next()?;
        let im = if self.iq { self.values.next()? } else { Ok(0.0) };
        Some(re.and_then(|re| Ok(Sample::new(re, im?))))
    }
}
