//! The settings of an instrument, as plain values that every board reads. A board turns them into
//! its own register words and checks them as a whole. It changes nothing before everything fits.
//!
//! | offset | field |
//! |---|---|
//! | 0 | version of this layout: u8, 1, or 2 if more than one tone is reported, or 3 to 6 |
//! | 1 | drive: u8, 0 none, 1 DAC, 2 ADF4159, 3 external |
//! | 2 | divider before the synthesiser: u8 |
//! | 3 | flags: u8, bit 0 measures from power-on, bit 1 leaves the converter's codes uncorrected, bits 2 and 3 tones reported a block less one |
//! | 4 | core's clock, MHz; guard; blocks a record; DAC's low and high code; slots: 6 u16 |
//! | 16 | synthesiser's crystal, carrier at the bottom of a ramp: 2 f64, Hz |
//! | 32 | clock's error, ppm; range's offset, m; range's slope: 3 f32 |
//! | 44 | the measurement's configuration: as in a capture's header |
//! | 128 | only from version 3 on: the curvature of a chirp's sweep: f64 |
//! | 136 | only from version 4 on: the carrier's linewidth and the bandwidth of its envelope: 2 f32, Hz |
//! | 144 | only from version 5 on: the mode: u8, 0 blocks, 1 sums, 2 bursts; u8, bit 0 wants a rate that holds for the worst block; zero: 2 bytes; blocks of a sum or the hold-off: u32; drift or ratio: f32, a ratio of 0 for the usual one; least energy of a burst: u32 |
//! | 160 | only in version 6: the bounds of a target's range, m, and of its velocity, m/s, low end first: 4 f64, NaN where there is none |
//!
//! Version 3 is that of settings whose sweep is curved or whose mixing is the less usual one: readers without these would take a
//! straight sweep and the usual mixing, so they refuse it. Version 4 is that of settings with a carrier of its own width, version 5 that of sums, bursts and rates for the worst block, version 6 that of bounds of range or velocity. All other settings are, byte for byte, what earlier programs write.
//! A chirp's [`Chirp::guard_s`] is not sent: it follows from guard and rate.
//!
//! The layout has no checksum of its own. The frame that carries it has one, and so has the flash
//! page that keeps it.

use crate::bytes::{Reader, Writer};
use crate::config;
use crate::config::EncodingError;
use crate::settings_error::SettingsError;
use fixed::types::I32F32;
use heapless::Vec;
use picket_dsp::acquire::burst::Trigger;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier;
use picket_dsp::config::{Config, Scene};
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_dsp::solve::equations::Chirp;
#[cfg(doc)]
use picket_dsp::tone::lines::MOST;

/// The largest number of guard samples before a block.
pub const GUARD: u16 = 64;

/// The source of the chirp.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Drive {
    /// Nothing: a continuous wave.
    #[default]
    Off,
    /// The board's DAC, between two codes.
    Dac {
        /// The code at the lowest frequency.
        low: u16,
        /// The code at the highest frequency.
        high: u16,
    },
    /// A ramp synthesiser on SPI1.
    Adf4159 {
        /// Frequency of its crystal, Hz.
        reference_hz: f64,
        /// Carrier at the bottom of a ramp, Hz.
        start_hz: f64,
        /// The radar head's divider between the carrier and the synthesiser.
        divider: u8,
    },
    /// An external source, which marks the start of each chirp by a rise at the sync input.
    External,
}

/// Corrections from a comparison with known references.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// How much faster than nominal the sample clock runs, parts per million.
    pub clock_ppm: f32,
    /// Offset of the range, m: true range = slope * measured range + offset.
    pub range_offset_m: f32,
    /// Slope of the range, 0.5 to 2; see `range_offset_m`.
    pub range_slope: f32,
}

impl Default for Calibration {
    fn default() -> Self {
        Self { clock_ppm: 0.0, range_offset_m: 0.0, range_slope: 1.0 }
    }
}

