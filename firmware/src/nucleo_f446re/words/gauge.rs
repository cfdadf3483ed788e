//! Clocks compared with each other (RM 6.2.11, internal/external clock measurement): the watchdog's oscillator and the probe's clock, in
//! ticks of timers.
//!
//! **At the start** the core runs by its internal oscillator, and counts the probe's clock by it. A clock outside of the internal
//! oscillator's tolerance around 8 MHz is wrong, and is not used: multiplied it would drive the core beyond its limits.
//!
//! **By the internal oscillator** the board looks once a second whether the probe's clock is there, in the same way, and starts anew by it.
//!
//! **In operation** the probe's clock drives the timers, and counts the watchdog's oscillator ten times a second. If this oscillator once
//! was within its own tolerance and then seems to be outside, one of the two has changed.

use super::guard::LSI_HZ;

/// Periods from one capture to the next (ICxPSC).
pub const PERIODS: u32 = 8;

/// Captures of the probe's clock at the start: half a millisecond, in which a tick is 120 ppm.
pub const START_CAPTURES: u32 = 64;
/// The slowest and the fastest rate of the internal oscillator, permille, at -40 to 105 degrees (DS table 42).
const INTERNAL: [u32; 2] = [920, 1_045];

/// Whether [`START_CAPTURES`] of the probe's clock may take this number of ticks of a core that the internal oscillator drives at
/// `core_hz`.
pub fn probe_fits(ticks: u32, core_hz: u32) -> bool {
    let exact = START_CAPTURES * PERIODS * (core_hz / 1_000_000);
    let [slow, fast] = INTERNAL.map(|permille| exact * permille);
    (slow..=fast).contains(&ticks.saturating_mul(1_000))
}

/// Whether a capture of the watchdog's oscillator may take this number of ticks of a timer.
pub fn period_fits(ticks: u32, timer_hz: u32) -> bool {
    let [_, slow, fast] = LSI_HZ.map(|hz| (hz / 1_000).saturating_mul(ticks));
    (slow..=fast).contains(&(PERIODS * (timer_hz / 1_000)))
}

/// Captures of the probe's clock: 8 ms.
pub const PROBE_CAPTURES: u32 = 1_000;
/// Captures of the watchdog's oscillator: 16 ms.
pub const WATCHDOG_CAPTURES: u32 = 64;

/// The frequency of a clock, Hz, of which `captures` took this number of ticks of a timer.
pub fn hz(captures: u32, ticks: u32, timer_hz: u32) -> f64 {
    let periods = f64::from(captures) * f64::from(PERIODS);
    periods * f64::from(timer_hz) / f64::from(ticks.max(1))
}

#[cfg(test)]
mod tests {
    use super::super::clock::HSI_HZ;
    use super::*;

    #[test]
    fn ticks_become_hertz() {
        // 8,000 periods of 1 MHz are 8 ms, which are 1,440,000 ticks of 180 MHz.
        assert_eq!(hz(PROBE_CAPTURES, 1_440_000, 180_000_000), 1e6);
        assert_eq!(hz(WATCHDOG_CAPTURES, 1_440_000, 90_000_000), 32e3);
        assert!(hz(1, 0, 1).is_finite());
    }

    /// Whether a clock of `probe` times 8 MHz is right by a core at `internal` times 16 and 180 MHz.
    fn fits(probe: f64, internal: f64) -> bool {
        let [slow, fast] = [16, 180].map(|mhz| {
            // 512 microseconds.
            probe_fits((512.0 * f64::from(mhz) * internal / probe) as u32, 1_000_000 * mhz)
        });
        assert_eq!(slow, fast, "{probe} {internal}");
        slow
    }

    #[test]
    fn a_probe_of_8_mhz_is_used_by_any_oscillator_and_no_other_usual_crystal_by_any() {
        for internal in [0.921, 0.96, 0.99, 1.0, 1.01, 1.044] {
            assert!(fits(1.0, internal), "{internal}");
            // 4, 6, 10, 12, 16, 25 MHz.
            for mhz in [4.0, 6.0, 10.0, 12.0, 16.0, 25.0] {
                assert!(!fits(mhz / 8.0, internal), "{mhz} {internal}");
            }
        }
        assert!(!probe_fits(0, HSI_HZ) && !probe_fits(u32::MAX, HSI_HZ));
        // By a correct oscillator, 8 MHz may be 4 % slow and 8 % fast.
        assert!(fits(0.96, 1.0) && !fits(0.95, 1.0));
        assert!(fits(1.08, 1.0) && !fits(1.09, 1.0));
    }

    #[test]
    fn an_oscillator_within_its_data_sheet_fits_and_a_clock_of_half_or_twice_the_rate_does_not() {
        for timer_hz in [72_000_000, 90_000_000] {
            let ticks = |lsi: f64| (8.0 / lsi * f64::from(timer_hz)) as u32;
            for lsi in [17_010.0, 32_000.0, 46_990.0] {
                assert!(period_fits(ticks(lsi), timer_hz), "{lsi}");
            }
            // The typical oscillator, counted by a clock with half or twice its stated rate.
            for lsi in [16_000.0, 64_000.0] {
                assert!(!period_fits(ticks(lsi), timer_hz), "{lsi}");
            }
            assert!(!period_fits(0, timer_hz));
        }
    }
}
