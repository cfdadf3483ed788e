//! The converters, the sample clock, and the DMA stream that fills two slots in turn.
//!
//! The stream runs by itself (double-buffer mode, RM 9.3.10). While it fills one slot, the
//! interrupt replaces the other slot by an empty one. A write to the address register in use stops
//! the stream with an error, so a late interrupt cannot silently spoil a block.

use super::chirp;
use super::registers::{adc_common, adc1, adc2, dma2, enable, wait};
use super::start::ticks;
use super::words::Words;
use super::words::clock::Tree;
use super::words::passage::{Elapsed, Look, Passage};
use super::words::pulses::Rises;
use super::words::sampling::Sampling;
use super::{N, SLOT, SLOTS};
use crate::instrument::plan::Plan;
use crate::shared::{self, Shared};
use cortex_m::peripheral::NVIC;
use picket_dsp::acquire::frontend::{Blocks, Counters, Dma, FrontEnd, Status, Timing};
use static_cell::ConstStaticCell;
use stm32f4::stm32f446 as pac;

/// The inputs: ADC1's is PA0, Arduino A0, and ADC2's PA1, A1 (DS table 10).
const IN_PHASE: u8 = 0;
const QUADRATURE: u8 = 1;

/// Memory of a block with its guard.
type Memory = [u32; SLOT];
type Slot = crate::slot::Slot<SLOT>;

/// The stream and the two slots that it fills.
pub struct Chain {
    held: [Slot; 2],
    sampling: Sampling,
    /// Whether the converters' clock is a quarter of their bus's, and not half of it.
    quarter: bool,
    /// Samples in a segment.
    length: u32,
    passage: Passage,
    rises: Rises,
}

impl Chain {
    fn target(&self) -> bool {
        dma2().st(0).cr().read().ct().bit()
    }

    /// Stops the stream, the sample clock, and every timer that counts it.
    fn stop(&mut self) {
        chirp::stop();
        self.rises.stop();
        // The converters' requests end with them, so that the next start is like the first.
        adc1().cr2().reset();
        adc2().cr2().reset();
        adc_common().ccr().reset();
        let control = dma2().st(0).cr();
        control.modify(|_, w| w.en().disabled());
        // A transfer in progress ends within a few cycles. If not, the next block shows the error.
        let _ = wait(|| !control.read().en().bit());
        dma2().lifcr().write(|w| {
            w.ctcif0().clear().chtif0().clear().cteif0().clear().cdmeif0().clear().cfeif0().clear()
        });
    }

    /// Starts at the first sample of a chirp.
    fn start(&mut self) {
        chirp::rewind();
        let stream = dma2().st(0);
        let [first, second] = &self.held;
        let Sampling { iq, continuous, .. } = self.sampling;
        let result = if iq { adc_common().cdr().as_ptr() } else { adc1().dr().as_ptr() };
        // SAFETY: the stream reads the converters' result, and writes into slots that it alone has: as many results as fit.
        unsafe {
            stream.par().write(|w| w.pa().bits(result.expose_provenance() as u32));
            stream.m0ar().write(|w| w.m0a().bits(first.address()));
            stream.m1ar().write(|w| w.m1a().bits(second.address()));
        }
        stream.ndtr().write(|w| w.ndt().set(self.length as u16));
        // No FIFO.
        stream.fcr().write(|w| w.dmdis().enabled().fth().quarter());
        stream.cr().write(|w| {
            // Channel 0 is ADC1 (RM 9.3.4, table 29).
            w.chsel().set(0).dbm().enabled().pl().very_high().minc().incremented();
            w.circ().enabled().tcie().enabled().teie().enabled().dmeie().enabled();
            if iq {
                w.msize().bits32().psize().bits32()
            } else {
                w.msize().bits16().psize().bits16()
            }
        });
        // The barrier puts the slots in memory before the stream writes them.
        cortex_m::asm::dmb();
        stream.cr().modify(|_, w| w.en().enabled());
        adc_common().ccr().write(|w| {
            if iq {
                w.multi().dual_r().dma().mode2().dds().continuous();
            }
            if self.quarter { w.adcpre().div4() } else { w.adcpre().div2() }
        });
        self.prepare(adc1(), IN_PHASE);
        if iq {
            self.prepare(adc2(), QUADRATURE);
            // ADC1's trigger drives ADC2.
            adc2().cr2().write(|w| w.adon().enabled().cont().bit(continuous));
        }
        adc1().cr2().write(|w| {
            w.adon().enabled().cont().bit(continuous).dma().bit(!iq).dds().bit(!iq);
            w.extsel().tim3trgo().exten().rising_edge()
        });
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

    /// Prepares a converter for one conversion of an input at a time.
    fn prepare(&self, adc: &pac::adc1::RegisterBlock, input: u8) {
        adc.sr().reset();
        adc.cr1().write(|w| w.ovrie().enabled());
        let time = self.sampling.time;
        adc.smpr2().write(|w| w.smp0().set(time).smp1().set(time));
        // SAFETY: the converter has this input.
        adc.sqr3().write(|w| unsafe { w.sq1().bits(input) });
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
        let flags = dma2().lisr().read();
        let target = self.target();
        let (complete, transfer, mode) =
            (flags.tcif0().bit(), flags.teif0().bit(), flags.dmeif0().bit());
        dma2()
            .lifcr()
            .write(|w| w.ctcif0().bit(complete).cteif0().bit(transfer).cdmeif0().bit(mode));
        let adc_overrun = adc1().sr().read().ovr().bit() || adc2().sr().read().ovr().bit();
        let broken = transfer || mode || chirp::underrun();
        self.passage.status(Look { now, complete, target, broken, adc_overrun })
    }

    fn exchange(&mut self, empty: Slot) -> Result<Slot, Slot> {
        let stream = dma2().st(0);
        let [first, second] = &mut self.held;
        // The barrier completes all reads of the controller's data before the addresses change.
        cortex_m::asm::dmb();
        let seen = self.passage.target();
        // SAFETY: the stream alone has this slot until it is exchanged, and fills as many results as fit.
        let place = unsafe {
            if seen {
                stream.m0ar().write(|w| w.m0a().bits(empty.address()));
                first
            } else {
                stream.m1ar().write(|w| w.m1a().bits(empty.address()));
                second
            }
        };
        let full = core::mem::replace(place, empty);
        if stream.cr().read().ct().bit() == seen {
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
    let timing: Timing = plan.timing;
    let chain = Chain {
        held: [a, b],
        sampling: words.sampling,
        quarter: tree.apb2_hz > 2 * tree.adc_hz,
        length: plan.length,
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
