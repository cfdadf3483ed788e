//! The sample clock, the converters and the DMA stream that empties them.
//!
//! TIM3 counts the sample period. Each of its updates triggers ADC1, and ADC2 in step for I/Q
//! records. Stream 0 of DMA2 moves every result into one of two slots in turn.
//!
//! **No jitter.** The converter's clock samples the trigger. A period that is not a whole number of the converter's cycles would vary by
//! one cycle: 28 or 44 ns of jitter. So the period is a whole number of cycles.
//!
//! **At the fastest rate** a conversion fills the whole period, and the next trigger would find the converter busy. Then only the first
//! sample is triggered and the conversions follow each other by themselves, with an equal period.

use super::clock::Tree;
use picket_wire::settings_error::RateError;

/// A timer's prescaler and reload value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Period {
    /// TIMx_PSC (RM 17.4.11).
    pub prescaler: u16,
    /// TIMx_ARR (RM 17.4.12).
    pub reload: u16,
}

impl Period {
    /// The period in ticks of the timer.
    pub const fn ticks(self) -> u32 {
        (self.prescaler as u32 + 1).saturating_mul(self.reload as u32 + 1)
    }
}

/// The sample clock, and the settings of the converters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// TIM3's period.
    pub period: Period,
    /// The rate of this period, Hz: the nearest to the wanted one.
    pub rate_hz: f64,
    /// The sampling time, by its number in ADC_SMPRx.
    pub time: u8,
    /// Whether only the first sample is triggered.
    pub continuous: bool,
    /// Whether ADC2 samples as well.
    pub iq: bool,
}

/// The sampling times to choose from, in cycles, by their number in ADC_SMPRx (RM 13.13.5).
const SAMPLING_CYCLES: [u32; 8] = [3, 15, 28, 56, 84, 112, 144, 480];
/// Cycles of a conversion of 12 bits after sampling (RM 13.5).
const CONVERSION: u32 = 12;
/// Cycles between the end of a conversion and the next trigger, in which the trigger reaches the
/// converter's clock.
const SLACK: u32 = 3;

/// Cycles of the converter's clock from a conversion to the next, for this number of wanted cycles.
fn apart(wanted: u32) -> u32 {
    let shortest = SAMPLING_CYCLES[0] + CONVERSION;
    if wanted <= shortest { shortest } else { wanted.max(shortest + SLACK) }
}

/// The fastest rate at which a block of `samples` lasts `cycles` of the core, Hz.
pub fn fastest(tree: &Tree, samples: u32, cycles: u64) -> f64 {
    let ratio = tree.core_hz.checked_div(tree.adc_hz).unwrap_or(1).max(1);
    let wanted = cycles.div_ceil(u64::from(samples.max(1)) * u64::from(ratio));
    let cycles = apart(u32::try_from(wanted).unwrap_or(u32::MAX));
    f64::from(tree.adc_hz) / f64::from(cycles)
}

