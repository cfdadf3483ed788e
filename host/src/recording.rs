//! Recordings as streams of samples: wav, headerless int16, csv and JSON lines.
//!
//! Files are read through once, sample by sample, so memory does not grow with their size.
//!
//! Values are in *codes* of a 16-bit converter. Integer wav of up to 16 bits and int16 files keep their own codes;
//! 24- and 32-bit wav is divided by 2^8 and 2^16; floating-point wav is multiplied by 2^15; csv
//! and JSON are taken as codes. [`Options::scale`] multiplies all of them. The integer arithmetic
//! takes the nearest code.

use num_complex::Complex;
use serde::Deserialize;
use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
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

/// Why a recording cannot be read. Each message is one line that says what to do.
#[derive(Debug)]
#[non_exhaustive]
pub enum RecordingError {
    /// The file cannot be opened or read.
    Io(PathBuf, io::Error),
    /// The file holds no samples.
    Empty(PathBuf),
    /// The name does not tell the format.
    Format(PathBuf),
    /// The length in bytes is not a whole number of samples of this many bytes.
    OddSize(PathBuf, u64, u64),
    /// The wav header is wrong or of a kind that cannot be read.
    Wav(PathBuf, String),
    /// The wav header announces more bytes of samples than the file holds.
    Truncated(PathBuf, u64, u64),
    /// This many channels, and whether I/Q was asked for.
    Channels(PathBuf, usize, bool),
    /// The file does not know its sample rate.
    RateMissing(PathBuf),
    /// The sample rate is not a positive number.
    Rate(f64),
    /// The line and what is wrong with it.
    Line(PathBuf, u64, String),
    /// Fewer samples than one record needs: the samples there are, and those needed.
    Short(PathBuf, u64, usize),
}

impl fmt::Display for RecordingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use RecordingError::*;
        match self {
            Io(path, error) if error.kind() == io::ErrorKind::NotFound => {
                write!(f, "{}: no such file", path.display())
            }
            Io(path, error) => write!(f, "{}: {error}", path.display()),
            Empty(path) => write!(f, "{}: the file holds no samples", path.display()),
            Format(path) => write!(
                f,
                "{}: the name does not tell the format: add --format wav, i16, csv or json",
                path.display()
            ),
            OddSize(path, bytes, frame) => write!(
                f,
                "{}: {bytes} bytes are not a whole number of {frame}-byte samples: the file is cut off or not int16",
                path.display()
            ),
            Wav(path, what) => write!(f, "{}: not a readable wav file: {what}", path.display()),
            Truncated(path, said, held) => write!(
                f,
                "{}: truncated wav: its header announces {said} bytes of samples, the file holds {held}: copy it again",
                path.display()
            ),
            Channels(path, 2, false) => write!(
                f,
                "{}: two channels: add --iq if they are I and Q, or extract one channel",
                path.display()
            ),
            Channels(path, channels, true) => {
                write!(f, "{}: --iq needs two channels, the file has {channels}", path.display())
            }
            Channels(path, channels, false) => {
                write!(f, "{}: {channels} channels: extract one, or two as I and Q", path.display())
            }
            RateMissing(path) => {
                write!(
                    f,
                    "{}: the file does not tell its sample rate: add --rate HZ",
                    path.display()
                )
            }
            Rate(rate) => {
                write!(f, "the sample rate must be a positive number of hertz, not {rate}")
            }
            Line(path, line, what) => write!(f, "{}, line {line}: {what}", path.display()),
            Short(path, held, needed) => write!(
                f,
                "{}: {held} samples are fewer than one record of {needed}: choose a smaller --n or --skip",
                path.display()
            ),
        }
    }
}

impl std::error::Error for RecordingError {}

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
            Format::Wav => wav(path, options),
            Format::I16 => int16(path, options),
            Format::Csv => csv_columns(path, options),
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

