//! Where samples come from: packed numbers, or columns in memory.

use super::number::Number;
use super::unit::Named;
use super::{RecordingError, Sample};
use std::io::{ErrorKind, Read};
use std::path::PathBuf;

/// What gives a recording's samples, one after the other.
pub(super) trait Source: Send {
    /// Appends at most `count` samples in the file's units, NaN where one is missing. Fewer only at the end.
    fn read(&mut self, into: &mut Vec<Sample>, count: usize) -> Result<(), RecordingError>;

    /// Whether there is a column of times.
    fn is_timed(&self) -> bool {
        false
    }

    /// The times of the rows that were read, and what is known of their column, where there is one.
    fn times(&mut self) -> Option<(Vec<f64>, Named)> {
        None
    }
}

/// Samples of a reader that packs its numbers without anything between them.
pub(super) struct Packed<R> {
    pub path: PathBuf,
    pub reader: R,
    pub number: Number,
    /// Numbers in a frame.
    pub channels: usize,
    /// The number that is the sample, from 0, and the one that is its quadrature part.
    pub picked: (usize, Option<usize>),
    /// Frames that are left.
    pub left: u64,
    /// The bytes of the last reading.
    pub buffer: Vec<u8>,
}

impl<R: Read + Send> Source for Packed<R> {
    fn read(&mut self, into: &mut Vec<Sample>, count: usize) -> Result<(), RecordingError> {
        let frame = self.channels * self.number.width();
        let frames = (count as u64).min(self.left) as usize;
        self.buffer.resize(frames * frame, 0);
        let mut filled = 0;
        while filled < self.buffer.len() {
            match self.reader.read(&mut self.buffer[filled..]) {
                Ok(0) => break,
                Ok(more) => filled += more,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(RecordingError::Io(self.path.clone(), error)),
            }
        }
        let whole = filled / frame;
        self.left = if whole < frames { 0 } else { self.left - frames as u64 };
        self.number.samples(&self.buffer[..whole * frame], self.channels, self.picked, into);
        Ok(())
    }
}

/// Samples in memory.
pub(super) struct Held {
    pub samples: std::vec::IntoIter<Sample>,
}

impl Source for Held {
    fn read(&mut self, into: &mut Vec<Sample>, count: usize) -> Result<(), RecordingError> {
        into.extend(self.samples.by_ref().take(count));
        Ok(())
    }
}
