//! The number of blocks that the stream has completed and passed: by its flags, by a timer, and by the segments of a chirp. Registers are
//! read elsewhere, so a model of the stream can drive this module, too.

use crate::progress::Progress;
use core::mem::take;
use picket_dsp::acquire::frontend::Status;

/// One look at the stream and the converters.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// The timer, read first: a block that ends after this read is counted by the flags alone, while a block that ended before the time and
    /// after the flags would count twice.
    pub now: u32,
    /// The stream has completed a block.
    pub complete: bool,
    /// The slot that is being filled (CT), read after the flags: a block that ends in between is counted now or next time, never twice.
    pub target: bool,
    /// The stream has failed, or the chirp's table was not read in time.
    pub broken: bool,
    /// A converter had a sample before the last one was fetched.
    pub adc_overrun: bool,
}

/// The passage of blocks.
#[derive(Clone, Copy, Debug)]
pub struct Passage {
    /// CT at the last look that showed a completed block.
    target: bool,
    /// Whether a late exchange has stopped the stream, or samples are missing.
    stopped: bool,
    /// Blocks of pulses in vain that are not yet counted.
    vain: u32,
    /// Blocks of a chirp.
    segments: u32,
    /// Blocks completed or passed.
    progress: Progress,
    /// The ends of blocks.
    time: Elapsed,
}

impl Passage {
    /// The passage of a stream that stands still. `segments` is a chirp's number of segments; none is one.
    pub fn new(segments: usize, time: Elapsed) -> Self {
        let progress = Progress::new(segments);
        Self {
            target: false,
            stopped: false,
            vain: 0,
            segments: segments.max(1) as u32,
            progress,
            time,
        }
    }

    /// Begins the stream's first block now, in the first slot.
    pub fn begin(&mut self, now: u32) {
        (self.target, self.stopped) = (false, false);
        self.time.begin(now);
    }

    /// Notes that a late exchange has stopped the stream, or that a chirp has not all of its samples: the next look shows a fault.
    pub fn stop(&mut self) {
        self.stopped = true;
    }

    /// Notes pulses of a chirp's source that opened no gate. Their blocks count as passed before the next chirp.
    pub fn miss(&mut self, pulses: u32) {
        self.vain = self.vain.saturating_add(pulses.saturating_mul(self.segments));
    }

    /// Whether the second slot was being filled at the last look that showed a completed block.
    pub const fn target(&self) -> bool {
        self.target
    }

    /// Counts the blocks in a look.
    pub fn status(&mut self, look: Look) -> Status {
        let Look { now, complete, target, broken, adc_overrun } = look;
        let dma_error = broken || self.stopped;
        let seen = completed(complete, target != self.target);
        let completed = if dma_error || adc_overrun {
            // The flags of a stream that stands still do not count the blocks that passed since.
            self.time.beside(seen)
        } else {
            self.time.completed(seen, now)
        };
        if completed > 0 {
            self.target = target;
        }
        let vain = if completed > 0 && self.progress.begins() { take(&mut self.vain) } else { 0 };
        let completed = completed.saturating_add(vain);
        self.progress.pass(completed);
        Status { completed, dma_error, adc_overrun }
    }

    /// Blocks to leave out if the stream begins again now: see [`Elapsed::late`].
    pub fn late(&self, now: u32) -> u32 {
        self.time.late(now)
    }

    /// Passes blocks to the first one of a whole chirp, those of pulses in vain included, and returns their number.
    pub fn skip(&mut self, blocks: u32) -> u32 {
        let vain = take(&mut self.vain);
        self.progress.skip(blocks).saturating_add(self.progress.skip(vain))
    }
}

/// The completed blocks that the stream shows (see [`picket_dsp::acquire::frontend::Status::completed`]): none unless a block is complete,
/// one if the slot being filled has changed since the last call, otherwise two.
const fn completed(complete: bool, target_changed: bool) -> u32 {
    match (complete, target_changed) {
        (false, _) => 0,
        (true, true) => 1,
        (true, false) => 2,
    }
}

/// The ends of blocks, by a timer that never stops: the number that have passed unseen.
#[derive(Clone, Copy, Debug)]
pub struct Elapsed {
    /// Ticks of a block; 0 if blocks do not follow the clock, or are too long for the timer.
    block: u32,
    /// The end of the last block that was counted.
    last: u32,
}

impl Elapsed {
    /// The ends of blocks of this many ticks; `None` if blocks do not follow the clock.
    pub const fn new(block_ticks: Option<u64>) -> Self {
        match block_ticks {
            // Half of the timer's range, so that a difference is never ambiguous.
            Some(block @ 1..=0x7FFF_FFFF) => Elapsed { block: block as u32, last: 0 },
            _ => Elapsed { block: 0, last: 0 },
        }
    }

    /// Begins the first block now.
    pub fn begin(&mut self, now: u32) {
        self.last = now;
    }

    /// The completed blocks, where the stream's flags show `seen` of them: the flags give the parity, and time gives the number.
    pub fn completed(&mut self, seen: u32, now: u32) -> u32 {
        if seen == 0 || self.block == 0 {
            return seen;
        }
        let beyond = now.wrapping_sub(self.last).saturating_sub(seen.saturating_mul(self.block));
        // Pairs of blocks, to the nearest.
        let pairs = beyond.saturating_add(self.block).checked_div(self.block.saturating_mul(2));
        let completed = seen + 2 * pairs.unwrap_or(0);
        self.last = self.last.wrapping_add(completed.wrapping_mul(self.block));
        completed
    }

    /// Of `seen` completed blocks before a fault, the ones that [`Elapsed::late`] will not count: by the clock it counts them all.
    pub fn beside(&self, seen: u32) -> u32 {
        if self.block == 0 { seen } else { 0 }
    }

    /// The number of blocks to leave out by a stream that begins now: blocks whose time has come since the last counted one, begun ones
    /// included, and at least one.
    pub fn late(&self, now: u32) -> u32 {
        now.wrapping_sub(self.last).checked_div(self.block).map_or(1, |whole| whole + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_tells_how_many_blocks_passed() {
        let start = u32::MAX - 500;
        for late in [0, 40, 250, 490] {
            for blocks in 1..2000_u32 {
                let mut time = Elapsed::new(Some(1000));
                time.begin(start);
                let now = start.wrapping_add(1000 * blocks + late);
                assert_eq!(time.completed(2 - blocks % 2, now), blocks, "{late}");
                assert_eq!(time.late(now), 1);
                // The next one, punctual.
                assert_eq!(time.completed(1, now.wrapping_add(1000 - late)), 1);
            }
        }
        let mut time = Elapsed::new(Some(1000));
        time.begin(start);
        assert_eq!(
            (time.late(start.wrapping_add(999)), time.late(start.wrapping_add(1000))),
            (1, 2)
        );
        assert_eq!(time.completed(0, start.wrapping_add(9999)), 0);
        // The second block ends after the time was read and before the flags were.
        let mut time = Elapsed::new(Some(1000));
        time.begin(start);
        assert_eq!(time.completed(2, start.wrapping_add(1999)), 2);
        assert_eq!(time.completed(1, start.wrapping_add(3000)), 1);
        // Before a fault, the flags count only where the time is unknown.
        assert_eq!((time.beside(2), Elapsed::new(None).beside(2)), (0, 2));
        // Without a clock the flags alone count.
        for mut time in [Elapsed::new(None), Elapsed::new(Some(1 << 31))] {
            assert_eq!((time.completed(2, 5), time.late(12345)), (2, 1));
        }
    }
}