impl Calibration {
    /// The clock's error beyond which a board refuses the settings, parts per million.
    pub const MOST_PPM: f32 = 1e3;

    /// The true rate, Hz, of a clock that runs at `nominal_hz` by the board's crystal.
    pub fn true_hz(&self, nominal_hz: f64) -> f64 {
        nominal_hz * self.pace()
    }

    /// The rate by the board's crystal, Hz, of a clock that truly runs at `true_hz`.
    pub fn nominal_hz(&self, true_hz: f64) -> f64 {
        true_hz / self.pace()
    }

    /// How fast the clock runs, 1 for the nominal pace. An error that no board accepts counts as none.
    fn pace(&self) -> f64 {
        let accepted = self.clock_ppm.abs() <= Self::MOST_PPM;
        if accepted { 1.0 + f64::from(self.clock_ppm) * 1e-6 } else { 1.0 }
    }

    /// Corrects the range of a measurement.
    pub fn apply(&self, measurement: &mut Measurement) {
        if *self == Self::default() {
            return;
        }
        if let Outcome::Target(target) = &mut measurement.result {
            let range = target.range.to_num::<f64>() * f64::from(self.range_slope);
            let range = range + f64::from(self.range_offset_m);
            // A cast saturates and turns NaN into 0.
            target.range = I32F32::from_bits((range * 4_294_967_296.0) as i64);
            target.sigma_range *= self.range_slope;
        }
    }
}

/// What is made of the blocks.
// The first case is zeros, so that a meter in static memory is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(u8)]
pub enum Mode {
    /// Each block is measured.
    #[default]
    Blocks,
    /// Blocks are added without their phases, and each sum is measured: see [`picket_dsp::accumulate`] and [`crate::sum`].
    Accumulate {
        /// Blocks of a sum, 1 to 65536.
        blocks: u32,
        /// The line moves by this many bins from one block to the next.
        drift_bins: f32,
    },
    /// Bursts are cut out of the stream, and each is measured: see [`picket_dsp::burst`] and [`crate::burst`].
    Bursts(Trigger),
}

/// The settings of an instrument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The core's clock, MHz: one of the board's speeds; 0 for its default.
    pub core_mhz: u16,
    /// Whether two converters sample in step for I/Q records.
    pub iq: bool,
    /// Rate, band, method, scene. The board rounds the rate to the nearest that it has, sets its
    /// converter's codes, and takes block and guard as the duration of a ramp.
    pub config: Config,
    /// Samples dropped at the start of each segment, at most [`GUARD`]. They cover the longest
    /// delay of an echo and the settling of the filters.
    pub guard: u16,
    /// What makes the chirp.
    pub drive: Drive,
    /// How blocks are used. Sums and bursts need an image with the feature `signals`, a scene without a chirp, and neither
    /// tracks nor further tones.
    pub mode: Mode,
    /// One block in `report_every` sends telemetry; all blocks are measured.
    pub report_every: u16,
    /// Tones reported a block, 1 to [`MOST`]. Above 1, all of them follow the block's telemetry with their
    /// phases: see [`crate::lines`]. An image built without the feature `lines` refuses that, and this crate
    /// has the field only with it.
    #[cfg(feature = "lines")]
    pub most: u8,
    /// The highest order, 2 to 15, of the harmonics from which a fundamental is found in each block: see
    /// [`crate::fundamental`]. 0 for none. As `most`, it needs the feature `lines`.
    #[cfg(feature = "lines")]
    pub harmonics: u8,
    /// Blocks in the board's memory; 0 for its usual number. More slots tolerate longer pauses of the
    /// measurement.
    pub slots: u16,
    /// Whether to measure from power-on, without a command.
    pub start: bool,
    /// Whether a board that corrects its converter's codes shall leave them as they are.
    pub uncorrected: bool,
    /// Whether the rate must hold for the worst block that a search over signals found: the board refuses a rate at which that block
    /// takes longer than it lasts. Otherwise the rate must hold for usual blocks.
    pub worst_case: bool,
    /// Corrections of rate and range.
    pub calibration: Calibration,
}

