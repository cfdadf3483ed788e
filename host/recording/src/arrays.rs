//! Named arrays, as npz and mat files hold them: their columns are channels, one of them may be the time, and a single number with a
//! rate's name is the rate.

use super::axes::Cube;
use super::scaling::Unit;
use super::source::{Held, Source};
use super::times::{self, Timing, Untimely};
use super::unit::Named;
use super::{Opened, Options, RecordingError, Sample, pick};
use std::path::Path;

/// Channels of an array, at most: others are records.
const MOST: usize = 8;

/// An array has its channels along its shorter side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Channels {
    pub count: usize,
    /// Samples of each.
    pub length: u64,
    /// The numbers of one moment lie together, not those of one channel.
    pub together: bool,
}

impl Channels {
    /// Of an array of these sides; `rows_first` where the last index runs fastest.
    pub fn of(sides: &[u64], rows_first: bool) -> Option<Self> {
        match *sides {
            [] => Some(Self { count: 1, length: 1, together: true }),
            [length] => Some(Self { count: 1, length, together: true }),
            [rows, columns] => {
                let (count, length) = (rows.min(columns), rows.max(columns));
                let together = (columns <= rows) == rows_first;
                Some(Self { count: usize::try_from(count.max(1)).ok()?, length, together })
            }
            _ => None,
        }
    }
}

/// An array with a name.
#[derive(Clone, Debug)]
pub(super) struct Array {
    pub name: String,
    numbers: Vec<f64>,
    complex: bool,
    sides: Vec<u64>,
    rows_first: bool,
    /// The parts of complex numbers are next to each other; empty where the sides are more than channels.
    channels: Vec<Vec<f64>>,
}

impl Array {
    /// The array of numbers of these sides; `None` where some are missing.
    pub fn new(
        name: &str,
        numbers: Vec<f64>,
        complex: bool,
        sides: Vec<u64>,
        rows_first: bool,
    ) -> Option<Self> {
        let parts = if complex { 2 } else { 1 };
        let all = sides.iter().try_fold(parts, |all: u64, side| all.checked_mul(*side))?;
        let all = usize::try_from(all).ok()?;
        let mut numbers = numbers;
        numbers.get(..all)?;
        // What is behind them is none of them.
        numbers.truncate(all);
        let channels = Channels::of(&sides, rows_first).filter(|of| of.count <= MOST);
        let channels = channels.map_or(Vec::new(), |of| Self::columns(&numbers, complex, of));
        Some(Self { name: name.into(), numbers, complex, sides, rows_first, channels })
    }

    fn columns(numbers: &[f64], complex: bool, of: Channels) -> Vec<Vec<f64>> {
        let parts = if complex { 2 } else { 1 };
        let length = of.length as usize;
        let channel = |place: usize| -> Vec<f64> {
            let (channel, part) = (place / parts, place % parts);
            match of.together {
                true => numbers.iter().skip(place).step_by(of.count * parts).copied().collect(),
                false => {
                    let own = numbers.iter().skip(channel * length * parts).take(length * parts);
                    own.skip(part).step_by(parts).copied().collect()
                }
            }
        };
        (0..of.count * parts).map(channel).collect()
    }

    /// The records in it, where its sides are more than channels.
    fn cube(&self, path: &Path, options: &Options) -> Result<Option<Opened>, RecordingError> {
        let Some(cube) = Cube::of(path, &self.sides, self.rows_first, self.complex, options)?
        else {
            return Ok(None);
        };
        let source = Held { samples: cube.samples(&self.numbers).into_iter() };
        Ok(Some(Opened {
            iq: cube.complex,
            length: Some(cube.length()),
            row: Some(cube.samples),
            frame: cube.frame(),
            axes: Some(cube.axes),
            notes: vec![cube.note.clone()],
            ..Opened::new(Unit::FREE, Box::new(source))
        }))
    }

    fn length(&self) -> usize {
        self.channels.first().map_or(0, Vec::len)
    }

