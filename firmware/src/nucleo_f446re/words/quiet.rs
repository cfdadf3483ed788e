//! The chip's measures against the noise that its flash puts on the converters' results (errata ES0298, "Internal noise impacting the ADC
//! accuracy"; application note AN4073).

/// A measure against this noise. The self-test measures the noise with each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quiet {
    /// No measure: flash is read ahead of the program.
    Ahead,
    /// Flash is read when the program needs it, and both caches stay on.
    Still,
    /// Flash without read-ahead, and ADCDC1, which requires it (RM 5.4.1).
    First,
    /// Flash without read-ahead, and ADC1DC2 with ADC2DC2 in place of ADCDC1: for converters of 30 MHz or more that sample simultaneously
    /// (RM 8.2.3).
    Second,
}

impl Quiet {
    /// The measure that the images use.
    pub const USED: Self = Quiet::First;

    /// FLASH_ACR (RM 3.8.1), PRFTEN 8.
    pub const fn prefetch(self) -> u32 {
        match self {
            Quiet::Ahead => 1 << 8,
            _ => 0,
        }
    }

    /// PWR_CR (RM 5.4.1), ADCDC1 13.
    pub const fn power(self) -> u32 {
        match self {
            Quiet::First => ADCDC1,
            _ => 0,
        }
    }

    /// SYSCFG_PMC (RM 8.2.3), ADC1DC2 16 and ADC2DC2 17.
    pub const fn mode(self) -> u32 {
        match self {
            Quiet::Second => ADC_DC2,
            _ => 0,
        }
    }
}

/// The bit of PWR_CR.
pub const ADCDC1: u32 = 1 << 13;
/// The bits of SYSCFG_PMC.
pub const ADC_DC2: u32 = 0b11 << 16;
/// The bit of FLASH_ACR.
pub const PREFETCH: u32 = 1 << 8;

#[cfg(test)]
mod tests {
    use super::*;

    // RM 5.4.1: ADCDC1 only while flash is not read ahead; RM 8.2.3: ADCxDC2 only without ADCDC1.
    #[test]
    fn no_two_bits_that_exclude_each_other() {
        for quiet in [Quiet::Ahead, Quiet::Still, Quiet::First, Quiet::Second] {
            let (ahead, first, second) =
                (quiet.prefetch() != 0, quiet.power() != 0, quiet.mode() != 0);
            assert!(u32::from(ahead) + u32::from(first) + u32::from(second) <= 1, "{quiet:?}");
        }
        assert_eq!(
            (Quiet::USED.prefetch(), Quiet::USED.power(), Quiet::USED.mode()),
            (0, 0x2000, 0)
        );
        assert_eq!((Quiet::Ahead.prefetch(), Quiet::Second.mode()), (0x100, 0x3_0000));
    }
}
