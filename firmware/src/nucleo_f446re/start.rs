//! From reset to running clock, pins and watchdog.

use super::gauge;
use super::registers::{enable, flash, gpioa, gpiob, iwdg, pwr, rcc, syscfg, tim5, wait};
use super::words::clock::{HSI_HZ, Multiplier, Source, Speed, Tree};
use super::words::guard::{self, WATCHDOG};
use crate::instrument::fault;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use picket_wire::boot::{Causes, LastEnd};
use stm32f4::stm32f446 as pac;

/// The causes of the chip's reset. Clears the flags.
pub fn causes() -> Causes {
    let causes = guard::causes(rcc().csr().read().bits());
    rcc().csr().modify(|_, w| w.rmvf().clear());
    causes
}

/// Starts the clock at this speed from the best source available.
pub fn clock(speed: Speed) -> Tree {
    for source in [Source::HsePll, Source::HsiPll] {
        let tree = Tree::new(speed, source);
        if multiplied(&tree) {
            return tree;
        }
        back();
    }
    Tree::new(speed, Source::Hsi)
}

/// Tries a tree with the multiplier.
fn multiplied(tree: &Tree) -> bool {
    let Some(Multiplier { divider, factor }) = tree.pll else { return false };
    let (rcc, pwr) = (rcc(), pwr());
    let external = tree.source == Source::HsePll;
    // The probe drives the pin. HSI is on after reset.
    if external {
        rcc.cr().modify(|_, w| w.hsebyp().bypassed().hseon().on());
        if !wait(|| rcc.cr().read().hserdy().is_ready()) || !gauge::crystal(HSI_HZ) {
            return false;
        }
    }
    rcc.apb1enr().modify(|_, w| w.pwren().enabled());
    // Flash is not read ahead after a reset.
    pwr.cr().modify(|_, w| w.vos().scale1().adcdc1().bit(Quiet::USED == Quiet::First));
    rcc.pllcfgr().write(|w| {
        // PLLQ and PLLR serve nothing.
        // SAFETY: the numbers fit their fields, and are in their ranges (RM 6.3.2).
        unsafe { w.pllm().bits(divider).plln().bits(factor).pllq().bits(8).pllr().bits(2) };
        w.pllp().div2().pllsrc().bit(external)
    });
    rcc.cr().modify(|_, w| w.pllon().on());
    if !wait(|| rcc.cr().read().pllrdy().is_ready()) {
        return false;
    }
    // RM 5.1.4.
    if tree.over_drive {
        pwr.cr().modify(|_, w| w.oden().set_bit());
        if !wait(|| pwr.csr().read().odrdy().bit()) {
            return false;
        }
        pwr.cr().modify(|_, w| w.odswen().set_bit());
        if !wait(|| pwr.csr().read().odswrdy().bit()) {
            return false;
        }
    }
    // The wait states come before the speed (RM 3.4.1), and are read back as it demands.
    access(tree);
    if !wait(|| flash().acr().read().latency().bits() == tree.wait_states) {
        return false;
    }
    // The buses are divided by 16 while the speed changes, as in ST's own code.
    rcc.cfgr().write(|w| w.ppre1().div16().ppre2().div16());
    rcc.cfgr().modify(|_, w| w.sw().pll());
    if !wait(|| rcc.cfgr().read().sws().is_pll()) {
        return false;
    }
    rcc.cfgr().modify(|_, w| w.ppre1().div4().ppre2().div2());
    if external {
        // If the crystal's clock fails, the chip goes on by its own clock and raises an NMI.
        rcc.cr().modify(|_, w| w.csson().on());
    }
    true
}

/// Sets the flash's wait states, with both caches on.
fn access(tree: &Tree) {
    flash().acr().write(|w| {
        w.latency().set(tree.wait_states).prften().bit(Quiet::USED == Quiet::Ahead);
        w.icen().enabled().dcen().enabled()
    });
}

