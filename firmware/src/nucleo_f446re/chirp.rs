//! The sample clock's timer, and the source of a chirp in step with it: the DAC with its table, or
//! the synthesiser.

use super::N;
use super::registers::{dac, dma1, enable, gpiob, put, spi1, tim2, tim3, tim4, wait};
use super::words::Words;
use super::words::pulses::Look;
use super::words::sampling::{TIMER_CR2_UPDATE, TIMER_SMCR_COUNT_TIM3};
use super::words::waveform::{
    DAC_CR, DAC_REST, DAC_SR_UNDERRUN, DAC_STREAM, STEPS, SyncInput, SyncOutput,
};
use crate::instrument::adf4159::Adf4159;
use crate::instrument::plan::Plan;
use core::sync::atomic::{AtomicU16, AtomicU32, Ordering};
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use picket_wire::settings::Drive;
use static_cell::ConstStaticCell;
use stm32f4::stm32f446 as pac;

/// TIM2_CR1 and TIM2_SMCR where TIM2 gates the sample clock, otherwise 0.
static GATE: AtomicU16 = AtomicU16::new(0);
static SLAVE: AtomicU16 = AtomicU16::new(0);
/// Half a sample's period: TIM3's count where the gate opens, and half of [`Period::ticks`](super::words::sampling::Period::ticks).
static CENTRE: AtomicU16 = AtomicU16::new(0);
static EARLY: AtomicU32 = AtomicU32::new(0);
/// TIM2_CCMR2 while the samples run and while they stand, where TIM2 marks the chirps.
static MARK: AtomicU16 = AtomicU16::new(0);
static REST: AtomicU16 = AtomicU16::new(0);
/// The DAC's first code, and the steps of its table; 0 steps if the DAC does not play.
static FIRST: AtomicU16 = AtomicU16::new(0);
static LENGTH: AtomicU16 = AtomicU16::new(0);

/// The memory of the DAC's table; `None` at the second call.
pub fn table() -> Option<&'static mut [u16; STEPS]> {
    static TABLE: ConstStaticCell<[u16; STEPS]> = ConstStaticCell::new([0; STEPS]);
    TABLE.try_take()
}

/// Sets up the timers and the source of the chirp; [`run`] starts them. Returns false if the
/// synthesiser does not respond on its bus.
pub fn set_up(plan: &Plan<N>, words: &Words) -> bool {
    let period = words.sampling.period;
    put!(tim3().psc(), u32::from(period.prescaler));
    put!(tim3().arr(), u32::from(period.reload));
    put!(tim3().cr2(), TIMER_CR2_UPDATE);
    let segments = plan.settings.segments();
    if plan.settings.drive == Drive::External {
        let chirp = u64::from(plan.length) * u64::from(segments);
        CENTRE.store(period.reload.div_ceil(2), Ordering::Relaxed);
        EARLY.store(period.ticks() / 2, Ordering::Relaxed);
        gate(chirp * u64::from(period.ticks()));
    } else {
        mark(segments, plan.length);
    }
    if let Some(wave) = &words.waveform
        && let Some(table) = table()
    {
        play(wave.code(0), wave.fill(table), wave.hold);
    }
    match &words.synthesiser {
        Some(ramps) => Adf4159::new(Bus::new(), Enable).start(ramps).is_ok(),
        None => true,
    }
}

/// Sets up the DAC: a first code, then the codes of a table round and round, each for `hold` samples. The table's last code is the first
/// one.
pub fn play(first: u16, table: &'static [u16], hold: u16) {
    FIRST.store(first, Ordering::Relaxed);
    LENGTH.store(table.len() as u16, Ordering::Relaxed);
    let stream = dma1().st(5);
    // DAC_DHR12R1 (RM 14.5.3).
    put!(stream.par(), 0x4000_7408);
    put!(stream.m0ar(), table.as_ptr().expose_provenance() as u32);
    put!(tim4().arr(), u32::from(hold.saturating_sub(1)));
    put!(tim4().cr2(), TIMER_CR2_UPDATE);
    put!(tim4().smcr(), TIMER_SMCR_COUNT_TIM3);
}

