//! Measures clocks by each other, see [`words::gauge`](super::words::gauge).

use super::registers::{enable, pwr, rcc, tim5, tim11, wait};
use super::words::clock::HSE_HZ;
use super::words::gauge::{
    PROBE_CAPTURES, START_CAPTURES, WATCHDOG_CAPTURES, hz, period_fits, probe_fits,
};
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use cortex_m::peripheral::NVIC;
use stm32f4::stm32f446 as pac;

/// Chooses the probe's clock for the RTC, which nothing else uses: the manual does not say whether its divided clock reaches TIM11 without.
/// A choice that another program made stays, until the supply of VBAT has gone.
fn choose() {
    pwr().cr().modify(|_, w| w.dbp().set_bit());
    rcc().bdcr().modify(|r, w| {
        if r.rtcsel().is_no_clock() {
            w.rtcsel().hse();
        }
        w.rtcen().enabled()
    });
}

/// As [`probe_captured`]; if no capture comes, once more with the clock chosen for the RTC.
fn probe_ticks(captures: u32) -> Option<u32> {
    probe_captured(captures).or_else(|| {
        choose();
        probe_captured(captures)
    })
}

/// Ticks of TIM11, at the core's clock, in this number of captures of the probe's clock; `None` if it does not come. 1,000 captures take 8
/// ms.
fn probe_captured(captures: u32) -> Option<u32> {
    rcc().apb2enr().modify(|_, w| w.tim11en().enabled());
    // 1 MHz of the probe's 8 MHz, which is channel 1's input.
    rcc().cfgr().modify(|_, w| w.rtcpre().set(8));
    let timer = tim11();
    // SAFETY: the number fits its field.
    timer.or().write(|w| unsafe { w.rmp().bits(2) });
    timer.ccmr1_input().write(|w| w.cc1s().ti1().ic1psc().eight_events());
    timer.ccer().write(|w| w.cc1e().enabled());
    timer.arr().write(|w| w.arr().set(u16::MAX));
    timer.cr1().write(|w| w.cen().enabled());
    // Reading the value clears the flag.
    let next =
        || wait(|| timer.sr().read().cc1if().bit()).then(|| timer.ccr1().read().ccr().bits());
    // A measurement before may have left a capture.
    let _ = timer.ccr1().read().bits();
    let mut whole = 0_u32;
    let mut last = next();
    timer.sr().reset();
    for _ in 0..captures {
        let now = next();
        let (Some(from), Some(to)) = (last, now) else { break };
        whole = whole.wrapping_add(u32::from(to.wrapping_sub(from)));
        last = now;
    }
    let missed = timer.sr().read().cc1of().bit();
    timer.cr1().reset();
    rcc().apb2enr().modify(|_, w| w.tim11en().disabled());
    (last.is_some() && !missed).then_some(whole)
}

/// Whether the probe's clock is right, as far as the internal oscillator can judge, which drives the core at `core_hz`. The check takes half
/// a millisecond.
pub fn crystal(core_hz: u32) -> bool {
    probe_ticks(START_CAPTURES).is_some_and(|ticks| probe_fits(ticks, core_hz))
}

/// Whether a look at the watchdog's oscillator has its first capture, and that capture.
static BEGUN: AtomicBool = AtomicBool::new(false);
static FROM: AtomicU32 = AtomicU32::new(0);
/// Whether the oscillator was once within its tolerance.
static TRUSTED: AtomicBool = AtomicBool::new(false);

/// Captures the watchdog's oscillator from now on.
pub fn capture() {
    let timer = tim5();
    // The oscillator is channel 4's input; channel 1 goes on waking the core.
    // SAFETY: the number fits its field.
    timer.or().write(|w| unsafe { w.it4_rmp().bits(1) });
    timer.ccmr2_input().write(|w| w.cc4s().ti4().ic4psc().eight_events());
    timer.ccer().modify(|_, w| w.cc4e().enabled());
}

/// Begins a look: the next two captures interrupt.
pub fn look() {
    BEGUN.store(false, Relaxed);
    tim5().dier().modify(|_, w| w.cc4ie().enabled());
}

/// Takes a capture, if one waits. Returns whether the oscillator, by a timer of `timer_hz`, has left its tolerance: it or the clock that
/// drives the timer has changed.
pub fn changed(timer_hz: u32) -> bool {
    let timer = tim5();
    let flags = timer.sr().read();
    if !flags.cc4if().bit() || !timer.dier().read().cc4ie().bit() {
        return false;
    }
    let now = timer.ccr4().read().bits();
    let ticks = now.wrapping_sub(FROM.load(Relaxed));
    FROM.store(now, Relaxed);
    timer.sr().write(|w| w.cc4of().clear());
    // A capture that was overwritten is not next to the following one.
    if !BEGUN.load(Relaxed) || flags.cc4of().bit() {
        BEGUN.store(true, Relaxed);
        return false;
    }
    timer.dier().modify(|_, w| w.cc4ie().disabled());
    let fits = period_fits(ticks, timer_hz);
    let trusted = TRUSTED.load(Relaxed);
    TRUSTED.store(trusted | fits, Relaxed);
    trusted && !fits
}

/// The probe's clock in hertz, by a core of `core_hz`; `None` if it does not come. It takes 8 ms.
pub fn probe_hz(core_hz: u32) -> Option<f64> {
    // TIM11 runs at the core's rate: its bus has half of that rate, and timers run at twice their bus.
    let ticks = probe_ticks(PROBE_CAPTURES)?;
    Some(f64::from(HSE_HZ / 1_000_000) * hz(PROBE_CAPTURES, ticks, core_hz))
}

/// The watchdog's oscillator in hertz, by a timer of `timer_hz`; `None` if it does not come. It
/// takes 16 ms, in which the core does not wake.
pub fn watchdog_hz(timer_hz: u32) -> Option<f64> {
    // A look would take captures away.
    NVIC::mask(pac::Interrupt::TIM5);
    let ticks = captured_ticks(WATCHDOG_CAPTURES);
    // A look that had begun has lost its first capture.
    BEGUN.store(false, Relaxed);
    enable(pac::Interrupt::TIM5);
    Some(hz(WATCHDOG_CAPTURES, ticks?, timer_hz))
}

/// Ticks of TIM5 in so many captures of the watchdog's oscillator; `None` if it does not come.
fn captured_ticks(captures: u32) -> Option<u32> {
    let timer = tim5();
    let next = || wait(|| timer.sr().read().cc4if().bit()).then(|| timer.ccr4().read().bits());
    let _ = next();
    let first = next();
    let mut last = first;
    for _ in 0..captures {
        if last.is_some() {
            last = next();
        }
    }
    Some(last?.wrapping_sub(first?))
}