/// A measure against the noise that the chip's flash puts on the converters' results (errata ES0298, "Internal noise impacting the ADC
/// accuracy"; application note AN4073). The self-test measures the noise with each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quiet {
    /// No measure: flash is read ahead of the program.
    Ahead,
    /// Flash is read when the program needs it, and both caches stay on.
    Still,
    /// Flash without read-ahead, and ADCDC1, which requires it (RM 5.4.1).
    First,
    /// Flash without read-ahead, and ADC1DC2 with ADC2DC2 in place of ADCDC1: for converters of 30 MHz or more that sample simultaneously
    /// (RM 8.2.3).
    Second,
}

impl Quiet {
    /// The measure that the images use.
    pub const USED: Self = Quiet::First;
}

/// Takes a measure against the chip's noise, in place of the one before.
pub fn quiet(quiet: Quiet) {
    // Bits that exclude the new bits are cleared first, and bits that require flash without read-ahead are set last.
    pwr().cr().modify(|_, w| w.adcdc1().clear_bit());
    syscfg().pmc().reset();
    flash().acr().modify(|_, w| w.prften().bit(quiet == Quiet::Ahead));
    pwr().cr().modify(|_, w| w.adcdc1().bit(quiet == Quiet::First));
    let second = quiet == Quiet::Second;
    syscfg().pmc().write(|w| w.adc1dc2().bit(second).adc2dc2().bit(second));
}

/// Handles the failure of the crystal's clock (RM 6.2.7): the board restarts, by its own clock if
/// the other is still missing.
// SAFETY: cortex-m-rt's vector table has the handler under this name.
#[unsafe(no_mangle)]
extern "C" fn NonMaskableInt() {
    rcc().cir().modify(|_, w| w.cssc().clear());
    fault::end(LastEnd { kind: 3, pc: 0, more: [0; 2] })
}

/// Returns to the internal oscillator, from which the chip starts.
fn back() {
    rcc().cfgr().reset();
    // The result does not matter: if the switch failed, the next attempt fails, too.
    let _ = wait(|| rcc().cfgr().read().sws().is_hsi());
    rcc().cr().modify(|_, w| w.pllon().off().csson().off().hsebyp().not_bypassed().hseon().off());
    pwr().cr().modify(|_, w| w.odswen().clear_bit().oden().clear_bit());
    access(&Tree::new(Speed::Mhz144, Source::Hsi));
}

/// Looks, once a second of a board that runs by its internal oscillator, whether the probe's clock is there and right. True at the second
/// time in a row: a restart would use it.
pub fn returned(tree: &Tree) -> bool {
    static LAST: AtomicU32 = AtomicU32::new(0);
    static SEEN: AtomicBool = AtomicBool::new(false);
    let now = ticks();
    if tree.source == Source::HsePll || now.wrapping_sub(LAST.load(Relaxed)) < tree.timer_hz {
        return false;
    }
    LAST.store(now, Relaxed);
    let cr = rcc().cr();
    let right = cr.read().hserdy().is_ready() && gauge::crystal(tree.core_hz);
    if !right {
        // Asked for anew: a clock that failed does not become ready by itself.
        cr.modify(|_, w| w.hseon().off());
        cr.modify(|_, w| w.hsebyp().bypassed().hseon().on());
    }
    SEEN.swap(right, Relaxed) && right
}

/// Starts the peripherals' clocks.
pub fn buses() {
    rcc().ahb1enr().modify(|_, w| {
        w.gpioaen().enabled().gpioben().enabled().dma1en().enabled().dma2en().enabled()
    });
    rcc().apb1enr().modify(|_, w| {
        w.tim2en().enabled().tim3en().enabled().tim4en().enabled().tim5en().enabled();
        w.usart2en().enabled().pwren().enabled().dacen().enabled()
    });
    rcc().apb2enr().modify(|_, w| {
        w.adc1en().enabled().adc2en().enabled().spi1en().enabled().syscfgen().enabled()
    });
}

