//! JSON lines: records of their own.

use super::input::Input;
use super::{Levels, Options, RecordingError, Sample, Scaling};
use serde::Deserialize;
use std::io::{BufRead, ErrorKind, Read};
use std::path::{Path, PathBuf};

/// A record of a JSON line.
#[derive(Clone, Debug)]
pub struct JsonRecord {
    /// Its name, or its line's number.
    pub id: serde_json::Value,
    /// True for I/Q.
    pub iq: bool,
    /// The samples, in codes of 16 bits.
    pub samples: Vec<Sample>,
    /// How its numbers became codes.
    pub scaling: Scaling,
}

#[derive(Deserialize)]
struct JsonLine {
    id: Option<serde_json::Value>,
    kind: String,
    re: Vec<f64>,
    #[serde(default)]
    im: Option<Vec<f64>>,
}

/// No record is longer, in bytes.
const LONGEST: u64 = 1 << 28;

/// The records of a file of JSON lines, one at a time.
pub struct Records {
    path: PathBuf,
    reader: Box<dyn BufRead>,
    line: u64,
    scale: Option<f64>,
}

impl Records {
    /// Opens a file of JSON lines.
    pub fn open(path: &Path, options: Options) -> Result<Self, RecordingError> {
        Ok(Self::of(path, Input::open(path)?, options))
    }

    /// Whether a file of JSON holds records, and not lists of samples of one recording. Of stdin nobody knows before it is read.
    pub fn are_in(path: &Path) -> bool {
        if path == Path::new("-") {
            return true;
        }
        let of_record = |head: &[u8]| {
            let text = super::text::decoded(head);
            text.contains("\"re\"") || !text.contains(['[', ':'])
        };
        Input::open(path).map_or(true, |input| of_record(&input.head))
    }

    /// The records in these bytes of a file of this name, for whom has no file system.
    pub fn from_bytes(
        name: &Path,
        bytes: Vec<u8>,
        options: Options,
    ) -> Result<Self, RecordingError> {
        Ok(Self::of(name, Input::from_bytes(name, bytes.into())?, options))
    }

    fn of(path: &Path, input: Input, options: Options) -> Self {
        Records {
            path: path.into(),
            reader: Box::new(input.reader()),
            line: 0,
            scale: options.scale,
        }
    }

    fn parse(&self, text: &str) -> Result<JsonRecord, String> {
        let line: JsonLine = serde_json::from_str(text).map_err(|error| {
            let text = error.to_string();
            // The position within the line follows "at": the line number is ours.
            let end = text.find(" at line").unwrap_or(text.len());
            // It quotes what is wrong, however long that is.
            let what: String = text[..end].chars().take(200).collect();
            format!("not a record {{\"id\", \"kind\", \"re\", \"im\"}}: {what}")
        })?;
        let iq = match line.kind.as_str() {
            "r" => false,
            "c" => true,
            other => {
                let other: String = other.chars().take(20).collect();
                return Err(format!("kind \"{other}\" must be \"r\" or \"c\""));
            }
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
        let parts = line.re.iter().zip(im);
        let samples: Vec<Sample> =
            parts.map(|(&re, im)| Sample::of(re, iq.then_some(im))).collect();
        let scaling = match self.scale {
            Some(factor) => Scaling { factor, shift: 0.0 },
            None => Levels::from_samples(&samples, iq)
                .map_or(Scaling::CODES, |levels| Scaling::from_levels(&levels)),
        };
        let part = |x: f64| scaling.code(x);
        let code =
            |sample: Sample| Sample::of(part(sample.value.re), iq.then(|| part(sample.value.im)));
        let samples = samples.into_iter().map(code).collect();
        Ok(JsonRecord { id: line.id.unwrap_or_else(|| self.line.into()), iq, samples, scaling })
    }
}

impl Iterator for Records {
    type Item = Result<JsonRecord, RecordingError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let mut text = String::new();
            self.line += 1;
            match self.reader.by_ref().take(LONGEST).read_line(&mut text) {
                Ok(0) => return None,
                Ok(length) if length as u64 == LONGEST => {
                    let what = "the line is longer than 256 MB".into();
                    return Some(Err(RecordingError::Line(self.path.clone(), self.line, what)));
                }
                Ok(_) if text.trim().is_empty() => continue,
                Ok(_) => {
                    let wrong = |what| RecordingError::Line(self.path.clone(), self.line, what);
                    return Some(self.parse(&text).map_err(wrong));
                }
                Err(error) if error.kind() == ErrorKind::InvalidData => {
                    let what = "not text: is it of another --format?".into();
                    return Some(Err(RecordingError::Line(self.path.clone(), self.line, what)));
                }
                Err(error) => return Some(Err(RecordingError::Io(self.path.clone(), error))),
            }
        }
    }
}
