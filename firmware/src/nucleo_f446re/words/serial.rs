//! USART2, which appears on the host as a serial port of the board's probe.

/// Bits per second.
pub const BAUD: u32 = 921_600;

/// USART_BRR for a rate on a bus (RM 25.4.4, with 16 samples a bit): cycles of the bus in a bit,
/// rounded.
pub const fn divider(bus_hz: u32, baud: u32) -> u16 {
    match (bus_hz as u64 + baud as u64 / 2).checked_div(baud as u64) {
        Some(cycles) if cycles >= 16 => cycles as u16,
        // No bit is shorter than its 16 samples.
        _ => 16,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nucleo_f446re::words::clock::{Source, Speed, Tree};

    #[test]
    fn rates_are_near_enough_at_every_clock() {
        let error = |bus_hz: u32| {
            let baud = f64::from(bus_hz) / f64::from(divider(bus_hz, BAUD));
            (baud / f64::from(BAUD) - 1.0) * 100.0
        };
        // 36 MHz / 39 = 923,077; 45 MHz / 49 = 918,367; 16 MHz / 17 = 941,176.
        assert_eq!(divider(36_000_000, BAUD), 39);
        assert_eq!(divider(45_000_000, BAUD), 49);
        assert_eq!(divider(16_000_000, BAUD), 17);
        for speed in [Speed::Mhz144, Speed::Mhz180] {
            assert!(error(Tree::new(speed, Source::HsePll).apb1_hz).abs() < 0.36);
        }
        // RM 25.4.5, table 153: a receiver tolerates 3.75 %. The internal oscillator adds its own 1
        // %.
        assert!(error(Tree::new(Speed::Mhz180, Source::Hsi).apb1_hz).abs() + 1.0 < 3.75);
        assert_eq!(divider(1, BAUD), 16);
        assert_eq!(divider(1, 0), 16);
    }
}