impl Sampling {
    /// The sampling nearest to `rate_hz`, with the longest sampling time that fits.
    ///
    /// # Errors
    /// The converter or the timer cannot make the rate.
    pub fn plan(tree: &Tree, rate_hz: f64, iq: bool) -> Result<Self, RateError> {
        if !(rate_hz > 0.0 && rate_hz.is_finite()) {
            return Err(RateError::Slow);
        }
        let ratio = tree.timer_hz.checked_div(tree.adc_hz).unwrap_or(1).max(1);
        // The period in the converter's cycles.
        let wanted = libm::round(f64::from(tree.adc_hz) / rate_hz) as u32;
        // The slowest rate is 1 Hz.
        if wanted > tree.adc_hz {
            return Err(RateError::Slow);
        }
        let shortest = SAMPLING_CYCLES[0] + CONVERSION;
        // A period up to half a cycle too short is rounding; below that, the rate is too fast.
        if wanted < shortest {
            return Err(RateError::Fast);
        }
        let cycles = apart(wanted);
        let ticks = cycles.saturating_mul(ratio);
        // The prescaler itself is a whole number of the converter's cycles, and doubles from step to step: so a rate that was answered does
        // not change when it is set again.
        let scale = match ticks.div_ceil(1 << 16) {
            0 | 1 => 1,
            more => more.next_power_of_two().max(ratio),
        };
        let reload = (ticks.saturating_add(scale / 2)).checked_div(scale).unwrap_or(1);
        let (Ok(prescaler), Ok(reload)) =
            (u16::try_from(scale.saturating_sub(1)), u16::try_from(reload.saturating_sub(1)))
        else {
            return Err(RateError::Slow);
        };
        let period = Period { prescaler, reload };
        let cycles = period.ticks().checked_div(ratio).unwrap_or(shortest);
        let continuous = cycles == shortest;
        let room = if continuous { cycles } else { cycles.saturating_sub(SLACK) };
        let fits = |sampling: &u32| sampling + CONVERSION <= room;
        let time = SAMPLING_CYCLES.iter().rposition(fits).ok_or(RateError::Fast)?;
        Ok(Sampling {
            period,
            rate_hz: f64::from(tree.timer_hz) / f64::from(period.ticks().max(1)),
            time: time as u8,
            continuous,
            iq,
        })
    }
}

/// Cycles in which the core measures and reports a block of 1024 by the usual method, real and I/Q, while it sends as many records as the
/// line carries, with some margin. Counted on an emulated core without wait states (host-tests/tests/rsemu/streams.rs).
pub const BLOCK_CYCLES: [u64; 2] = [102_000, 212_000];

