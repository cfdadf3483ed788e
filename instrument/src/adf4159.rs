//! The ramp synthesiser ADF4159 by Analog Devices, as 24 GHz radar heads carry it: a phase-locked
//! loop that steps its own fraction.
//!
//! Equations and bits are from its data sheet, revision E: RF = f_PFD (INT + FRAC / 2^25) (eq. 1, 2), f_PFD = REF (1 + D) / (R (1 + T))
//! (eq. 3), step f_DEV = f_PFD / 2^25 * DEV * 2^OFFSET (eq. 5), time of a step CLK1 * CLK2 / f_PFD (eq. 6). The words are written from R7
//! to R0; words with two selections are written twice.

use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
use picket_dsp::solve::chirp::Shape;
use picket_wire::settings_error::RampError;

/// The ramps to make. Frequencies are at the RF input, behind the radar head's own divider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramps {
    /// The crystal at REF_IN, Hz: 10 to 110 MHz. The chip takes up to 260 MHz, but needs a divider
    /// above 110 MHz.
    pub reference_hz: f64,
    /// The lowest frequency, Hz: 0.5 to 13 GHz.
    pub start_hz: f64,
    /// Rise of a ramp, Hz.
    pub bandwidth_hz: f64,
    /// Duration of a ramp, s. The flat top of a trapezoid has the same duration.
    pub duration_s: f64,
    /// The ramps.
    pub shape: Shape,
    /// Whether a rise at TX_DATA, from the board's sync output, starts each ramp; otherwise the
    /// ramps run freely.
    pub triggered: bool,
}

/// The modulus of the fraction.
const MODULUS: f64 = (1u64 << 25) as f64;
/// The shortest step, in cycles of f_PFD: CLK1 * CLK2 with CLK2 = 1. The loop cannot follow shorter steps.
const CLK1: u32 = 50;

/// The eleven words, in the order of writing.
pub type Words = [u32; 11];

/// A signed number of `bits` bits in its two's complement.
const fn field(value: i32, bits: u32) -> u32 {
    value as u32 & ((1 << bits) - 1)
}

impl Ramps {
    /// The register words.
    ///
    /// # Errors
    /// A frequency, the bandwidth or the duration is out of the chip's range.
    pub fn words(&self) -> Result<Words, RampError> {
        let pfd = self.reference_hz;
        if !(10e6..=110e6).contains(&pfd) {
            return Err(RampError::Reference);
        }
        let (start, stop) = (self.start_hz, self.start_hz + self.bandwidth_hz);
        // All frequencies above 8 GHz need the prescaler 8/9, which needs INT of 75 or more.
        let whole = start / pfd;
        if !(start >= 0.5e9 && stop <= 13e9 && (75.0..4096.0).contains(&whole)) {
            return Err(RampError::Frequency);
        }
        let integer = whole as u32;
        let fraction = libm::round((whole - f64::from(integer)) * MODULUS) as u32;
        // Rounding may carry into the integer.
        let (integer, fraction) =
            if fraction >> 25 == 0 { (integer, fraction) } else { (integer + 1, 0) };
        let step = self.step()?;
        let (mode, delay) = match self.shape {
            // RAMP MODE R3 11:10: 0 continuous sawtooth, 1 continuous triangle, 2 single sawtooth.
            Shape::Sawtooth if self.triggered => (2, 0),
            Shape::Sawtooth => (0, 0),
            Shape::Triangle => (1, 0),
            // Ramp delay (17) in a triangle (22), which clips it, counted in steps' clocks (16).
            Shape::Trapezoid => (1, self.delay()? << 3 | 1 << 17 | 1 << 22 | 1 << 16),
        };
        let trigger = u32::from(self.triggered) << 20;
        let clocks = 3 << 19 | step.clk2 << 7;
        let deviation = step.offset << 19 | field(step.deviation, 16) << 3;
        Ok([
            trigger | delay | 7,
            step.count << 3 | 6,
            1 << 23 | step.count << 3 | 6,
            deviation | 5,
            1 << 23 | deviation | 5,
            clocks | 4,
            1 << 6 | clocks | 4,
            // Bit 17 is reserved and set; positive polarity (6).
            1 << 17 | mode << 10 | 1 << 6 | 3,
            // Charge pump 2.5 mA (27:24 = 7), prescaler 8/9 (22), R = 1 (19:15), CLK1 (14:3).
            7 << 24 | 1 << 22 | 1 << 15 | CLK1 << 3 | 2,
            (fraction & 0x1FFF) << 15 | 1,
            // Ramps on (31), digital lock detect at MUXOUT (30:27 = 6).
            1 << 31 | 6 << 27 | integer << 15 | (fraction >> 13) << 3,
        ])
    }

