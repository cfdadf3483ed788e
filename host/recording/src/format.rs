//! The formats of recordings, by a file's name and by its first bytes.

use super::number::{Kind, Number};
use super::scaling::Unit;
use super::{npy, text};
use std::path::Path;

/// How a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Format {
    /// RIFF WAVE, 8 to 32 bit integers, 32 or 64 bit floats.
    Wav,
    /// FLAC.
    Flac,
    /// Headerless 8-bit integers.
    I8,
    /// Headerless unsigned 8-bit integers, 128 in the middle.
    U8,
    /// Headerless 16-bit integers, little-endian.
    I16,
    /// Headerless unsigned 16-bit integers, little-endian, 32768 in the middle.
    U16,
    /// Headerless 32-bit integers, little-endian.
    I32,
    /// Headerless 32-bit floats, little-endian.
    F32,
    /// Headerless 64-bit floats, little-endian.
    F64,
    /// Pairs of I and Q as signed bytes.
    Cs8,
    /// Pairs of I and Q as unsigned bytes, 128 in the middle.
    Cu8,
    /// Pairs of I and Q as 16-bit integers.
    Cs16,
    /// Pairs of I and Q as 16-bit integers, in fours: I I Q Q, as TI's DCA1000 writes them.
    Iiqq,
    /// Pairs of I and Q as 32-bit floats.
    Cf32,
    /// Pairs of I and Q as 64-bit floats.
    Cf64,
    /// NumPy's array.
    Npy,
    /// NumPy's archive of arrays.
    Npz,
    /// MATLAB's file of level 5, as `save -v7` writes it.
    Mat,
    /// HDF5, MATLAB's files of version 7.3 among them.
    Hdf5,
    /// SigMF: the description, the samples beside it, or the archive of both.
    Sigmf,
    /// Columns: samples, or I and Q; an oscilloscope's with its time and its header lines.
    Csv,
    /// One record a line: {"id", "kind": "r" or "c", "re": [..], "im": [..]}.
    Json,
}

/// Headerless numbers: what they are, whether they are pairs, and how they become codes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Raw {
    pub number: Number,
    pub complex: bool,
    pub unit: Unit,
}

/// The names that formats' suffixes have. SDR programs name pairs by several.
const SUFFIXES: [(Format, &[&str]); 21] = [
    (Format::Wav, &["wav", "wave", "rf64", "w64"]),
    (Format::Flac, &["flac", "fla"]),
    (Format::I8, &["i8", "s8"]),
    (Format::U8, &["u8"]),
    (Format::I16, &["i16", "s16", "bin", "raw", "pcm", "dat"]),
    (Format::U16, &["u16"]),
    (Format::I32, &["i32", "s32"]),
    (Format::F32, &["f32", "float"]),
    (Format::F64, &["f64", "double"]),
    (Format::Cs8, &["cs8", "ci8", "sc8", "c8"]),
    (Format::Cu8, &["cu8", "uc8"]),
    (Format::Cs16, &["cs16", "ci16", "sc16", "c16"]),
    (Format::Cf32, &["cf32", "fc32", "cfile", "complex"]),
    (Format::Cf64, &["cf64", "fc64"]),
    (Format::Npy, &["npy"]),
    (Format::Npz, &["npz"]),
    (Format::Mat, &["mat"]),
    (Format::Hdf5, &["h5", "hdf5", "hdf"]),
    (Format::Sigmf, &["sigmf", "sigmf-meta", "sigmf-data"]),
    (Format::Csv, &["csv", "txt", "tsv", "tab", "asc", "log", "py", "c", "h"]),
    (Format::Json, &["json", "jsonl", "ndjson"]),
];

/// Suffixes that leave the kind of numbers open.
const VAGUE: [&str; 5] = ["bin", "raw", "pcm", "dat", "iq"];

