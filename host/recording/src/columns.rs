//! Columns of numbers: one of real samples, two of I and Q, or an oscilloscope's with a time beside them.

use super::input::Input;
use super::scaling::Unit;
use super::source::Source;
use super::table::{self, Between, Shape, Unclear};
use super::times::{self, Timing};
use super::unit::Named;
use super::{Axes, Opened, Options, RecordingError, Sample, list, text};
use std::collections::VecDeque;
use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};

/// No line is longer, in bytes.
const LONGEST: u64 = 1 << 20;
/// Numbers from here on, and infinite ones, are an oscilloscope's mark for a sample that it could not take (9.9e37).
const OVERFLOW: f64 = 1e30;

/// So many columns and no time among them are records, a row each.
const RECORDS: usize = 16;

pub(super) fn open(
    path: &Path,
    input: Input,
    options: &Options,
    timing: Option<&Timing>,
) -> Result<Opened, RecordingError> {
    let head = text::decoded(&input.head);
    let binary = |byte: u8| byte == 0 || (byte < b' ' && !b"\t\r\n\x0c".contains(&byte));
    if head.bytes().any(binary) {
        return Err(RecordingError::Line(path.into(), 1, "not text that can be read".into()));
    }
    if let Some(found) = list::found(&head) {
        return list::open(path, input, found, options);
    }
    let mut lines: Vec<&str> = head.lines().collect();
    if !input.whole() && lines.len() > 1 {
        // The last one is cut off.
        lines.pop();
    }
    if lines.iter().take(8).any(|line| line.contains("Sample values on dB scale")) {
        let what = "its values are decibels: export them on a linear scale".into();
        return Err(RecordingError::Line(path.into(), 1, what));
    }
    let chosen = options.channel.is_some() || options.iq;
    let shape =
        table::shape(&lines, options.decimal_comma, chosen).map_err(|unclear| match unclear {
            Unclear::Empty => RecordingError::Empty(path.into()),
            Unclear::Comma(line) => RecordingError::Comma(path.into(), line),
        })?;
    let rows = shape.time.is_none() && !chosen && shape.columns.len() >= RECORDS
        || options.axes.is_some() && !chosen;
    let wanted = if rows { Wanted::Row } else { wanted(&shape, options, path)? };
    let (rate_hz, timed) = (shape.rate_hz, shape.time.is_some());
    let width = shape.columns.len() as u64;
    let rows = Rows {
        path: path.into(),
        reader: text::reader(input),
        line: 0,
        row: 0,
        wanted,
        shape,
        times: (timed && timing.is_none()).then(Vec::new),
        timing: timing.cloned(),
        ready: VecDeque::new(),
        ended: false,
    };
    let iq = matches!(wanted, Wanted::Columns(_, Some(_)));
    let mut opened = Opened { rate_hz, iq, ..Opened::new(Unit::FREE, Box::new(rows)) };
    if wanted == Wanted::Row {
        opened.row = Some(width);
        opened.axes = "chirp,sample".parse::<Axes>().ok();
        opened.notes.push(format!("each row of {width} numbers is taken as a record of its own"));
    }
    Ok(opened)
}

/// What is read of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wanted {
    /// A column, or two as I and Q, from 0.
    Columns(usize, Option<usize>),
    /// All, one behind the other.
    Row,
}

/// The columns to read, from 0: of the samples, or of I and Q.
fn wanted(shape: &Shape, options: &Options, path: &Path) -> Result<Wanted, RecordingError> {
    if let Some((first, second)) = options.channel {
        let at = |column: usize| {
            let there = column.checked_sub(1).filter(|at| shape.columns.contains(at));
            there.ok_or_else(|| RecordingError::Channel(path.into(), column, 0))
        };
        return Ok(Wanted::Columns(at(first)?, second.map(at).transpose()?));
    }
    let time = shape.time.as_ref().map(|(column, _)| *column);
    let values: Vec<usize> = shape.columns.iter().copied().filter(|&at| Some(at) != time).collect();
    match (values[..].first(), values.get(1), time) {
        (Some(&only), None, _) if values.len() == 1 && !options.iq => {
            Ok(Wanted::Columns(only, None))
        }
        (Some(&i), Some(&q), None) if values.len() == 2 => Ok(Wanted::Columns(i, Some(q))),
        (Some(&i), Some(&q), Some(_)) if values.len() == 2 && options.iq => {
            Ok(Wanted::Columns(i, Some(q)))
        }
        (.., None) => Err(RecordingError::Channels(path.into(), values.len(), options.iq)),
        (.., Some(_)) => {
            let name = |at: &usize| match shape.names.get(*at).filter(|name| !name.is_empty()) {
                Some(name) => format!("{} ({name})", at + 1),
                None => (at + 1).to_string(),
            };
            let names: Vec<String> = values.iter().map(name).collect();
            let (first, second) =
                (values.first().map_or(1, |at| at + 1), values.get(1).map_or(2, |at| at + 1));
            Err(RecordingError::Columns(
                path.into(),
                format!(
                    "values in columns {}: choose by --column {first}, two for I and Q by --column {first},{second}",
                    names.join(", ")
                ),
            ))
        }
    }
}