    fn step(&self) -> Result<Step, RampError> {
        let steps = |clk2: u32| self.duration_s * self.reference_hz / f64::from(CLK1 * clk2);
        // The word for the number of steps has 20 bits.
        let clk2 = (1..4096).find(|&clk2| steps(clk2) < 1_048_575.5).ok_or(RampError::Ramp)?;
        let count = libm::round(steps(clk2));
        // NaN fails this test, too.
        if !(2.0..=1_048_575.0).contains(&count) {
            return Err(RampError::Ramp);
        }
        let wanted = self.bandwidth_hz / count / (self.reference_hz / MODULUS);
        // The smallest exponent for which the word is below 2^15.
        let scaled = |offset: u32| libm::round(wanted / f64::from(1u32 << offset));
        let offset = (0..10).find(|&offset| scaled(offset) < 32_767.5).ok_or(RampError::Ramp)?;
        let deviation = scaled(offset) as i32;
        if deviation < 1 {
            return Err(RampError::Ramp);
        }
        Ok(Step { count: count as u32, clk2, deviation, offset })
    }

    /// The duration of the flat top, in cycles of f_PFD times CLK1: 12 bits.
    fn delay(&self) -> Result<u32, RampError> {
        let delay = libm::round(self.duration_s * self.reference_hz / f64::from(CLK1));
        if (1.0..4096.0).contains(&delay) { Ok(delay as u32) } else { Err(RampError::Ramp) }
    }

    /// The true bandwidth in Hz and the true duration in s of the words.
    ///
    /// # Errors
    /// The errors of [`Ramps::words`].
    pub fn actual(&self) -> Result<(f64, f64), RampError> {
        let Step { count, clk2, deviation, offset } = self.step()?;
        let step_hz =
            self.reference_hz / MODULUS * f64::from(deviation) * f64::from(1u32 << offset);
        let step_s = f64::from(CLK1 * clk2) / self.reference_hz;
        Ok((step_hz * f64::from(count), step_s * f64::from(count)))
    }
}

struct Step {
    count: u32,
    clk2: u32,
    deviation: i32,
    offset: u32,
}

/// The chip on its bus. The bus's chip select is the chip's LE, because a word is taken over when
/// LE rises.
#[derive(Debug)]
pub struct Adf4159<S, P> {
    spi: S,
    enable: P,
}

/// The reason why a word did not reach the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusError<S, P> {
    /// The bus failed.
    Spi(S),
    /// The enable pin failed.
    Pin(P),
}

impl<S: SpiDevice, P: OutputPin> Adf4159<S, P> {
    /// The chip, before the first word.
    pub const fn new(spi: S, enable: P) -> Self {
        Self { spi, enable }
    }

    /// Switches the chip on (CE) and writes all words, from R7 to R0.
    ///
    /// # Errors
    /// The bus or the pin failed.
    pub fn start(&mut self, words: &Words) -> Result<(), BusError<S::Error, P::Error>> {
        self.enable.set_high().map_err(BusError::Pin)?;
        words.iter().try_for_each(|word| self.spi.write(&word.to_be_bytes())).map_err(BusError::Spi)
    }

