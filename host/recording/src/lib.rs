//! Recordings as streams of samples: wav, FLAC, headerless numbers, SigMF, csv, npy, npz, mat and JSON lines; from a file, from
//! bytes, or from stdin by the name `-`.
//!
//! They are read sample by sample, so memory does not grow with their size; npz, mat and compressed arrays are held in memory.
//!
//! Samples are in *codes* of a 16-bit converter. 16-bit integers keep their own codes, unsigned ones count from the middle; 8-bit ones
//! are spread over all of them (times 257, so that their rails are the rails). All others are scaled by the data, see
//! [`Scaling::from_levels`]: whole numbers that fit 16 bits stay what they are, volts and floats are spread over all codes, in whole codes per
//! step of the converter that they came from, and what is clipped lies at the rails. For that a file is read twice; of a pipe the
//! first 8192 samples decide. [`Options::scale`] gives a scale instead. [`Recording::scaling`] leads back to the file's own units.
//! The integer arithmetic takes the nearest code.
//!
//! A sample without a number (NaN, infinite, an empty cell) is missing: it takes the place of one, see [`Blocks::missing`].

mod arrays;
mod axes;
mod blocks;
mod columns;
mod converter;
mod doubt;
mod error;
#[cfg(feature = "packed")]
mod flac;
mod format;
#[cfg(feature = "packed")]
mod hdf5;
mod input;
mod levels;
mod list;
#[cfg(feature = "packed")]
mod mat;
mod npy;
#[cfg(feature = "packed")]
mod npz;
mod number;
#[cfg(feature = "json")]
mod objects;
mod opening;
mod order;
mod pick;
mod raw;
#[cfg(feature = "json")]
mod records;
mod scaling;
#[cfg(feature = "packed")]
mod sigmf;
mod source;
mod table;
mod text;
mod times;
mod unit;
mod wav;
mod words;

pub use axes::{Axes, Axis};
pub use blocks::Blocks;
pub use converter::Converter;
pub use error::RecordingError;
pub use format::Format;
pub use levels::Levels;
#[cfg(feature = "json")]
pub use records::{JsonRecord, Records};
pub use scaling::Scaling;
pub use times::Clock;

use input::Input;
use levels::Gauge;
use num_complex::Complex;
use opening::{Chained, opened, timed};
use scaling::Unit;
use source::{Held, Source};
use std::fmt;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Samples that are read at once.
const CHUNK: usize = 4096;

/// Sample rates, from one sample in eleven days to a terahertz.
pub const RATES_HZ: RangeInclusive<f64> = 1e-6..=1e12;

/// Samples of a pipe that decide its scale.
const BEGINNING: usize = 8192;

/// What a user says about a file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// The format; `None`: from the file's name or its first bytes.
    pub format: Option<Format>,
    /// Samples per second, where the file does not know, or another is right.
    pub rate_hz: Option<f64>,
    /// True where two channels, or pairs of numbers, are I and Q.
    pub iq: bool,
    /// Factor to the usual codes of the format; chosen by the data where `None`, see the module's documentation.
    pub scale: Option<f64>,
    /// The channel or column, from 1; with a second one: I and Q.
    pub channel: Option<(usize, Option<usize>)>,
    /// Commas in a csv file are decimal, not between columns.
    pub decimal_comma: bool,
    /// Channels of headerless numbers, in turn.
    pub channels: Option<usize>,
    /// What the sides of an array count.
    pub axes: Option<Axes>,
    /// The part that is read, from 1, of a recording whose rate changes; the longest where `None`.
    pub part: Option<usize>,
    /// The converter that the numbers are codes of, in files of any format. Numbers that are no whole ones are spread over its codes.
    pub converter: Option<Converter>,
}

/// One sample, in codes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// The value; its imaginary part is the quadrature channel, 0 for real samples.
    pub value: Complex<f64>,
}

impl Sample {
    /// A sample of one number, or of two.
    fn of(re: f64, im: Option<f64>) -> Self {
        Sample { value: Complex::new(re, im.unwrap_or(0.0)) }
    }

    /// The nearest 16-bit codes; what does not fit ends at the rails.
    pub fn code(&self) -> [i16; 2] {
        // A cast cuts digits off, and saturates.
        let nearest = |x: f64| (x + 0.5f64.copysign(x)) as i16;
        [nearest(self.value.re), nearest(self.value.im)]
    }

    fn is_missing(&self) -> bool {
        !(self.value.re.is_finite() && self.value.im.is_finite())
    }
}

