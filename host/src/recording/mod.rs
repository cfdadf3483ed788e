//! Recordings as streams of samples: wav, headerless int16, csv and JSON lines.
//!
//! Files are read through once, sample by sample, so memory does not grow with their size.
//!
//! Values are in *codes* of a 16-bit converter. 16-bit wav and int16 files keep their own codes; 8-bit wav
//! is spread over all of them (times 257, so that its rails are the rails); 24- and 32-bit wav is
//! divided by 2^8 and 2^16; floating-point wav is multiplied by 2^15; csv and JSON are taken as codes. [`Options::scale`] multiplies all of them. The integer arithmetic
//! takes the nearest code.

mod columns;
mod error;
mod int16;
mod records;
mod wav;

pub use error::RecordingError;
pub use records::{JsonRecord, Records};

use num_complex::Complex;
use std::fmt;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// How a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// RIFF WAVE, 8 to 32 bit integers or 32 bit floats.
    Wav,
    /// Headerless 16-bit integers, little-endian.
    I16,
    /// One column of real samples or two of I and Q, with or without a header line.
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
            "bin" | "i16" | "raw" | "pcm" | "dat" => Some(Format::I16),
            "csv" | "txt" => Some(Format::Csv),
            "json" | "jsonl" | "ndjson" => Some(Format::Json),
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
}

impl Default for Options {
    fn default() -> Self {
        Options { format: None, rate_hz: None, iq: false, scale: 1.0 }
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
        if let Some(rate) = options.rate_hz.filter(|&rate| !(rate > 0.0 && rate.is_finite())) {
            return Err(RecordingError::Rate(rate));
        }
        let format = options
            .format
            .or_else(|| Format::guess(path))
            .ok_or_else(|| RecordingError::Format(path.into()))?;
        match format {
            Format::Wav => wav::open(path, options),
            Format::I16 => int16::open(path, options),
            Format::Csv => columns::open(path, options),
            Format::Json => Err(RecordingError::Line(
                path.into(),
                1,
                "JSON lines are records of their own, not one recording".into(),
            )),
        }
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

    /// Cuts the recording into blocks of `n` samples, `hop` apart, after leaving out `skip` samples. Both `n`
    /// and `hop` are at least 1. What is left at the end and fills no block is not used.
    pub fn blocks(self, n: usize, hop: usize, skip: u64) -> Blocks {
        Blocks { recording: self, n, hop, pending: skip, read: 0, samples: Vec::with_capacity(n) }
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

/// The file and its length in bytes.
fn open_file(path: &Path) -> Result<(File, u64), RecordingError> {
    let failed = |error| RecordingError::Io(path.into(), error);
    let file = File::open(path).map_err(failed)?;
    let metadata = file.metadata().map_err(failed)?;
    if metadata.is_dir() {
        return Err(RecordingError::Io(path.into(), io::ErrorKind::IsADirectory.into()));
    }
    // A pipe has no length, and only reading shows whether it is empty.
    if metadata.is_file() && metadata.len() == 0 {
        return Err(RecordingError::Empty(path.into()));
    }
    Ok((file, metadata.len()))
}