/// Lets the DAC hold a code, so that the circuit behind it is never driven by a floating pin.
pub fn rest(code: u16) {
    put!(dac().cr(), DAC_REST);
    put!(dac().dhr12r1(), u32::from(code.min(4095)));
}

/// Sets up a pulse for each chirp.
fn mark(segments: u16, length: u32) {
    let SyncOutput { reload, compare, mode, rest, enable } = SyncOutput::new(segments, length);
    MARK.store(mode as u16, Ordering::Relaxed);
    REST.store(rest as u16, Ordering::Relaxed);
    put!(tim2().smcr(), TIMER_SMCR_COUNT_TIM3);
    put!(tim2().arr(), reload);
    put!(tim2().ccr3(), compare);
    put!(tim2().ccmr2_output(), rest);
    put!(tim2().ccer(), enable);
}

/// Sets up the gate: a pulse from an external source opens the sample clock for one chirp.
fn gate(ticks: u64) {
    let Some(input) = SyncInput::new(ticks) else { return };
    put!(tim2().arr(), input.reload);
    put!(tim2().ccr1(), input.compare);
    put!(tim2().ccmr1_output(), input.mode);
    put!(tim2().ccer(), input.enable);
    put!(tim2().cr2(), input.control2);
    put!(tim3().smcr(), input.gate);
    GATE.store(input.control as u16, Ordering::Relaxed);
    SLAVE.store(input.slave as u16, Ordering::Relaxed);
    enable(pac::Interrupt::TIM2);
}

/// What the sync input shows since the last call; its flags are cleared.
pub fn rises() -> Look {
    let timer = tim2();
    let flags = timer.sr().read();
    let early = timer.ccr2().read().bits() < EARLY.load(Ordering::Relaxed);
    let more = flags.cc2of().bit();
    let rises = if flags.cc2if().bit() { 1 + u32::from(more) } else { 0 };
    let closed = flags.uif().bit();
    // The flags that were seen are cleared by zeros (RM 17.4.5); the others get ones.
    timer.sr().modify(|_, w| {
        if closed {
            w.uif().clear_bit();
        }
        if rises > 0 {
            w.cc2if().clear_bit();
        }
        if more {
            w.cc2of().clear_bit();
        }
        w
    });
    Look { rises, early, closed }
}

/// Whether the next rise interrupts. The gate's close does in any case.
pub fn listen(rises: bool) {
    tim2().dier().write(|w| w.uie().set_bit().cc2ie().bit(rises));
}

/// Whether the gate is closed.
pub fn closed() -> bool {
    tim2().cr1().read().cen().bit_is_clear()
}

/// Puts the sample clock in the middle of its period, from where it begins with the next chirp.
pub fn centre() {
    put!(tim3().cnt(), CENTRE.load(Ordering::Relaxed));
}

/// Stops the sample clock, and with it every timer that counts it.
pub fn stop() {
    for timer in [tim3(), tim4()] {
        put!(timer.cr1(), 0);
    }
    // A gate that is open counts on, and would let the rest of a chirp through; a pulse would open it.
    if gated() {
        put!(tim2().dier(), 0);
        put!(tim2().smcr(), 0);
    }
    put!(tim2().cr1(), 0);
    if !gated() {
        put!(tim2().ccmr2_output(), REST.load(Ordering::Relaxed));
    }
    if LENGTH.load(Ordering::Relaxed) > 0 {
        rest(FIRST.load(Ordering::Relaxed));
    } else {
        put!(dac().cr(), 0);
    }
    put!(dma1().st(5).cr(), 0);
    let _ = wait(|| dma1().st(5).cr().read().bits() & 1 == 0);
}

/// Returns to the start of a chirp. The converters must be off and the DAC at rest, because the events that load the timers' registers
/// trigger both.
pub fn rewind() {
    // HIFCR, stream 5's flags: 11:6.
    put!(dma1().hifcr(), 0x3D << 6);
    put!(dac().sr(), DAC_SR_UNDERRUN);
    // TIM2 at 0 closes its gate.
    put!(tim2().egr(), 1);
    for timer in [tim3(), tim4()] {
        put!(timer.egr(), 1);
    }
    // The counters of samples stand just before their overflow, so that their first period begins with the first sample.
    let reload = tim4().arr().read().bits();
    put!(tim4().cnt(), reload);
    if gated() {
        centre();
    } else {
        let reload = tim2().arr().read().bits();
        put!(tim2().cnt(), reload);
    }
}