/// Starts the pins, over their reset values, and TIM5, which never stops.
///
/// | pin | Arduino | use |
/// |---|---|---|
/// | PA0, PA1 | A0, A1 | the converters' inputs: in phase, quadrature |
/// | PA2, PA3 | - | USART2 to the probe, AF7 (DS table 11); the receiver rests high |
/// | PA4 | A2 | DAC: the chirp |
/// | PA5, PA7 | D13, D11 | SPI1 to a synthesiser, AF5: clock, data |
/// | PB6, PB5 | D10, D4 | the synthesiser's LE and CE |
/// | PB10 | D6 | sync output, TIM2's channel 3, AF1 |
/// | PB3 | D3 | sync input, TIM2's channel 2, AF1, which rests low |
pub fn pins(tree: &Tree) {
    let (a, b) = (gpioa(), gpiob());
    a.afrl().write(|w| w.afrl2().af7().afrl3().af7().afrl5().af5().afrl7().af5());
    a.ospeedr().write(|w| {
        // The debugger's pin 13 has its reset value (RM 7.4.3), which the crate does not know.
        w.ospeedr2().high_speed().ospeedr3().high_speed().ospeedr5().high_speed();
        w.ospeedr7().high_speed().ospeedr13().very_high_speed()
    });
    a.pupdr().write(|w| w.pupdr3().pull_up());
    a.moder().write(|w| {
        w.moder0().analog().moder1().analog().moder4().analog();
        w.moder2().alternate().moder3().alternate().moder5().alternate().moder7().alternate()
    });
    b.afrl().write(|w| w.afrl3().af1());
    b.afrh().write(|w| w.afrh10().af1());
    b.ospeedr().write(|w| w.ospeedr10().high_speed());
    b.pupdr().write(|w| w.pupdr3().pull_down());
    b.moder().write(|w| {
        w.moder3().alternate().moder10().alternate().moder5().output().moder6().output()
    });
    tim5().arr().write(|w| w.set(u32::MAX));
    // It loads the reload value.
    tim5().egr().write(|w| w.ug().update());
    WAKE.store(tree.timer_hz / WAKES_A_SECOND, Relaxed);
    next();
    tim5().dier().write(|w| w.cc1ie().enabled());
    gauge::capture();
    enable(pac::Interrupt::TIM5);
    tim5().cr1().write(|w| w.cen().enabled());
}

/// The rate at which the core wakes where nothing else wakes it. The loop then feeds the watchdog, if it makes progress.
const WAKES_A_SECOND: u32 = 10;

/// Ticks between two wakes.
static WAKE: AtomicU32 = AtomicU32::new(0);

/// Handles TIM5's interrupt, which wakes the core and watches the clock.
pub extern "C" fn wake() {
    if tim5().sr().read().cc1if().bit() {
        next();
        gauge::look();
    }
    if gauge::changed(WAKES_A_SECOND * WAKE.load(Relaxed)) {
        fault::end(LastEnd { kind: 3, pc: 0, more: [0; 2] })
    }
}

/// Sets the next wake.
fn next() {
    tim5().ccr1().write(|w| w.set(ticks().wrapping_add(WAKE.load(Relaxed))));
    tim5().sr().write(|w| w.cc1if().clear());
}

/// Waits until `ready`, for at most this many milliseconds by TIM5, and looks once more at the end; false if it gave up.
#[must_use]
pub fn within(milliseconds: u32, mut ready: impl FnMut() -> bool) -> bool {
    let begun = ticks();
    let patience = WAKE.load(Relaxed) / (1000 / WAKES_A_SECOND) * milliseconds;
    while ticks().wrapping_sub(begun) < patience {
        if ready() {
            return true;
        }
    }
    ready()
}

/// Ticks of [`Tree::timer_hz`] since the start, modulo 2^32.
pub fn ticks() -> u32 {
    tim5().cnt().read().bits()
}

/// Starts the watchdog. Nothing can stop it.
pub fn watchdog() {
    iwdg().kr().write(|w| w.key().start());
    iwdg().kr().write(|w| w.key().unlock());
    // SR: the words are on their way. If they never arrive, the watchdog bites after 0.5 s instead.
    let _ = wait(|| iwdg().sr().read().bits() == 0);
    iwdg().pr().write(|w| w.pr().divide_by64());
    iwdg().rlr().write(|w| w.rl().set(WATCHDOG.reload));
    let _ = wait(|| iwdg().sr().read().bits() == 0);
    feed();
}

/// Feeds the watchdog.
pub fn feed() {
    iwdg().kr().write(|w| w.key().feed());
}