impl Default for Settings {
    /// Real records at 500 kS/s, measured from power-on.
    fn default() -> Self {
        Self {
            core_mhz: 0,
            iq: false,
            config: Config::new(500e3, Codes::unsigned::<12>()),
            guard: 0,
            drive: Drive::Off,
            mode: Mode::Blocks,
            report_every: 1,
            #[cfg(feature = "lines")]
            most: 1,
            #[cfg(feature = "lines")]
            harmonics: 0,
            slots: 0,
            start: true,
            uncorrected: false,
            worst_case: false,
            calibration: Calibration::default(),
        }
    }
}

const VERSION: u8 = 1;

/// The version of settings that ask for several tones or for a fundamental: readers that do not know this version
/// refuse it.
const LINES: u8 = 2;

/// The version of settings with the less usual mixing or a curved sweep.
const WAVEFORM: u8 = 3;

/// The version of settings with a carrier of its own width.
const CARRIER: u8 = 4;

/// The version of settings with sums or bursts, or with a rate that must hold for the worst block.
const MODE: u8 = 5;

/// The version of settings with bounds of range or velocity: without them more chirps are ambiguous.
const BOUNDS: u8 = 6;

/// The version of a layout that has the fields of all versions, whatever their values: [`crate::stored`] takes it apart.
pub(crate) const WHOLE: u8 = u8::MAX;

impl Settings {
    /// Length of the settings of versions 1 and 2, bytes.
    pub const SHORT: usize = 44 + config::BYTES;
    /// Length of the settings of version 3, bytes.
    pub const LONG: usize = Self::SHORT + 8;
    /// Length of the settings of version 4, bytes.
    pub const WIDE: usize = Self::LONG + 8;
    /// Length of the settings of version 5, bytes.
    pub const MODED: usize = Self::WIDE + 16;
    /// Length of the longest settings, bytes.
    pub const BYTES: usize = Self::MODED + 32;

    /// The settings as bytes, for blocks of `n` samples.
    pub fn to_bytes(&self, n: usize) -> Vec<u8, { Self::BYTES }> {
        self.written(n, self.version())
    }

    /// All fields, whatever their values, for blocks of `n` samples.
    pub(crate) fn to_whole(self, n: usize) -> Vec<u8, { Self::BYTES }> {
        self.written(n, WHOLE)
    }

    /// The lowest version that has fields for these values.
    fn version(&self) -> u8 {
        let waveform = config::unusual(&self.config) || self.curvature() != 0.0;
        if self.config.range_m.is_some() || self.config.velocity_mps.is_some() {
            BOUNDS
        } else if self.mode != Mode::Blocks || self.worst_case {
            MODE
        } else if self.config.carrier != Carrier::default() {
            CARRIER
        } else if waveform {
            WAVEFORM
        } else if (self.further(), self.order()) == (0, 0) {
            VERSION
        } else {
            LINES
        }
    }

    /// The curvature of a chirp's sweep; 0 without a chirp.
    const fn curvature(&self) -> f64 {
        match self.config.scene {
            Scene::Chirp(Chirp { sweep_curvature, .. }) => sweep_curvature,
            _ => 0.0,
        }
    }

