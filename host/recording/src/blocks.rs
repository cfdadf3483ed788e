//! A recording's samples in blocks.

use super::{Recording, RecordingError, Sample};
use std::collections::VecDeque;

/// Blocks of a recording, which may overlap. Holds one block in memory.
#[derive(Debug)]
pub struct Blocks {
    recording: Recording,
    n: usize,
    hop: usize,
    /// Samples from one block to the next in the mean, and the blocks so far.
    every: f64,
    given: u64,
    /// Samples to leave out before the next block.
    pending: u64,
    samples: Vec<Sample>,
    /// Whether a block was given.
    begun: bool,
    /// The numbers of the samples that are missing, of the last block or later ones.
    missing: VecDeque<u64>,
}

impl Blocks {
    pub(super) fn new(recording: Recording, n: usize, hop: usize, skip: u64) -> Self {
        let samples = Vec::with_capacity(n);
        let missing = VecDeque::new();
        let every = hop as f64;
        Self { recording, n, hop, every, given: 0, pending: skip, samples, begun: false, missing }
    }

    /// Each block as near as samples are to this many samples after the last one, in the mean.
    #[must_use]
    pub fn every(mut self, samples: f64) -> Self {
        self.every = samples.max(1.0);
        self.hop = self.step();
        self
    }

    /// From the block after those given to the next one.
    fn step(&self) -> usize {
        let at = |block: u64| (block as f64 * self.every).round();
        (at(self.given + 1) - at(self.given)).max(1.0) as usize
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

    /// Whether the block given last is not one stretch: a sample of it is missing, or a record ends within it.
    pub fn gap(&self) -> bool {
        let end = self.recording.read;
        let start = end.saturating_sub(self.n as u64);
        let ends = |row: u64| start / row != end.saturating_sub(1) / row;
        self.missing() > 0 || self.recording.row.is_some_and(|row| ends(row.max(1)))
    }

    /// The next block and the number of its first sample, or `None` at the end. An error if the
    /// recording does not fill even one block.
    pub fn next_block(&mut self) -> Result<Option<(u64, &[Sample])>, RecordingError> {
        let mut samples = std::mem::take(&mut self.samples);
        samples.drain(..self.hop.min(samples.len()));
        if self.begun {
            self.given += 1;
        }
        self.hop = self.step();
        let start = self.append(&mut samples, self.n);
        self.samples = samples;
        Ok(start?.map(|start| (start, &*self.samples)))
    }

    /// Appends the next block to `into`, and gives the number of its first sample, as [`Blocks::next_block`]: without a copy
    /// where blocks do not overlap.
    pub fn append_block(&mut self, into: &mut Vec<Sample>) -> Result<Option<u64>, RecordingError> {
        if self.hop >= self.n {
            return self.append(into, into.len() + self.n);
        }
        let Some((start, samples)) = self.next_block()? else { return Ok(None) };
        into.extend_from_slice(samples);
        Ok(Some(start))
    }

    /// Fills `samples` with the rest of a block, up to this many of them.
    fn append(
        &mut self,
        samples: &mut Vec<Sample>,
        wanted: usize,
    ) -> Result<Option<u64>, RecordingError> {
        while self.pending > 0 {
            let mut left_out = Vec::new();
            let some = self.pending.min(1 << 16) as usize;
            self.recording.fill(&mut left_out, some)?;
            if left_out.is_empty() {
                return self.end(0);
            }
            self.pending -= left_out.len() as u64;
        }
        self.recording.fill(samples, wanted - samples.len())?;
        if samples.len() < wanted {
            return self.end(samples.len() + self.n - wanted);
        }
        self.begun = true;
        self.pending = self.hop.saturating_sub(self.n) as u64;
        let start = self.recording.read - self.n as u64;
        self.missing.extend(self.recording.missing.drain(..));
        while self.missing.front().is_some_and(|&number| number < start) {
            self.missing.pop_front();
        }
        Ok(Some(start))
    }

    /// The end, with this many samples of a block.
    fn end(&self, samples: usize) -> Result<Option<u64>, RecordingError> {
        let path = || self.recording.path.clone();
        match (self.begun, self.recording.read) {
            (false, 0) => Err(RecordingError::Empty(path())),
            (false, _) => Err(RecordingError::Short(path(), samples as u64, self.n)),
            (true, _) => Ok(None),
        }
    }
}
