//! Files that others have made. Each is read to its end, or ends in an error of one line.

use picket_recording::{Format, Options, Recording, Records};
use std::path::Path;

/// RIFF WAVE.
pub fn wav(bytes: &[u8]) {
    recording(Format::Wav, bytes);
}

/// NumPy's arrays.
pub fn npy(bytes: &[u8]) {
    recording(Format::Npy, bytes);
}

/// Columns of numbers, and tables of oscilloscopes.
pub fn csv(bytes: &[u8]) {
    recording(Format::Csv, bytes);
}

/// Numbers without a header; the first byte tells which.
pub fn raw(bytes: &[u8]) {
    let Some((&which, rest)) = bytes.split_first() else { return };
    let formats = [
        Format::I16,
        Format::U16,
        Format::I32,
        Format::F32,
        Format::Cf64,
        Format::Cu8,
        Format::Iiqq,
    ];
    recording(formats[usize::from(which) % formats.len()], rest);
}

/// FLAC, npz, mat, HDF5 and SigMF; the first byte tells which.
pub fn archive(bytes: &[u8]) {
    let Some((&which, rest)) = bytes.split_first() else { return };
    let formats = [Format::Flac, Format::Npz, Format::Mat, Format::Hdf5, Format::Sigmf];
    recording(formats[usize::from(which) % formats.len()], rest);
}

/// Lists of numbers in text, as debuggers and programs write them; and JSON that is one recording.
pub fn list(bytes: &[u8]) {
    recording(Format::Csv, &[b"\0x = {1, 2, 3, 4, 5, 6, 7, 8, ", bytes].concat());
    recording(Format::Json, bytes);
}

/// A table whose first column is the time.
pub fn times(bytes: &[u8]) {
    let rows: String = bytes
        .chunks(3)
        .map(|it| format!("{},{}\n", i32::from(it[0]) * 7 - i32::from(it.len() as u8), it[0]))
        .collect();
    recording(Format::Csv, format!("\0time,x\n{rows}").as_bytes());
    recording(Format::Csv, &[b"\0time,x\n", bytes].concat());
}

/// JSON lines.
pub fn json(bytes: &[u8]) {
    let Ok(records) = Records::from_bytes(NAME.as_ref(), bytes.to_vec(), Options::default()) else {
        return;
    };
    for record in records {
        match record {
            Ok(record) => assert!(!record.samples.is_empty()),
            Err(error) => one_line(&error),
        }
    }
}

const NAME: &str = "recording";
/// Samples in a block.
const N: usize = 64;

/// The first byte tells how the rest is read.
fn recording(format: Format, bytes: &[u8]) {
    let Some((&how, rest)) = bytes.split_first() else { return };
    let options = Options {
        format: Some(format),
        rate_hz: (how & 1 != 0).then_some(48e3),
        iq: how & 2 != 0,
        scale: (how & 4 != 0).then_some(0.5),
        channel: match how >> 3 & 3 {
            0 | 1 => None,
            2 => Some((1, None)),
            _ => Some((2, Some(1))),
        },
        decimal_comma: how & 32 != 0,
        ..Options::default()
    };
    let recording = Recording::from_bytes(Path::new(NAME), rest.to_vec(), options);
    let mut blocks = match recording {
        Ok(recording) => recording.blocks(N, 1 + usize::from(how >> 6) * N, 0),
        Err(error) => return one_line(&error),
    };
    assert!(blocks.recording().rate_hz() >= 0.0);
    let mut last = None;
    loop {
        match blocks.next_block() {
            Ok(Some((first, samples))) => {
                assert!(samples.len() == N && last.is_none_or(|last| first > last));
                // Codes saturate, whatever the value.
                let _ = samples.iter().fold(0, |sum, it| sum ^ it.code()[0] ^ it.code()[1]);
                last = Some(first);
            }
            Ok(None) => return,
            Err(error) => return one_line(&error),
        }
    }
}

fn one_line(error: &impl std::fmt::Display) {
    let told = error.to_string();
    assert!(!told.is_empty() && !told.contains(char::is_control), "{told:?}");
}
