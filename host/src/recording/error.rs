//! Why a recording cannot be read.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a recording cannot be read. Each message is one line that says what to do.
#[derive(Debug)]
#[non_exhaustive]
pub enum RecordingError {
    /// The file cannot be opened or read.
    Io(PathBuf, io::Error),
    /// The file holds no samples.
    Empty(PathBuf),
    /// The name does not tell the format.
    Format(PathBuf),
    /// The length in bytes is not a whole number of samples of this many bytes.
    OddSize(PathBuf, u64, u64),
    /// The wav header is wrong or of a kind that cannot be read.
    Wav(PathBuf, String),
    /// The wav header announces more bytes of samples than the file holds.
    Truncated(PathBuf, u64, u64),
    /// This many channels, and whether I/Q was asked for.
    Channels(PathBuf, usize, bool),
    /// The file does not know its sample rate.
    RateMissing(PathBuf),
    /// The sample rate is not a positive number.
    Rate(f64),
    /// The line and what is wrong with it.
    Line(PathBuf, u64, String),
    /// Fewer samples than one record needs: the samples there are, and those needed.
    Short(PathBuf, u64, usize),
}

impl fmt::Display for RecordingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use RecordingError::*;
        match self {
            Io(path, error) if error.kind() == io::ErrorKind::NotFound => {
                write!(f, "{}: no such file", path.display())
            }
            Io(path, error) => write!(f, "{}: {error}", path.display()),
            Empty(path) => write!(f, "{}: the file holds no samples", path.display()),
            Format(path) => write!(
                f,
                "{}: the name does not tell the format: add --format wav, i16, csv or json",
                path.display()
            ),
            OddSize(path, bytes, frame) => write!(
                f,
                "{}: {bytes} bytes are not a whole number of {frame}-byte samples: the file is cut off or not int16",
                path.display()
            ),
            Wav(path, what) => write!(f, "{}: not a readable wav file: {what}", path.display()),
            Truncated(path, said, held) => write!(
                f,
                "{}: truncated wav: its header announces {said} bytes of samples, the file holds {held}: copy it again",
                path.display()
            ),
            Channels(path, 2, false) => write!(
                f,
                "{}: two channels: add --iq if they are I and Q, or extract one channel",
                path.display()
            ),
            Channels(path, channels, true) => {
                write!(f, "{}: --iq needs two channels, the file has {channels}", path.display())
            }
            Channels(path, channels, false) => {
                write!(f, "{}: {channels} channels: extract one, or two as I and Q", path.display())
            }
            RateMissing(path) => {
                write!(
                    f,
                    "{}: the file does not tell its sample rate: add --rate HZ",
                    path.display()
                )
            }
            Rate(rate) => {
                write!(f, "the sample rate must be a positive number of hertz, not {rate}")
            }
            Line(path, line, what) => write!(f, "{}, line {line}: {what}", path.display()),
            Short(path, held, needed) => write!(
                f,
                "{}: {held} samples are fewer than one record of {needed}: choose a smaller --n or --skip",
                path.display()
            ),
        }
    }
}

impl std::error::Error for RecordingError {}
