//! The radar played on a desk: a chip with registers and a FIFO behind an SPI bus, before targets whose echoes follow from the delay of
//! the transmitted phase.

use bgt60trxx::config::Config;
use embassy_futures::{block_on, poll_once};
use embedded_hal_async::{delay::DelayNs, digital, spi};
use picket_dsp::Verdict;
use picket_with_bgt60tr13c::{
    CHIRPS, Memory, N, PERIOD_S, RECEIVERS, REGISTERS, Ramp, frames, run,
};
use std::convert::Infallible;
use std::f64::consts::TAU;

/// Range in the frame's middle, m; velocity, m/s, positive when approaching; amplitude in codes.
type Target = (f64, f64, f64);

/// The chip. A register has its number of 7 bits and 24 bits of data (data sheet, "Serial peripheral interface").
struct Chip {
    registers: [u32; 128],
    fifo: Vec<u8>,
    targets: Vec<Target>,
    noise: u64,
    /// The frames that it may still make. Then its interrupt stays low.
    frames: u32,
}

impl Chip {
    fn new(targets: &[Target], frames: u32) -> Self {
        let mut registers = [0; 128];
        registers[0x02] = 0x00_0303;
        Self { registers, fifo: Vec::new(), targets: targets.to_vec(), noise: 1, frames }
    }

    fn uniform(&mut self) -> f64 {
        self.noise = self.noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.noise >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A frame as the converters write it: receivers in turn, two samples in three bytes, the first sample's high bits first.
    fn frame(&mut self) {
        // The ramp of 37 us ends where the configurator's header says, and rises by 2333 of 2^-20 of 640 MHz each cycle of 80 MHz.
        let (end_hz, rate_hz) = (62.5e9, 2e6);
        let slope = 2333.0 * 640e6 / f64::from(1 << 20) * 80e6;
        let start_hz = end_hz - slope * 37e-6;
        let mut samples = Vec::new();
        for chirp in 0..CHIRPS {
            for n in 0..N {
                let within_s = 37e-6 - (N - n) as f64 / rate_hz;
                let time_s = chirp as f64 * PERIOD_S + within_s;
                let from_middle_s = time_s - 0.5 * (CHIRPS - 1) as f64 * PERIOD_S - 21e-6;
                for receiver in 0..RECEIVERS {
                    let mut code = 2048.0;
                    for (range_m, velocity_mps, codes) in self.targets.clone() {
                        let delay_s =
                            2.0 * (range_m - velocity_mps * from_middle_s) / 299_792_458.0;
                        let cycles =
                            start_hz * delay_s + slope * delay_s * (within_s - 0.5 * delay_s);
                        // Each receiver sees another phase.
                        code += codes * (TAU * (cycles + 0.3 * receiver as f64)).cos();
                    }
                    let noise: f64 = (0..12).map(|_| self.uniform() - 0.5).sum();
                    code += 5.0 * noise;
                    samples.push(code.round().clamp(0.0, 4095.0) as u32);
                }
            }
        }
        for pair in samples.chunks(2) {
            let word = pair[0] << 12 | pair[1];
            self.fifo.extend([(word >> 16) as u8, (word >> 8) as u8, word as u8]);
        }
    }

    fn write(&mut self, address: usize, data: u32) {
        self.registers[address] = data;
        if address == 0 {
            // Resets clear themselves; so does the start.
            self.registers[0] = data & !0xF;
            if data & 0b1110 != 0 {
                self.fifo.clear();
            }
            if data & 1 != 0 && self.frames > 0 {
                self.frames -= 1;
                self.frame();
            }
        }
    }
}

impl Chip {
    /// The interrupt: as many words as the limit says.
    fn is_full(&self) -> bool {
        self.fifo.len() / 3 > (self.registers[0x06] & 0x1FFF) as usize
    }
}

/// A pin or the bus of the chip.
struct Wire<'a>(&'a std::cell::RefCell<Chip>);

impl spi::ErrorType for Wire<'_> {
    type Error = Infallible;
}

impl spi::SpiDevice for Wire<'_> {
    async fn transaction(
        &mut self,
        operations: &mut [spi::Operation<'_, u8>],
    ) -> Result<(), Infallible> {
        let [spi::Operation::TransferInPlace(bytes)] = operations else {
            panic!("not one transfer: {operations:?}")
        };
        let mut chip = self.0.borrow_mut();
        let word = u32::from_be_bytes(bytes[..4].try_into().unwrap());
        let address = (word >> 25) as usize;
        if address == 0x7F {
            // A burst: read, from the FIFO, without a bound.
            assert_eq!(word, 0xFF00_0000 | 0x60 << 17);
            assert!(chip.is_full());
            let words = bytes.len() - 4;
            bytes[..4].fill(0);
            bytes[4..].copy_from_slice(&chip.fifo[..words]);
            chip.fifo.drain(..words);
        } else if word >> 24 & 1 == 1 {
            chip.write(address, word & 0xFF_FFFF);
            bytes.fill(0);
        } else {
            bytes.copy_from_slice(&chip.registers[address].to_be_bytes());
        }
        Ok(())
    }
}

