//! From reset to running clock, pins and watchdog.

use super::gauge;
use super::registers::{
    clear, enable, flash, gpioa, gpiob, iwdg, put, pwr, rcc, set, syscfg, tim5, wait,
};
use super::words::clock::{HSI_HZ, Source, Speed, Tree};
use super::words::guard::{self, FEED, START, UNLOCK, WATCHDOG};
use super::words::pins::{AHB1, APB1, APB2, PORT_A, PORT_B, Port};
use super::words::quiet::{ADCDC1, PREFETCH, Quiet};
use crate::instrument::fault;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use picket_wire::boot::{Causes, LastEnd};
use stm32f4::stm32f446 as pac;

/// The causes of the chip's reset. Clears the flags.
pub fn causes() -> Causes {
    let causes = guard::causes(rcc().csr().read().bits());
    // RMVF 24.
    set!(rcc().csr(), 1 << 24);
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
    let Some(pll) = tree.pll else { return false };
    let (rcc, pwr) = (rcc(), pwr());
    // HSEBYP 18 and HSEON 16: the probe drives the pin; HSERDY 17. HSI is on after reset.
    if tree.source == Source::HsePll {
        set!(rcc.cr(), 1 << 18 | 1 << 16);
        if !wait(|| rcc.cr().read().bits() & 1 << 17 != 0) || !gauge::crystal(HSI_HZ) {
            return false;
        }
    }
    // PWREN 28; VOS 15:14 = 3, scale 1. Flash is not read ahead after a reset.
    set!(rcc.apb1enr(), 1 << 28);
    set!(pwr.cr(), 3 << 14 | Quiet::USED.power());
    put!(rcc.pllcfgr(), pll);
    // PLLON 24, PLLRDY 25.
    set!(rcc.cr(), 1 << 24);
    if !wait(|| rcc.cr().read().bits() & 1 << 25 != 0) {
        return false;
    }
    if tree.over_drive {
        // ODEN 16, ODRDY 16, then ODSWEN 17, ODSWRDY 17 (RM 5.1.4).
        for bit in [1 << 16, 1 << 17] {
            set!(pwr.cr(), bit);
            if !wait(|| pwr.csr().read().bits() & bit != 0) {
                return false;
            }
        }
    }
    // The wait states come before the speed (RM 3.4.1), and are read back as it demands.
    put!(flash().acr(), tree.flash);
    if !wait(|| flash().acr().read().bits() & 15 == tree.flash & 15) {
        return false;
    }
    // The buses are divided by 16 while the speed changes, as in ST's own code.
    let [slow, switched, last] = tree.steps();
    put!(rcc.cfgr(), slow);
    put!(rcc.cfgr(), switched);
    // SWS 3:2 follows SW 1:0.
    if !wait(|| rcc.cfgr().read().bits() >> 2 & 3 == tree.cfgr & 3) {
        return false;
    }
    put!(rcc.cfgr(), last);
    if tree.source == Source::HsePll {
        // CSSON 19: if the crystal's clock fails, the chip goes on by its own clock and raises an NMI.
        set!(rcc.cr(), 1 << 19);
    }
    true
}

/// Takes a measure against the chip's noise, in place of the one before.
pub fn quiet(quiet: Quiet) {
    // Bits that exclude the new bits are cleared first, and bits that require flash without read-ahead are set last.
    clear!(pwr().cr(), ADCDC1);
    put!(syscfg().pmc(), 0);
    let access = flash().acr().read().bits() & !PREFETCH;
    put!(flash().acr(), access | quiet.prefetch());
    set!(pwr().cr(), quiet.power());
    put!(syscfg().pmc(), quiet.mode());
}

/// Handles the failure of the crystal's clock (RM 6.2.7): the board restarts, by its own clock if
/// the other is still missing.
// SAFETY: cortex-m-rt's vector table has the handler under this name.
#[unsafe(no_mangle)]
extern "C" fn NonMaskableInt() {
    // CSSC 23 of RCC_CIR.
    set!(rcc().cir(), 1 << 23);
    fault::end(LastEnd { kind: 3, pc: 0, more: [0; 2] })
}

/// Returns to the internal oscillator, from which the chip starts.
fn back() {
    put!(rcc().cfgr(), 0);
    // The result does not matter: if the switch failed, the next attempt fails, too.
    let _ = wait(|| rcc().cfgr().read().bits() >> 2 & 3 == 0);
    clear!(rcc().cr(), (1 << 24 | 1 << 19 | 1 << 18 | 1 << 16));
    clear!(pwr().cr(), (1 << 17 | 1 << 16));
    put!(flash().acr(), Tree::new(Speed::Mhz144, Source::Hsi).flash);
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
    set!(rcc().ahb1enr(), AHB1);
    set!(rcc().apb1enr(), APB1);
    set!(rcc().apb2enr(), APB2);
}

/// Starts the pins, and TIM5, which never stops.
pub fn pins(tree: &Tree) {
    let Port { mode, speed, pull, alternate: [low, high] } = PORT_A;
    put!(gpioa().afrl(), low);
    put!(gpioa().afrh(), high);
    put!(gpioa().ospeedr(), speed);
    put!(gpioa().pupdr(), pull);
    put!(gpioa().moder(), mode);
    let Port { mode, speed, pull, alternate: [low, high] } = PORT_B;
    put!(gpiob().afrl(), low);
    put!(gpiob().afrh(), high);
    put!(gpiob().ospeedr(), speed);
    put!(gpiob().pupdr(), pull);
    put!(gpiob().moder(), mode);
    put!(tim5().arr(), u32::MAX);
    // UG 0 loads the reload value; CEN 0.
    put!(tim5().egr(), 1);
    WAKE.store(tree.timer_hz / WAKES_A_SECOND, Relaxed);
    next();
    // CC1IE 1.
    put!(tim5().dier(), 1 << 1);
    gauge::capture();
    enable(pac::Interrupt::TIM5);
    put!(tim5().cr1(), 1);
}

/// The rate at which the core wakes where nothing else wakes it. The loop then feeds the watchdog, if it makes progress.
const WAKES_A_SECOND: u32 = 10;

/// Ticks between two wakes.
static WAKE: AtomicU32 = AtomicU32::new(0);

/// Handles TIM5's interrupt, which wakes the core and watches the clock.
pub extern "C" fn wake() {
    // CC1IF 1.
    if tim5().sr().read().bits() & 1 << 1 != 0 {
        next();
        gauge::look();
    }
    if gauge::changed(WAKES_A_SECOND * WAKE.load(Relaxed)) {
        fault::end(LastEnd { kind: 3, pc: 0, more: [0; 2] })
    }
}

/// Sets the next wake.
fn next() {
    put!(tim5().ccr1(), ticks().wrapping_add(WAKE.load(Relaxed)));
    // CC1IF 1 is cleared by a zero.
    put!(tim5().sr(), !(1 << 1));
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
    put!(iwdg().kr(), START);
    put!(iwdg().kr(), UNLOCK);
    // SR: the words are on their way. If they never arrive, the watchdog bites after 0.5 s instead.
    let _ = wait(|| iwdg().sr().read().bits() == 0);
    put!(iwdg().pr(), WATCHDOG.prescaler);
    put!(iwdg().rlr(), WATCHDOG.reload);
    let _ = wait(|| iwdg().sr().read().bits() == 0);
    feed();
}

/// Feeds the watchdog.
pub fn feed() {
    put!(iwdg().kr(), FEED);
}
