//! NumPy's archives of arrays: `np.savez`, and with compression `np.savez_compressed`.

use super::arrays::{self, Array};
use super::input::Input;
use super::{Opened, Options, RecordingError, npy};
use flate2::read::DeflateDecoder;
use rawzip::{CompressionMethod, ZipArchive};
use std::io::Read;
use std::path::Path;

/// No array is longer than this when it is unpacked, in bytes.
const LONGEST: u64 = 1 << 31;

pub(super) fn open(path: &Path, input: Input, options: &Options) -> Result<Opened, RecordingError> {
    let bytes = input.all(path)?;
    let arrays = arrays_in(&bytes).map_err(|what| RecordingError::Npz(path.into(), what))?;
    arrays::opened(path, arrays, options)
}

fn arrays_in(bytes: &[u8]) -> Result<Vec<Array>, String> {
    let text = |error: rawzip::Error| error.to_string();
    let archive = ZipArchive::from_slice(bytes).map_err(text)?;
    let mut entries = archive.entries();
    let mut arrays = Vec::new();
    while let Some(entry) = entries.next_entry().map_err(text)? {
        let name = String::from_utf8_lossy(entry.file_path().as_ref()).into_owned();
        let Some(name) = name.strip_suffix(".npy") else { continue };
        let packed = archive.get_entry(entry.wayfinder()).map_err(text)?;
        let mut unpacked = Vec::new();
        let read = match entry.compression_method() {
            CompressionMethod::STORE => packed.data().take(LONGEST).read_to_end(&mut unpacked),
            CompressionMethod::DEFLATE => {
                DeflateDecoder::new(packed.data()).take(LONGEST).read_to_end(&mut unpacked)
            }
            other => {
                return Err(format!("its arrays are packed by {other:?}: save it by np.savez"));
            }
        };
        read.map_err(|error| format!("{name}: {error}"))?;
        // What is no array of numbers, as a name or a date, is no recording either.
        arrays.extend(npy::array(name, &unpacked).ok());
    }
    if arrays.is_empty() { Err("it has no array of numbers".into()) } else { Ok(arrays) }
}
