//! Targets with range and velocity from Infineon's 60 GHz radar BGT60TR13C: the driver `bgt60trxx` reads a frame of chirps from the
//! radar's FIFO by SPI, a [`Framer`] makes records of the words, a [`Frame`] finds the targets.
//!
//! The radar's settings are the 38 registers that Infineon's configurator exports (`radar_settings.h`). The slope of the ramp and the
//! sample rate follow from them, so that a setting is typed once.
#![no_std]

use bgt60trxx::config::Config;
use bgt60trxx::error::Error;
use bgt60trxx::{Radar, Variant};
use embedded_hal::digital::OutputPin;
use embedded_hal_async::{delay::DelayNs, digital::Wait, spi::SpiDevice};
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::frame::{Cells, Frame, FrameConfig, FrameTarget};
use picket_dsp::{Chirp, Codes, ConfigError, Format, Framer, Pipeline, Plan, Real, Shape, Verdict};

/// Samples of a chirp.
pub const N: usize = 64;
/// Chirps of a frame.
pub const CHIRPS: usize = 32;
/// Receivers, whose samples alternate in the FIFO. The first is measured.
pub const RECEIVERS: usize = 3;
/// From one chirp to the next, s.
pub const PERIOD_S: f64 = 299.787e-6;
/// The crystal, Hz.
const CLOCK_HZ: f64 = 80e6;

/// Chirps of 37 us, 4.2 GHz, every .3 ms: what Infineon's own example of gestures sets (mtb-example-psoc6-radar-gestures,
/// source/radar_settings.h).
#[rustfmt::skip]
pub const REGISTERS: [u32; 38] = [
    0x011e_8270, 0x030a_0210, 0x09e9_67fd, 0x0b08_05b4, 0x0d10_2bff, 0x0f01_0d00, 0x1100_0000,
    0x1300_0000, 0x1500_0000, 0x1700_0be0, 0x1900_0000, 0x1b00_0000, 0x1d00_0000, 0x1f00_0b60,
    0x2113_fc51, 0x237f_f41f, 0x2500_0c63, 0x2d00_0490, 0x3b00_0480, 0x4900_0480, 0x5700_0480,
    0x5911_be0e, 0x5b56_040a, 0x5d01_f000, 0x5f78_7e1e, 0x61b1_2902, 0x6300_091d, 0x6500_0172,
    0x6700_0040, 0x6900_0000, 0x6b00_0000, 0x6d00_0000, 0x6f2a_0b10, 0x7f00_0100, 0x8f00_0100,
    0x9f00_0100, 0xad00_0000, 0xb700_0000,
];

/// What the registers say of the ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// Where it begins, Hz.
    pub start_hz: f64,
    /// How far it goes, Hz.
    pub bandwidth_hz: f64,
    /// How long it takes, s.
    pub duration_s: f64,
    /// Samples a second of each receiver.
    pub rate_hz: f64,
    /// Samples of a chirp.
    pub samples: u32,
}

impl Ramp {
    /// Reads it from the registers ADC0, PLL1_0 to PLL1_3 (data sheet, "PLL chirp registers"). `None` if one is missing.
    pub fn of(registers: &[u32]) -> Option<Self> {
        let register = |address: u32| {
            let word = registers.iter().find(|&&word| word >> 25 == address);
            word.map(|word| word & 0xFF_FFFF)
        };
        let divider = register(0x01)? >> 14;
        // The numbers of 24 bits have a sign.
        let signed = |word: u32| f64::from(((word << 8) as i32) >> 8);
        let (start, step) = (signed(register(0x30)?), signed(register(0x31)?));
        // The synthesiser runs at 8 times the crystal; a number counts 2^-20 of that, and a step is added at each cycle of the crystal.
        let unit_hz = 8.0 * CLOCK_HZ / f64::from(1 << 20);
        let cycles = 8.0 * f64::from(register(0x32)? & 0x3FFF);
        Some(Self {
            start_hz: 96.0 * 8.0 * CLOCK_HZ + start * unit_hz,
            bandwidth_hz: step * cycles * unit_hz,
            duration_s: cycles / CLOCK_HZ,
            rate_hz: CLOCK_HZ / f64::from(divider),
            samples: register(0x33)? & 0xFFF,
        })
    }
}

/// Bytes of a frame in the FIFO, two samples in three, behind the four of the command.
const BYTES: usize = 4 + N * CHIRPS * RECEIVERS * 3 / 2;
/// Cells of a frame: all bins that are ranges.
const CELLS: usize = N / 2 * CHIRPS;

