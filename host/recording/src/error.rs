//! Why a recording cannot be read.

use super::Format;
use std::fmt::{self, Write};
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
    /// Neither the name nor the bytes show the format; the possible readings of the bytes.
    Unclear(PathBuf, &'static [Format]),
    /// The length in bytes is not a whole number of samples of this many bytes.
    OddSize(PathBuf, u64, u64),
    /// The wav header is wrong or of a kind that cannot be read.
    Wav(PathBuf, String),
    /// The wav header announces more bytes of samples than the file holds.
    Truncated(PathBuf, u64, u64),
    /// This many channels, and whether I/Q was asked for.
    Channels(PathBuf, usize, bool),
    /// The sample rate is none of [`crate::RATES_HZ`].
    Rate(f64),
    /// The line and what is wrong with it.
    Line(PathBuf, u64, String),
    /// The npy header is wrong or of a kind that cannot be read.
    Npy(PathBuf, String),
    /// The name says numbers, and the bytes are text.
    Either(PathBuf),
    /// Commas may be decimal, or stand between columns.
    Comma(PathBuf, String),
    /// Columns of values in addition to the time, with what to type for them.
    Columns(PathBuf, String),
    /// This channel or column is not there; those that are.
    Channel(PathBuf, usize, usize),
    /// Two channels are chosen as I and Q, but each is I/Q already; there are this many.
    AlreadyPairs(PathBuf, usize),
    /// This many channels of complex numbers, and none is chosen.
    ComplexChannels(PathBuf, usize),
    /// A file of another kind, and what to do with it.
    Other(PathBuf, &'static str),
    /// Headerless numbers that look like others, and what to add for them.
    Like(PathBuf, &'static str),
    /// The npz archive is damaged or of a kind that cannot be read.
    Npz(PathBuf, String),
    /// The mat file is damaged or of a kind that cannot be read.
    Mat(PathBuf, String),
    /// A format that only the tools read, not the page.
    Packed(PathBuf),
    /// The HDF5 file is damaged or of a kind that cannot be read.
    Hdf5(PathBuf, String),
    /// The FLAC file is damaged or of a kind that cannot be read.
    Flac(PathBuf, String),
    /// The SigMF description is wrong or of a kind that cannot be read.
    Sigmf(PathBuf, String),
    /// Fewer samples than one record needs: the samples there are, and those needed.
    Short(PathBuf, u64, usize),
}

impl fmt::Display for RecordingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use RecordingError::*;
        let f = &mut Plain { line: f, left: LONGEST };
        match self {
            Io(path, error) if error.kind() == io::ErrorKind::NotFound => {
                write!(f, "{}: no such file", path.display())
            }
            Io(path, error) => write!(f, "{}: {error}", path.display()),
            Empty(path) => write!(f, "{}: the file holds no samples", path.display()),
            Unclear(path, []) => write!(
                f,
                "{}: neither its name nor its first bytes show the format: add --format wav, flac, i16, cs16, cu8, f32, cf32, npy, npz, mat, sigmf, csv or json",
                path.display()
            ),
            Unclear(path, readings) => {
                let names: Vec<String> =
                    readings.iter().map(|it| format!("{it:?}").to_lowercase()).collect();
                write!(
                    f,
                    "{}: its bytes look like {}: add --format {}",
                    path.display(),
                    match readings {
                        [Format::Cu8, ..] => "numbers of 8 bits, in pairs of I and Q or not",
                        _ => "floats, in pairs of I and Q or not",
                    },
                    names.join(" or ")
                )
            }
            OddSize(path, bytes, frame) => write!(
                f,
                "{}: {bytes} bytes are not a whole number of {frame}-byte samples: the file is cut off or of another --format",
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
                "{}: two channels: add --iq if they are I and Q, or --channel 1 or 2",
                path.display()
            ),
            Channels(path, channels, true) => {
                write!(f, "{}: --iq needs two channels, the file has {channels}", path.display())
            }
            Channels(path, channels, false) => {
                write!(
                    f,
                    "{}: {channels} channels: choose one by --channel 1 to {channels}, or two as I and Q: --channel 1,2",
                    path.display()
                )
            }
            Rate(rate) => {
                write!(
                    f,
                    "the sample rate must be a positive number of hertz, 1e-6 to 1e12, not {rate}"
                )
            }
            Npy(path, what) => write!(f, "{}: not a readable npy file: {what}", path.display()),
            Either(path) => write!(
                f,
                "{}: the name says int16, but it looks like text: add --format csv, or --format i16",
                path.display()
            ),
            Comma(path, line) => write!(
                f,
                "{}: \"{line}\" may be one number or two columns: add --decimal-comma, or --column 1 (or 1,2 for I and Q)",
                path.display()
            ),
            Columns(path, what) => write!(f, "{}: {what}", path.display()),
            Channel(path, channel, 0) => {
                write!(f, "{}: there is no number in column {channel}", path.display())
            }
            Channel(path, channel, most) => {
                write!(f, "{}: there is no channel {channel}: choose 1 to {most}", path.display())
            }
            AlreadyPairs(path, channels) => write!(
                f,
                "{}: each of its {channels} channels is I and Q already: choose one by --channel",
                path.display()
            ),
            ComplexChannels(path, channels) => write!(
                f,
                "{}: {channels} channels of complex numbers: choose one by --channel 1 to {channels}",
                path.display()
            ),
            Other(path, what) | Like(path, what) => write!(f, "{}: {what}", path.display()),
            Packed(path) => write!(
                f,
                "{}: only the tool reads this format: type picket analyze, or save it as wav or npy",
                path.display()
            ),
            Npz(path, what) => write!(f, "{}: not a readable npz file: {what}", path.display()),
            Mat(path, what) => write!(f, "{}: not a readable mat file: {what}", path.display()),
            Hdf5(path, what) => write!(f, "{}: not a readable HDF5 file: {what}", path.display()),
            Flac(path, what) => write!(f, "{}: not a readable FLAC file: {what}", path.display()),
            Sigmf(path, what) => {
                write!(f, "{}: not a readable SigMF recording: {what}", path.display())
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

/// The longest message, in characters.
const LONGEST: usize = 500;

/// A line of a message. What it quotes of a file can neither break the line nor reach the terminal
/// as a command, and is cut where it is too long to read.
struct Plain<'a, 'b> {
    line: &'a mut fmt::Formatter<'b>,
    left: usize,
}

impl Write for Plain<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for letter in text.chars() {
            match self.left.checked_sub(1) {
                None => return Ok(()),
                Some(0) => self.line.write_str("...")?,
                Some(_) if letter.is_control() => write!(self.line, "{}", letter.escape_debug())?,
                Some(_) => self.line.write_char(letter)?,
            }
            self.left -= 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_one_line_whatever_the_file_holds() {
        let quoted = RecordingError::Npy("x".into(), "kind \"<f8\n\u{1b}[2J\"".into()).to_string();
        assert!(quoted.ends_with(r#"kind "<f8\n\u{1b}[2J""#), "{quoted}");
        let long = RecordingError::Comma("x".into(), "1,".repeat(1 << 20)).to_string();
        assert!(long.len() < 600 && long.ends_with("..."), "{long}");
    }
}
