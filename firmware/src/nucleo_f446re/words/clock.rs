//! The clock tree, from the probe's 8 MHz or the internal 16 MHz to core, buses and converter.
//!
//! Two speeds give the converter its two best rates. A sample takes 15 cycles of at most 36 MHz (DS
//! 6.3.20): at 144 MHz the converter has 36 MHz and 2.4 MS/s, at 180 MHz it has 22.5 MHz and 1.5
//! MS/s.

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

/// The multiplier: its output is halved (PLLP).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Multiplier {
    /// PLLM: what divides its input.
    pub divider: u8,
    /// PLLN: what multiplies the divided input.
    pub factor: u16,
}

/// The frequencies of the tree, in hertz, and what makes them.
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
    /// The multiplier (RM 6.3.2), behind which the buses run at a quarter and half of the core's clock; `None` without it.
    pub pll: Option<Multiplier>,
    /// Wait states of the flash.
    pub wait_states: u8,
    /// Whether the regulator needs its over-drive (RM 5.1.4): above 168 MHz.
    pub over_drive: bool,
}

/// The fastest clock of the converter, Hz (DS 6.3.20).
const ADC_LIMIT_HZ: u32 = 36_000_000;

impl Tree {
    /// The tree for this speed from this source.
    pub const fn new(speed: Speed, source: Source) -> Self {
        let (input, divider) = match source {
            Source::HsePll => (HSE_HZ, 4),
            Source::HsiPll => (HSI_HZ, 8),
            Source::Hsi => return Self::internal(),
        };
        // The multiplier's input is 2 MHz, as RM 6.3.2 recommends against jitter.
        let factor = speed.mhz();
        let core_hz = input / divider as u32 * factor as u32 / 2;
        let (apb1_hz, apb2_hz) = (core_hz / 4, core_hz / 2);
        Tree {
            source,
            core_hz,
            apb1_hz,
            apb2_hz,
            timer_hz: 2 * apb1_hz,
            adc_hz: apb2_hz / if apb2_hz / 2 <= ADC_LIMIT_HZ { 2 } else { 4 },
            pll: Some(Multiplier { divider, factor }),
            wait_states: wait_states(core_hz),
            over_drive: core_hz > 168_000_000,
        }
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
            wait_states: wait_states(HSI_HZ),
            over_drive: false,
        }
    }
}

/// The flash's wait states at 2.7 to 3.6 V: one for every 30 MHz begun after the first (RM 3.4.1, table 5).
pub const fn wait_states(core_hz: u32) -> u8 {
    (core_hz.saturating_sub(1) / 30_000_000) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_speeds_from_both_oscillators() {
        let tree = Tree::new(Speed::Mhz180, Source::HsePll);
        assert_eq!(tree.core_hz, 180_000_000);
        assert_eq!((tree.apb1_hz, tree.apb2_hz), (45_000_000, 90_000_000));
        assert_eq!((tree.timer_hz, tree.adc_hz), (90_000_000, 22_500_000));
        assert_eq!((tree.wait_states, tree.over_drive), (5, true));

        let tree = Tree::new(Speed::Mhz144, Source::HsePll);
        assert_eq!(tree.core_hz, 144_000_000);
        assert_eq!((tree.apb1_hz, tree.apb2_hz), (36_000_000, 72_000_000));
        assert_eq!((tree.timer_hz, tree.adc_hz), (72_000_000, 36_000_000));
        assert_eq!((tree.wait_states, tree.over_drive), (4, false));

        let internal = Tree::new(Speed::Mhz144, Source::HsiPll);
        assert_eq!(Tree { source: tree.source, pll: tree.pll, ..internal }, tree);

        let slow = Tree::new(Speed::Mhz180, Source::Hsi);
        assert_eq!((slow.core_hz, slow.timer_hz, slow.adc_hz), (16_000_000, 16_000_000, 8_000_000));
        assert_eq!((slow.pll, slow.wait_states), (None, 0));
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
                if let Some(Multiplier { divider, factor }) = tree.pll {
                    let oscillator = if source == Source::HsePll { HSE_HZ } else { HSI_HZ };
                    let input = oscillator / u32::from(divider);
                    let vco = input * u32::from(factor);
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
        for (mhz, wanted) in
            [(16, 0), (30, 0), (60, 1), (90, 2), (91, 3), (120, 3), (150, 4), (151, 5), (180, 5)]
        {
            assert_eq!(wait_states(mhz * 1_000_000), wanted, "{mhz} MHz");
        }
    }
}