    // Not inlined: the wire and the flash take their versions of it.
    #[inline(never)]
    fn written(&self, n: usize, version: u8) -> Vec<u8, { Self::BYTES }> {
        let (drive, codes, [reference_hz, start_hz], divider) = match self.drive {
            Drive::Off => (0, [0; 2], [0.0; 2], 0),
            Drive::Dac { low, high } => (1, [low, high], [0.0; 2], 0),
            Drive::Adf4159 { reference_hz, start_hz, divider } => {
                (2, [0; 2], [reference_hz, start_hz], divider)
            }
            Drive::External => (3, [0; 2], [0.0; 2], 0),
        };
        let Calibration { clock_ppm, range_offset_m, range_slope } = self.calibration;
        let mut bytes = [0; Self::BYTES];
        let mut writer = Writer::new(&mut bytes);
        let Carrier { linewidth_hz, envelope_hz } = self.config.carrier;
        let switches = u8::from(self.start) | u8::from(self.uncorrected) << 1;
        let flags = switches | self.further() << 2 | self.order() << 4;
        writer.put([version, drive, divider, flags]);
        for word in [self.core_mhz, self.guard, self.report_every, codes[0], codes[1], self.slots] {
            writer.u16(word);
        }
        writer.f64(reference_hz);
        writer.f64(start_hz);
        for number in [clock_ppm, range_offset_m, range_slope] {
            writer.f32(number);
        }
        config::put(&mut writer, self.iq, n as u32, &self.config);
        if version >= WAVEFORM {
            writer.f64(self.curvature());
        }
        if version >= CARRIER {
            writer.f32(linewidth_hz);
            writer.f32(envelope_hz);
        }
        let (mode, count, number, least) = match self.mode {
            Mode::Blocks => (0, 0, 0.0, 0),
            Mode::Accumulate { blocks, drift_bins } => (1, blocks, drift_bins, 0),
            Mode::Bursts(Trigger { ratio, hold_off, least }) => {
                (2, hold_off, ratio.unwrap_or(0.0), least)
            }
        };
        if version >= MODE {
            writer.put([mode, u8::from(self.worst_case), 0, 0]);
            writer.u32(count);
            writer.f32(number);
            writer.u32(least);
        }
        if version >= BOUNDS {
            for bound in [self.config.range_m, self.config.velocity_mps] {
                let (low, high) = bound.unwrap_or((f64::NAN, f64::NAN));
                writer.f64(low);
                writer.f64(high);
            }
        }
        // A buffer of this length holds what was written into it.
        Vec::from_slice(writer.written()).unwrap_or_default()
    }

    /// Reads settings and the length of a block from the bytes of [`Settings::to_bytes`], and skips what follows them. The board
    /// checks them further.
    ///
    /// # Errors
    /// The bytes are too few or of another version, or a field has an unknown value.
    pub fn from_bytes(bytes: &[u8]) -> Result<(Self, usize), SettingsError> {
        match bytes.first() {
            Some(VERSION..=BOUNDS) => Self::read(bytes),
            Some(_) => Err(SettingsError::Encoding(EncodingError::Version)),
            None => Err(SettingsError::Encoding(EncodingError::Field)),
        }
    }

    /// Reads the bytes of [`Settings::to_whole`].
    pub(crate) fn from_whole(bytes: &[u8]) -> Result<(Self, usize), SettingsError> {
        Self::read(bytes)
    }

