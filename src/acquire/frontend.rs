//! Ownership of the converter's buffers: which block may be read, and which blocks were lost.
//!
//! # Signal path
//!
//! ```text
//!            slots with samples            blocks: slot + stamp
//! converter -> DMA -> [`Filler`] (interrupt) -> queue -> [`Blocks`] (main loop) -> pipeline
//!               ^                                              |
//!               +------------ queue of empty slots <-----------+
//! ```
//!
//! **Why ping-pong.** The converter never waits. While the main loop works on one block, the next
//! block needs a slot, so there are at least two slots of `N` samples. The work on a block may take
//! as long as the spare slots last; with one spare slot, that is one block.
//!
//! **Who owns what.** A *slot* is a token for the memory of one block. The board makes it
//! ([`Dma::Slot`]). It is neither `Copy` nor `Clone`, and it is always in exactly one place: with
//! the DMA controller, in one of the two queues, or with the main loop. So no one reads a buffer
//! that is being written, and this file needs no `unsafe`.
//!
//! **Which interrupt.** The interrupt at the end of a block. If software starts every block, it is terminal count (PL081: a timer's
//! interrupt starts the block). If the controller alternates between two slots by itself, it is transfer complete (STM32, double-buffer
//! mode). The interrupt only exchanges slots and counts, so its cost does not depend on the block's length.
//!
//! **What each fault does.** Every block that the converter fills advances the sequence and the sample clock, even if the block is lost.
//! The segments of a chirp follow the sequence, so a loss does not shift them. After any loss, the next delivered block is marked as
//! following a gap.
//!
//! | fault | seen by | consequence |
//! |---|---|---|
//! | main loop too slow | no empty slot | `overruns`: the block is dropped, its slot filled again |
//! | interrupt doubled | no block completed | `spurious`: ignored, no gap |
//! | interrupt lost | several blocks completed | `missed`: all but the last are dropped |
//! | interrupt late | the slot is being filled again | `late`: the block is dropped |
//! | DMA error, ADC overrun | the controller's flags | `broken`: everything filled since the last interrupt is dropped, the chain restarts |
//!
//! The delivered and the dropped blocks add up to the filled ones: [`Counters::filled`].

use super::queue::{put, take};
use super::sample::{Segment, Stamp};
use heapless::spsc::{Consumer, Producer, Queue};

/// The controller's work since the last call.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Status {
    /// Blocks whose last sample was stored: 1 for a punctual interrupt, 0 for a doubled one, more
    /// after lost interrupts.
    ///
    /// A count of samples or timer periods gives the exact number. The flags of an STM32 give 0
    /// without transfer complete. With transfer complete they give 1 if the current target has
    /// changed since the last call, and 2 if it has not.
    pub completed: u32,
    /// A transfer failed and the chain has stopped.
    pub dma_error: bool,
    /// The converter had a sample before the last one was fetched; the chain has stopped.
    pub adc_overrun: bool,
}

/// A DMA controller that fills slots with the converter's samples.
///
/// From construction on, the controller holds the slots it needs: one if software starts every
/// block, two if it alternates by itself. The interrupt calls these methods.
pub trait Dma {
    /// The right to one block of memory. Neither `Copy` nor `Clone`; `&'static mut [i16; N]` will
    /// do.
    type Slot: Send;

    /// The events since the last call. Clears the flags that it reads.
    fn status(&mut self) -> Status;

    /// Returns the slot of the last completed block and takes `empty` to be filled in its place.
    ///
    /// # Errors
    /// Returns `empty`, with nothing changed, if the controller is already filling the completed
    /// slot again. The implementation must check this *after* it has written the new address.
    fn exchange(&mut self, empty: Self::Slot) -> Result<Self::Slot, Self::Slot>;

    /// Clears the faults and starts again at a block's first sample, with the slots it holds.
    ///
    /// Returns the number of block periods between the end of the last block counted in `completed` and the first new sample, rounded up to
    /// whole blocks and at least 1. The sample clock advances by this number.
    fn restart(&mut self) -> u32;
}

/// The timing of successive blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Timing {
    /// Sample periods from a block's first sample to the next block's: the block's length plus the
    /// guard samples, which are dropped.
    pub period: u32,
    /// The segments of the waveform, in order; empty for a continuous wave.
    pub segments: &'static [Segment],
}

impl Timing {
    /// A continuous wave in blocks of `n` samples without a pause.
    pub const fn continuous(n: u32) -> Self {
        Self { period: n, segments: &[] }
    }