fn suffix(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

impl Format {
    /// The format that a file's name ends in.
    pub fn guess(path: &Path) -> Option<Self> {
        let suffix = suffix(path)?;
        SUFFIXES.iter().find(|(_, names)| names.contains(&suffix.as_str())).map(|&(it, _)| it)
    }

    /// Whether a file of this name may hold any numbers.
    pub(super) fn vague(path: &Path) -> bool {
        suffix(path).is_some_and(|suffix| VAGUE.contains(&suffix.as_str()))
    }

    /// The format by a file's first bytes.
    pub(super) fn seen(head: &[u8]) -> Option<Self> {
        let at =
            |place: usize, bytes: &[u8]| head.get(place..).is_some_and(|x| x.starts_with(bytes));
        let text = || text::decoded(&head[..head.len().min(512)]);
        match () {
            () if at(0, b"RIFF") || at(0, b"RF64") || at(0, b"RIFX") => Some(Format::Wav),
            () if at(0, b"fLaC") => Some(Format::Flac),
            () if at(0, npy::MAGIC) => Some(Format::Npy),
            () if at(0, b"PK\x03\x04") => Some(Format::Npz),
            () if at(0, b"\x89HDF") || at(512, b"\x89HDF") => Some(Format::Hdf5),
            () if at(0, b"MATLAB ") => Some(Format::Mat),
            () if at(257, b"ustar") => Some(Format::Sigmf),
            () if text().trim_start().starts_with('{') && text().contains("core:") => {
                Some(Format::Sigmf)
            }
            () => None,
        }
    }

    /// What to do with a file of another kind, by its first bytes.
    pub(super) fn cure(head: &[u8]) -> Option<&'static str> {
        let at =
            |place: usize, bytes: &[u8]| head.get(place..).is_some_and(|x| x.starts_with(bytes));
        let has = |bytes: &[u8]| head.windows(bytes.len()).any(|it| it == bytes);
        match () {
            () if at(0, b"PK\x03\x04") && (has(b"xl/") || has(b"[Content_Types].xml")) => {
                Some("a spreadsheet (xlsx): save the sheet as CSV")
            }
            () if at(0, b"PK\x03\x04") && has(b"mimetypeapplication/vnd.oasis") => {
                Some("a spreadsheet (ods): save the sheet as CSV")
            }
            () if at(0, b"\xd0\xcf\x11\xe0") => Some("a spreadsheet (xls): save the sheet as CSV"),
            () if at(0, b"\x1f\x8b") => Some("compressed by gzip: unpack it by gunzip"),
            () if at(0, b"BZh") => Some("compressed by bzip2: unpack it by bunzip2"),
            () if at(0, b"\xfd7zXZ\0") => Some("compressed by xz: unpack it by unxz"),
            () if at(0, b"\x28\xb5\x2f\xfd") => Some("compressed by zstd: unpack it by unzstd"),
            () if at(0, b"7z\xbc\xaf\x27\x1c") => Some("an archive (7z): unpack it"),
            () if at(0, b"TDSm") => {
                Some("a TDMS file: export it as CSV, or by Python's nptdms as npy")
            }
            () if at(0, b"OggS") || at(0, b"ID3") || at(4, b"ftyp") => {
                Some("lossy audio: record wav or flac, or convert it by ffmpeg -i FILE x.wav")
            }
            () => None,
        }
    }

    /// The headerless numbers that it means, if it does.
    pub(super) fn raw(self) -> Option<Raw> {
        let of = |kind: Kind, complex, unit| Some(Raw { number: kind.little(), complex, unit });
        match self {
            Format::I8 => of(Kind::I8, false, Unit::eight_bits(0.0)),
            Format::U8 => of(Kind::U8, false, Unit::eight_bits(128.0)),
            Format::I16 => of(Kind::I16, false, Unit::CODES),
            Format::U16 => of(Kind::U16, false, Unit::OFFSET_16),
            Format::I32 => of(Kind::I32, false, Unit::bits(32)),
            Format::F32 => of(Kind::F32, false, Unit::SHARE),
            Format::F64 => of(Kind::F64, false, Unit::SHARE),
            Format::Cs8 => of(Kind::I8, true, Unit::eight_bits(0.0)),
            Format::Cu8 => of(Kind::U8, true, Unit::eight_bits(128.0)),
            Format::Cs16 | Format::Iiqq => of(Kind::I16, true, Unit::CODES),
            Format::Cf32 => of(Kind::F32, true, Unit::SHARE),
            Format::Cf64 => of(Kind::F64, true, Unit::SHARE),
            _ => None,
        }
    }
}