/// The lines of numbers.
struct Rows {
    path: PathBuf,
    reader: Box<dyn BufRead + Send>,
    /// Lines read, and rows of numbers.
    line: usize,
    row: u64,
    shape: Shape,
    wanted: Wanted,
    /// The times so far, where they are not known yet.
    times: Option<Vec<f64>>,
    timing: Option<Timing>,
    /// Samples of the rows that were read.
    ready: VecDeque<Sample>,
    ended: bool,
}

impl Rows {
    fn wrong(&self, what: String) -> RecordingError {
        RecordingError::Line(self.path.clone(), self.line as u64, what)
    }

    /// Reads the samples of a line.
    fn take(&mut self, line: &str) -> Result<(), RecordingError> {
        let fields = self.shape.between.fields(line);
        let width = self.shape.width;
        // A line of an oscilloscope's table may have more, or end in commas.
        let needed = match self.wanted {
            Wanted::Columns(first, second) => first.max(second.unwrap_or(0)),
            Wanted::Row => self.shape.columns.last().copied().unwrap_or(0),
        };
        if fields.len() <= needed || (fields.len() > width && self.shape.between != Between::Space)
        {
            return Err(
                self.wrong(format!("{} columns where the first line has {width}", fields.len()))
            );
        }
        let value = |column: usize| match table::number(fields[column], self.shape.decimal_comma) {
            Some(value) if value.abs() < OVERFLOW => Ok(value),
            Some(_) => Ok(f64::NAN),
            None if table::says_nothing(fields[column]) => Ok(f64::NAN),
            None => Err(self.wrong(format!("\"{}\" is not a number", fields[column]))),
        };
        let samples: Vec<Sample> = match self.wanted {
            Wanted::Columns(first, second) => {
                vec![Sample::of(value(first)?, second.map(value).transpose()?)]
            }
            Wanted::Row => {
                let each = self.shape.columns.iter().map(|&at| Ok(Sample::of(value(at)?, None)));
                each.collect::<Result<_, RecordingError>>()?
            }
        };
        let row = self.row;
        self.row += 1;
        if let (Some(times), Some((column, _))) = (&mut self.times, &self.shape.time)
            && times.len() < times::KEPT
        {
            let time =
                fields.get(*column).and_then(|it| table::number(it, self.shape.decimal_comma));
            times.push(time.unwrap_or(f64::NAN));
        }
        if let Some(timing) = &self.timing {
            if !timing.rows.contains(&row) {
                self.ended = row >= timing.rows.end;
                return Ok(());
            }
            if let Ok(at) = timing.gaps.binary_search_by_key(&row, |gap| gap.0) {
                let missing = Sample::of(f64::NAN, None);
                self.ready.extend((0..timing.gaps[at].1).map(|_| missing));
            }
        }
        self.ready.extend(samples);
        Ok(())
    }

    /// Reads the next line of numbers; false at the end.
    fn next(&mut self) -> Result<bool, RecordingError> {
        loop {
            let mut bytes = Vec::new();
            match self.reader.by_ref().take(LONGEST).read_until(b'\n', &mut bytes) {
                Ok(0) => return Ok(false),
                Ok(length) if length as u64 == LONGEST => {
                    return Err(self.wrong("a line longer than 1 MB is no table".into()));
                }
                Ok(_) => {}
                Err(error) => return Err(RecordingError::Io(self.path.clone(), error)),
            }
            self.line += 1;
            let line = String::from_utf8_lossy(&bytes);
            let line = line.trim_start_matches('\u{feff}');
            if self.line > self.shape.start && !table::skipped(line) {
                let taken = self.take(line.trim_end_matches(['\r', '\n']));
                // A last line without its end was cut off.
                return match taken {
                    Err(_) if !line.ends_with('\n') && self.row > 0 => Ok(false),
                    taken => taken.map(|()| true),
                };
            }
        }
    }
}

impl Source for Rows {
    fn read(&mut self, into: &mut Vec<Sample>, count: usize) -> Result<(), RecordingError> {
        let wanted = into.len() + count;
        while into.len() < wanted {
            match self.ready.pop_front() {
                Some(sample) => into.push(sample),
                None if self.ended || !self.next()? => break,
                None => {}
            }
        }
        Ok(())
    }

    fn is_timed(&self) -> bool {
        self.times.is_some()
    }

    fn times(&mut self) -> Option<(Vec<f64>, Named)> {
        Some((self.times.take()?, self.shape.time.as_ref()?.1.clone()))
    }
}
