//! The converter, its FIFO, and two DMA channels that start each other.
//!
//! While one channel fills its slot, the interrupt gives the other one an empty slot. A chained
//! channel starts where its last transfer ended: the ring of its address (`words::chained`) makes that
//! its slot's beginning, so a late interrupt spoils the slot that the channel holds, and nothing else.

use super::registers::{adc, dma, enable, put, wait};
use super::start::ticks;
use super::words::{BLOCK_BYTES, BOTH, CHAINED, ERRORS, Elapsed, FIFO, Words, chained};
use super::{N, SLOT, SLOTS, line};
use crate::instrument::plan::Plan;
use crate::shared::{self, Shared};
use picket::acquire::frontend::{Blocks, Counters, Dma, FrontEnd, Status};
use rp2040_hal::pac::{self, NVIC};
use static_cell::ConstStaticCell;

/// Memory of a block, aligned to the ring of a channel's address.
#[repr(C, align(4096))]
struct Memory([u32; SLOT]);
const _: () =
    assert!(align_of::<Memory>().is_multiple_of(BLOCK_BYTES) && BLOCK_BYTES.is_power_of_two());

type Slot = crate::slot::Slot<SLOT>;

/// The two channels and the slots that they fill.
pub struct Chain {
    held: [Slot; 2],
    words: Words,
    /// The channel that completed last.
    last: bool,
    /// Whether a late exchange has stopped the channels.
    stopped: bool,
    time: Elapsed,
}

/// The number of a channel.
const fn number(second: bool) -> usize {
    if second { CHAINED[1] } else { CHAINED[0] }
}

fn busy(second: bool) -> bool {
    dma().ch(number(second)).ch_ctrl_trig().read().busy().bit_is_set()
}

fn failed(second: bool) -> bool {
    dma().ch(number(second)).ch_ctrl_trig().read().bits() & ERRORS != 0
}

impl Chain {
    /// Stops the converter and both channels.
    fn stop(&mut self) {
        // EN 0 stays, START_MANY 3 ends. READY 8: no conversion is under way.
        put!(adc().cs(), 1);
        let _ = wait(|| adc().cs().read().ready().bit_is_set());
        // An abort may raise the interrupt (RP2040-E13).
        put!(dma().inte0(), 0);
        put!(dma().chan_abort(), BOTH);
        let _ = wait(|| !busy(false) && !busy(true));
        for second in [false, true] {
            put!(dma().ch(number(second)).ch_al1_ctrl(), 0);
        }
        // The FIFO has four places.
        for _ in 0..4 {
            let _ = adc().fifo().read().bits();
        }
        put!(dma().ints0(), BOTH);
    }

    /// Starts at the first sample of a block.
    fn start(&mut self) {
        let [first, second] = &self.held;
        for (second, slot) in [(false, first), (true, second)] {
            let channel = dma().ch(number(second));
            put!(channel.ch_read_addr(), adc().fifo().as_ptr() as u32);
            put!(channel.ch_write_addr(), slot.address());
            put!(channel.ch_trans_count(), N as u32);
            put!(channel.ch_al1_ctrl(), chained(number(!second)));
        }
        (self.last, self.stopped) = (true, false);
        put!(dma().inte0(), BOTH);
        // The barrier puts the slots in memory before a channel writes them.
        cortex_m::asm::dmb();
        put!(dma().multi_chan_trigger(), 1 << CHAINED[0]);
        put!(adc().div(), self.words.divider());
        put!(adc().fcs(), FIFO);
        self.time = Elapsed::new(self.words.block_cycles(), ticks());
        // EN 0, START_MANY 3; AINSEL 14:12 is input 0, GPIO 26.
        put!(adc().cs(), 1 | 1 << 3);
    }
}

impl Dma for Chain {
    type Slot = Slot;

