//! The sample clock's timer, and the source of a chirp in step with it: the DAC with its table, or
//! the synthesiser.

use super::N;
use super::registers::{dac, dma1, enable, gpiob, spi1, tim2, tim3, tim4, wait};
use super::words::Words;
use super::words::pulses::Look;
use super::words::waveform::{STEPS, SyncOutput, gate_ticks};
use crate::instrument::adf4159::Adf4159;
use crate::instrument::plan::Plan;
use core::sync::atomic::{AtomicBool, AtomicU16, AtomicU32, Ordering};
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use picket_wire::settings::Drive;
use static_cell::ConstStaticCell;
use stm32f4::stm32f446 as pac;

/// Whether TIM2 gates the sample clock; otherwise it marks the chirps.
static GATED: AtomicBool = AtomicBool::new(false);
/// Half a sample's period: TIM3's count where the gate opens, and half of [`Period::ticks`](super::words::sampling::Period::ticks).
static CENTRE: AtomicU16 = AtomicU16::new(0);
static EARLY: AtomicU32 = AtomicU32::new(0);
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
    tim3().psc().write(|w| w.psc().set(period.prescaler));
    tim3().arr().write(|w| w.arr().set(period.reload));
    tim3().cr2().write(|w| w.mms().update());
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
    // SAFETY: the stream reads the table, which nothing changes, and writes the DAC's register.
    unsafe {
        let code = dac().dhr12r1().as_ptr();
        stream.par().write(|w| w.pa().bits(code.expose_provenance() as u32));
        stream.m0ar().write(|w| w.m0a().bits(table.as_ptr().expose_provenance() as u32));
    }
    tim4().arr().write(|w| w.arr().set(hold.saturating_sub(1)));
    tim4().cr2().write(|w| w.mms().update());
    // It counts TIM3 (RM 17.4.3, table 101).
    tim4().smcr().write(|w| w.ts().itr2().sms().ext_clock_mode());
}

/// Lets the DAC hold a code, so that the circuit behind it is never driven by a floating pin.
pub fn rest(code: u16) {
    // Without trigger and request a code appears as soon as it is written. TSEL stays, because it must not change while EN is set.
    dac().cr().write(|w| w.en1().enabled().tsel1().tim4trgo());
    dac().dhr12r1().write(|w| w.daccdhr().set(code.min(4095)));
}

/// Sets up a pulse for each chirp.
fn mark(segments: u16, length: u32) {
    let SyncOutput { reload, compare } = SyncOutput::new(segments, length);
    // It counts TIM3 (RM 17.4.3, table 101).
    tim2().smcr().write(|w| w.ts().itr2().sms().ext_clock_mode());
    tim2().arr().write(|w| w.set(reload));
    tim2().ccr3().write(|w| w.set(compare));
    output(false);
    tim2().ccer().write(|w| w.cc3e().enabled());
}

/// Lets the sync output mark the chirps, or forces it low. When it begins, it stays low until the comparison changes, which is at the
/// first sample.
fn output(marks: bool) {
    tim2().ccmr2_output().write(|w| {
        w.oc3pe().enabled();
        if marks { w.oc3m().pwm_mode1() } else { w.oc3m().force_inactive() }
    });
}

/// Sets up TIM2 as the gate of TIM3: a rise on PB3 (Arduino D3) lets exactly the samples of one chirp through, so the samples synchronise
/// again to each chirp of an external source.
///
/// ```text
/// gate      ____/                               \____   a whole number of periods
/// samples        .   |   |   |   |   |   |   |   .      the first and the last half a period from its edges
/// ```
///
/// TIM3 begins in the middle of its period and is left there, so that a gate which opens or closes some cycles late takes the same samples.
fn gate(ticks: u64) {
    let Some(ticks) = gate_ticks(ticks) else { return };
    let timer = tim2();
    // The gate is open from 1 to the last count.
    timer.arr().write(|w| w.set(ticks));
    timer.ccr1().write(|w| w.set(1));
    // Channel 1 is an output, and channel 2 an input: two views of one register. A rise counts once the pin was high for eight ticks, 89 ns.
    timer.ccmr1_output().write(|w| w.oc1m().pwm_mode2());
    timer.ccmr1_input().modify(|_, w| w.cc2s().ti2().ic2f().fck_int_n8());
    // Each rise captures the count.
    timer.ccer().write(|w| w.cc2e().enabled());
    timer.cr2().write(|w| w.mms().compare_oc1());
    // TIM2 is its input (RM 17.4.3, table 101).
    tim3().smcr().write(|w| w.ts().itr1().sms().gated_mode());
    GATED.store(true, Ordering::Relaxed);
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
    tim3().cnt().write(|w| w.cnt().set(CENTRE.load(Ordering::Relaxed)));
}

