//! A capture: the samples of blocks, into a file. A block that loses a piece on the line is requested again.

use super::{Kept, WatchError};
use crate::device::Blocks;
use picket_wire::status::Raw;
use std::time::{Duration, Instant};

/// Blocks on their way into a file.
pub struct Capture {
    file: Kept,
    wanted: u16,
    left: u16,
    pieces: Blocks,
    /// When the last piece came, or was asked for.
    last: Instant,
    /// How often was asked again since a block came whole.
    tries: u32,
}

/// So often the missing blocks are asked for again.
const TRIES: u32 = 5;
/// A pause on the line after which no more pieces come. The blocks' own duration comes on top.
const PAUSE: Duration = Duration::from_secs(1);

impl Capture {
    /// Captures `wanted` blocks into this file.
    pub fn create(file: Kept, wanted: u16) -> Self {
        let pieces = Blocks::default();
        Capture { file, wanted, left: wanted, pieces, last: Instant::now(), tries: 0 }
    }

    /// Whether blocks are missing.
    pub fn misses(&self) -> bool {
        self.left > 0
    }

    /// Takes a piece of a block of `length` bytes.
    pub fn push(&mut self, raw: &Raw, length: usize) -> Result<(), WatchError> {
        self.last = Instant::now();
        if let Some((_, bytes)) = self.pieces.push(raw, length)
            && self.left > 0
        {
            self.file.write(&bytes)?;
            (self.left, self.tries) = (self.left - 1, 0);
            if self.left == 0 {
                eprintln!("--capture: done");
            }
        }
        Ok(())
    }

    /// The blocks to ask for again, where a block lasts so long; `None` as long as they may still come.
    ///
    /// # Errors
    /// They were asked for often enough.
    pub fn again(&mut self, block: Duration) -> Result<Option<u16>, WatchError> {
        // A board that is asked waits for the next block to begin, and then for its end.
        if self.left == 0 || self.last.elapsed() < PAUSE + block.saturating_mul(3) {
            return Ok(None);
        }
        let Capture { wanted, left, .. } = *self;
        if self.tries >= TRIES {
            return Err(WatchError::Holes { got: wanted - left, wanted });
        }
        eprintln!("--capture: {left} of {wanted} blocks did not come whole; asking again");
        (self.last, self.tries) = (Instant::now(), self.tries + 1);
        Ok(Some(left))
    }

    /// The capture begins now, however long the orders before it took.
    pub fn begin(&mut self) {
        self.last = Instant::now();
    }
}
