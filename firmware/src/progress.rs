//! The number of blocks that have passed, by the segments of a chirp.

/// The count of blocks from the start on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    passed: u64,
    segments: u64,
}

impl Progress {
    /// The count before the first block of chirps with this number of segments; none is one.
    pub const fn new(segments: usize) -> Self {
        Self { passed: 0, segments: if segments == 0 { 1 } else { segments as u64 } }
    }

    /// Counts blocks.
    pub const fn pass(&mut self, blocks: u32) {
        self.passed = self.passed.wrapping_add(blocks as u64);
    }

    /// Whether the next block is the first one of a chirp.
    pub fn begins(&self) -> bool {
        self.passed.checked_rem(self.segments).unwrap_or(0) == 0
    }

    /// Passes blocks up to the first one of a whole chirp, and returns their number.
    pub fn skip(&mut self, blocks: u32) -> u32 {
        self.pass(blocks);
        let within = self.passed.checked_rem(self.segments).unwrap_or(0);
        let more = if within == 0 { 0 } else { self.segments.saturating_sub(within) };
        self.pass(more as u32);
        blocks.saturating_add(more as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chirp_begins_after_what_is_skipped() {
        for segments in 0..=3usize {
            let whole = segments.max(1) as u64;
            let mut progress = Progress::new(segments);
            for blocks in 0..20 {
                progress.pass(blocks);
                let skipped = progress.skip(blocks);
                assert!((blocks..blocks + whole as u32).contains(&skipped));
                assert_eq!(progress.passed % whole, 0);
            }
        }
    }
}
