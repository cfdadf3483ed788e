//! The independent watchdog, which recovers a hung instrument.

use picket_wire::boot::Causes;

/// Reset causes from RCC_CSR (RM 6.3.21): LPWR 31, WWDG 30, IWDG 29, SFT 28, POR 27, PIN 26, BOR 25.
pub fn causes(csr: u32) -> Causes {
    let bit = |mask: u32, place: u8| if csr & mask == 0 { 0 } else { 1 << place };
    // Every cause pulls the pin, so the pin counts only if it stands alone.
    let others = bit(1 << 27 | 1 << 25, 0) | bit(1 << 28, 2) | bit(1 << 29, 3);
    let others = others | bit(1 << 31 | 1 << 30, 4);
    Causes(if others == 0 { bit(1 << 26, 1) } else { others })
}

/// The watchdog, whose clock is divided by 64.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Watchdog {
    /// IWDG_RLR (RM 20.4.3).
    pub reload: u16,
}

/// The watchdog's own oscillator in hertz: nominal, slowest and fastest (DS table 43).
pub const LSI_HZ: [u32; 3] = [32_000, 17_000, 47_000];

/// The longest absence of the processing loop, ms: erasing a sector of 16 KB by words takes at most 0.5 s, one of 128 KB, the slowest that
/// the data sheet knows, 2 s (DS table 48).
pub const LONGEST_MS: u32 = 2_000;

impl Watchdog {
    /// A watchdog that bites nominally `ms` after its last feed, up to 8,190 ms.
    pub const fn after(ms: u32) -> Self {
        let ms = if ms > 8_190 { 8_190 } else { ms };
        let ticks = LSI_HZ[0] / 64 * ms / 1_000;
        Watchdog { reload: ticks.saturating_sub(1) as u16 }
    }

    /// Milliseconds until the watchdog bites if its oscillator runs at `lsi_hz`.
    pub const fn milliseconds(self, lsi_hz: u32) -> u32 {
        let cycles = (self.reload as u64 + 1) * 64 * 1_000;
        match cycles.checked_div(lsi_hz as u64) {
            Some(ms) => ms as u32,
            None => u32::MAX,
        }
    }
}

/// The watchdog that the images use.
pub const WATCHDOG: Watchdog = Watchdog::after(4_000);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_watchdog_outlasts_an_erasure_and_no_more_than_8_s() {
        assert_eq!(WATCHDOG, Watchdog { reload: 1_999 });
        let [nominal, slow, fast] = LSI_HZ.map(|hz| WATCHDOG.milliseconds(hz));
        // 2000 ticks of 64 cycles.
        assert_eq!((nominal, slow, fast), (4_000, 7_529, 2_723));
        assert!(fast > LONGEST_MS);
        assert!(Watchdog::after(u32::MAX).reload <= 0xFFF);
        assert_eq!(WATCHDOG.milliseconds(0), u32::MAX);
    }
}