/// A file's contents before its numbers become codes.
struct Opened {
    rate_hz: Option<f64>,
    iq: bool,
    length: Option<u64>,
    unit: Unit,
    source: Box<dyn Source>,
    /// Samples of a record, if the recording has separate ones.
    row: Option<u64>,
    /// Such records in a frame.
    frame: Option<u64>,
    axes: Option<Axes>,
    /// How its samples lie in time.
    clock: Option<Clock>,
    /// What was assumed.
    notes: Vec<String>,
}

impl Opened {
    /// Real samples without any description.
    fn new(unit: Unit, source: Box<dyn Source>) -> Self {
        let (rate_hz, length, row, frame, axes, clock) = (None, None, None, None, None, None);
        let notes = Vec::new();
        Self { rate_hz, iq: false, length, unit, source, row, frame, axes, clock, notes }
    }
}

/// An open recording.
pub struct Recording {
    path: PathBuf,
    rate_hz: Option<f64>,
    iq: bool,
    length: Option<u64>,
    scaling: Scaling,
    row: Option<u64>,
    frame: Option<u64>,
    axes: Option<Axes>,
    clock: Option<Clock>,
    notes: Vec<String>,
    source: Box<dyn Source>,
    /// Samples read, and the last one of them.
    read: u64,
    last: Sample,
    /// The numbers of the missing ones that were not yet returned.
    missing: Vec<u64>,
    missed: u64,
}

impl fmt::Debug for Recording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Recording({}, {:?} Hz, iq {})", self.path.display(), self.rate_hz, self.iq)
    }
}

impl Recording {
    /// Opens a file of any format but JSON lines, which hold records and not a stream: `Records`.
    pub fn open(path: &Path, options: Options) -> Result<Self, RecordingError> {
        let input = Input::open(path)?;
        let again = input.bytes.is_some();
        Self::of(path, input, options, again.then_some(&|| Input::open(path)))
    }

    /// The recording in these bytes of a file of this name, for whom has no file system.
    pub fn from_bytes(
        name: &Path,
        bytes: Vec<u8>,
        options: Options,
    ) -> Result<Self, RecordingError> {
        let bytes: Arc<[u8]> = bytes.into();
        let input = || Input::from_bytes(name, bytes.clone());
        Self::of(name, input()?, options, Some(&input))
    }

