//! Comma-separated columns: one of real samples, two of I and Q.

use super::{Options, Recording, RecordingError, Sample, open_file};
use std::io::BufReader;
use std::path::Path;

pub(super) fn open(path: &Path, options: Options) -> Result<Recording, RecordingError> {
    let (file, _) = open_file(path)?;
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
