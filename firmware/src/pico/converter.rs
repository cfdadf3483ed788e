//! The converter, its FIFO, and two DMA channels that start each other.
//!
//! While one channel fills its slot, the interrupt notes an empty slot for the other one. At the end of a block a further channel reads
//! that note: it gives the other channel its slot and starts it. Without a new note the channel fills its old slot again, so a late
//! interrupt spoils that slot, and nothing else.

use super::chirp::Chirp;
use super::elapsed::{Elapsed, Pulsed};
use super::pulse::Pulse;
use super::registers::{adc, control, dma, enable, failed, put, single, wait};
use super::start::ticks;
use super::words::{BOTH, CHAINED, TURNED, Words};
use super::{N, SLOT, SLOTS, line};
use crate::instrument::plan::Plan;
use crate::progress::Progress;
use crate::shared::{self, Shared};
use core::sync::atomic::{AtomicU32, Ordering};
use picket_dsp::acquire::frontend::{Blocks, Counters, Dma, FrontEnd, Status};
use rp2040_hal::pac::{self, NVIC};
use static_cell::ConstStaticCell;

/// Memory of a block with its guard.
type Memory = [u32; SLOT];
type Slot = crate::slot::Slot<SLOT>;

/// The slot that each of the two channels has next.
static NEXT: [AtomicU32; 2] = [AtomicU32::new(0), AtomicU32::new(0)];

/// The two channels and the slots that they fill.
pub struct Chain {
    held: [Slot; 2],
    words: Words,
    /// The channel that completed last.
    last: bool,
    /// Whether a late exchange has stopped the channels.
    stopped: bool,
    time: Time,
    progress: Progress,
    chirp: Option<Chirp>,
}

/// The way in which blocks follow each other.
enum Time {
    /// Without a pause.
    Free(Elapsed),
    /// By the chirps that the sync input opens; the last field says whether one was open when the samples stopped.
    Pulsed(Pulse, Pulsed, bool),
}

impl Time {
    fn new(plan: &Plan<N>, words: &Words) -> Self {
        let (block, segments) = (words.block_cycles(), plan.settings.segments());
        match words.gate {
            Some(gate) => {
                let pulsed = Pulsed::new(block, segments.into());
                Time::Pulsed(Pulse::new(gate, words), pulsed, false)
            }
            None => Time::Free(Elapsed::new(block, ticks())),
        }
    }

    /// Counts completed blocks, see [`Elapsed::completed`].
    fn completed(&mut self, odd: bool, now: u32) -> u32 {
        match self {
            Time::Free(elapsed) => elapsed.completed(odd, now),
            Time::Pulsed(pulse, pulsed, _) => {
                let open = pulse.look(pulsed);
                pulsed.completed(odd, open)
            }
        }
    }

    /// Counts the blocks before a failure, see [`Elapsed::ended`].
    fn ended(&mut self, now: u32) -> u32 {
        match self {
            Time::Free(elapsed) => elapsed.ended(now),
            Time::Pulsed(pulse, pulsed, _) => {
                let open = pulse.look(pulsed);
                pulsed.ended(open)
            }
        }
    }

    /// Counts the blocks at a restart, see [`Elapsed::restart`]. The samples stand.
    fn restart(&mut self, now: u32) -> u32 {
        match self {
            Time::Free(elapsed) => elapsed.restart(now),
            Time::Pulsed(pulse, pulsed, open) => {
                pulse.look(pulsed);
                pulsed.restart(core::mem::take(open))
            }
        }
    }
}

/// One of two values, by the channel.
const fn of<T: Copy>([one, other]: [T; 2], second: bool) -> T {
    if second { other } else { one }
}

/// Whether a channel works, or waits for requests.
pub fn busy(channel: usize) -> bool {
    dma().ch(channel).ch_ctrl_trig().read().busy().bit_is_set()
}

/// Whether a channel fills its slot, or is about to.
fn fills(second: bool) -> bool {
    // In this order: the turning channel starts the chained one.
    busy(of(TURNED, second)) || busy(of(CHAINED, second))
}

/// Notes the next slot of a channel.
fn note(second: bool, slot: &Slot) {
    of(NEXT.each_ref(), second).store(slot.address(), Ordering::Relaxed);
    // The barrier puts the note into memory, and completes all reads of the slot, before the channel
    // may be started.
    cortex_m::asm::dmb();
}

/// Turns a channel off, so that no other starts it, before it is aborted: an abort may complete it, and start the channel that it names
/// (RP2040-E13).
pub fn off<const CHANNEL: usize>() {
    dma().ch(CHANNEL).ch_al1_ctrl().modify(|_, w| w.en().clear_bit());
}

/// Waits until an aborted channel rests, and forgets its control word.
pub fn rest<const CHANNEL: usize>() {
    let _ = wait(|| !busy(CHANNEL));
    dma().ch(CHANNEL).ch_al1_ctrl().reset();
}

impl Chain {
    /// Stops the converter and both channels.
    fn stop(&mut self) {
        if let Time::Pulsed(pulse, pulsed, open) = &mut self.time {
            *open |= pulse.stop(pulsed);
        }
        // It stays on, and its turns end. It is ready when no conversion is under way.
        adc().cs().write(|w| w.en().set_bit());
        let _ = wait(|| adc().cs().read().ready().bit_is_set());
        // An abort may raise the interrupt (RP2040-E13).
        put!(dma().inte0(), 0);
        off::<{ CHAINED[0] }>();
        off::<{ CHAINED[1] }>();
        off::<{ TURNED[0] }>();
        off::<{ TURNED[1] }>();
        put!(dma().chan_abort(), BOTH | 1 << TURNED[0] | 1 << TURNED[1]);
        rest::<{ CHAINED[0] }>();
        rest::<{ CHAINED[1] }>();
        rest::<{ TURNED[0] }>();
        rest::<{ TURNED[1] }>();
        if let Some(chirp) = &self.chirp {
            chirp.stop();
        }
        // The FIFO has four places.
        for _ in 0..4 {
            let _ = adc().fifo().read().bits();
        }
        put!(dma().ints0(), BOTH);
    }

