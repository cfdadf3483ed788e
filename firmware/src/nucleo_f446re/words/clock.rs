//! The clock tree, from the probe's 8 MHz or the internal 16 MHz to core, buses and converter.
//!
//! Two speeds give the converter its two best rates. A sample takes 15 cycles of at most 36 MHz (DS
//! 6.3.20): at 144 MHz the converter has 36 MHz and 2.4 MS/s, at 180 MHz it has 22.5 MHz and 1.5
//! MS/s.

use super::quiet::Quiet;
use picket_wire::boot::Clock;

/// The core's speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Speed {
    /// 144 MHz: up to 2.4 MS/s.
    Mhz144,
    /// 180 MHz: up to 1.5 MS/s.
    #[default]
    Mhz180,
}

/// The source of the clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Source {
    /// The probe's crystal, multiplied: some ten ppm.
    HsePll,
    /// The internal oscillator, multiplied, because the probe's clock did not start: frequencies
    /// may be 1 % wrong.
    HsiPll,
    /// The internal oscillator alone, because the multiplier did not lock: also 1 %, and slow.
    #[default]
    Hsi,
}

impl Source {
    /// The source in the terms of the boot record.
    pub const fn clock(self) -> Clock {
        match self {
            Source::HsePll => Clock::External,
            Source::HsiPll => Clock::Internal,
            Source::Hsi => Clock::Slow,
        }
    }
}

impl Speed {
    /// The speed of this many MHz; 0 is the default, and other values are `None`.
    pub const fn from_mhz(mhz: u16) -> Option<Self> {
        match mhz {
            144 => Some(Speed::Mhz144),
            0 | 180 => Some(Speed::Mhz180),
            _ => None,
        }
    }

    /// The speed in MHz.
    pub const fn mhz(self) -> u16 {
        match self {
            Speed::Mhz144 => 144,
            Speed::Mhz180 => 180,
        }
    }
}

/// The probe's clock in hertz (NUCLEO-64 manual UM1724, 6.7.1: MCO of the ST-LINK).
pub const HSE_HZ: u32 = 8_000_000;
/// The internal oscillator in hertz.
pub const HSI_HZ: u32 = 16_000_000;

/// The frequencies of the tree, in hertz, and the register words that make them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tree {
    /// The source of the clock.
    pub source: Source,
    /// Clock of the core, Hz.
    pub core_hz: u32,
    /// Clock of the first peripheral bus, Hz: USART2 and the DAC.
    pub apb1_hz: u32,
    /// Clock of the second peripheral bus, Hz: the ADC before its prescaler.
    pub apb2_hz: u32,
    /// Clock of the timers on the first bus, Hz: twice the bus's clock if that is divided (RM 6.2, figure 14).
    pub timer_hz: u32,
    /// Clock of the converter, Hz.
    pub adc_hz: u32,
    /// RCC_PLLCFGR (RM 6.3.2); `None` without the multiplier.
    pub pll: Option<u32>,
    /// RCC_CFGR (RM 6.3.3).
    pub cfgr: u32,
    /// FLASH_ACR (RM 3.8.1).
    pub flash: u32,
    /// The ADC's prescaler, ADCPRE in ADC_CCR (RM 13.13.16).
    pub adc_prescaler: u32,
    /// Whether the regulator needs its over-drive (RM 5.1.4): above 168 MHz.
    pub over_drive: bool,
}

/// The fastest clock of the converter, Hz (DS 6.3.20).
const ADC_LIMIT_HZ: u32 = 36_000_000;

impl Tree {
    /// The tree for this speed from this source.
    pub const fn new(speed: Speed, source: Source) -> Self {
        let (input, source_bit, divider) = match source {
            Source::HsePll => (HSE_HZ, 1, 4),
            Source::HsiPll => (HSI_HZ, 0, 8),
            Source::Hsi => return Self::internal(),
        };
        // The multiplier's input is 2 MHz, as RM 6.3.2 recommends against jitter; its output is
        // halved.
        let multiplier = match speed {
            Speed::Mhz144 => 144,
            Speed::Mhz180 => 180,
        };
        let core_hz = input / divider * multiplier / 2;
        // PLLM 5:0, PLLN 14:6, PLLP 17:16 (0 halves), PLLSRC 22. PLLQ 27:24 and PLLR 30:28 serve
        // nothing: 8 and 2.
        let pll = divider | multiplier << 6 | source_bit << 22 | 8 << 24 | 2 << 28;
        // SW 1:0 = 2 the multiplier, PPRE1 12:10 = 5 a quarter, PPRE2 15:13 = 4 a half.
        let cfgr = 2 | 5 << 10 | 4 << 13;
        let (apb1_hz, apb2_hz) = (core_hz / 4, core_hz / 2);
        let adc_prescaler = if apb2_hz / 2 <= ADC_LIMIT_HZ { 0 } else { 1 };
        Tree {
            source,
            core_hz,
            apb1_hz,
            apb2_hz,
            timer_hz: 2 * apb1_hz,
            adc_hz: apb2_hz / if adc_prescaler == 0 { 2 } else { 4 },
            pll: Some(pll),
            cfgr,
            flash: flash_access(core_hz),
            adc_prescaler,
            over_drive: core_hz > 168_000_000,
        }
    }

