//! Columns of numbers: one of real samples, two of I and Q, or an oscilloscope's with a time beside them.

use super::input::Input;
use super::scaling::Unit;
use super::source::Source;
use super::table::{self, Between, Shape, Unclear};
use super::{Opened, Options, RecordingError, Sample, text};
use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};

/// No line is longer, in bytes.
const LONGEST: u64 = 1 << 20;
/// Numbers from here on, and infinite ones, are an oscilloscope's mark for a sample that it could not take (9.9e37).
const OVERFLOW: f64 = 1e30;

pub(super) fn open(path: &Path, input: Input, options: &Options) -> Result<Opened, RecordingError> {
    let head = text::decoded(&input.head);
    let binary = |byte: u8| byte == 0 || (byte < b' ' && !b"\t\r\n\x0c".contains(&byte));
    if head.bytes().any(binary) {
        return Err(RecordingError::Line(path.into(), 1, "not text that can be read".into()));
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
    let wanted = wanted(&shape, options, path)?;
    let told = shape.time.and_then(|(_, step)| Some(1.0 / step?));
    let rows = Rows {
        path: path.into(),
        reader: text::reader(input),
        line: 0,
        wanted,
        rate_hz: shape.rate_hz,
        shape,
    };
    Ok(Opened {
        rate_hz: told.or(rows.rate_hz),
        iq: wanted.1.is_some(),
        length: None,
        unit: Unit::FREE,
        source: Box::new(rows),
    })
}

/// The columns to read, from 0: of the samples, or of I and Q.
fn wanted(
    shape: &Shape,
    options: &Options,
    path: &Path,
) -> Result<(usize, Option<usize>), RecordingError> {
    if let Some((first, second)) = options.channel {
        let at = |column: usize| {
            let there = column.checked_sub(1).filter(|at| shape.columns.contains(at));
            there.ok_or_else(|| RecordingError::Channel(path.into(), column, 0))
        };
        return Ok((at(first)?, second.map(at).transpose()?));
    }
    let time = shape.time.map(|(column, _)| column);
    let values: Vec<usize> = shape.columns.iter().copied().filter(|&at| Some(at) != time).collect();
    match (values[..].first(), values.get(1), time) {
        (Some(&only), None, _) if values.len() == 1 && !options.iq => Ok((only, None)),
        (Some(&i), Some(&q), None) if values.len() == 2 => Ok((i, Some(q))),
        (Some(&i), Some(&q), Some(_)) if values.len() == 2 && options.iq => Ok((i, Some(q))),
        (.., None) => Err(RecordingError::Channels(path.into(), values.len(), options.iq)),
        (.., Some(_)) => {
            let name = |at: &usize| match shape.names.get(*at).filter(|name| !name.is_empty()) {
                Some(name) => format!("{} ({name})", at + 1),
                None => (at + 1).to_string(),
            };
            let names: Vec<String> = values.iter().map(name).collect();
            Err(RecordingError::Columns(
                path.into(),
                format!(
                    "values beside the time in columns {}: choose by --column, two for I and Q",
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
    /// Lines read.
    line: usize,
    shape: Shape,
    wanted: (usize, Option<usize>),
    rate_hz: Option<f64>,
}

impl Rows {
    fn wrong(&self, what: String) -> RecordingError {
        RecordingError::Line(self.path.clone(), self.line as u64, what)
    }

    fn sample(&self, line: &str) -> Result<Sample, RecordingError> {
        let fields = self.shape.between.fields(line);
        let width = self.shape.width;
        // A line of an oscilloscope's table may have more, or end in commas.
        let needed = self.wanted.0.max(self.wanted.1.unwrap_or(0));
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
        Ok(Sample::of(value(self.wanted.0)?, self.wanted.1.map(value).transpose()?))
    }
}

impl Rows {
    /// The next line of numbers; `None` at the end.
    fn next(&mut self) -> Option<Result<Sample, RecordingError>> {
        loop {
            let mut bytes = Vec::new();
            match self.reader.by_ref().take(LONGEST).read_until(b'\n', &mut bytes) {
                Ok(0) => return None,
                Ok(length) if length as u64 == LONGEST => {
                    return Some(Err(self.wrong("a line longer than 1 MB is no table".into())));
                }
                Ok(_) => {}
                Err(error) => return Some(Err(RecordingError::Io(self.path.clone(), error))),
            }
            self.line += 1;
            let line = String::from_utf8_lossy(&bytes);
            let line = line.trim_start_matches('\u{feff}');
            if self.line > self.shape.start && !table::skipped(line) {
                return Some(self.sample(line.trim_end_matches(['\r', '\n'])));
            }
        }
    }
}

impl Source for Rows {
    fn read(&mut self, into: &mut Vec<Sample>, count: usize) -> Result<(), RecordingError> {
        for _ in 0..count {
            match self.next() {
                Some(sample) => into.push(sample?),
                None => break,
            }
        }
        Ok(())
    }
}