    /// Starts at the first sample of a block, and of a chirp.
    fn start(&mut self) {
        let [first, second] = &self.held;
        for (second, slot) in [(false, first), (true, second)] {
            let channel = dma().ch(of(CHAINED, second));
            put!(channel.ch_read_addr(), adc().fifo().as_ptr() as u32);
            put!(channel.ch_trans_count(), self.words.transfers());
            // Half words from the converter. The end starts the channel that turns to the other one.
            channel.ch_al1_ctrl().write(|w| {
                let w = control(w, of(TURNED, !second)).high_priority().set_bit();
                w.incr_write().set_bit().data_size().size_halfword().treq_sel().adc()
            });
            let turn = dma().ch(of(TURNED, second));
            put!(
                turn.ch_read_addr(),
                of(NEXT.each_ref(), second).as_ptr().expose_provenance() as u32
            );
            put!(turn.ch_write_addr(), channel.ch_al2_write_addr_trig().as_ptr() as u32);
            put!(turn.ch_trans_count(), 1);
            turn.ch_al1_ctrl().write(|w| single(w, of(TURNED, second)));
            note(second, slot);
        }
        (self.last, self.stopped) = (true, false);
        put!(dma().inte0(), BOTH);
        put!(dma().multi_chan_trigger(), 1 << TURNED[0]);
        put!(adc().div(), self.words.divider());
        adc().fcs().write(|w| {
            w.en().set_bit().dreq_en().set_bit();
            w.over().clear_bit_by_one().under().clear_bit_by_one();
            // SAFETY: the FIFO has places for more than one sample.
            unsafe { w.thresh().bits(1) }
        });
        if let Some(chirp) = &self.chirp {
            chirp.rewind();
        }
        cortex_m::interrupt::free(|_| match &mut self.time {
            Time::Free(time) => {
                *time = Elapsed::new(self.words.block_cycles(), ticks());
                if let Some(chirp) = &self.chirp {
                    chirp.run();
                }
                put!(adc().cs(), self.words.start());
            }
            Time::Pulsed(pulse, ..) => pulse.arm(),
        });
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
            // Of the two, the channel that does not run completed last.
            _ => fills(false),
        };
        let [one, other] = CHAINED;
        let broken = failed(one) || failed(other);
        let completed = match flags {
            _ if broken => self.time.ended(ticks()),
            0 => 0,
            _ => self.time.completed(last != self.last, ticks()),
        };
        self.last = last;
        self.progress.pass(completed);
        let adc_overrun = adc().fcs().read().over().bit_is_set();
        let dma_error = self.stopped || broken;
        Status { completed, dma_error, adc_overrun }
    }

    fn exchange(&mut self, empty: Slot) -> Result<Slot, Slot> {
        let last = self.last;
        if fills(last) {
            return Err(empty);
        }
        note(last, &empty);
        let [first, second] = &mut self.held;
        let place = if last { second } else { first };
        let full = core::mem::replace(place, empty);
        if !fills(last) {
            return Ok(full);
        }
        // The channel has started meanwhile, and its slot is unknown.
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
        self.progress.skip(passed)
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

/// Starts the samples at the start of a chirp; samples that passed since [`pause`] are counted as lost.
pub fn resume() {
    FILLER.with(|filler| {
        filler.restart();
        // Interrupts raised before belong to the old start.
        NVIC::unpend(pac::Interrupt::DMA_IRQ_0);
    });
}

/// Whether the gate was open at any time since the last call; without one the samples always pass.
pub fn gate_opened() -> bool {
    let opened = |time: &mut Time| match time {
        Time::Pulsed(pulse, ..) => pulse.opened(),
        Time::Free(_) => true,
    };
    FILLER.with(|filler| opened(&mut filler.dma().time)).unwrap_or(true)
}

/// The front end's counters so far.
pub fn counters() -> Counters {
    FILLER.counters()
}

/// Sets up the channels and starts the converter. Returns the main loop's end; `None` at the second
/// call.
pub fn start(plan: &Plan<N>, words: &Words) -> Option<Blocks<'static, Slot>> {
    // One cell for all, since each cell has a flag, which is as large as its memory's alignment.
    static MEMORY: ConstStaticCell<[Memory; SLOTS]> = ConstStaticCell::new([[0; SLOT]; SLOTS]);
    static FRONT_END: ConstStaticCell<FrontEnd<Slot, SPARES>> =
        ConstStaticCell::new(FrontEnd::new());
    let mut slots = MEMORY.try_take()?.iter_mut().map(Slot::new);
    let [a, b, c] = [slots.next()?, slots.next()?, slots.next()?];
    let time = Time::new(plan, words);
    let progress = Progress::new(plan.timing.segments.len());
    let chirp = match &words.waveform {
        Some(wave) => Some(Chirp::new(wave)?),
        None => None,
    };
    let (held, words) = ([a, b], *words);
    let chain = Chain { held, words, last: true, stopped: false, time, progress, chirp };
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
    shared::sleep(|| {
        FILLER.with(|filler| {
            if let Time::Pulsed(pulse, ..) = &mut filler.dma().time {
                pulse.watch();
            }
        });
        blocks.is_some_and(Blocks::waiting) || line::waiting()
    });
}
