//! HDF5, as h5py writes it, and MATLAB's files of version 7.3.

use super::arrays::{self, Array};
use super::input::Input;
use super::number::Kind;
use super::{Opened, Options, RecordingError};
use hdf5_pure::{AttrValue, DType, Dataset, File, Group};
use std::path::Path;

/// Groups within each other, and arrays, at most.
const DEEP: usize = 8;
const MOST: usize = 1000;
/// No array has more numbers.
const LONGEST: u64 = 1 << 28;

pub(super) fn open(path: &Path, input: Input, options: &Options) -> Result<Opened, RecordingError> {
    let wrong = |what: String| RecordingError::Hdf5(path.into(), what);
    let bytes = input.all(path)?;
    let file = File::from_bytes(bytes).map_err(|error| wrong(error.to_string()))?;
    let mut arrays = Vec::new();
    gather(&file.root(), "", DEEP, &mut arrays).map_err(wrong)?;
    if arrays.is_empty() {
        let cure = "it has no array of numbers that can be read; in Python: import h5py, numpy; numpy.save('x.npy', h5py.File('x.h5')['NAME'][()])";
        return Err(wrong(cure.into()));
    }
    arrays::opened(path, arrays, options)
}

/// The arrays of a group and of those in it.
fn gather(group: &Group, name: &str, deep: usize, into: &mut Vec<Array>) -> Result<(), String> {
    let text = |error: hdf5_pure::Error| error.to_string();
    rates(&group.attrs().unwrap_or_default(), into);
    for own in group.datasets().map_err(text)? {
        if into.len() >= MOST {
            return Ok(());
        }
        // What is no array of numbers, as a name or a date, is no recording either.
        let Ok(dataset) = group.dataset(&own) else { continue };
        rates(&dataset.attrs().unwrap_or_default(), into);
        into.extend(array(&dataset, &format!("{name}{own}")));
    }
    if deep > 0 {
        for own in group.groups().map_err(text)? {
            // MATLAB keeps what its variables refer to there.
            if own.starts_with('#') {
                continue;
            }
            if let Ok(inner) = group.group(&own) {
                gather(&inner, &format!("{name}{own}/"), deep - 1, into)?;
            }
        }
    }
    Ok(())
}

/// Rates in attributes, as arrays of one number, which is where files of other formats have them.
fn rates(attributes: &std::collections::HashMap<String, AttrValue>, into: &mut Vec<Array>) {
    for (name, value) in attributes {
        let number = match *value {
            AttrValue::F32(x) => f64::from(x),
            AttrValue::F64(x) => x,
            AttrValue::I32(x) => f64::from(x),
            AttrValue::I64(x) => x as f64,
            AttrValue::U32(x) => f64::from(x),
            AttrValue::U64(x) => x as f64,
            AttrValue::F64Array(ref all) if all.len() == 1 => all[0],
            _ => continue,
        };
        into.extend(Array::new(name, vec![number], false, Vec::new(), true));
    }
}

/// The numbers of a dataset; complex ones are pairs of floats, as h5py writes them.
fn array(dataset: &Dataset, name: &str) -> Option<Array> {
    let sides = dataset.shape().ok()?;
    let all = sides.iter().try_fold(1u64, |all, side| all.checked_mul(*side))?;
    if all > LONGEST {
        return None;
    }
    let pair = |kind: Kind| -> Option<Vec<f64>> {
        let (bytes, mut samples) = (dataset.read_raw().ok()?, Vec::new());
        kind.little().samples(&bytes, 1, (0, None), &mut samples);
        Some(samples.into_iter().map(|sample| sample.value.re).collect())
    };
    let (numbers, complex) = match dataset.dtype().ok()? {
        DType::Compound(fields) => match &fields[..] {
            [(_, DType::F32), (_, DType::F32)] => (pair(Kind::F32)?, true),
            [(_, DType::F64), (_, DType::F64)] => (pair(Kind::F64)?, true),
            [(_, DType::I16), (_, DType::I16)] => (pair(Kind::I16)?, true),
            _ => return None,
        },
        DType::String | DType::VariableLengthString | DType::ObjectReference => return None,
        _ => (dataset.read_f64().ok()?, false),
    };
    Array::new(name, numbers, complex, sides, true)
}