/// The memory of a frame: 26 KB, for a `static`.
pub struct Memory {
    bytes: [u8; BYTES],
    words: [u16; N * CHIRPS * RECEIVERS],
    cells: [[i16; 2]; CELLS],
}

impl Memory {
    /// Empty.
    pub const NEW: Self =
        Self { bytes: [0; BYTES], words: [0; N * CHIRPS * RECEIVERS], cells: [[0; 2]; CELLS] };
}

/// What frames are made of these registers.
///
/// # Errors
/// [`ConfigError::Scene`] for registers that are missing, [`ConfigError::Length`] for another number of samples.
pub fn frames(registers: &[u32]) -> Result<FrameConfig, ConfigError> {
    let ramp = Ramp::of(registers).ok_or(ConfigError::Scene)?;
    if ramp.samples as usize != N {
        return Err(ConfigError::Length);
    }
    let chirp = Chirp {
        shape: Shape::Sawtooth,
        wavelength_m: SPEED_OF_LIGHT / ramp.start_hz,
        bandwidth_hz: ramp.bandwidth_hz,
        duration_s: ramp.duration_s,
        guard_s: ramp.duration_s - N as f64 / ramp.rate_hz,
        ..Chirp::default()
    };
    Ok(FrameConfig {
        // Within the 8.3 m/s after which velocities repeat.
        velocity_mps: Some((-4.0, 4.0)),
        ..FrameConfig::new(chirp, ramp.rate_hz, N, false, CHIRPS, PERIOD_S)
    })
}

/// Measures frame after frame, and hands over the targets of each, the strongest first. Returns what went wrong: begin anew then.
///
/// The radar stands still during the search, because its FIFO holds no more than two frames.
pub async fn run<SPI, RST, IRQ, DLY>(
    (spi, reset, interrupt, delay): (SPI, RST, IRQ, DLY),
    memory: &mut Memory,
    mut each: impl FnMut(&[FrameTarget]),
) -> Result<core::convert::Infallible, Error>
where
    SPI: SpiDevice,
    RST: OutputPin,
    IRQ: Wait,
    DLY: DelayNs,
{
    let Memory { bytes, words, cells } = memory;
    let plan = frames(&REGISTERS).and_then(|frames| frames.plan());
    let frame = plan.ok().and_then(|plan| Frame::new(plan, Cells::Narrow(cells)));
    let (Some(mut frame), Some(ramp)) = (frame, Ramp::of(&REGISTERS)) else {
        return Err(Error::NoConfigSet);
    };
    let plan = Plan::tone(ramp.rate_hz, Codes::unsigned::<12>());
    let mut pipeline = Pipeline::<Real, N>::new(plan);
    let mut framer = Framer::<Real, N>::new(Format::unsigned::<12>());
    let mut radar = Radar::new(Variant::BGT60TR13C, spi, reset, interrupt, delay).await?;
    radar.configure(settings(&ramp)).await?;
    loop {
        radar.start().await?;
        radar.get_fifo_data(bytes, words).await?;
        radar.reset_fifo().await?;
        frame.clear();
        let mut complete = false;
        for chirp in words.chunks_exact(N * RECEIVERS) {
            let mut first = [0; N];
            let samples = chirp.iter().step_by(RECEIVERS);
            first.iter_mut().zip(samples).for_each(|(first, &word)| *first = word);
            framer.push(&first, |_, samples| {
                let clipped = pipeline.look(samples);
                complete = frame.push(&pipeline.spectrum().view(), clipped);
            });
        }
        if complete {
            each(&frame.targets());
        }
    }
}

/// Whether something surely comes nearer, by 10 cm a second or more.
pub fn is_nearing(seen: &FrameTarget) -> bool {
    let target = &seen.target;
    target.verdict == Verdict::Good && target.velocity.is_some_and(|velocity| velocity > 0.1)
}

/// The same as the driver wants it.
fn settings(ramp: &Ramp) -> Config {
    Config {
        rx_antennas: RECEIVERS as u8,
        tx_antennas: 1,
        tx_power_level: 31,
        if_gain_db: 60,
        lower_frequency_hz: ramp.start_hz as u64,
        upper_frequency_hz: (ramp.start_hz + ramp.bandwidth_hz) as u64,
        num_chirps_per_frame: CHIRPS as u8,
        num_samples_per_chirp: N as u16,
        chirp_repetition_time_s: PERIOD_S,
        frame_repetition_time_s: 0.030_044_6,
        sample_rate_hz: ramp.rate_hz as u32,
        registers: REGISTERS,
    }
}