    /// The stamp of block `number`, which counts from 0 and never wraps.
    pub fn stamp(&self, number: u64, gap: bool) -> Stamp {
        let phase = number.checked_rem(self.segments.len() as u64).unwrap_or(0);
        Stamp {
            sequence: number as u32,
            clock: number.wrapping_mul(u64::from(self.period)),
            segment: self.segments.get(phase as usize).copied().unwrap_or_default(),
            gap,
        }
    }
}

/// The fates of the blocks. All counts wrap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Blocks delivered.
    pub blocks: u32,
    /// Blocks dropped because the main loop held every spare slot.
    pub overruns: u32,
    /// Blocks dropped because their interrupt was lost.
    pub missed: u32,
    /// Blocks dropped because their interrupt came while the slot was being filled again.
    pub late: u32,
    /// Blocks dropped for a DMA error or an ADC overrun, and blocks that passed during the restart.
    pub broken: u32,
    /// Interrupts without a new block.
    pub spurious: u32,
    /// Transfers that failed.
    pub dma_errors: u32,
    /// The number of times that the converter overran.
    pub adc_overruns: u32,
}

impl Counters {
    /// Blocks dropped for any reason.
    pub fn lost(&self) -> u32 {
        self.overruns.wrapping_add(self.missed).wrapping_add(self.late).wrapping_add(self.broken)
    }

    /// Spurious interrupts, failed transfers and converter overruns.
    pub fn faults(&self) -> u32 {
        self.spurious.wrapping_add(self.dma_errors).wrapping_add(self.adc_overruns)
    }

    /// The counts since the counters stood at `zero`.
    pub fn since(&self, zero: &Self) -> Self {
        Self {
            blocks: self.blocks.wrapping_sub(zero.blocks),
            overruns: self.overruns.wrapping_sub(zero.overruns),
            missed: self.missed.wrapping_sub(zero.missed),
            late: self.late.wrapping_sub(zero.late),
            broken: self.broken.wrapping_sub(zero.broken),
            spurious: self.spurious.wrapping_sub(zero.spurious),
            dma_errors: self.dma_errors.wrapping_sub(zero.dma_errors),
            adc_overruns: self.adc_overruns.wrapping_sub(zero.adc_overruns),
        }
    }

    /// Blocks that the converter filled: the delivered and the lost ones.
    pub fn filled(&self) -> u32 {
        self.blocks.wrapping_add(self.lost())
    }
}

fn count(counter: &mut u32, more: u32) {
    *counter = counter.wrapping_add(more);
}

/// A block of samples. The holder owns it.
#[derive(Debug)]
pub struct Block<S> {
    /// Where and when the block was taken.
    pub stamp: Stamp,
    /// The counters up to this block.
    pub counters: Counters,
    /// The samples.
    pub slot: S,
}

/// The two queues between interrupt and main loop, with room for `M - 1` spare slots each.
pub struct FrontEnd<S, const M: usize> {
    full: Queue<Block<S>, M>,
    empty: Queue<S, M>,
}

/// Without the blocks in it.
impl<S, const M: usize> core::fmt::Debug for FrontEnd<S, M> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("FrontEnd").finish_non_exhaustive()
    }
}

impl<S, const M: usize> Default for FrontEnd<S, M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S, const M: usize> FrontEnd<S, M> {
    /// Empty queues.
    pub const fn new() -> Self {
        Self { full: Queue::new(), empty: Queue::new() }
    }

    /// Splits the front end into the interrupt's half and the main loop's half. `spares` are the
    /// slots that `dma` does not hold: at least one and at most `M - 1`, checked at compile time.
    pub fn split<D: Dma<Slot = S>, const SPARES: usize>(
        &mut self,
        dma: D,
        timing: Timing,
        spares: [S; SPARES],
    ) -> (Filler<'_, D>, Blocks<'_, S>) {
        const { assert!(0 < SPARES && SPARES < M, "M - 1 spare slots at most, at least one") };
        let (full, blocks) = self.full.split();
        let (mut release, empty) = self.empty.split();
        for slot in spares {
            // A slot that found no room would be given up; the queue has room for every spare.
            let _ = put(&mut release, slot);
        }
        let filler = Filler {
            dma,
            timing,
            full,
            empty,
            spare: None,
            number: 0,
            gap: false,
            counters: Counters::default(),
        };
        (filler, Blocks { full: blocks, empty: release })
    }
}