    /// The rate in it, Hz.
    fn rate_hz(&self) -> Option<f64> {
        let name = self.name.to_ascii_lowercase();
        let [only] = &self.channels[..] else { return None };
        let &[number] = &only[..] else { return None };
        let rates =
            ["fs", "rate", "sample_rate", "samplerate", "sampling_rate", "sr", "rate_hz", "fs_hz"];
        let steps = ["dt", "tinterval", "sample_interval", "ts"];
        let positive = number.is_finite() && number > 0.0;
        match () {
            () if !positive => None,
            () if rates.contains(&name.as_str()) => Some(number),
            () if steps.contains(&name.as_str()) => Some(1.0 / number),
            () => None,
        }
    }
}

/// A channel of an array, with the name that a person knows it by.
struct Column<'a> {
    name: String,
    parts: &'a [Vec<f64>],
}

/// The recording in these arrays: of the longest ones.
pub(super) fn opened(
    path: &Path,
    arrays: Vec<Array>,
    options: &Options,
) -> Result<Opened, RecordingError> {
    let told = arrays.iter().find_map(Array::rate_hz);
    let largest = arrays.iter().max_by_key(|array| array.numbers.len());
    if let Some(largest) = largest.filter(|it| it.channels.is_empty() || options.axes.is_some())
        && let Some(cube) = largest.cube(path, options)?
    {
        return Ok(Opened { rate_hz: told, ..cube });
    }
    let length = arrays.iter().map(Array::length).max().unwrap_or(0);
    if length == 0 {
        return Err(RecordingError::Empty(path.into()));
    }
    let mut columns: Vec<Column> = Vec::new();
    for array in arrays.iter().filter(|array| array.length() == length) {
        let parts = if array.complex { 2 } else { 1 };
        let several = array.channels.len() > parts;
        for (number, parts) in (1..).zip(array.channels.chunks(parts)) {
            let name =
                if several { format!("{}, {number}", array.name) } else { array.name.clone() };
            columns.push(Column { name, parts });
        }
    }
    let (time, values): (Vec<&Column>, Vec<&Column>) = columns
        .iter()
        .partition(|column| columns.len() > 1 && column.parts.len() == 1 && is_time(column));
    let timing = match time.first() {
        Some(column) if options.rate_hz.is_none() => timing(path, column, told, options)?,
        _ => None,
    };
    let chosen = |place: usize| columns.get(place);
    let complex = |column: &Column| column.parts.len() == 2;
    let parts: Vec<&Vec<f64>> = match (options.channel, &values[..]) {
        (Some(_), _) => {
            // A person counts all columns, the time among them.
            if let [only] = &columns[..]
                && complex(only)
            {
                let (first, second) = pick::complex(path, 1, options)?;
                [Some(first), second].into_iter().flatten().map(|part| &only.parts[part]).collect()
            } else {
                let (first, second) = pick::real(path, columns.len(), options)?;
                let picked = [Some(first), second].into_iter().flatten().filter_map(chosen);
                let picked: Vec<&Column> = picked.collect();
                if picked.len() > 1 && picked.iter().any(|column| complex(column)) {
                    return Err(RecordingError::AlreadyPairs(path.into(), columns.len()));
                }
                picked.into_iter().flat_map(|column| column.parts).collect()
            }
        }
        (None, [only]) if complex(only) || !options.iq => only.parts.iter().collect(),
        (None, [i, q]) if !complex(i) && !complex(q) && (options.iq || is_pair(i, q)) => {
            vec![&i.parts[0], &q.parts[0]]
        }
        (None, _) => {
            let number = |column: &Column| {
                columns.iter().position(|it| std::ptr::eq(it, column)).unwrap_or(0) + 1
            };
            let names: Vec<String> =
                values.iter().map(|it| format!("{} ({})", number(it), it.name)).collect();
            let names = names.join(", ");
            return Err(RecordingError::Columns(
                path.into(),
                format!("values in {names}: choose by --channel, two for I and Q"),
            ));
        }
    };
    let samples = |k: usize| Sample::of(parts[0][k], parts.get(1).map(|part| part[k]));
    let rows = timing.as_ref().map_or(0..u64::MAX, |timing| timing.rows.clone());
    let mut gaps = timing.iter().flat_map(|timing| &timing.gaps).peekable();
    let mut taken = Vec::with_capacity(length);
    for row in rows.start as usize..rows.end.min(length as u64) as usize {
        if let Some(gap) = gaps.next_if(|gap| gap.0 == row as u64) {
            taken.extend((0..gap.1).map(|_| Sample::of(f64::NAN, None)));
        }
        taken.push(samples(row));
    }
    let clock = timing.as_ref().and_then(|timing| timing.clock);
    let source: Box<dyn Source> = Box::new(Held { samples: taken.into_iter() });
    Ok(Opened {
        rate_hz: clock.map(|clock| clock.rate_hz).or(told),
        clock,
        iq: parts.len() == 2,
        length: timing.is_none().then_some(length as u64),
        notes: timing.into_iter().map(|timing| timing.note).collect(),
        ..Opened::new(Unit::FREE, source)
    })
}

