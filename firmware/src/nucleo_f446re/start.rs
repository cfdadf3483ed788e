//! From reset to running clock, pins and watchdog.

use super::registers::{clear, flash, gpioa, gpiob, iwdg, put, pwr, rcc, set, tim5, wait};
use super::words::clock::{Source, Speed, Tree};
use super::words::guard::{self, FEED, START, UNLOCK, WATCHDOG, brown_out};
use super::words::pins::{AHB1, APB1, APB2, PORT_A, PORT_B, Port};
use picket_wire::boot::Causes;

/// Why the chip was reset. Clears the flags.
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
        if !wait(|| rcc.cr().read().bits() & 1 << 17 != 0) {
            return false;
        }
    }
    // PWREN 28; VOS 15:14 = 3, scale 1.
    set!(rcc.apb1enr(), 1 << 28);
    set!(pwr.cr(), 3 << 14);
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
    put!(rcc.cfgr(), tree.cfgr);
    // SWS 3:2 follows SW 1:0.
    wait(|| rcc.cfgr().read().bits() >> 2 & 3 == tree.cfgr & 3)
}

/// Returns to the internal oscillator, from which the chip starts.
fn back() {
    put!(rcc().cfgr(), 0);
    // The result does not matter: if the switch failed, the next attempt fails too.
    let _ = wait(|| rcc().cfgr().read().bits() >> 2 & 3 == 0);
    clear!(rcc().cr(), (1 << 24 | 1 << 18 | 1 << 16));
    clear!(pwr().cr(), (1 << 17 | 1 << 16));
    put!(flash().acr(), Tree::new(Speed::Mhz144, Source::Hsi).flash);
}

/// Starts the peripherals' clocks, the pins, and TIM5, which never stops.
pub fn peripherals() {
    set!(rcc().ahb1enr(), AHB1);
    set!(rcc().apb1enr(), APB1);
    set!(rcc().apb2enr(), APB2);
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
    put!(tim5().cr1(), 1);
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

/// Sets the brown-out level, once in the chip's life.
pub fn brown_out_level() {
    const KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];
    let flash = flash();
    let Some(word) = brown_out(flash.optcr().read().bits()) else { return };
    if !wait(|| flash.sr().read().bits() & 1 << 16 == 0) {
        return;
    }
    KEYS.iter().for_each(|&key| {
        put!(flash.optkeyr(), key);
    });
    put!(flash.optcr(), word);
    // OPTSTRT 1; BSY 16; OPTLOCK 0 (RM 3.6.2).
    put!(flash.optcr(), word | 1 << 1);
    let _ = wait(|| flash.sr().read().bits() & 1 << 16 == 0);
    put!(flash.optcr(), word | 1);
}