/// Whether an external source's pulses open a gate.
pub fn gated() -> bool {
    GATE.load(Ordering::Relaxed) != 0
}

/// Whether the gate was open at any time since the last call; without one the samples always pass. The main loop calls this.
pub fn gate_opened() -> bool {
    if !gated() {
        return true;
    }
    // TIF 6: a pulse came; it is cleared by a zero (RM 17.4.5). CEN 0: the gate is open.
    let pulse = tim2().sr().read().bits() & 1 << 6 != 0;
    put!(tim2().sr(), !(1 << 6));
    pulse || tim2().cr1().read().bits() & 1 != 0
}

/// Whether the DAC's table was not read in time. The DAC then requests no more codes (RM 14.3.7).
pub fn underrun() -> bool {
    LENGTH.load(Ordering::Relaxed) > 0 && dac().sr().read().bits() & DAC_SR_UNDERRUN != 0
}

/// Starts the counters of samples, then the samples.
pub fn run() {
    let length = LENGTH.load(Ordering::Relaxed);
    if length > 0 {
        put!(dac().dhr12r1(), u32::from(FIRST.load(Ordering::Relaxed)));
        put!(dma1().st(5).ndtr(), u32::from(length));
        put!(dma1().st(5).cr(), DAC_STREAM);
        put!(dma1().st(5).cr(), DAC_STREAM | 1);
        put!(dac().cr(), DAC_CR);
        put!(tim4().cr1(), 1);
    }
    if !gated() {
        put!(tim2().ccmr2_output(), MARK.load(Ordering::Relaxed));
        put!(tim2().cr1(), 1);
    }
    put!(tim3().cr1(), 1);
    if gated() {
        // The next rise of the source opens the gate.
        put!(tim2().cr1(), GATE.load(Ordering::Relaxed));
        put!(tim2().smcr(), SLAVE.load(Ordering::Relaxed));
        listen(true);
    }
}

/// SPI1 with the synthesiser's LE as chip select.
struct Bus;

impl Bus {
    fn new() -> Self {
        gpiob().bsrr().write(|w| w.bs6().set_());
        // A sixteenth of the bus, 5.6 MHz at most; mode 0.
        spi1().cr1().write(|w| {
            w.ssm().enabled().ssi().slave_not_selected().br().div16().mstr().master();
            w.spe().enabled()
        });
        Bus
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), spi::ErrorKind> {
        for &byte in bytes {
            if !wait(|| spi1().sr().read().txe().bit()) {
                return Err(spi::ErrorKind::Other);
            }
            spi1().dr().write(|w| w.set(byte.into()));
        }
        // Then the last bit is out.
        let idle = |flags: pac::spi1::sr::R| flags.txe().bit() && !flags.bsy().bit();
        let done = wait(|| idle(spi1().sr().read()));
        done.then_some(()).ok_or(spi::ErrorKind::Other)
    }
}

impl spi::ErrorType for Bus {
    type Error = spi::ErrorKind;
}

impl SpiDevice for Bus {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        gpiob().bsrr().write(|w| w.br6().reset());
        let done = operations.iter().try_for_each(|operation| match operation {
            Operation::Write(bytes) => self.send(bytes),
            // The chip never answers.
            _ => Err(spi::ErrorKind::Other),
        });
        gpiob().bsrr().write(|w| w.bs6().set_());
        done
    }
}

/// The synthesiser's CE pin.
struct Enable;

impl digital::ErrorType for Enable {
    type Error = core::convert::Infallible;
}

impl OutputPin for Enable {
    fn set_low(&mut self) -> Result<(), Self::Error> {
        gpiob().bsrr().write(|w| w.br5().reset());
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Self::Error> {
        gpiob().bsrr().write(|w| w.bs5().set_());
        Ok(())
    }
}