fn open(path: &Path) -> Result<(File, u64), RecordingError> {
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

fn wav(path: &Path, options: Options) -> Result<Recording, RecordingError> {
    let (file, bytes) = open(path)?;
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
            let excess = spec.bits_per_sample.saturating_sub(16);
            let codes = options.scale / f64::from(excess).exp2();
            Box::new(reader.into_samples::<i32>().map(move |x| x.map(|x| f64::from(x) * codes)))
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

fn int16(path: &Path, options: Options) -> Result<Recording, RecordingError> {
    let (file, bytes) = open(path)?;
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

fn csv_columns(path: &Path, options: Options) -> Result<Recording, RecordingError> {
    let (file, _) = open(path)?;
    let reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(BufReader::new(file));
    let owned = path.to_path_buf();
    let mut rows = reader.into_records().map(move |row| {
        row.map_err(|error| {
            let line = error.position().map_or(0, csv::Position::line);
            RecordingError::Line(owned.clone(), line, "not text that can be read".into())
        })
    });
    let mut first = rows.next().transpose()?;
    // A header is a first row of which no field is a number.
    if first.as_ref().is_some_and(|row| row.iter().all(|field| field.parse::<f64>().is_err())) {
        first = rows.next().transpose()?;
    }
    let Some(first) = first else {
        return Err(RecordingError::Empty(path.into()));
    };
    let columns = first.len();
    if !(1..=2).contains(&columns) || (options.iq && columns != 2) {
        return Err(RecordingError::Channels(path.into(), columns, options.iq));
    }
    let rate_hz = options.rate_hz.ok_or_else(|| RecordingError::RateMissing(path.into()))?;
    let (owned, scale) = (path.to_path_buf(), options.scale);
    let stream = std::iter::once(Ok(first)).chain(rows).map(move |row| {
        let row = row?;
        let line = row.position().map_or(0, csv::Position::line);
        let wrong = |what: String| RecordingError::Line(owned.clone(), line, what);
        if row.len() != columns {
            return Err(wrong(format!("{} columns where the first line has {columns}", row.len())));
        }
        let value = |field: &str| match field.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value * scale),
            Ok(value) => Err(wrong(format!("{value} is not a sample"))),
            Err(_) => Err(wrong(format!("\"{field}\" is not a number"))),
        };
        let mut fields = row.iter();
        let mut next = || fields.next().map_or(Ok(0.0), value);
        Ok(Sample::new(next()?, next()?))
    });
    let iq = columns == 2;
    Ok(Recording { path: path.into(), rate_hz, iq, length: None, stream: Box::new(stream) })
}

/// A record of a JSON line.
#[derive(Clone, Debug)]
pub struct JsonRecord {
    /// Its name, or its line's number.
    pub id: serde_json::Value,
    /// True for I/Q.
    pub iq: bool,
    /// The samples.
    pub samples: Vec<Sample>,
}

#[derive(Deserialize)]
struct JsonLine {
    id: Option<serde_json::Value>,
    kind: String,
    re: Vec<f64>,
    #[serde(default)]
    im: Option<Vec<f64>>,
}

/// The records of a file of JSON lines, one at a time.
pub struct Records {
    path: PathBuf,
    reader: BufReader<File>,
    line: u64,
    scale: f64,
}

impl Records {
    /// Opens a file of JSON lines.
    pub fn open(path: &Path, options: Options) -> Result<Self, RecordingError> {
        let (file, _) = open(path)?;
        Ok(Records {
            path: path.into(),
            reader: BufReader::new(file),
            line: 0,
            scale: options.scale,
        })
    }

    fn parse(&self, text: &str) -> Result<JsonRecord, String> {
        let line: JsonLine = serde_json::from_str(text).map_err(|error| {
            let text = error.to_string();
            // The position within the line follows "at": the line number is ours.
            let end = text.find(" at line").unwrap_or(text.len());
            format!("not a record {{\"id\", \"kind\", \"re\", \"im\"}}: {}", &text[..end])
        })?;
        let iq = match line.kind.as_str() {
            "r" => false,
            "c" => true,
            other => return Err(format!("kind \"{other}\" must be \"r\" or \"c\"")),
        };
        let imaginary = line.im.unwrap_or_default();
        if line.re.is_empty() {
            return Err("the record holds no samples".into());
        }
        if iq && imaginary.len() != line.re.len() {
            return Err(format!("{} values of re but {} of im", line.re.len(), imaginary.len()));
        }
        if !iq && imaginary.iter().any(|&x| x != 0.0) {
            return Err("a real record (kind \"r\") has imaginary parts".into());
        }
        let im = imaginary.into_iter().chain(std::iter::repeat(0.0));
        let samples = line
            .re
            .iter()
            .zip(im)
            .map(|(&re, im)| Sample::new(re * self.scale, im * self.scale))
            .collect();
        Ok(JsonRecord { id: line.id.unwrap_or_else(|| self.line.into()), iq, samples })
    }
}

impl Iterator for Records {
    type Item = Result<JsonRecord, RecordingError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let mut text = String::new();
            self.line += 1;
            match self.reader.read_line(&mut text) {
                Ok(0) => return None,
                Ok(_) if text.trim().is_empty() => continue,
                Ok(_) => {
                    let wrong = |what| RecordingError::Line(self.path.clone(), self.line, what);
                    return Some(self.parse(&text).map_err(wrong));
                }
                Err(error) => return Some(Err(RecordingError::Io(self.path.clone(), error))),
            }
        }
    }
}