/// The largest number of cycles known for a block with 0, 1, 2 and 3 rounds, real and I/Q: the instructions of the worst block that any
/// search over signals found so far (host-tests, `nucleo::instructions`), 1.64 cycles each, and 37,000 for its record.
pub const WORST_CYCLES: [[u64; 4]; 2] =
    [[186_000, 875_000, 1_370_000, 1_820_000], [347_000, 970_000, 1_450_000, 1_865_000]];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nucleo_f446re::words::clock::{Source, Speed};

    /// Cycles in which the input is sampled.
    fn cycles(sampling: Sampling) -> u32 {
        SAMPLING_CYCLES[usize::from(sampling.time)]
    }

    fn plan(speed: Speed, rate_hz: f64, iq: bool) -> Result<Sampling, RateError> {
        Sampling::plan(&Tree::new(speed, Source::HsePll), rate_hz, iq)
    }

    #[test]
    fn the_fastest_rates_are_exact_and_continuous() {
        let fast = plan(Speed::Mhz144, 2.4e6, false).unwrap();
        // 72 MHz / 30 = 2.4 MHz; 3 + 12 cycles of 36 MHz.
        assert_eq!(fast.period, Period { prescaler: 0, reload: 29 });
        assert_eq!((fast.rate_hz, cycles(fast), fast.continuous), (2.4e6, 3, true));
        let fast = plan(Speed::Mhz180, 1.5e6, true).unwrap();
        // 90 MHz / 60; 3 + 12 cycles of 22.5 MHz.
        assert_eq!(fast.period, Period { prescaler: 0, reload: 59 });
        assert_eq!((fast.rate_hz, cycles(fast), fast.continuous), (1.5e6, 3, true));
        assert_eq!(plan(Speed::Mhz180, 1.6e6, false), Err(RateError::Fast));
        assert_eq!(plan(Speed::Mhz144, 2.6e6, false), Err(RateError::Fast));
        let internal = Tree::new(Speed::Mhz180, Source::Hsi);
        assert_eq!(Sampling::plan(&internal, 1e6, false), Err(RateError::Fast));
        assert_eq!(Sampling::plan(&internal, 500e3, false).unwrap().period.ticks(), 36);
    }

    #[test]
    fn the_fastest_rate_of_a_block_is_one_that_the_timers_make() {
        for speed in [Speed::Mhz144, Speed::Mhz180] {
            let tree = Tree::new(speed, Source::HsePll);
            for cycles in (60_000..2_000_000).step_by(1_733) {
                let rate_hz = fastest(&tree, 1024, cycles);
                let sampling = Sampling::plan(&tree, rate_hz, false).unwrap();
                assert_eq!(sampling.rate_hz, rate_hz, "{cycles}");
                let lasts = |rate_hz: f64| 1024.0 * f64::from(tree.core_hz) / rate_hz;
                let least = lasts(fastest(&tree, 1024, 0)).max(cycles as f64);
                assert!((cycles as f64..1.2 * least).contains(&lasts(rate_hz)), "{cycles}");
            }
        }
    }

    #[test]
    fn slower_rates_sample_longer() {
        let slow = plan(Speed::Mhz180, 100e3, false).unwrap();
        // 225 cycles of 22.5 MHz: 144 + 12 fit, 480 + 12 do not.
        assert_eq!((slow.period.ticks(), cycles(slow), slow.continuous), (900, 144, false));
        let slow = plan(Speed::Mhz180, 10.0, false).unwrap();
        // 9,000,000 ticks: the prescaler must be 138 or more, a power of two is 256, and 35,156
        // periods of 256 are the nearest.
        assert_eq!((slow.period, cycles(slow)), (Period { prescaler: 255, reload: 35_155 }, 480));
        assert_eq!(slow.rate_hz, 90e6 / 8_999_936.0);
        for rate in [0.0, -5.0, f64::NAN, f64::INFINITY, 0.01] {
            assert_eq!(plan(Speed::Mhz180, rate, false), Err(RateError::Slow), "{rate}");
        }
    }

    #[test]
    fn every_period_is_whole_cycles_and_leaves_time() {
        for speed in [Speed::Mhz144, Speed::Mhz180] {
            for source in [Source::HsePll, Source::Hsi] {
                let tree = Tree::new(speed, source);
                let ratio = tree.timer_hz / tree.adc_hz;
                let mut rate = 1.0;
                while let Ok(sampling) = Sampling::plan(&tree, rate, false) {
                    let ticks = sampling.period.ticks();
                    assert_eq!(ticks % ratio, 0, "{rate}");
                    let period = ticks / ratio;
                    let busy = cycles(sampling) + CONVERSION;
                    let slack = if sampling.continuous { 0 } else { SLACK };
                    assert!(busy + slack <= period, "{rate}");
                    // Within a cycle, except in the gap below the fastest rate.
                    let exact = f64::from(tree.adc_hz) / rate;
                    let bridge = if exact < 18.0 { 3.0 } else { 0.5 + exact / 65_000.0 };
                    assert!(
                        (f64::from(period) - exact).abs() <= bridge,
                        "{rate}: {period} {exact}"
                    );
                    rate *= 1.037;
                }
                assert!(rate > 500e3, "{rate}");
            }
        }
    }

    /// Of slow rates, for which the prescaler is used, one in some ten thousand once moved.
    #[test]
    fn a_rate_that_was_answered_stays_when_it_is_set_again() {
        for speed in [Speed::Mhz144, Speed::Mhz180] {
            for source in [Source::HsePll, Source::Hsi] {
                let tree = Tree::new(speed, source);
                // Rates about each prescaler step, where they once moved.
                for scale in 1..=1500u32 {
                    let edge = f64::from(tree.timer_hz) / (65536.0 * f64::from(scale));
                    for near in -40..40 {
                        let rate_hz = edge * (1.0 + f64::from(near) * 1e-6);
                        let plan = |rate_hz| Sampling::plan(&tree, rate_hz, false);
                        let Ok(Sampling { rate_hz: first, .. }) = plan(rate_hz) else { continue };
                        assert_eq!(plan(first).map(|again| again.rate_hz), Ok(first));
                    }
                }
            }
        }
    }
}