    /// RCC_CFGR step by step, on the way to the multiplier: both buses divided by 16 (PPRE1 12:10
    /// and PPRE2 15:13 = 7), the multiplier chosen, the buses' own dividers.
    pub const fn steps(&self) -> [u32; 3] {
        let slow = 7 << 10 | 7 << 13;
        [slow, slow | self.cfgr & 3, self.cfgr]
    }

    /// The tree without multiplier and dividers.
    const fn internal() -> Self {
        Tree {
            source: Source::Hsi,
            core_hz: HSI_HZ,
            apb1_hz: HSI_HZ,
            apb2_hz: HSI_HZ,
            timer_hz: HSI_HZ,
            adc_hz: HSI_HZ / 2,
            pll: None,
            cfgr: 0,
            flash: flash_access(HSI_HZ),
            adc_prescaler: 0,
            over_drive: false,
        }
    }
}

/// FLASH_ACR at 2.7 to 3.6 V: one wait state for every 30 MHz begun after the first (RM 3.4.1,
/// table 5), both caches on. [`Quiet`] decides on the prefetch.
pub const fn flash_access(core_hz: u32) -> u32 {
    let wait_states = core_hz.saturating_sub(1) / 30_000_000;
    wait_states | 1 << 9 | 1 << 10 | Quiet::USED.prefetch()
}

#[cfg(test)]
mod tests {
    use super::*;

    // Worked out by hand from RM 6.3.2 and 6.3.3.
    #[test]
    fn both_speeds_from_both_oscillators() {
        let tree = Tree::new(Speed::Mhz180, Source::HsePll);
        assert_eq!(tree.core_hz, 180_000_000);
        assert_eq!((tree.apb1_hz, tree.apb2_hz), (45_000_000, 90_000_000));
        assert_eq!((tree.timer_hz, tree.adc_hz), (90_000_000, 22_500_000));
        assert_eq!(tree.pll, Some(0x2840_2D04));
        assert_eq!(tree.cfgr, 0x0000_9402);
        assert_eq!((tree.flash, tree.adc_prescaler, tree.over_drive), (0x605, 1, true));
        assert_eq!(tree.steps(), [0xFC00, 0xFC02, 0x9402]);

        let tree = Tree::new(Speed::Mhz144, Source::HsePll);
        assert_eq!(tree.core_hz, 144_000_000);
        assert_eq!((tree.apb1_hz, tree.apb2_hz), (36_000_000, 72_000_000));
        assert_eq!((tree.timer_hz, tree.adc_hz), (72_000_000, 36_000_000));
        assert_eq!(tree.pll, Some(0x2840_2404));
        assert_eq!((tree.flash, tree.adc_prescaler, tree.over_drive), (0x604, 0, false));

        let internal = Tree::new(Speed::Mhz144, Source::HsiPll);
        assert_eq!(internal.pll, Some(0x2800_2408));
        assert_eq!(Tree { source: tree.source, pll: tree.pll, ..internal }, tree);

        let slow = Tree::new(Speed::Mhz180, Source::Hsi);
        assert_eq!((slow.core_hz, slow.timer_hz, slow.adc_hz), (16_000_000, 16_000_000, 8_000_000));
        assert_eq!((slow.pll, slow.cfgr, slow.flash), (None, 0, 0x600));
    }

    #[test]
    fn no_limit_is_passed() {
        for speed in [Speed::Mhz144, Speed::Mhz180] {
            for source in [Source::HsePll, Source::HsiPll, Source::Hsi] {
                let tree = Tree::new(speed, source);
                // DS table 16: 180, 45 and 90 MHz; DS 6.3.20: 0.6 to 36 MHz.
                assert!(tree.core_hz <= 180_000_000 && tree.apb1_hz <= 45_000_000);
                assert!(tree.apb2_hz <= 90_000_000);
                assert!((600_000..=ADC_LIMIT_HZ).contains(&tree.adc_hz));
                if let Some(pll) = tree.pll {
                    let input = if pll >> 22 & 1 == 1 { HSE_HZ } else { HSI_HZ } / (pll & 63);
                    let vco = input * (pll >> 6 & 511);
                    // RM 6.3.2: input 1 to 2 MHz, VCO 100 to 432 MHz.
                    assert!((1_000_000..=2_000_000).contains(&input));
                    assert!((100_000_000..=432_000_000).contains(&vco));
                    assert_eq!(vco / 2, tree.core_hz);
                }
            }
        }
    }

    // RM 3.4.1, table 5, the column 2.7 to 3.6 V.
    #[test]
    fn wait_states_at_the_edges_of_the_table() {
        for (mhz, wait_states) in
            [(16, 0), (30, 0), (60, 1), (90, 2), (91, 3), (120, 3), (150, 4), (151, 5), (180, 5)]
        {
            assert_eq!(flash_access(mhz * 1_000_000) & 15, wait_states, "{mhz} MHz");
        }
    }
}
