//! The functions of the board's pins, and the clocks of the peripherals.
//!
//! | pin | Arduino | use |
//! |---|---|---|
//! | PA0, PA1 | A0, A1 | the converters' inputs: in phase, quadrature |
//! | PA2, PA3 | - | USART2 to the probe |
//! | PA4 | A2 | DAC: the chirp |
//! | PA5, PA7 | D13, D11 | SPI1 to a synthesiser: clock, data |
//! | PB6, PB5 | D10, D4 | the synthesiser's LE and CE |
//! | PB10 | D6 | sync output |
//! | PB3 | D3 | sync input |

/// The words of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Port {
    /// GPIOx_MODER (RM 7.4.1): 0 input, 1 output, 2 alternate, 3 analog.
    pub mode: u32,
    /// GPIOx_OSPEEDR (RM 7.4.3).
    pub speed: u32,
    /// GPIOx_PUPDR (RM 7.4.4): 1 up, 2 down.
    pub pull: u32,
    /// GPIOx_AFRL and AFRH (RM 7.4.9).
    pub alternate: [u32; 2],
}

/// The setting of a pin, over the port's reset values.
struct Pin {
    number: u32,
    mode: u32,
    alternate: u32,
    pull: u32,
}

const fn pin(number: u32, mode: u32, alternate: u32, pull: u32) -> Pin {
    Pin { number, mode, alternate, pull }
}

impl Port {
    const fn with(self, pin: Pin) -> Self {
        let Pin { number, mode, alternate, pull } = pin;
        let (two, four) = (2 * number, 4 * (number % 8));
        let [low, high] = self.alternate;
        let alternate = match number {
            0..8 => [low | alternate << four, high],
            _ => [low, high | alternate << four],
        };
        Port {
            mode: self.mode & !(3 << two) | mode << two,
            // Alternate functions switch at 50 MHz; analog pins do not switch.
            speed: self.speed | if mode == 2 { 2 << two } else { 0 },
            pull: self.pull & !(3 << two) | pull << two,
            alternate,
        }
    }
}

/// Port A (reset values of RM 7.4: the debugger's pins).
pub const PORT_A: Port =
    Port { mode: 0xA800_0000, speed: 0x0C00_0000, pull: 0x6400_0000, alternate: [0; 2] }
        .with(pin(0, 3, 0, 0))
        .with(pin(1, 3, 0, 0))
        // AF7 USART2 (DS table 11). The receiver rests high.
        .with(pin(2, 2, 7, 0))
        .with(pin(3, 2, 7, 1))
        .with(pin(4, 3, 0, 0))
        // AF5 SPI1.
        .with(pin(5, 2, 5, 0))
        .with(pin(7, 2, 5, 0));

/// Port B.
pub const PORT_B: Port =
    Port { mode: 0x0000_0280, speed: 0x0000_00C0, pull: 0x0000_0100, alternate: [0; 2] }
        // AF1 TIM2: CH2 is the sync input, CH3 the output. The input rests low.
        .with(pin(3, 2, 1, 2))
        .with(pin(5, 1, 0, 0))
        .with(pin(6, 1, 0, 0))
        .with(pin(10, 2, 1, 0));

/// GPIOB_BSRR: sets LE.
pub const LE_HIGH: u32 = 1 << 6;
/// GPIOB_BSRR: clears LE.
pub const LE_LOW: u32 = 1 << 22;
/// GPIOB_BSRR: sets CE.
pub const CE_HIGH: u32 = 1 << 5;
/// GPIOB_BSRR: clears CE.
pub const CE_LOW: u32 = 1 << 21;

/// RCC_AHB1ENR (RM 6.3.10): DMA2 22, DMA1 21, GPIOB 1, GPIOA 0.
pub const AHB1: u32 = 1 << 22 | 1 << 21 | 0b11;
/// RCC_APB1ENR (RM 6.3.13): DAC 29, PWR 28, USART2 17, TIM5 to TIM2 3:0.
pub const APB1: u32 = 1 << 29 | 1 << 28 | 1 << 17 | 0b1111;
/// RCC_APB2ENR (RM 6.3.14): SYSCFG 14, SPI1 12, ADC2 9, ADC1 8.
pub const APB2: u32 = 1 << 14 | 1 << 12 | 0b11 << 8;

/// SPI1_CR1 (RM 26.7.1): select by software 9:8, on 6, a sixteenth of the bus (5.6 MHz at most) 5:3, master 2, mode 0.
pub const SPI_CR1: u32 = 0b11 << 8 | 1 << 6 | 3 << 3 | 1 << 2;

#[cfg(test)]
mod tests {
    use super::*;

    // RM 7.4, worked out by hand.
    #[test]
    fn ports() {
        assert_eq!(PORT_A.mode, 0xA800_8BAF);
        assert_eq!(PORT_A.pull, 0x6400_0040);
        assert_eq!(PORT_A.alternate, [0x5050_7700, 0]);
        assert_eq!(PORT_A.speed, 0x0C00_88A0);
        assert_eq!(PORT_B.mode, 0x0020_1680);
        assert_eq!(PORT_B.pull, 0x0000_0180);
        assert_eq!(PORT_B.alternate, [0x0000_1000, 0x0000_0100]);
    }

    // RM 6.3.10 to 6.3.14, 26.7.1.
    #[test]
    fn clocks_and_spi() {
        assert_eq!((AHB1, APB1, APB2), (0x0060_0003, 0x3002_000F, 0x0000_5300));
        assert_eq!(SPI_CR1, 0x035C);
    }
}
