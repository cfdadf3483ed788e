//! Measures clocks by each other: [`words::gauge`](super::words::gauge) says how.

use super::registers::{clear, put, rcc, set, tim5, tim11};
use super::start::within;
use super::words::clock::HSE_HZ;
use super::words::gauge::{
    APB2, EIGHTH, PROBE_CAPTURES, TIM5_CAPTURE, TIM5_ENABLE, TIM5_INPUT, TIM11_CAPTURE,
    TIM11_ENABLE, TIM11_INPUT, WATCHDOG_CAPTURES, hz,
};

/// The longest wait for a capture, ms: of an oscillator of 17 kHz eight periods take 0.5.
const PATIENCE_MS: u32 = 2;

/// The probe's clock in hertz, by a core of `core_hz`; `None` if it does not come. It takes 8 ms.
pub fn probe_hz(core_hz: u32) -> Option<f64> {
    set!(rcc().apb2enr(), APB2);
    set!(rcc().cfgr(), EIGHTH);
    let timer = tim11();
    put!(timer.or(), TIM11_INPUT);
    put!(timer.ccmr1_input(), TIM11_CAPTURE);
    put!(timer.ccer(), TIM11_ENABLE);
    put!(timer.arr(), 0xFFFF);
    put!(timer.cr1(), 1);
    // CC1IF 1, which reading the value clears, and CC1OF 9: one was overwritten.
    let next = || {
        within(PATIENCE_MS, || timer.sr().read().bits() & 1 << 1 != 0)
            .then(|| timer.ccr1().read().bits())
    };
    let mut whole = 0_u32;
    let mut last = next();
    put!(timer.sr(), 0);
    for _ in 0..PROBE_CAPTURES {
        let now = next();
        let (Some(from), Some(to)) = (last, now) else { break };
        whole = whole.wrapping_add(u32::from((to as u16).wrapping_sub(from as u16)));
        last = now;
    }
    let missed = timer.sr().read().bits() & 1 << 9 != 0;
    put!(timer.cr1(), 0);
    clear!(rcc().apb2enr(), APB2);
    // It runs at the core's rate: its bus has half of that, and timers twice their bus.
    let found = f64::from(HSE_HZ / 1_000_000) * hz(PROBE_CAPTURES, whole, core_hz);
    (last.is_some() && !missed).then_some(found)
}

/// The watchdog's oscillator in hertz, by a timer of `timer_hz`; `None` if it does not come. It
/// takes 16 ms.
pub fn watchdog_hz(timer_hz: u32) -> Option<f64> {
    let timer = tim5();
    put!(timer.or(), TIM5_INPUT);
    put!(timer.ccmr2_input(), TIM5_CAPTURE);
    // Channel 4 captures; channel 1 goes on waking the core.
    set!(timer.ccer(), TIM5_ENABLE);
    let next = || {
        within(PATIENCE_MS, || timer.sr().read().bits() & 1 << 4 != 0)
            .then(|| timer.ccr4().read().bits())
    };
    let _ = next();
    let first = next();
    let mut last = first;
    for _ in 0..WATCHDOG_CAPTURES {
        if last.is_some() {
            last = next();
        }
    }
    clear!(timer.ccer(), TIM5_ENABLE);
    let ticks = last?.wrapping_sub(first?);
    Some(hz(WATCHDOG_CAPTURES, ticks, timer_hz))
}