    /// Switches the chip off.
    ///
    /// # Errors
    /// The pin failed.
    pub fn stop(&mut self) -> Result<(), BusError<S::Error, P::Error>> {
        self.enable.set_low().map_err(BusError::Pin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal::digital;
    use embedded_hal::spi::{self, Operation};
    use std::{vec, vec::Vec};

    /// An initialisation published with the maker's evaluation software: reference 100 MHz, 12.0125
    /// GHz, triangle.
    const RAMPS: Ramps = Ramps {
        reference_hz: 100e6,
        start_hz: 12.0125e9,
        bandwidth_hz: 91e6,
        duration_s: 280e-6,
        shape: Shape::Triangle,
        triggered: false,
    };

    #[test]
    fn words_are_those_of_the_makers_software_where_the_choice_is_the_same() {
        let [r7, r6, r6b, r5, r5b, r4, r4b, r3, r2, r1, r0] = RAMPS.words().unwrap();
        // INT 120, FRAC 512 << 13; MUXOUT differs.
        assert_eq!(r0 & !(15 << 27), 0xF83C_1000 & !(15 << 27));
        assert_eq!(r1 & 0x0FFF_8007, 1);
        assert_eq!(r2, 0x0740_8192);
        // The words differ in the bleed current, which is off here.
        assert_eq!(r3, 0x00C2_0443 & !(7 << 22));
        assert_eq!((r4, r4b), (0x0018_0084, 0x0018_00C4));
        // 280 us in steps of 0.5 us; 162.5 kHz are 54,525.95 times 2.98 Hz, which is 27,263 << 1.
        assert_eq!((r6, r6b), (560 << 3 | 6, 1 << 23 | 560 << 3 | 6));
        assert_eq!((r5, r5b), (1 << 19 | 27_263 << 3 | 5, 1 << 23 | 1 << 19 | 27_263 << 3 | 5));
        assert_eq!(r7, 7);
    }

    #[test]
    fn a_trapezoid_is_a_clipped_triangle_started_by_a_pulse() {
        let trapezoid = Ramps { shape: Shape::Trapezoid, triggered: true, ..RAMPS };
        let [r7, ..] = trapezoid.words().unwrap();
        assert_eq!(r7, 560 << 3 | 1 << 16 | 1 << 17 | 1 << 20 | 1 << 22 | 7);
        let sawtooth = Ramps { shape: Shape::Sawtooth, triggered: true, ..RAMPS };
        assert_eq!(sawtooth.words().unwrap()[7] >> 10 & 3, 2);
    }

    #[test]
    fn what_the_words_make_is_what_was_asked() {
        for (bandwidth_hz, duration_s) in
            [(91e6, 280e-6), (200e6, 2.2e-3), (15e6, 20e-3), (500e6, 50e-6), (10e6, 1.0)]
        {
            let ramps = Ramps { bandwidth_hz, duration_s, ..RAMPS };
            ramps.words().unwrap();
            let (hz, s) = ramps.actual().unwrap();
            // Half a step of the word, which is at least 2^14 unless the ramp is slow, and half a
            // step of time.
            assert!((s - duration_s).abs() <= 0.25e-6 + duration_s * 1e-6, "{s} {duration_s}");
            let resolution = 0.5 * 100e6 / MODULUS * (duration_s / 0.5e-6).min(1_048_576.0);
            assert!(
                (hz - bandwidth_hz).abs() <= resolution + bandwidth_hz / 3e4,
                "{hz} {bandwidth_hz}"
            );
        }
    }

    #[test]
    fn what_cannot_be_made() {
        let fails = |ramps: Ramps, error| assert_eq!(ramps.words(), Err(error), "{ramps:?}");
        fails(Ramps { reference_hz: 5e6, ..RAMPS }, RampError::Reference);
        fails(Ramps { reference_hz: f64::NAN, ..RAMPS }, RampError::Reference);
        fails(Ramps { start_hz: 0.4e9, ..RAMPS }, RampError::Frequency);
        fails(Ramps { start_hz: 6e9, ..RAMPS }, RampError::Frequency);
        fails(Ramps { start_hz: 12.95e9, ..RAMPS }, RampError::Frequency);
        fails(Ramps { duration_s: 0.0, ..RAMPS }, RampError::Ramp);
        fails(Ramps { duration_s: f64::NAN, ..RAMPS }, RampError::Ramp);
        fails(Ramps { duration_s: 1e4, ..RAMPS }, RampError::Ramp);
        fails(Ramps { bandwidth_hz: 0.0, ..RAMPS }, RampError::Ramp);
        fails(Ramps { shape: Shape::Trapezoid, duration_s: 3e-3, ..RAMPS }, RampError::Ramp);
    }

    /// A bus that keeps the words written, and fails if `fails` is set.
    #[derive(Default)]
    struct Bus {
        words: Vec<u32>,
        fails: bool,
    }

    impl spi::ErrorType for &mut Bus {
        type Error = spi::ErrorKind;
    }

    impl SpiDevice for &mut Bus {
        fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
            for operation in operations {
                match operation {
                    // One selection for each word: LE must rise after each.
                    &mut Operation::Write(&[a, b, c, d]) if !self.fails => {
                        self.words.push(u32::from_be_bytes([a, b, c, d]));
                    }
                    _ => return Err(spi::ErrorKind::Other),
                }
            }
            Ok(())
        }
    }

    struct Pin(Option<bool>);

    impl digital::ErrorType for Pin {
        type Error = core::convert::Infallible;
    }

    impl OutputPin for Pin {
        fn set_low(&mut self) -> Result<(), Self::Error> {
            self.0 = Some(false);
            Ok(())
        }
        fn set_high(&mut self) -> Result<(), Self::Error> {
            self.0 = Some(true);
            Ok(())
        }
    }

    #[test]
    fn words_go_out_from_r7_to_r0_and_a_deaf_bus_is_told() {
        let words = RAMPS.words().unwrap();
        let mut bus = Bus::default();
        let mut chip = Adf4159::new(&mut bus, Pin(None));
        chip.start(&words).unwrap();
        assert_eq!(chip.enable.0, Some(true));
        chip.stop().unwrap();
        assert_eq!(chip.enable.0, Some(false));
        assert_eq!(bus.words, words);
        let addresses: Vec<u32> = bus.words.iter().map(|word| word & 7).collect();
        assert_eq!(addresses, vec![7, 6, 6, 5, 5, 4, 4, 3, 2, 1, 0]);
        bus.fails = true;
        let told = Adf4159::new(&mut bus, Pin(None)).start(&words);
        assert_eq!(told, Err(BusError::Spi(spi::ErrorKind::Other)));
    }
}
