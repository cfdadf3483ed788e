//! The number of blocks that have passed: by the timer, or by the pulses of a chirp's source.

use super::words::ADC_HZ;

/// The ends of blocks: the flags of two channels cannot count above two, but the timer can.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Elapsed {
    /// Cycles of a block.
    block: u32,
    /// The end of the last counted block: microseconds of the timer, and cycles less than one microsecond.
    micros: u32,
    cycles: u32,
}

/// Cycles of the converter's clock in a microsecond.
const PER_MICROSECOND: u32 = ADC_HZ / 1_000_000;

impl Elapsed {
    /// Blocks of `block` cycles, from now on.
    pub const fn new(block: u32, now: u32) -> Self {
        Self { block, micros: now, cycles: 0 }
    }

    /// Cycles since the last counted block's end. Up to half an hour, positive or negative.
    fn since(&self, now: u32) -> i64 {
        let micros = i64::from(now.wrapping_sub(self.micros) as i32);
        micros * i64::from(PER_MICROSECOND) - i64::from(self.cycles)
    }

    /// Blocks completed since the last call, if at least one was; `odd` says that the channel which completed last differs from the one at
    /// the last call. The timer may be early or late by less than a block: the parity corrects the count.
    pub fn completed(&mut self, odd: bool, now: u32) -> u32 {
        let since = self.since(now);
        let block = i64::from(self.block);
        let blocks = if odd && 2 * since < 5 * block {
            // The usual case, without a division.
            1
        } else {
            // The count of this parity nearest to the middle of the block that is being filled.
            let whole = since.div_euclid(block.max(1));
            let late = 2 * since.rem_euclid(block.max(1)) >= block;
            match (whole & 1 == i64::from(odd), late) {
                (true, _) => whole,
                (false, true) => whole + 1,
                (false, false) => whole - 1,
            }
        };
        let blocks = blocks.clamp(0, u32::MAX.into()) as u32;
        self.pass(blocks);
        blocks
    }

    /// Blocks whose time is over since the last call, after a channel has failed: the channel then reports an end that its block does not
    /// have.
    pub fn ended(&mut self, now: u32) -> u32 {
        let blocks = self.since(now).div_euclid(i64::from(self.block.max(1)));
        let blocks = blocks.clamp(0, u32::MAX.into()) as u32;
        self.pass(blocks);
        blocks
    }

    /// Counts blocks.
    fn pass(&mut self, blocks: u32) {
        let cycles = u64::from(blocks) * u64::from(self.block) + u64::from(self.cycles);
        let per = u64::from(PER_MICROSECOND);
        self.micros = self.micros.wrapping_add((cycles / per) as u32);
        self.cycles = (cycles % per) as u32;
    }

    /// Blocks that have begun since the last counted one: at least one. Counting begins again now.
    pub fn restart(&mut self, now: u32) -> u32 {
        let block = i64::from(self.block.max(1));
        let passed = (self.since(now).max(1) + block - 1) / block;
        *self = Self::new(self.block, now);
        passed.clamp(1, u32::MAX.into()) as u32
    }
}

/// Blocks of chirps that follow pulses: each pulse opens the gate for the blocks of one chirp. A pulse that comes too early, or while the
/// samples stand, opens no gate; its blocks count as lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pulsed {
    /// Cycles of a block.
    block: u32,
    /// Blocks of a chirp.
    segments: u32,
    /// Blocks of the chirps that are over.
    over: u64,
    /// Blocks that are counted.
    counted: u64,
    /// Blocks of pulses in vain that are not yet counted, and blocks of pulses after the last chirp that is over.
    missed: u64,
    after: u64,
}

impl Pulsed {
    /// Blocks of `block` cycles, `segments` in a chirp.
    pub const fn new(block: u32, segments: u32) -> Self {
        Self { block, segments, over: 0, counted: 0, missed: 0, after: 0 }
    }

    /// Ends a chirp during which `missed` pulses came in vain.
    pub fn close(&mut self, missed: u32) {
        self.over += u64::from(self.segments);
        self.missed += self.after;
        self.after = self.chirps(missed);
    }

    /// Blocks of `chirps` chirps.
    fn chirps(&self, chirps: u32) -> u64 {
        u64::from(chirps) * u64::from(self.segments)
    }

    /// Counts pulses in vain.
    pub fn miss(&mut self, pulses: u32) {
        self.missed += self.chirps(pulses);
    }

    /// Whole blocks of an open chirp after `open` cycles, and whether half of a further block is over.
    fn within(&self, open: Option<u32>) -> (u64, bool) {
        let (cycles, block) = (open.unwrap_or(0), self.block.max(1));
        ((cycles / block).into(), cycles % block >= block / 2)
    }

    /// Blocks completed since the last call, if at least one was, pulses in vain included. A chirp that is not over has been open for
    /// `open` cycles; `odd` is that of [`Elapsed::completed`].
    pub fn completed(&mut self, odd: bool, open: Option<u32>) -> u32 {
        let (whole, late) = self.within(open);
        let right = (self.over + whole).wrapping_sub(self.counted) & 1 == u64::from(odd);
        let within = match (right, late) {
            (true, _) => whole,
            (false, true) => whole + 1,
            (false, false) => whole.saturating_sub(1),
        };
        self.count(self.over + within)
    }

    /// Blocks whose time is over since the last call, after a channel has failed.
    pub fn ended(&mut self, open: Option<u32>) -> u32 {
        let (whole, _) = self.within(open);
        self.count(self.over + whole)
    }

    fn count(&mut self, blocks: u64) -> u32 {
        if blocks > self.over {
            self.missed += core::mem::take(&mut self.after);
        }
        let new = blocks.saturating_sub(self.counted) + self.missed;
        (self.counted, self.missed) = (blocks.max(self.counted), 0);
        new.min(u32::MAX.into()) as u32
    }