    // Not inlined: see `written`.
    #[inline(never)]
    fn read(bytes: &[u8]) -> Result<(Self, usize), SettingsError> {
        let mut reader = Reader(bytes);
        let field = SettingsError::Encoding(EncodingError::Field);
        let [version, drive, divider, flags] = reader.take().ok_or(field)?;
        let wants = version == LINES || (version >= WAVEFORM && flags >> 2 != 0);
        let lines = cfg!(feature = "lines") && wants;
        if wants && !lines {
            return Err(SettingsError::Encoding(EncodingError::Version));
        }
        let mut word = || reader.u16().ok_or(field);
        let [core_mhz, guard, report_every, low, high, slots] =
            [word()?, word()?, word()?, word()?, word()?, word()?];
        let mut long = || reader.f64().ok_or(field);
        let [reference_hz, start_hz] = [long()?, long()?];
        let mut short = || reader.f32().ok_or(field);
        let [clock_ppm, range_offset_m, range_slope] = [short()?, short()?, short()?];
        let (iq, n, mut config) = config::take(&mut reader).map_err(SettingsError::Encoding)?;
        let curvature = if version >= WAVEFORM { reader.f64().ok_or(field)? } else { 0.0 };
        if version >= CARRIER {
            let mut short = || reader.f32().ok_or(field);
            config.carrier = Carrier { linewidth_hz: short()?, envelope_hz: short()? };
        }
        let (mode, worst_case) = if version >= MODE {
            let [mode, switches, _, _] = reader.take().ok_or(field)?;
            let count = reader.u32().ok_or(field)?;
            let number = reader.f32().ok_or(field)?;
            let least = reader.u32().ok_or(field)?;
            let ratio = if number == 0.0 { None } else { Some(number) };
            let worst_case = switches & 1 != 0;
            let mode = match mode {
                0 if version >= BOUNDS || worst_case => Mode::Blocks,
                1 => Mode::Accumulate { blocks: count, drift_bins: number },
                2 => Mode::Bursts(Trigger { ratio, hold_off: count, least }),
                _ => return Err(field),
            };
            (mode, worst_case)
        } else {
            (Mode::Blocks, false)
        };
        if version >= BOUNDS {
            let mut bound = || {
                let ends = (reader.f64().ok_or(field)?, reader.f64().ok_or(field)?);
                Ok((!(ends.0.is_nan() && ends.1.is_nan())).then_some(ends))
            };
            (config.range_m, config.velocity_mps) = (bound()?, bound()?);
        }
        if let Scene::Chirp(chirp) = &mut config.scene {
            chirp.sweep_curvature = curvature;
            chirp.guard_s = f64::from(guard) / config.rate_hz;
        }
        let settings = Settings {
            core_mhz,
            iq,
            config,
            guard,
            drive: match drive {
                0 => Drive::Off,
                1 => Drive::Dac { low, high },
                2 => Drive::Adf4159 { reference_hz, start_hz, divider },
                3 => Drive::External,
                _ => return Err(field),
            },
            mode,
            report_every,
            #[cfg(feature = "lines")]
            most: if lines { 1 + (flags >> 2 & 3) } else { 1 },
            #[cfg(feature = "lines")]
            harmonics: if lines { flags >> 4 } else { 0 },
            slots,
            start: flags & 1 != 0,
            uncorrected: flags & 2 != 0,
            worst_case,
            calibration: Calibration { clock_ppm, range_offset_m, range_slope },
        };
        Ok((settings, n as usize))
    }

    /// Tones reported a block beyond the first, at most three. Without the feature `lines` there are none.
    pub const fn further(&self) -> u8 {
        #[cfg(feature = "lines")]
        return match self.most {
            2..=4 => self.most - 1,
            _ => 0,
        };
        #[cfg(not(feature = "lines"))]
        0
    }

    /// The highest order of the harmonics that are sought, 2 to 15; 0 for none. Without the feature `lines`
    /// there are none.
    pub const fn order(&self) -> u8 {
        #[cfg(feature = "lines")]
        return match self.harmonics {
            2..=15 => self.harmonics,
            _ => 0,
        };
        #[cfg(not(feature = "lines"))]
        0
    }

