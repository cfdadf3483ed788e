//! MATLAB's files of level 5 (`save -v6`, `-v7`), and Octave's by the same names.

use super::arrays::{self, Array};
use super::input::Input;
use super::{Opened, Options, RecordingError};
use matfile::{MatFile, NumericData};
use std::path::Path;

pub(super) fn open(path: &Path, input: Input, options: &Options) -> Result<Opened, RecordingError> {
    let wrong = |what: &str| RecordingError::Mat(path.into(), what.into());
    let bytes = input.all(path)?;
    if bytes.starts_with(b"\x89HDF") || bytes.starts_with(b"MATLAB 7.3") {
        return Err(wrong("it is of version 7.3: save it by save('name.mat', 'x', '-v7')"));
    }
    if !bytes.starts_with(b"MATLAB 5.0") {
        return Err(wrong("it is not of level 5: save it by save('name.mat', 'x', '-v7')"));
    }
    let file = MatFile::parse(&bytes[..]).map_err(|_| wrong("it is damaged, or cut off"))?;
    let arrays: Vec<Array> = file.arrays().iter().filter_map(array).collect();
    if arrays.is_empty() {
        return Err(wrong("it has no array of numbers"));
    }
    arrays::opened(path, arrays, options)
}

fn array(array: &matfile::Array) -> Option<Array> {
    let sides: Vec<u64> = array.size().iter().map(|&side| side as u64).collect();
    let (re, im) = numbers(array.data());
    let complex = im.is_some();
    let numbers = match im {
        Some(im) => re.into_iter().zip(im).flat_map(|(re, im)| [re, im]).collect(),
        None => re,
    };
    // The first index runs fastest.
    Array::new(array.name(), numbers, complex, sides, false)
}

/// Real and imaginary parts.
fn numbers(data: &NumericData) -> (Vec<f64>, Option<Vec<f64>>) {
    macro_rules! both {
        ($real:ident, $imag:ident, $x:ident => $number:expr) => {{
            let numbers = |all: &Vec<_>| all.iter().map(|&$x| $number).collect::<Vec<f64>>();
            (numbers($real), $imag.as_ref().map(numbers))
        }};
    }
    match data {
        NumericData::Int8 { real, imag } => both!(real, imag, x => f64::from(x)),
        NumericData::UInt8 { real, imag } => both!(real, imag, x => f64::from(x)),
        NumericData::Int16 { real, imag } => both!(real, imag, x => f64::from(x)),
        NumericData::UInt16 { real, imag } => both!(real, imag, x => f64::from(x)),
        NumericData::Int32 { real, imag } => both!(real, imag, x => f64::from(x)),
        NumericData::UInt32 { real, imag } => both!(real, imag, x => f64::from(x)),
        NumericData::Int64 { real, imag } => both!(real, imag, x => x as f64),
        NumericData::UInt64 { real, imag } => both!(real, imag, x => x as f64),
        NumericData::Single { real, imag } => both!(real, imag, x => f64::from(x)),
        NumericData::Double { real, imag } => both!(real, imag, x => x),
    }
}