/// The interrupt's half: exchanges full slots for empty ones and keeps count.
pub struct Filler<'a, D: Dma> {
    dma: D,
    timing: Timing,
    full: Producer<'a, Block<D::Slot>>,
    empty: Consumer<'a, D::Slot>,
    /// An empty slot that the controller gave back.
    spare: Option<D::Slot>,
    /// The number of the next block to complete.
    number: u64,
    /// Something was lost since the last delivered block.
    gap: bool,
    counters: Counters,
}

/// Without its slots.
impl<D: Dma> core::fmt::Debug for Filler<'_, D> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Filler")
            .field("timing", &self.timing)
            .field("number", &self.number)
            .field("counters", &self.counters)
            .finish_non_exhaustive()
    }
}

impl<D: Dma> Filler<'_, D> {
    /// Handles the block's interrupt and the fault interrupts; the board calls it from both. Cost:
    /// one exchange, whatever the block's length.
    pub fn interrupt(&mut self) {
        let status = self.dma.status();
        if status.dma_error || status.adc_overrun {
            return self.recover(status);
        }
        match status.completed {
            0 => count(&mut self.counters.spurious, 1),
            completed => {
                let missed = completed - 1;
                count(&mut self.counters.missed, missed);
                self.lose(missed);
                self.deliver();
            }
        }
    }

    /// Starts the chain again without a fault, as after a pause. The blocks that passed are counted
    /// as broken, and the next one follows a gap.
    pub fn restart(&mut self) {
        self.restart_after(0);
    }

    /// The controller, for the board's other uses, such as starting the next block.
    pub fn dma(&mut self) -> &mut D {
        &mut self.dma
    }

    /// The counters so far.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// It is unknown whether a block that completed before the fault is whole, so all of them are dropped.
    fn recover(&mut self, status: Status) {
        count(&mut self.counters.dma_errors, status.dma_error.into());
        count(&mut self.counters.adc_overruns, status.adc_overrun.into());
        self.restart_after(status.completed);
    }

    /// Starts the chain again. The `completed` blocks and the blocks that passed count as broken.
    fn restart_after(&mut self, completed: u32) {
        let broken = completed.saturating_add(self.dma.restart());
        count(&mut self.counters.broken, broken);
        self.lose(broken);
    }

    fn deliver(&mut self) {
        let Some(empty) = self.spare.take().or_else(|| take(&mut self.empty)) else {
            count(&mut self.counters.overruns, 1);
            return self.lose(1);
        };
        match self.dma.exchange(empty) {
            Ok(slot) => self.hand_over(slot),
            Err(empty) => {
                self.spare = Some(empty);
                count(&mut self.counters.late, 1);
                self.lose(1);
            }
        }
    }

    fn hand_over(&mut self, slot: D::Slot) {
        let stamp = self.timing.stamp(self.number, self.gap);
        let mut counters = self.counters;
        count(&mut counters.blocks, 1);
        // There is room: the queue holds as many blocks as there are spare slots.
        match put(&mut self.full, Block { stamp, counters, slot }) {
            Ok(()) => {
                self.counters = counters;
                self.number = self.number.wrapping_add(1);
                self.gap = false;
            }
            Err(block) => {
                self.spare = Some(block.slot);
                count(&mut self.counters.overruns, 1);
                self.lose(1);
            }
        }
    }

    fn lose(&mut self, blocks: u32) {
        self.number = self.number.wrapping_add(blocks.into());
        self.gap |= blocks > 0;
    }
}

/// The main loop's half: takes blocks and gives their slots back.
pub struct Blocks<'a, S> {
    full: Consumer<'a, Block<S>>,
    empty: Producer<'a, S>,
}

/// Without the blocks that wait.
impl<S> core::fmt::Debug for Blocks<'_, S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Blocks").field("waiting", &self.waiting()).finish_non_exhaustive()
    }
}

impl<S> Blocks<'_, S> {
    /// The oldest block, or `None` if no block waits. Give its slot back by [`Blocks::release`].
    pub fn receive(&mut self) -> Option<Block<S>> {
        take(&mut self.full)
    }

    /// Whether a block waits to be received.
    pub fn waiting(&self) -> bool {
        self.full.ready()
    }

    /// Gives a block's slot back to be filled.
    pub fn release(&mut self, slot: S) {
        // There is room: the queue holds every spare slot.
        let _ = put(&mut self.empty, slot);
    }

    /// Runs `work` on the oldest block and gives its slot back; `None` if no block waits.
    pub fn process<T>(&mut self, work: impl FnOnce(&Stamp, &Counters, &S) -> T) -> Option<T> {
        let Block { stamp, counters, slot } = self.receive()?;
        let result = work(&stamp, &counters, &slot);
        self.release(slot);
        Some(result)
    }
}
