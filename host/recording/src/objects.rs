//! Samples in JSON: a list, or objects with lists of numbers, as OmniPreSense's OPS243 writes I and Q line by line. What several
//! objects have of one name is one array; where one ends and the next begins samples may be missing. Objects of single numbers, as a logger
//! writes them, are the rows of a table.

use super::arrays::{self, Array};
use super::input::Input;
use super::times::Timing;
use super::{Opened, Options, RecordingError, columns, text};
use serde_json::{Deserializer, Value};
use std::io::Read;
use std::path::Path;

/// No file is longer, in bytes.
const LONGEST: u64 = 1 << 26;
/// Objects within each other.
const DEEP: usize = 16;

/// What separates a table's cells and lines.
const SEPARATORS: [char; 4] = [',', ';', '\n', '\r'];

/// Numbers of a name.
struct Series {
    name: String,
    numbers: Vec<f64>,
    sides: Vec<u64>,
    /// Lists that came one after the other, where they are of one length.
    lists: u64,
    length: Option<u64>,
}

pub(super) fn open(
    path: &Path,
    input: Input,
    options: &Options,
    timing: Option<&Timing>,
) -> Result<Opened, RecordingError> {
    let wrong = |what: String| RecordingError::Columns(path.into(), what);
    let mut text = String::new();
    let read = text::reader(input).take(LONGEST).read_to_string(&mut text);
    read.map_err(|error| RecordingError::Io(path.into(), error))?;
    if text.len() as u64 >= LONGEST {
        return Err(wrong("JSON longer than 64 MB: save it as npy or csv".into()));
    }
    let (mut all, mut rows): (Vec<Series>, Vec<Value>) = (Vec::new(), Vec::new());
    let mut values = Deserializer::from_str(&text).into_iter::<Value>();
    for value in values.by_ref() {
        match value {
            Ok(value) => {
                gather("", &value, DEEP, &mut all);
                match value {
                    // Beside a list there is no table.
                    _ if all.iter().any(|series| series.numbers.len() > 1) => {}
                    Value::Array(list) => rows.extend(list.into_iter().filter(Value::is_object)),
                    value => rows.push(value),
                }
            }
            // A last line may be cut off.
            Err(_) if !all.is_empty() => break,
            Err(error) => {
                let error: String = error.to_string().chars().take(100).collect();
                return Err(wrong(format!("not JSON: {error}")));
            }
        }
    }
    let most = all.iter().map(|it| it.numbers.len()).max().unwrap_or(0);
    if most < 2 && rows.len() > 1 {
        let table = table(&rows).into_bytes();
        return columns::open(path, Input::from_bytes(path, table.into())?, options, timing);
    }
    if most < 2 {
        return Err(wrong("no list of numbers in it".into()));
    }
    let row = all.iter().find(|it| it.numbers.len() == most && it.lists > 1 && it.sides.is_empty());
    let row = row.and_then(|it| it.length);
    let arrays = all.into_iter().filter_map(|it| {
        let sides = match (it.sides.is_empty(), it.lists) {
            (true, 0) => Vec::new(),
            (true, _) => vec![it.numbers.len() as u64],
            (false, _) => it.sides,
        };
        Array::new(&it.name, it.numbers, false, sides, true)
    });
    let opened = arrays::opened(path, arrays.collect(), options)?;
    Ok(match row {
        Some(row) if opened.row.is_none() => {
            let note = format!("each list of {row} numbers is taken as a record of its own");
            Opened { row: Some(row), notes: [opened.notes, vec![note]].concat(), ..opened }
        }
        _ => opened,
    })
}

/// The single values of objects, a row each, below the names of the first one's.
fn table(rows: &[Value]) -> String {
    let cells: Vec<_> = rows.iter().map(|row| singles("", row, DEEP)).collect();
    let names: Vec<&str> = cells[0].iter().map(|(name, _)| *name).collect();
    let line = |row: &Vec<(&str, String)>| -> String {
        let cell = |name: &&str| row.iter().find(|it| it.0 == *name).map(|(_, cell)| cell.as_str());
        names.iter().map(|name| cell(name).unwrap_or("")).collect::<Vec<_>>().join(",")
    };
    let head: Vec<String> = names.iter().map(|name| name.replace(SEPARATORS, " ")).collect();
    let lines = std::iter::once(head.join(",")).chain(cells.iter().map(line));
    lines.map(|line| line + "\n").collect()
}

/// The numbers of an object and what begins with a digit, as a time does, with their names.
fn singles<'a>(name: &'a str, value: &'a Value, deep: usize) -> Vec<(&'a str, String)> {
    match value {
        Value::Number(number) => vec![(name, number.to_string())],
        Value::String(text) if text.starts_with(|it: char| it.is_ascii_digit()) => {
            vec![(name, text.replace(SEPARATORS, " "))]
        }
        Value::Object(object) if deep > 0 => {
            object.iter().flat_map(|(name, value)| singles(name, value, deep - 1)).collect()
        }
        _ => Vec::new(),
    }
}

/// The numbers of a value, by their names.
fn gather(name: &str, value: &Value, deep: usize, all: &mut Vec<Series>) {
    let mut add = |numbers: Vec<f64>, sides: Vec<u64>, list: bool| {
        let count = numbers.len() as u64;
        match all.iter_mut().find(|series| series.name == name) {
            // A number again is another one.
            Some(series) if list && series.sides.is_empty() && sides.is_empty() => {
                series.numbers.extend(numbers);
                series.lists += 1;
                series.length = series.length.filter(|length| *length == count);
            }
            Some(_) => {}
            None => all.push(Series {
                name: name.into(),
                numbers,
                sides,
                lists: u64::from(list),
                length: list.then_some(count),
            }),
        }
    };
    match value {
        Value::Number(number) => add(vec![number.as_f64().unwrap_or(f64::NAN)], Vec::new(), false),
        Value::Array(list) if list.iter().all(|it| it.is_number() || it.is_null()) => {
            add(list.iter().map(|it| it.as_f64().unwrap_or(f64::NAN)).collect(), Vec::new(), true);
        }
        Value::Array(list) => {
            if let Some((numbers, sides)) = nested(value, DEEP) {
                add(numbers, sides, true);
            } else if deep > 0 {
                list.iter().for_each(|it| gather(name, it, deep - 1, all));
            }
        }
        Value::Object(object) if deep > 0 => {
            object.iter().for_each(|(name, value)| gather(name, value, deep - 1, all));
        }
        _ => {}
    }
}

/// The numbers of lists within lists, all of one length, and their sides.
fn nested(value: &Value, deep: usize) -> Option<(Vec<f64>, Vec<u64>)> {
    match value {
        Value::Number(number) => Some((vec![number.as_f64()?], Vec::new())),
        Value::Array(list) if deep > 0 => {
            let (mut numbers, mut sides) = (Vec::new(), None);
            for inner in list {
                let (more, inner) = nested(inner, deep - 1)?;
                numbers.extend(more);
                if sides.get_or_insert_with(|| inner.clone()) != &inner {
                    return None;
                }
            }
            Some((numbers, [vec![list.len() as u64], sides?].concat()))
        }
        _ => None,
    }
}
