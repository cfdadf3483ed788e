//! Headerless 16-bit integers, little-endian.

use super::{Options, Recording, RecordingError, Sample, open_file};
use std::io::{self, BufReader, Read};
use std::path::Path;

pub(super) fn open(path: &Path, options: Options) -> Result<Recording, RecordingError> {
    let (file, bytes) = open_file(path)?;
    let frame = if options.iq { 4 } else { 2 };
    if bytes % frame != 0 {
        return Err(RecordingError::OddSize(path.into(), bytes, frame));
    }
    let rate_hz = options.rate_hz.ok_or_else(|| RecordingError::RateMissing(path.into()))?;
    let mut reader = BufReader::with_capacity(1 << 16, file);
    let (owned, iq, scale) = (path.to_path_buf(), options.iq, options.scale);
    let stream = std::iter::from_fn(move || {
        let mut parts = [0u8; 4];
        match reader.read_exact(&mut parts[..frame as usize]) {
            Ok(()) => {
                let code = |at: usize| f64::from(i16::from_le_bytes([parts[at], parts[at + 1]]));
                Some(Ok(Sample::new(code(0) * scale, if iq { code(2) * scale } else { 0.0 })))
            }
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => None,
            Err(error) => Some(Err(RecordingError::Io(owned.clone(), error))),
        }
    });
    let length = (bytes > 0).then_some(bytes / frame);
    Ok(Recording { path: path.into(), rate_hz, iq, length, stream: Box::new(stream) })
}
