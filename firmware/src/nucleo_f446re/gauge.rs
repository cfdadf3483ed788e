//! Measures clocks by each other, see [`words::gauge`](super::words::gauge).

use super::registers::{clear, enable, put, pwr, rcc, set, tim5, tim11, wait};
use super::words::clock::HSE_HZ;
use super::words::gauge::{
    APB2, EIGHTH, PROBE_CAPTURES, START_CAPTURES, TIM5_CAPTURE, TIM5_ENABLE, TIM5_INPUT,
    TIM5_INTERRUPT, TIM11_CAPTURE, TIM11_ENABLE, TIM11_INPUT, WATCHDOG_CAPTURES, hz, period_fits,
    probe_fits,
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
    set!(rcc().apb2enr(), APB2);
    set!(rcc().cfgr(), EIGHTH);
    let timer = tim11();
    put!(timer.or(), TIM11_INPUT);
    put!(timer.ccmr1_input(), TIM11_CAPTURE);
    put!(timer.ccer(), TIM11_ENABLE);
    put!(timer.arr(), 0xFFFF);
    put!(timer.cr1(), 1);
    // CC1IF 1, which reading the value clears, and CC1OF 9: a capture was overwritten.
    let next = || {
        wait(|| timer.sr().read().bits() & 1 << 1 != 0).then(|| timer.ccr1().read().bits() as u16)
    };
    // A measurement before may have left a capture.
    let _ = timer.ccr1().read().bits();
    let mut whole = 0_u32;
    let mut last = next();
    put!(timer.sr(), 0);
    for _ in 0..captures {
        let now = next();
        let (Some(from), Some(to)) = (last, now) else { break };
        whole = whole.wrapping_add(u32::from(to.wrapping_sub(from)));
        last = now;
    }
    let missed = timer.sr().read().bits() & 1 << 9 != 0;
    put!(timer.cr1(), 0);
    clear!(rcc().apb2enr(), APB2);
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
    put!(timer.or(), TIM5_INPUT);
    put!(timer.ccmr2_input(), TIM5_CAPTURE);
    // Channel 4 captures; channel 1 goes on waking the core.
    set!(timer.ccer(), TIM5_ENABLE);
}

/// Begins a look: the next two captures interrupt.
pub fn look() {
    BEGUN.store(false, Relaxed);
    set!(tim5().dier(), TIM5_INTERRUPT);
}

/// Takes a capture, if one waits. Returns whether the oscillator, by a timer of `timer_hz`, has left its tolerance: it or the clock that
/// drives the timer has changed.
pub fn changed(timer_hz: u32) -> bool {
    let timer = tim5();
    let flags = timer.sr().read().bits();
    // CC4IF 4, which has the bit of its interrupt's enable, and CC4OF 12.
    if flags & timer.dier().read().bits() & TIM5_INTERRUPT == 0 {
        return false;
    }
    let now = timer.ccr4().read().bits();
    let ticks = now.wrapping_sub(FROM.load(Relaxed));
    FROM.store(now, Relaxed);
    put!(timer.sr(), !(1 << 12));
    // A capture that was overwritten is not next to the following one.
    if !BEGUN.load(Relaxed) || flags & 1 << 12 != 0 {
        BEGUN.store(true, Relaxed);
        return false;
    }
    clear!(timer.dier(), TIM5_INTERRUPT);
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
    let next =
        || wait(|| timer.sr().read().bits() & 1 << 4 != 0).then(|| timer.ccr4().read().bits());
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
