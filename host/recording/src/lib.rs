//! Recordings as streams of samples: wav, headerless numbers, csv, npy and JSON lines; from a file, or from stdin by the name `-`.
//!
//! They are read through once, sample by sample, so memory does not grow with their size.
//!
//! Values are in *codes* of a 16-bit converter. 16-bit wav and int16 files keep their own codes, unsigned ones count from the
//! middle; 8-bit wav is spread over all of them (times 257, so that its rails are the rails); 24- and 32-bit wav is divided by 2^8
//! and 2^16, int32 files too; floating-point wav and float32 files are multiplied by 2^15; csv, npy and JSON are taken as codes.
//! [`Options::scale`] multiplies all of them. The integer arithmetic takes the nearest code.

mod columns;
mod error;
mod input;
mod npy;
mod raw;
#[cfg(feature = "json")]
mod records;
mod table;
mod wav;

pub use error::RecordingError;
#[cfg(feature = "json")]
pub use records::{JsonRecord, Records};

use input::Input;
use num_complex::Complex;
use std::fmt;
use std::path::{Path, PathBuf};

/// How a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Format {
    /// RIFF WAVE, 8 to 32 bit integers or 32 bit floats.
    Wav,
    /// Headerless 16-bit integers, little-endian.
    I16,
    /// Headerless unsigned 16-bit integers, little-endian, 32768 in the middle.
    U16,
    /// Headerless 32-bit integers, little-endian.
    I32,
    /// Headerless 32-bit floats, little-endian, full scale from -1 to 1.
    F32,
    /// NumPy's array.
    Npy,
    /// Columns: samples, or I and Q; an oscilloscope's with its time and its header lines.
    Csv,
    /// One record a line: {"id", "kind": "r" or "c", "re": [..], "im": [..]}.
    Json,
}

impl Format {
    /// The format that a file's name ends in.
    pub fn guess(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "wav" | "wave" => Some(Format::Wav),
            "bin" | "i16" | "s16" | "raw" | "pcm" | "dat" => Some(Format::I16),
            "u16" => Some(Format::U16),
            "i32" | "s32" => Some(Format::I32),
            "f32" | "float" => Some(Format::F32),
            "npy" => Some(Format::Npy),
            "csv" | "txt" | "tsv" => Some(Format::Csv),
            "json" | "jsonl" | "ndjson" => Some(Format::Json),
            _ => None,
        }
    }
}

impl Format {
    /// The format that a file's first bytes tell.
    fn seen(head: &[u8]) -> Option<Self> {
        match head {
            [b'R', b'I', b'F', b'F', ..] | [b'R', b'F', b'6', b'4', ..] => Some(Format::Wav),
            head if head.starts_with(npy::MAGIC) => Some(Format::Npy),
            _ => None,
        }
    }
}

/// What a user says about a file.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// The format; guessed from the file's name where `None`.
    pub format: Option<Format>,
    /// Samples per second; wav files know their own.
    pub rate_hz: Option<f64>,
    /// True where two channels, or pairs of integers, are I and Q.
    pub iq: bool,
    /// Codes per unit of the file, see the module's documentation.
    pub scale: f64,
    /// The channel of a wav file, or the column of a csv file, from 1; with a second one: I and Q.
    pub channel: Option<(usize, Option<usize>)>,
    /// Commas in a csv file are decimal, not between columns.
    pub decimal_comma: bool,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            format: None,
            rate_hz: None,
            iq: false,
            scale: 1.0,
            channel: None,
            decimal_comma: false,
        }
    }
}

/// One sample, in codes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// The value; its imaginary part is the quadrature channel, 0 for real samples.
    pub value: Complex<f64>,
}

impl Sample {
    fn new(re: f64, im: f64) -> Self {
        Sample { value: Complex::new(re, im) }
    }

    /// The nearest 16-bit codes; what does not fit ends at the rails.
    pub fn code(&self) -> [i16; 2] {
        // `as` saturates.
        [self.value.re.round() as i16, self.value.im.round() as i16]
    }
}

/// Samples as they come, until the first error.
type Stream = Box<dyn Iterator<Item = Result<Sample, RecordingError>> + Send>;

/// An open recording.
pub struct Recording {
    path: PathBuf,
    rate_hz: f64,
    iq: bool,
    length: Option<u64>,
    stream: Stream,
}

impl fmt::Debug for Recording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Recording({}, {} Hz, iq {})", self.path.display(), self.rate_hz, self.iq)
    }
}