impl embedded_hal::digital::ErrorType for Wire<'_> {
    type Error = Infallible;
}

impl embedded_hal::digital::OutputPin for Wire<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

impl digital::Wait for Wire<'_> {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        if !self.0.borrow().is_full() {
            std::future::pending::<()>().await;
        }
        Ok(())
    }

    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        unimplemented!()
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), Infallible> {
        unimplemented!()
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), Infallible> {
        unimplemented!()
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), Infallible> {
        unimplemented!()
    }
}

impl DelayNs for Wire<'_> {
    async fn delay_ns(&mut self, _: u32) {}
}

/// A hand that nears and one that leaves.
#[test]
fn two_targets_of_every_frame_are_right() {
    let targets = [(0.82, 1.3, 300.0), (0.37, -0.2, 120.0)];
    let chip = std::cell::RefCell::new(Chip::new(&targets, 20));
    let mut memory = Box::new(Memory::NEW);
    let mut seen = 0;
    let parts = (Wire(&chip), Wire(&chip), Wire(&chip), Wire(&chip));
    // It ends when the chip makes no more frames.
    let ended = poll_once(run(parts, &mut memory, |found| {
        assert_eq!(found.len(), targets.len(), "{found:?}");
        for (seen, (range_m, velocity_mps, _)) in found.iter().zip(targets) {
            let target = &seen.target;
            let velocity = target.velocity.unwrap();
            let (range_off, velocity_off) =
                (target.range.to_num::<f64>() - range_m, velocity.to_num::<f64>() - velocity_mps);
            println!(
                "{:.5} m {:+.2} sigma, {velocity:.4} m/s {:+.2} sigma, {}",
                target.range,
                range_off / f64::from(target.sigma_range),
                velocity_off / f64::from(target.sigma_velocity),
                target.verdict
            );
            assert_eq!(target.verdict, Verdict::Good);
            assert!(range_off.abs() < 5.0 * f64::from(target.sigma_range));
            assert!(velocity_off.abs() < 5.0 * f64::from(target.sigma_velocity));
        }
        seen += 1;
    }));
    assert!(ended.is_pending());
    assert_eq!(seen, 20);
}

/// Another chip is refused.
#[test]
fn another_chip_is_refused() {
    let mut other = Chip::new(&[], 1);
    other.registers[0x02] = 0x00_0909;
    let chip = std::cell::RefCell::new(other);
    let mut memory = Box::new(Memory::NEW);
    let parts = (Wire(&chip), Wire(&chip), Wire(&chip), Wire(&chip));
    let ended = block_on(run(parts, &mut memory, |_| panic!("a target")));
    assert!(ended.is_err());
}

/// The ramp that the registers make is the one that the configurator was asked for: ours, and those that the driver comes with.
#[test]
fn the_registers_ramp_is_as_stated() {
    let ours = Ramp::of(&REGISTERS).unwrap();
    assert_eq!((ours.rate_hz, ours.samples), (2e6, 64));
    assert!((ours.start_hz + ours.bandwidth_hz - 62.5e9).abs() < 2e6, "{ours:?}");
    assert!((0.0..0.3e9).contains(&(58.5e9 - ours.start_hz)), "{ours:?}");
    for preset in [Config::test_preset(), Config::high_framerate_preset()] {
        let ramp = Ramp::of(&preset.registers).unwrap();
        let (low, high) = (preset.lower_frequency_hz as f64, preset.upper_frequency_hz as f64);
        assert_eq!(ramp.rate_hz as u32, preset.sample_rate_hz);
        assert_eq!(ramp.samples, u32::from(preset.num_samples_per_chirp));
        assert!((ramp.start_hz + ramp.bandwidth_hz - high).abs() < 2e6, "{ramp:?} {high}");
        // It begins below, so that it is steady where the samples begin.
        assert!((0.0..0.3e9).contains(&(low - ramp.start_hz)), "{ramp:?} {low}");
    }
    assert!(Ramp::of(&REGISTERS[..20]).is_none() && frames(&REGISTERS[..20]).is_err());
}