    fn of(
        path: &Path,
        input: Input,
        options: Options,
        again: Option<&dyn Fn() -> Result<Input, RecordingError>>,
    ) -> Result<Self, RecordingError> {
        let possible = |rate: Option<f64>| match rate.filter(|rate| !RATES_HZ.contains(rate)) {
            Some(rate) => Err(RecordingError::Rate(rate)),
            None => Ok(()),
        };
        possible(options.rate_hz)?;
        let mut opened = opened(path, input, &options, None)?;
        let usual = opened.unit.usual;
        let (mut gauge, mut timing) = (Gauge::default(), None);
        let by_data = options.scale.is_none()
            && (opened.unit.by_data || options.converter.is_some_and(Converter::is_narrow));
        let begin = match again {
            // The beginning, at once: most files have no times and need no data.
            Some(_) if !by_data && !opened.source.is_timed() => Vec::new(),
            Some(again) => {
                loop {
                    let mut samples = Vec::with_capacity(CHUNK);
                    opened.source.read(&mut samples, CHUNK)?;
                    let there = samples.iter().filter(|it| !it.is_missing());
                    there.for_each(|&it| gauge.add(it, opened.iq));
                    if samples.len() < CHUNK {
                        break;
                    }
                }
                timing = timed(path, &mut *opened.source, &options)?;
                opened = opening::opened(path, again()?, &options, timing.as_ref())?;
                Vec::new()
            }
            None => {
                let mut samples = Vec::new();
                opened.source.read(&mut samples, BEGINNING)?;
                let there = samples.iter().filter(|it| !it.is_missing());
                there.for_each(|&it| gauge.add(it, opened.iq));
                timing = timed(path, &mut *opened.source, &options)?;
                samples
            }
        };
        let whole = again.is_some() || begin.len() < BEGINNING;
        let levels = gauge.levels();
        let scaling = match (options.scale, levels) {
            (Some(scale), _) => {
                Scaling { factor: usual.factor * scale, shift: usual.shift * scale }
            }
            (None, Some(levels)) if by_data => {
                let of = if whole { Scaling::from_levels } else { Scaling::of_beginning };
                match options.converter.filter(|converter| converter.is_narrow()) {
                    Some(converter) => converter.scaling(&levels, of(&levels)),
                    None => of(&levels),
                }
            }
            _ => usual,
        };
        if !begin.is_empty() {
            let rest = opened.source;
            let first = Held { samples: begin.into_iter() };
            opened.source = Box::new(Chained { first, rest });
        }
        let Opened { rate_hz, iq, length, source, row, frame, axes, mut clock, mut notes, .. } =
            opened;
        let mut rate_hz = rate_hz;
        if let Some(timing) = timing {
            clock = timing.clock;
            rate_hz = clock.map(|clock| clock.rate_hz).or(rate_hz);
            notes.push(timing.note);
        }
        if options.rate_hz.is_some() {
            clock = None;
        }
        let rate_hz = options.rate_hz.or(rate_hz);
        possible(rate_hz)?;
        notes.retain(|note| !note.is_empty());
        Ok(Recording {
            path: path.into(),
            rate_hz,
            iq,
            length,
            scaling,
            row,
            frame,
            axes,
            clock,
            notes,
            source,
            read: 0,
            last: Sample::default(),
            missing: Vec::new(),
            missed: 0,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Samples per second; 1 if the rate is not known, so that frequencies are in cycles per sample.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz.unwrap_or(1.0)
    }

    /// Whether the file or the user states the rate.
    pub fn knows_rate(&self) -> bool {
        self.rate_hz.is_some()
    }

    /// The rate with its sigma, from a column of times, if there is one.
    pub fn clock(&self) -> Option<Clock> {
        self.clock
    }

    /// Samples of each record, where the recording is a row of records with pauses of unknown length between them, as of chirps.
    pub fn row(&self) -> Option<u64> {
        self.row
    }

    /// Records of a frame, where an array's sides count chirps: all of them where none counts frames.
    pub fn frame(&self) -> Option<u64> {
        self.frame
    }

    /// What the sides of the array count that it was read from.
    pub fn axes(&self) -> Option<Axes> {
        self.axes
    }

    /// What was assumed, in one line; `None` where nothing was.
    pub fn assumed(&self) -> Option<String> {
        (!self.notes.is_empty()).then(|| self.notes.join("; "))
    }

    /// True for I/Q samples.
    pub fn iq(&self) -> bool {
        self.iq
    }

    /// The number of samples, if the file states it before it is read.
    pub fn length(&self) -> Option<u64> {
        self.length
    }

    /// How the file's numbers became codes.
    pub fn scaling(&self) -> Scaling {
        self.scaling
    }

    /// Samples so far that the file has no number for.
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// Appends at most `count` samples; fewer only at the end.
    pub fn fill(&mut self, into: &mut Vec<Sample>, count: usize) -> Result<(), RecordingError> {
        let from = into.len();
        self.source.read(into, count)?;
        let Scaling { factor, shift } = self.scaling;
        let own = self.scaling != Scaling::CODES;
        let samples = &mut into[from..];
        // Where none is missing, as nearly always, nothing is asked of each one.
        if samples.iter().fold(true, |all, sample| all & !sample.is_missing()) {
            if own {
                for Sample { value } in &mut *samples {
                    let im = if self.iq { factor * value.im + shift } else { 0.0 };
                    *value = Complex::new(factor * value.re + shift, im);
                }
            }
            self.last = samples.last().copied().unwrap_or(self.last);
            self.read += samples.len() as u64;
            return Ok(());
        }
        for sample in samples {
            if sample.is_missing() {
                *sample = self.last;
                self.missing.push(self.read);
                self.missed += 1;
            } else if own {
                let Complex { re, im } = sample.value;
                let im = if self.iq { factor * im + shift } else { 0.0 };
                sample.value = Complex::new(factor * re + shift, im);
            }
            self.last = *sample;
            self.read += 1;
        }
        Ok(())
    }

    /// Its samples, one after the other. A missing one has the value of the one before it.
    pub fn samples(mut self) -> impl Iterator<Item = Result<Sample, RecordingError>> {
        let (mut chunk, mut ended) = (Vec::new().into_iter(), false);
        std::iter::from_fn(move || {
            if let Some(sample) = chunk.next() {
                return Some(Ok(sample));
            }
            if ended {
                return None;
            }
            let mut samples = Vec::with_capacity(CHUNK);
            let filled = self.fill(&mut samples, CHUNK);
            ended = filled.is_err() || samples.len() < CHUNK;
            chunk = samples.into_iter();
            filled.map_or_else(|error| Some(Err(error)), |()| chunk.next().map(Ok))
        })
    }

    /// Cuts the recording into blocks of `n` samples, `hop` apart, after leaving out `skip` samples. Both `n`
    /// and `hop` are at least 1. What is left at the end and fills no block is not used.
    pub fn blocks(self, n: usize, hop: usize, skip: u64) -> Blocks {
        Blocks::new(self, n, hop, skip)
    }
}