    /// Blocks from the last counted one to the end of the last chirp, pulses in vain included: at least one. Counting begins again. `open`
    /// says that the last chirp was not over.
    pub fn restart(&mut self, open: bool) -> u32 {
        let rest = if open { self.segments } else { 0 };
        self.missed += core::mem::take(&mut self.after);
        let passed = self.count(self.over + u64::from(rest)).max(1);
        *self = Self::new(self.block, self.segments);
        passed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pico::N;
    use crate::pico::words::Words;

    /// Interrupts late by any time, over hours, with a timer that is early or late by 2 us.
    #[test]
    fn blocks_are_counted_by_time_and_parity() {
        for period in [96, 97, 480, 65_536] {
            let length = N as u32;
            let words =
                Words { period, length, iq: false, corrects: true, waveform: None, gate: None };
            let block = u64::from(words.block_cycles());
            for error in [-2i64, 0, 2] {
                let begun = 0xFFFF_0000u32;
                let mut elapsed = Elapsed::new(words.block_cycles(), begun);
                let (mut seen, mut random) = (0u64, 1u64);
                for _ in 0..20_000 {
                    random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    let more = if random >> 62 == 0 { 1 + (random >> 40) % 9 } else { 1 };
                    let total = seen + more;
                    // Anywhere in the block after it.
                    let cycles = total * block + (random >> 20) % block;
                    let micros = (cycles / 48) as i64 + error;
                    let now = begun.wrapping_add(micros as u32);
                    let counted = elapsed.completed(more % 2 == 1, now);
                    assert_eq!(u64::from(counted), more, "{period} {error}");
                    seen = total;
                }
            }
        }
    }

    #[test]
    fn a_doubled_interrupt_counts_nothing() {
        let mut elapsed = Elapsed::new(96 * 1024, 0);
        assert_eq!(elapsed.completed(true, 2050), 1);
        assert_eq!(elapsed.completed(false, 2060), 0);
        assert_eq!(elapsed.completed(true, 4100), 1);
    }

    #[test]
    fn a_block_that_failed_has_not_ended() {
        let mut elapsed = Elapsed::new(96 * 1024, 0);
        assert_eq!((elapsed.ended(900), elapsed.restart(900)), (0, 1));
        assert_eq!((elapsed.ended(900 + 5000), elapsed.restart(900 + 5000)), (2, 1));
    }

    #[test]
    fn a_restart_rounds_up() {
        for (now, passed) in [(0, 1), (1, 1), (2048, 1), (2049, 2), (4096, 2), (20_481, 11)] {
            let mut elapsed = Elapsed::new(96 * 1024, 0);
            assert_eq!(elapsed.restart(now), passed, "{now}");
            assert_eq!(elapsed.completed(true, now + 2049), 1);
        }
    }

    /// Interrupts late by any time, chirps at any distance, pulses in vain, and a gate whose count is off by two microseconds.
    #[test]
    fn pulses_are_counted_with_the_blocks_of_their_chirps() {
        for (segments, period) in [(1u64, 96u32), (2, 96), (3, 97), (3, 960)] {
            let block = u64::from(period) * 1088;
            let mut pulsed = Pulsed::new(block as u32, segments as u32);
            let mut random = 1u64;
            let mut next = |most: u64| {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (random >> 33) % most
            };
            // The real blocks, and all blocks, pulses in vain included.
            let (mut real, mut all) = (0u64, 0u64);
            let (mut seen_real, mut seen) = (0u64, 0u64);
            for _ in 0..10_000 {
                let mut look = |real: u64, all: u64, open, pulsed: &mut Pulsed| {
                    let counted = pulsed.completed((real - seen_real) % 2 == 1, open);
                    assert_eq!(u64::from(counted), all - seen, "{segments} {period} {real}");
                    (seen_real, seen) = (real, all);
                };
                for number in 1..segments {
                    (real, all) = (real + 1, all + 1);
                    // Now and then the count is not read.
                    if next(4) > 0 {
                        let cycles = (number * block + next(block - 200)).saturating_sub(next(96));
                        look(real, all, Some(cycles as u32), &mut pulsed);
                    }
                }
                (real, all) = (real + 1, all + 1);
                let missed = if next(8) == 0 { next(3) } else { 0 };
                if next(4) == 0 {
                    // Before the gate is closed.
                    look(real, all, Some((segments * block - 48) as u32), &mut pulsed);
                    pulsed.close(missed as u32);
                } else {
                    pulsed.close(missed as u32);
                    if next(4) > 0 {
                        look(real, all, None, &mut pulsed);
                    }
                }
                // These pulses are counted with the next chirp.
                all += missed * segments;
            }
            pulsed.miss(2);
            let rest = pulsed.restart(true);
            assert_eq!(u64::from(rest), all - seen + 3 * segments);
            assert_eq!(pulsed, Pulsed::new(block as u32, segments as u32));
        }
    }

    #[test]
    fn nothing_is_counted_before_the_first_pulse() {
        let mut pulsed = Pulsed::new(96 * 1024, 3);
        assert_eq!((pulsed.ended(None), pulsed.completed(false, None)), (0, 0));
        assert_eq!(pulsed.restart(false), 1);
        // A fault in the second block: the rest of the chirp is lost, and a pulse after it.
        assert_eq!(pulsed.completed(true, Some(96 * 1024 + 50)), 1);
        assert_eq!(pulsed.ended(Some(96 * 1500)), 0);
        pulsed.miss(1);
        assert_eq!(pulsed.restart(true), 2 + 3);
    }
}