/// Stops the sample clock, and with it every timer that counts it.
pub fn stop() {
    tim3().cr1().reset();
    tim4().cr1().reset();
    // A gate that is open counts on, and would let the rest of a chirp through; a pulse would open it.
    if gated() {
        tim2().dier().reset();
        tim2().smcr().reset();
    }
    tim2().cr1().reset();
    if !gated() {
        output(false);
    }
    if LENGTH.load(Ordering::Relaxed) > 0 {
        rest(FIRST.load(Ordering::Relaxed));
    } else {
        dac().cr().reset();
    }
    let control = dma1().st(5).cr();
    control.reset();
    let _ = wait(|| !control.read().en().bit());
}

/// Returns to the start of a chirp. The converters must be off and the DAC at rest, because the events that load the timers' registers
/// trigger both.
pub fn rewind() {
    dma1().hifcr().write(|w| {
        w.ctcif5().clear().chtif5().clear().cteif5().clear().cdmeif5().clear().cfeif5().clear()
    });
    // It is cleared by a one.
    dac().sr().write(|w| w.dmaudr1().set_bit());
    // TIM2 at 0 closes its gate.
    tim2().egr().write(|w| w.ug().update());
    tim3().egr().write(|w| w.ug().update());
    tim4().egr().write(|w| w.ug().update());
    // The counters of samples stand just before their overflow, so that their first period begins with the first sample.
    let reload = tim4().arr().read().arr().bits();
    tim4().cnt().write(|w| w.cnt().set(reload));
    if gated() {
        centre();
    } else {
        let reload = tim2().arr().read().bits();
        tim2().cnt().write(|w| w.set(reload));
    }
}

/// Whether an external source's pulses open a gate.
pub fn gated() -> bool {
    GATED.load(Ordering::Relaxed)
}

/// Whether the gate was open at any time since the last call; without one the samples always pass. The main loop calls this.
pub fn gate_opened() -> bool {
    if !gated() {
        return true;
    }
    // TIF: a pulse came.
    let pulse = tim2().sr().read().tif().bit();
    tim2().sr().write(|w| w.tif().clear());
    pulse || !closed()
}

/// Whether the DAC's table was not read in time. The DAC then requests no more codes (RM 14.3.7).
pub fn underrun() -> bool {
    LENGTH.load(Ordering::Relaxed) > 0 && dac().sr().read().dmaudr1().bit()
}

/// Starts the counters of samples, then the samples.
pub fn run() {
    let length = LENGTH.load(Ordering::Relaxed);
    if length > 0 {
        dac().dhr12r1().write(|w| w.daccdhr().set(FIRST.load(Ordering::Relaxed)));
        let stream = dma1().st(5);
        stream.ndtr().write(|w| w.ndt().set(length));
        stream.cr().write(|w| {
            // Channel 7 is the DAC's first (RM 9.3.4, table 28).
            w.chsel().set(7).pl().high().msize().bits16().psize().bits16();
            w.minc().incremented().circ().enabled().dir().memory_to_peripheral()
        });
        stream.cr().modify(|_, w| w.en().enabled());
        // An underrun does not interrupt: it shows in SR.
        dac()
            .cr()
            .write(|w| w.en1().enabled().ten1().enabled().tsel1().tim4trgo().dmaen1().enabled());
        tim4().cr1().write(|w| w.cen().enabled());
    }
    if !gated() {
        output(true);
        tim2().cr1().write(|w| w.cen().enabled());
    }
    tim3().cr1().write(|w| w.cen().enabled());
    if gated() {
        // The next rise of the source opens the gate.
        tim2().cr1().write(|w| w.opm().enabled());
        tim2().smcr().write(|w| w.ts().ti2fp2().sms().trigger_mode());
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
