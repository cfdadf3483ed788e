//! A recording's samples in blocks.

use super::{Recording, RecordingError, Sample};
use std::collections::VecDeque;

/// Blocks of a recording, which may overlap. Holds one block in memory.
#[derive(Debug)]
pub struct Blocks {
    recording: Recording,
    n: usize,
    hop: usize,
    /// Samples to leave out before the next block.
    pending: u64,
    samples: Vec<Sample>,
    /// The numbers of the samples that are missing, of the last block or later ones.
    missing: VecDeque<u64>,
}

impl Blocks {
    pub(super) fn new(recording: Recording, n: usize, hop: usize, skip: u64) -> Self {
        let samples = Vec::with_capacity(n);
        Self { recording, n, hop, pending: skip, samples, missing: VecDeque::new() }
    }

    /// The recording.
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Samples of the block given last that the file has no number for. Each has the value of the one before it.
    pub fn missing(&self) -> usize {
        let end = self.recording.read;
        self.missing.iter().filter(|&&number| number < end).count()
    }

    /// The next block and the number of its first sample, or `None` at the end. An error if the
    /// recording does not fill even one block.
    pub fn next_block(&mut self) -> Result<Option<(u64, &[Sample])>, RecordingError> {
        let first = self.samples.is_empty();
        self.samples.drain(..self.hop.min(self.samples.len()));
        while self.pending > 0 {
            let mut left_out = Vec::new();
            let some = self.pending.min(1 << 16) as usize;
            self.recording.fill(&mut left_out, some)?;
            if left_out.is_empty() {
                return self.end(first);
            }
            self.pending -= left_out.len() as u64;
        }
        let wanted = self.n - self.samples.len();
        self.recording.fill(&mut self.samples, wanted)?;
        if self.samples.len() < self.n {
            return self.end(first);
        }
        self.pending = self.hop.saturating_sub(self.n) as u64;
        let start = self.recording.read - self.n as u64;
        self.missing.extend(self.recording.missing.drain(..));
        while self.missing.front().is_some_and(|&number| number < start) {
            self.missing.pop_front();
        }
        Ok(Some((start, &self.samples)))
    }

    fn end(&self, first: bool) -> Result<Option<(u64, &[Sample])>, RecordingError> {
        let path = || self.recording.path.clone();
        match (first, self.recording.read) {
            (true, 0) => Err(RecordingError::Empty(path())),
            (true, _) => Err(RecordingError::Short(path(), self.samples.len() as u64, self.n)),
            (false, _) => Ok(None),
        }
    }
}