    fn status(&mut self) -> Status {
        let flags = dma().intr().read().bits() & BOTH;
        put!(dma().ints0(), flags);
        let last = match flags {
            0 => self.last,
            1 => false,
            2 => true,
            // Of both, the one that does not run completed last.
            _ => busy(false),
        };
        let broken = failed(false) || failed(true);
        let completed = match flags {
            _ if broken => self.time.ended(ticks()),
            0 => 0,
            _ => self.time.completed(last != self.last, ticks()),
        };
        self.last = last;
        let adc_overrun = adc().fcs().read().over().bit_is_set();
        let dma_error = self.stopped || broken;
        Status { completed, dma_error, adc_overrun }
    }

    fn exchange(&mut self, empty: Slot) -> Result<Slot, Slot> {
        let last = self.last;
        if busy(last) {
            return Err(empty);
        }
        // The barrier completes all reads of the slot before the channel may write it.
        cortex_m::asm::dmb();
        put!(dma().ch(number(last)).ch_write_addr(), empty.address());
        let [first, second] = &mut self.held;
        let place = if last { second } else { first };
        let full = core::mem::replace(place, empty);
        if !busy(last) {
            return Ok(full);
        }
        // The channel has started meanwhile, and with which address is unknown.
        let empty = core::mem::replace(place, full);
        self.stop();
        self.stopped = true;
        NVIC::pend(pac::Interrupt::DMA_IRQ_0);
        Err(empty)
    }

    fn restart(&mut self) -> u32 {
        self.stop();
        let passed = self.time.restart(ticks());
        self.start();
        passed
    }
}

/// Places for the slots that the channels do not hold, and one that a queue leaves empty.
const SPARES: usize = SLOTS - 1;

static FILLER: Shared<Chain> = Shared::new();

/// Handles the interrupt at the end of a block.
pub extern "C" fn filled() {
    FILLER.interrupt();
}

/// Stops the samples until [`resume`].
pub fn pause() {
    FILLER.with(|filler| filler.dma().stop());
}

/// Starts the samples; what passed since [`pause`] is counted as lost.
pub fn resume() {
    FILLER.with(|filler| {
        filler.restart();
        // What was raised before concerns the old start.
        NVIC::unpend(pac::Interrupt::DMA_IRQ_0);
    });
}

/// The front end's counters so far.
pub fn counters() -> Counters {
    FILLER.counters()
}

/// Sets up the channels and starts the converter. Returns the main loop's end; `None` at the second
/// call.
pub fn start(plan: &Plan<N>, words: &Words) -> Option<Blocks<'static, Slot>> {
    // One cell, since each has a flag, which takes as much as its memory's alignment.
    static MEMORY: ConstStaticCell<[Memory; SLOTS]> =
        ConstStaticCell::new([const { Memory([0; SLOT]) }; SLOTS]);
    static FRONT_END: ConstStaticCell<FrontEnd<Slot, SPARES>> =
        ConstStaticCell::new(FrontEnd::new());
    let mut slots = MEMORY.try_take()?.iter_mut().map(|memory| Slot::new(&mut memory.0));
    let [a, b, c] = [slots.next()?, slots.next()?, slots.next()?];
    let time = Elapsed::new(words.block_cycles(), ticks());
    let chain = Chain { held: [a, b], words: *words, last: true, stopped: false, time };
    let (mut filler, mut blocks) = FRONT_END.try_take()?.split(chain, plan.timing, [c]);
    let more = usize::from(plan.settings.slots).saturating_sub(3);
    slots.take(more).for_each(|slot| blocks.release(slot));
    filler.dma().stop();
    filler.dma().start();
    FILLER.set(filler);
    enable(pac::Interrupt::DMA_IRQ_0);
    Some(blocks)
}

/// Sleeps until an interrupt. It returns at once if a block or a byte is waiting.
pub fn sleep(blocks: Option<&Blocks<'static, Slot>>) {
    shared::sleep(|| blocks.is_some_and(Blocks::waiting) || line::waiting());
}
