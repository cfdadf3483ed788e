//! The converters, the sample clock, and the DMA stream that fills two slots in turn.
//!
//! The stream runs by itself (double-buffer mode, RM 9.3.10). While it fills one slot, the
//! interrupt replaces the other slot by an empty one. A write to the address register in use stops
//! the stream with an error, so a late interrupt cannot silently spoil a block.

use super::chirp;
use super::registers::{adc_common, adc1, adc2, clear, dma2, enable, put, wait};
use super::start::ticks;
use super::words::Words;
use super::words::clock::Tree;
use super::words::passage::{Elapsed, Look, Passage};
use super::words::pulses::Rises;
use super::words::sampling::{ADC_SR_OVR, ConverterWords, STREAM_0_FLAGS, STREAM_CT, STREAM_EN};
use super::{N, SLOT, SLOTS};
use crate::instrument::plan::Plan;
use crate::shared::{self, Shared};
use cortex_m::peripheral::NVIC;
use picket_dsp::acquire::frontend::{Blocks, Counters, Dma, FrontEnd, Status, Timing};
use static_cell::ConstStaticCell;
use stm32f4::stm32f446 as pac;

/// Memory of a block with its guard.
type Memory = [u32; SLOT];
type Slot = crate::slot::Slot<SLOT>;

/// The stream and the two slots that it fills.
pub struct Chain {
    held: [Slot; 2],
    /// The words of the stream and of the converters, and the length of a segment in samples.
    control: u32,
    converter: ConverterWords,
    length: u32,
    iq: bool,
    passage: Passage,
    rises: Rises,
}

impl Chain {
    fn target(&self) -> bool {
        dma2().st(0).cr().read().bits() & STREAM_CT != 0
    }

    /// Stops the stream, the sample clock, and every timer that counts it.
    fn stop(&mut self) {
        chirp::stop();
        self.rises.stop();
        // The converters' requests end with them, so that the next start is like the first.
        put!(adc1().cr2(), 0);
        put!(adc2().cr2(), 0);
        put!(adc_common().ccr(), 0);
        clear!(dma2().st(0).cr(), STREAM_EN);
        // A transfer in progress ends within a few cycles. If not, the next block shows the error.
        let _ = wait(|| dma2().st(0).cr().read().bits() & STREAM_EN == 0);
        put!(dma2().lifcr(), STREAM_0_FLAGS);
    }

    /// Starts at the first sample of a chirp.
    fn start(&mut self) {
        chirp::rewind();
        let stream = dma2().st(0);
        let (
            ConverterWords { common, cr1, cr2, second_cr2, smpr2, sqr3, second_sqr3 },
            [first, second],
        ) = (self.converter, &self.held);
        // ADC_DR at 0x4C, ADC_CDR at 0x308 (RM 13.13.14, 13.13.17).
        put!(stream.par(), if self.iq { 0x4001_2308 } else { 0x4001_204C });
        put!(stream.m0ar(), first.address());
        put!(stream.m1ar(), second.address());
        put!(stream.ndtr(), self.length as u16 as u32);
        // Direct mode: no FIFO.
        put!(stream.fcr(), 0);
        put!(stream.cr(), self.control);
        // The barrier puts the slots in memory before the stream writes them.
        cortex_m::asm::dmb();
        put!(stream.cr(), self.control | STREAM_EN);
        put!(adc_common().ccr(), common);
        put!(adc1().sr(), 0);
        put!(adc1().cr1(), cr1);
        put!(adc1().smpr2(), smpr2);
        put!(adc1().sqr3(), sqr3);
        if self.iq {
            put!(adc2().sr(), 0);
            put!(adc2().cr1(), cr1);
            put!(adc2().smpr2(), smpr2);
            put!(adc2().sqr3(), second_sqr3);
            put!(adc2().cr2(), second_cr2);
        }
        put!(adc1().cr2(), cr2);
        // The converters settle in 3 us (DS 6.3.20): 540 cycles at most.
        cortex_m::asm::delay(600);
        if chirp::gated() {
            // Rises that came while the samples stood.
            self.rises.see(chirp::rises());
            let vain = self.rises.arm();
            self.passage.miss(vain);
        }
        chirp::run();
        self.passage.begin(ticks());
    }

    /// Follows the sync input. Returns whether a chirp lacks samples.
    fn pulsed(&mut self) -> bool {
        let look = chirp::rises();
        let within = self.rises.open() && !look.closed;
        let vain = self.rises.see(look);
        self.passage.miss(vain);
        // One rise in vain interrupts a chirp, no matter how many come: the others are seen at its end.
        chirp::listen(!within);
        if !look.closed || self.rises.open() {
            return false;
        }
        // The last result comes within a conversion: 22 us, or half a period if that is less.
        let whole = || dma2().st(0).ndtr().read().bits() == self.length || !chirp::closed();
        let short = !(0..1_000).any(|_| whole());
        if chirp::closed() {
            chirp::centre();
        }
        if short {
            self.passage.stop();
        }
        short
    }
}

