//! FLAC files.

use super::input::Input;
use super::pick::{self, Picked};
use super::scaling::Unit;
use super::source::Source;
use super::{Opened, Options, RecordingError, Sample};
use claxon::{Block, FlacReader};
use std::io::Read;
use std::path::{Path, PathBuf};

pub(super) fn open(path: &Path, input: Input, options: &Options) -> Result<Opened, RecordingError> {
    let reader = FlacReader::new(input.reader())
        .map_err(|error| RecordingError::Flac(path.into(), error.to_string()))?;
    let info = reader.streaminfo();
    let picked = pick::real(path, info.channels as usize, options)?;
    let unit = match info.bits_per_sample {
        8 => Unit::eight_bits(0.0),
        bits => Unit::bits(bits),
    };
    let source =
        Box::new(Decoded { path: path.into(), reader, picked, frame: Block::empty(), at: 0 });
    Ok(Opened {
        rate_hz: Some(info.sample_rate.into()),
        iq: picked.1.is_some(),
        length: info.samples,
        ..Opened::new(unit, source)
    })
}

/// The samples of a FLAC file, frame by frame.
struct Decoded<R: Read> {
    path: PathBuf,
    reader: FlacReader<R>,
    picked: Picked,
    frame: Block,
    /// The next sample of the frame.
    at: u32,
}

impl<R: Read + Send> Source for Decoded<R> {
    fn read(&mut self, into: &mut Vec<Sample>, count: usize) -> Result<(), RecordingError> {
        let end = into.len() + count;
        while into.len() < end {
            if self.at >= self.frame.duration() {
                let buffer = std::mem::replace(&mut self.frame, Block::empty()).into_buffer();
                let next = self.reader.blocks().read_next_or_eof(buffer);
                let failed = |error: claxon::Error| {
                    RecordingError::Flac(self.path.clone(), error.to_string())
                };
                let Some(frame) = next.map_err(failed)? else { return Ok(()) };
                let wanted = self.picked.0.max(self.picked.1.unwrap_or(0)) as u32;
                if frame.channels() <= wanted {
                    let what = "its frames differ in their channels".into();
                    return Err(RecordingError::Flac(self.path.clone(), what));
                }
                (self.frame, self.at) = (frame, 0);
            }
            let channel = |channel: usize| self.frame.sample(channel as u32, self.at).into();
            let (first, second) = self.picked;
            into.push(Sample::of(channel(first), second.map(channel)));
            self.at += 1;
        }
        Ok(())
    }
}