impl Recording {
    /// Opens a wav, int16 or csv file. (JSON lines hold records, not a stream: [`Records`].)
    pub fn open(path: &Path, options: Options) -> Result<Self, RecordingError> {
        checked(&options)?;
        Self::of(path, Input::open(path)?, options)
    }

    /// The recording in these bytes of a file of this name, for whom has no file system.
    pub fn of_bytes(name: &Path, bytes: Vec<u8>, options: Options) -> Result<Self, RecordingError> {
        checked(&options)?;
        Self::of(name, Input::of_bytes(name, bytes)?, options)
    }

    fn of(path: &Path, input: Input, options: Options) -> Result<Self, RecordingError> {
        let format =
            options.format.or_else(|| Format::guess(path)).or_else(|| Format::seen(&input.head));
        let format = format.ok_or_else(|| RecordingError::Format(path.into()))?;
        let guessed = options.format.is_none();
        match format {
            Format::Wav => wav::open(path, input, options),
            // Names like .dat are given to either.
            Format::I16 if guessed && input.text() => Err(RecordingError::Either(path.into())),
            Format::I16 | Format::U16 | Format::I32 | Format::F32 => {
                raw::open(path, input, format, options)
            }
            Format::Npy => npy::open(path, input, options),
            Format::Csv => columns::open(path, input, options),
            Format::Json => Err(RecordingError::Line(
                path.into(),
                1,
                "JSON lines are records of their own, not one recording".into(),
            )),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Samples per second.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// True for I/Q samples.
    pub fn iq(&self) -> bool {
        self.iq
    }

    /// The number of samples, where the file tells it before it is read.
    pub fn length(&self) -> Option<u64> {
        self.length
    }

    /// Its samples, one after the other.
    pub fn samples(self) -> impl Iterator<Item = Result<Sample, RecordingError>> {
        self.stream
    }

    /// Cuts the recording into blocks of `n` samples, `hop` apart, after leaving out `skip` samples. Both `n`
    /// and `hop` are at least 1. What is left at the end and fills no block is not used.
    pub fn blocks(self, n: usize, hop: usize, skip: u64) -> Blocks {
        Blocks { recording: self, n, hop, pending: skip, read: 0, samples: Vec::with_capacity(n) }
    }
}

fn checked(options: &Options) -> Result<(), RecordingError> {
    match options.rate_hz.filter(|&rate| !(rate > 0.0 && rate.is_finite())) {
        Some(rate) => Err(RecordingError::Rate(rate)),
        None => Ok(()),
    }
}

/// Blocks of a recording, which may overlap. Holds one block in memory.
#[derive(Debug)]
pub struct Blocks {
    recording: Recording,
    n: usize,
    hop: usize,
    /// Samples to leave out before the next block.
    pending: u64,
    read: u64,
    samples: Vec<Sample>,
}

impl Blocks {
    /// The recording.
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// The next block and the number of its first sample, or `None` at the end. An error if the
    /// recording does not fill even one block.
    pub fn next_block(&mut self) -> Result<Option<(u64, &[Sample])>, RecordingError> {
        let first = self.samples.is_empty();
        self.samples.drain(..self.hop.min(self.samples.len()));
        while self.pending > 0 {
            if self.take()?.is_none() {
                return self.end(first);
            }
            self.pending -= 1;
        }
        while self.samples.len() < self.n {
            match self.take()? {
                Some(sample) => self.samples.push(sample),
                None => return self.end(first),
            }
        }
        self.pending = self.hop.saturating_sub(self.n) as u64;
        Ok(Some((self.read - self.n as u64, &self.samples)))
    }

    fn take(&mut self) -> Result<Option<Sample>, RecordingError> {
        let sample = self.recording.stream.next().transpose()?;
        self.read += u64::from(sample.is_some());
        Ok(sample)
    }

    fn end(&self, first: bool) -> Result<Option<(u64, &[Sample])>, RecordingError> {
        let path = || self.recording.path.clone();
        match (first, self.read) {
            (true, 0) => Err(RecordingError::Empty(path())),
            (true, _) => Err(RecordingError::Short(path(), self.samples.len() as u64, self.n)),
            (false, _) => Ok(None),
        }
    }
}

/// Values as samples: one each, or two of I and Q.
fn pairs(
    mut values: impl Iterator<Item = Result<f64, RecordingError>>,
    iq: bool,
) -> impl Iterator<Item = Result<Sample, RecordingError>> {
    std::iter::from_fn(move || {
        let re = values.next()?;
        let im = if iq { Some(values.next()?) } else { None };
        Some(re.and_then(|re| Ok(Sample::of(re, im.transpose()?))))
    })
}