impl Dma for Chain {
    type Slot = Slot;

    fn status(&mut self) -> Status {
        // The order matters, see `Look`.
        let now = ticks();
        let flags = dma2().lisr().read().bits() & STREAM_0_FLAGS;
        let target = self.target();
        put!(dma2().lifcr(), flags);
        let adc_overrun = (adc1().sr().read().bits() | adc2().sr().read().bits()) & ADC_SR_OVR != 0;
        self.passage.status(Look { now, flags, target, adc_overrun, underrun: chirp::underrun() })
    }

    fn exchange(&mut self, empty: Slot) -> Result<Slot, Slot> {
        let stream = dma2().st(0);
        let [first, second] = &mut self.held;
        // The barrier completes all reads of the controller's data before the addresses change.
        cortex_m::asm::dmb();
        let seen = self.passage.target();
        let place = if seen {
            put!(stream.m0ar(), empty.address());
            first
        } else {
            put!(stream.m1ar(), empty.address());
            second
        };
        let full = core::mem::replace(place, empty);
        if (dma2().st(0).cr().read().bits() & STREAM_CT != 0) == seen {
            return Ok(full);
        }
        // The stream has meanwhile turned to this slot, and the address in use is unknown.
        let empty = core::mem::replace(place, full);
        self.stop();
        self.passage.stop();
        NVIC::pend(pac::Interrupt::DMA2_STREAM0);
        Err(empty)
    }

    fn restart(&mut self) -> u32 {
        self.stop();
        let late = self.passage.late(ticks());
        self.start();
        self.passage.skip(late)
    }
}

/// Places for the slots that the stream does not hold, and one that a queue leaves empty.
const SPARES: usize = SLOTS - 1;

static FILLER: Shared<Chain> = Shared::new();

/// Handles the interrupt at the end of a block, and every fault interrupt.
pub extern "C" fn filled() {
    FILLER.interrupt();
}

/// Handles the interrupt of the sync input. A chirp that lacks samples is a fault of the stream.
pub extern "C" fn pulsed() {
    if FILLER.with(|filler| filler.dma().pulsed()) == Some(true) {
        NVIC::pend(pac::Interrupt::DMA2_STREAM0);
    }
}

/// Stops the samples until [`resume`].
pub fn pause() {
    FILLER.with(|filler| filler.dma().stop());
}

/// Starts at the first sample of a chirp; samples that passed since [`pause`] are counted as lost.
pub fn resume() {
    FILLER.with(|filler| {
        filler.restart();
        // Interrupts raised before belong to the old start.
        NVIC::unpend(pac::Interrupt::DMA2_STREAM0);
        NVIC::unpend(pac::Interrupt::ADC);
    });
}

/// The front end's counters so far.
pub fn counters() -> Counters {
    FILLER.counters()
}

/// Sets up converters and stream, and starts them. Returns the main loop's end; `None` at the
/// second call.
#[inline(never)] // once in an image, not for the self-test, too
pub fn start(plan: &Plan<N>, words: &Words, tree: &Tree) -> Option<Blocks<'static, Slot>> {
    static MEMORY: [ConstStaticCell<Memory>; SLOTS] =
        [const { ConstStaticCell::new([0; SLOT]) }; SLOTS];
    // A queue with this number of places holds one item less.
    static FRONT_END: ConstStaticCell<FrontEnd<Slot, SPARES>> =
        ConstStaticCell::new(FrontEnd::new());
    let mut slots = MEMORY.iter().filter_map(|cell| cell.try_take().map(Slot::new));
    let [a, b, c] = [slots.next()?, slots.next()?, slots.next()?];
    let sampling = &words.sampling;
    let timing: Timing = plan.timing;
    let chain = Chain {
        held: [a, b],
        control: sampling.stream().control,
        converter: sampling.converter(tree),
        length: plan.length,
        iq: sampling.iq,
        rises: Rises::default(),
        passage: Passage::new(
            timing.segments.len(),
            // A host that plays the stream plays it at its own pace.
            Elapsed::new(words.block_ticks.filter(|_| !cfg!(feature = "played"))),
        ),
    };
    let (mut filler, mut blocks) = FRONT_END.try_take()?.split(chain, timing, [c]);
    let more = usize::from(plan.settings.slots).saturating_sub(3);
    slots.take(more).for_each(|slot| blocks.release(slot));
    chirp::set_up(plan, words);
    filler.dma().stop();
    filler.dma().start();
    FILLER.set(filler);
    enable(pac::Interrupt::DMA2_STREAM0);
    enable(pac::Interrupt::ADC);
    Some(blocks)
}

/// Sleeps until an interrupt. It returns at once if a block or a byte is waiting.
pub fn sleep(blocks: Option<&Blocks<'static, Slot>>) {
    shared::sleep(|| blocks.is_some_and(Blocks::waiting) || super::serial::waiting());
}