    /// Segments in a chirp; 1 without a chirp.
    pub fn segments(&self) -> u16 {
        self.config.scene.segments().len().max(1) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_dsp::config::Scene;
    use picket_dsp::solve::chirp::{Shape, Target};
    use picket_dsp::solve::equations::Chirp;

    fn chirp(shape: Shape, drive: Drive) -> Settings {
        let scene = Scene::Chirp(Chirp {
            shape,
            wavelength_m: 0.0125,
            bandwidth_hz: 200e6,
            duration_s: 1.0,
            guard_s: 64.0 / 500e3,
            ..Chirp::default()
        });
        let config = Config { rate_hz: 500e3, scene, ..Settings::default().config };
        Settings { config, guard: 64, drive, ..Settings::default() }
    }

    #[test]
    fn settings_come_back_as_they_were() {
        let calibration = Calibration { clock_ppm: -12.5, range_offset_m: 0.3, range_slope: 1.001 };
        let head = Drive::Adf4159 { reference_hz: 80e6, start_hz: 24e9, divider: 2 };
        for settings in [
            Settings::default(),
            Settings {
                core_mhz: 144,
                ..chirp(Shape::Trapezoid, Drive::Dac { low: 0, high: 4095 })
            },
            Settings { uncorrected: true, ..Settings::default() },
            Settings { worst_case: true, ..Settings::default() },
            Settings { iq: true, start: false, calibration, ..chirp(Shape::Triangle, head) },
            Settings { report_every: 999, slots: 7, ..chirp(Shape::Sawtooth, Drive::External) },
        ] {
            let bytes = settings.to_bytes(1024);
            assert_eq!(Settings::from_bytes(&bytes), Ok((settings, 1024)));
        }
        let bounded = chirp(Shape::Triangle, Drive::External);
        for (range_m, velocity_mps) in [
            (Some((0.0, 20.0)), None),
            (None, Some((-5.0, 5.5))),
            (Some((1.0, 2.0)), Some((0.0, 3.0))),
        ] {
            let config = Config { range_m, velocity_mps, ..bounded.config };
            let settings = Settings { config, ..bounded };
            let bytes = settings.to_bytes(1024);
            assert_eq!((bytes[0], bytes.len()), (6, Settings::BYTES));
            assert_eq!(Settings::from_bytes(&bytes), Ok((settings, 1024)));
        }
        let trigger = Trigger { ratio: Some(2.5), hold_off: 100, least: 9 };
        for mode in [
            Mode::Accumulate { blocks: 100, drift_bins: -0.25 },
            Mode::Bursts(Trigger::default()),
            Mode::Bursts(trigger),
        ] {
            let settings = Settings { mode, ..Settings::default() };
            let bytes = settings.to_bytes(1024);
            assert_eq!((bytes[0], bytes.len()), (5, Settings::MODED));
            assert_eq!(Settings::from_bytes(&bytes), Ok((settings, 1024)));
            let cut = Settings::from_bytes(&bytes[..Settings::WIDE]);
            assert_eq!(cut, Err(SettingsError::Encoding(EncodingError::Field)));
        }
        #[cfg(feature = "lines")]
        for most in 1..=4 {
            let settings = Settings { most, ..Settings::default() };
            let bytes = settings.to_bytes(1024);
            assert_eq!(Settings::from_bytes(&bytes), Ok((settings, 1024)));
            // A reader of one tone refuses those of more.
            assert_eq!(bytes[0], if most > 1 { 2 } else { 1 });
            let settings = Settings { harmonics: 11 + most, ..settings };
            let bytes = settings.to_bytes(1024);
            assert_eq!((Settings::from_bytes(&bytes), bytes[0]), (Ok((settings, 1024)), 2));
        }
        let told = |place: usize, value: u8| {
            let mut bytes = Settings::default().to_bytes(1024);
            bytes[place] = value;
            Settings::from_bytes(&bytes)
        };
        assert_eq!(told(0, 9), Err(SettingsError::Encoding(EncodingError::Version)));
        assert_eq!(told(1, 9), Err(SettingsError::Encoding(EncodingError::Field)));
        assert_eq!(told(44 + 12, 1), Err(SettingsError::Encoding(EncodingError::Length)));
    }

    #[test]
    fn calibration_moves_ranges_and_nothing_else() {
        let mut measurement = Measurement::default();
        let calibration = Calibration { clock_ppm: 0.0, range_offset_m: -0.25, range_slope: 1.01 };
        calibration.apply(&mut measurement);
        assert_eq!(measurement, Measurement::default());
        let target = Target { range: I32F32::from_num(10), sigma_range: 0.5, ..Target::default() };
        measurement.result = Outcome::Target(target);
        calibration.apply(&mut measurement);
        let Outcome::Target(target) = measurement.result else { panic!("still a target") };
        assert!((target.range.to_num::<f64>() - 9.85).abs() < 1e-6);
        assert_eq!(target.sigma_range, 0.5 * 1.01);
        let before = measurement;
        Calibration::default().apply(&mut measurement);
        assert_eq!(measurement, before);
    }
}
