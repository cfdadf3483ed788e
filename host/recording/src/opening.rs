//! How a file is opened: by which format, and what is known before its numbers become codes.

use super::input::Input;
#[cfg(feature = "json")]
use super::objects;
use super::source::{Held, Source};
use super::times::{self, Timing, Untimely};
use super::{
    Format, Opened, Options, RecordingError, Sample, columns, doubt, npy, order, raw, text, wav,
};
#[cfg(feature = "packed")]
use super::{flac, hdf5, mat, npz, sigmf};
use std::path::Path;

/// The numbers of a file. The name decides the format, unless the first bytes show another.
pub(super) fn opened(
    path: &Path,
    input: Input,
    options: &Options,
    timing: Option<&Timing>,
) -> Result<Opened, RecordingError> {
    if let Some(cure) = Format::cure(&input.head) {
        return Err(RecordingError::Other(path.into(), cure));
    }
    let seen = Format::seen(&input.head);
    let guessed = Format::guess(path);
    let format = match (options.format, seen, guessed) {
        (Some(format), ..) => format,
        // A sound file has a name that may be anything's.
        (None, Some(seen), Some(guessed)) if guessed.raw().is_none() && guessed != Format::Csv => {
            if guessed == Format::Json {
                seen
            } else {
                guessed
            }
        }
        (None, Some(seen), _) => seen,
        (None, None, Some(guessed)) => guessed,
        (None, None, None) if text::is_text(&input.head) => Format::Csv,
        (None, None, None) => {
            return Err(RecordingError::Unclear(path.into(), doubt::readings(&input.head)));
        }
    };
    if options.format.is_none() && format.raw().is_some() {
        if text::is_text(&input.head) {
            // Names like .dat are given to either.
            return Err(RecordingError::Either(path.into()));
        }
        let readings = doubt::readings(&input.head);
        if Format::vague(path) && !readings.is_empty() {
            return Err(RecordingError::Unclear(path.into(), readings));
        }
        let told = options.iq || options.channel.is_some() || options.channels.is_some();
        if let Some(like) = order::like(&input.head, format).filter(|_| !told) {
            return Err(RecordingError::Like(path.into(), like));
        }
    }
    match format {
        Format::Wav => wav::open(path, input, options),
        #[cfg(feature = "packed")]
        Format::Flac => flac::open(path, input, options),
        Format::Npy => npy::open(path, input, options),
        #[cfg(feature = "packed")]
        Format::Npz => npz::open(path, input, options),
        #[cfg(feature = "packed")]
        Format::Mat => mat::open(path, input, options),
        #[cfg(feature = "packed")]
        Format::Hdf5 => hdf5::open(path, input, options),
        #[cfg(feature = "packed")]
        Format::Sigmf => sigmf::open(path, input, options),
        #[cfg(not(feature = "packed"))]
        Format::Flac | Format::Npz | Format::Mat | Format::Hdf5 | Format::Sigmf => {
            Err(RecordingError::Packed(path.into()))
        }
        Format::Csv => columns::open(path, input, options, timing),
        #[cfg(feature = "json")]
        Format::Json => objects::open(path, input, options, timing),
        #[cfg(not(feature = "json"))]
        Format::Json => Err(RecordingError::Packed(path.into())),
        _ => raw::open(path, input, format, options),
    }
}

/// How the rows lie in time that were read.
pub(super) fn timed(
    path: &Path,
    source: &mut dyn Source,
    options: &Options,
) -> Result<Option<Timing>, RecordingError> {
    let Some((times, named)) = source.times() else { return Ok(None) };
    if options.rate_hz.is_some() {
        // Samples are as even as the user says.
        return Ok(None);
    }
    match times::timing(&times, &named, options.part) {
        Ok(timing) => Ok(Some(timing)),
        Err(Untimely::Other) => Ok(None),
        Err(Untimely::Said(what)) => {
            let what = format!(
                "its time, column {}, {what}: add --rate HZ to do without it",
                named.column
            );
            Err(RecordingError::Columns(path.into(), what))
        }
    }
}

/// What was read to look at it, and then the rest.
pub(super) struct Chained {
    pub first: Held,
    pub rest: Box<dyn Source>,
}

impl Source for Chained {
    fn read(&mut self, into: &mut Vec<Sample>, count: usize) -> Result<(), RecordingError> {
        let from = into.len();
        self.first.read(into, count)?;
        let more = count - (into.len() - from);
        if more > 0 { self.rest.read(into, more) } else { Ok(()) }
    }
}
