//! Clocks held against each other (RM 6.2.11, internal/external clock measurement): the watchdog's
//! oscillator and the probe's clock, in ticks of timers that the multiplier drives.

/// RCC_APB2ENR (RM 6.3.14): TIM11 18.
pub const APB2: u32 = 1 << 18;
/// RCC_CFGR (RM 6.3.3): RTCPRE 20:16 = 8 makes 1 MHz of the probe's 8 MHz.
pub const EIGHTH: u32 = 8 << 16;
/// TIM11_OR: TI1_RMP 1:0 = 2, that 1 MHz is channel 1's input.
pub const TIM11_INPUT: u32 = 2;
/// TIM5_OR: TI4_RMP 7:6 = 1, the watchdog's oscillator is channel 4's input.
pub const TIM5_INPUT: u32 = 1 << 6;
/// Periods from one capture to the next: ICxPSC = 3.
pub const PERIODS: u32 = 8;
/// TIM11_CCMR1 (RM 17.4.7): CC1S 1:0 = 1 its own input, IC1PSC 3:2 = 3.
pub const TIM11_CAPTURE: u32 = 1 | 3 << 2;
/// TIM5_CCMR2: the same for channel 4, CC4S 9:8 and IC4PSC 11:10.
pub const TIM5_CAPTURE: u32 = TIM11_CAPTURE << 8;
/// TIM11_CCER: CC1E 0.
pub const TIM11_ENABLE: u32 = 1;
/// TIM5_CCER: CC4E 12.
pub const TIM5_ENABLE: u32 = 1 << 12;

/// Captures of the probe's clock: 8 ms.
pub const PROBE_CAPTURES: u32 = 1_000;
/// Captures of the watchdog's oscillator: 16 ms.
pub const WATCHDOG_CAPTURES: u32 = 64;

/// The frequency of a clock, Hz, of which so many captures took so many ticks of a timer.
pub fn hz(captures: u32, ticks: u32, timer_hz: u32) -> f64 {
    let periods = f64::from(captures) * f64::from(PERIODS);
    periods * f64::from(timer_hz) / f64::from(ticks.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_become_hertz() {
        // 8,000 periods of 1 MHz are 8 ms, which are 1,440,000 ticks of 180 MHz.
        assert_eq!(hz(PROBE_CAPTURES, 1_440_000, 180_000_000), 1e6);
        assert_eq!(hz(WATCHDOG_CAPTURES, 1_440_000, 90_000_000), 32e3);
        assert!(hz(1, 0, 1).is_finite());
    }
}