/// How the rows lie in time by this column.
fn timing(
    path: &Path,
    column: &Column,
    rate_hz: Option<f64>,
    options: &Options,
) -> Result<Option<Timing>, RecordingError> {
    let name = column.name.clone();
    // Arrays are in the units of physics, unless their name says another.
    let named =
        Named { column: name.clone(), names: vec![name, "time (s)".into()], step: None, rate_hz };
    match times::timing(&column.parts[0], &named, options.part) {
        Ok(timing) => Ok(Some(timing)),
        Err(Untimely::Other) => Ok(None),
        Err(Untimely::Said(what)) => {
            let what = format!("its time, {}, {what}: add --rate HZ to do without it", column.name);
            Err(RecordingError::Columns(path.into(), what))
        }
    }
}

/// Whether a column is the time: by its name, and because it rises evenly.
fn is_time(column: &Column) -> bool {
    let name = column.name.to_ascii_lowercase();
    let named =
        name.starts_with("time") || name.ends_with("_t") || name.ends_with("time") || name == "t";
    let unnamed = name.is_empty() || name.contains(',');
    named || unnamed && times::is_even(&column.parts[0])
}

/// Whether two columns are I and Q by their names, or have none of their own because they are one array.
fn is_pair(i: &Column, q: &Column) -> bool {
    let names = [i, q].map(|column| column.name.to_ascii_lowercase());
    let pairs = [("i", "q"), ("re", "im"), ("real", "imag"), ("in_phase", "quadrature")];
    pairs.iter().any(|&(i, q)| names[0] == i && names[1] == q)
        || (names[0].ends_with(", 1") && names[1].ends_with(", 2"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shorter_side_counts_channels() {
        let of = |sides: &[u64], rows_first| {
            let channels = Channels::of(sides, rows_first).unwrap();
            (channels.count, channels.length, channels.together)
        };
        assert_eq!(of(&[9, 2], true), (2, 9, true));
        assert_eq!(of(&[2, 9], true), (2, 9, false));
        assert_eq!(of(&[9, 2], false), (2, 9, false));
        assert_eq!(of(&[2, 9], false), (2, 9, true));
        assert_eq!(of(&[1, 9], false).0, 1);
        let numbers: Vec<f64> = (0..8).map(f64::from).collect();
        let of = |sides: Vec<u64>, rows_first| {
            Array::new("x", numbers.clone(), true, sides, rows_first).unwrap().channels
        };
        assert_eq!(of(vec![2, 2], false), [[0.0, 2.0], [1.0, 3.0], [4.0, 6.0], [5.0, 7.0]]);
        assert_eq!(of(vec![2, 2], true), [[0.0, 4.0], [1.0, 5.0], [2.0, 6.0], [3.0, 7.0]]);
    }
}
