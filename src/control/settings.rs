//! All that a user sets on an instrument, checked as a whole: nothing changes before everything fits.

use super::adf4159::{RampError, Ramps, Words};
use super::clock::{Speed, Tree};
use super::sampling::{RateError, Sampling};
use super::waveform::{Waveform, WaveformError, segments};
use crate::acquire::capture::{Header, HeaderError, Pattern};
use crate::acquire::frontend::Timing;
use crate::acquire::sample::{Codes, Iq, Real};
use crate::config::{Config, ConfigError, Plan, Scene};
use crate::pipeline::{Measurement, Outcome};
use crate::solve::chirp::Shape;
use fixed::types::I32F32;

/// The most guard samples before a block.
pub const GUARD: u16 = 64;

/// What makes the chirp.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Drive {
    /// Nothing: a continuous wave.
    #[default]
    Off,
    /// The board's DAC, between two codes.
    Dac {
        /// The code at the lowest frequency.
        low: u16,
        /// The code at the highest.
        high: u16,
    },
    /// A ramp synthesiser on SPI1.
    Adf4159 {
        /// Its crystal, Hz.
        reference_hz: f64,
        /// The carrier at the bottom of a ramp, Hz.
        start_hz: f64,
        /// What the head divides the carrier by before the synthesiser sees it.
        divider: u8,
    },
    /// A source of its own, which tells the start of each chirp by a rise at the sync input.
    External,
}

/// What a comparison with known references has shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// How much faster the sample clock runs than it should, parts per million.
    pub clock_ppm: f32,
    /// True range = slope * measured range + offset; metres.
    pub range_offset_m: f32,
    /// See `range_offset_m`: 0.5 to 2.
    pub range_slope: f32,
}

impl Default for Calibration {
    fn default() -> Self {
        Self { clock_ppm: 0.0, range_offset_m: 0.0, range_slope: 1.0 }
    }
}

impl Calibration {
    /// Corrects the range of a measurement.
    pub fn apply(&self, measurement: &mut Measurement) {
        if *self == Self::default() {
            return;
        }
        if let Outcome::Target(target) = &mut measurement.result {
            let range = target.range.to_num::<f64>() * f64::from(self.range_slope);
            let range = range + f64::from(self.range_offset_m);
            // A cast holds the value to the range of the type and takes NaN to 0.
            target.range = I32F32::from_bits((range * 4_294_967_296.0) as i64);
            target.sigma_range *= self.range_slope;
        }
    }
}

/// What a user sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The core's speed.
    pub speed: Speed,
    /// Two converters in step for I/Q records, else one.
    pub iq: bool,
    /// Rate, band, method, scene. The rate becomes the nearest that there is, the codes are the converter's, the duration of
    /// a ramp is that of block and guard.
    pub config: Config,
    /// Samples dropped at the start of each segment: cover the echo's longest delay and the filters' settling.
    pub guard: u16,
    /// What makes the chirp.
    pub drive: Drive,
    /// A record is sent for every so many blocks; all are measured.
    pub report_every: u16,
    /// Whether to measure from power-on, without waiting for a command.
    pub start: bool,
    /// Corrections.
    pub calibration: Calibration,
}

impl Default for Settings {
    /// A real tone at 500 kS/s, measured at once.
    fn default() -> Self {
        Self {
            speed: Speed::default(),
            iq: false,
            config: Config { rate_hz: 500e3, codes: Codes::Unsigned12, ..Config::default() },
            guard: 0,
            drive: Drive::Off,
            report_every: 1,
            start: true,
            calibration: Calibration::default(),
        }
    }
}

/// Why settings cannot work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SettingsError {
    /// The bytes are no settings, or damaged.
    Encoding(HeaderError),
    /// The measurement's configuration.
    Config(ConfigError),
    /// The sample rate.
    Rate(RateError),
    /// The DAC's waveform.
    Waveform(WaveformError),
    /// The synthesiser's ramps.
    Ramps(RampError),
    /// This image measures blocks of another length.
    Length,
    /// More than [`GUARD`] guard samples, or some without a chirp.
    Guard,
    /// A chirp without a drive, a drive without a chirp.
    Drive,
    /// The sync input needs the sample clock's gate, which the fastest rate does not have.
    Sync,
    /// A correction is no number, above 1000 ppm, or a slope outside 0.5 to 2.
    Calibration,
    /// I/Q records have the converters' offset at 0 Hz, far above any signal: the band must lie on one side of it.
    Offset,
    /// This image does not follow tones: it is built without the feature `tracking`.
    Tracking,
}

/// Bins around 0 Hz that the offset takes.
const OFFSET_BINS: i32 = 2;

impl SettingsError {
    /// A number for the wire: what is wrong and in which way.
    pub const fn code(self) -> [u8; 2] {
        match self {
            SettingsError::Encoding(error) => [1, error as u8],
            SettingsError::Config(error) => [2, error as u8],
            SettingsError::Rate(error) => [3, error as u8],
            SettingsError::Waveform(error) => [4, error as u8],
            SettingsError::Ramps(error) => [5, error as u8],
            SettingsError::Length => [6, 0],
            SettingsError::Guard => [7, 0],
            SettingsError::Drive => [8, 0],
            SettingsError::Sync => [9, 0],
            SettingsError::Calibration => [10, 0],
            SettingsError::Offset => [11, 0],
            SettingsError::Tracking => [12, 0],
        }
    }

    /// The words for the first number of [`SettingsError::code`].
    pub const fn message_of(code: u8) -> &'static str {
        match code {
            1 => "the settings are damaged or of another version",
            2 => "the configuration does not work",
            3 => {
                "the sample rate is out of reach at this clock: 1 Hz to 2.4 MS/s (144 MHz) or 1.5 MS/s"
            }
            4 => "the DAC cannot play the chirp: codes 0 to 4095, guard so that steps are whole",
            5 => "the synthesiser cannot make these ramps",
            6 => "this image measures blocks of another length",
            7 => "guard samples: at most 64, and only with a chirp",
            8 => "a chirp needs a drive, and a drive a chirp",
            9 => "the sync input does not work at the fastest rate: use a slower one",
            10 => "calibration: at most 1000 ppm, slope 0.5 to 2",
            11 => {
                "I/Q: the converters' offset lies at 0 Hz, so search a band on one side of it, three bins away or more"
            }
            12 => {
                "this image does not follow tones: flash one that is built with --tracking, or follow 0"
            }
            _ => "the settings do not work",
        }
    }
}

/// Settings that were checked, as words for the registers and a plan for the pipeline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instrument {
    /// The settings with what was rounded: rate, duration, codes.
    pub settings: Settings,
    /// The sample clock and the converters.
    pub sampling: Sampling,
    /// The pipeline's plan.
    pub plan: Plan,
    /// Samples of a segment: block and guard.
    pub length: u32,
    /// How blocks follow each other.
    pub timing: Timing,
    /// What the DAC plays.
    pub waveform: Option<Waveform>,
    /// What the synthesiser is told.
    pub synthesiser: Option<Words>,
}

impl Settings {
    /// Checks everything for blocks of `n` samples on a board whose clock is `tree`.
    pub fn validate(&self, n: usize, tree: &Tree) -> Result<Instrument, SettingsError> {
        let Calibration { clock_ppm, range_offset_m, range_slope } = self.calibration;
        let right = clock_ppm.abs() <= 1e3 && range_offset_m.is_finite();
        if !(right && (0.5..=2.0).contains(&range_slope)) {
            return Err(SettingsError::Calibration);
        }
        let chirp = matches!(self.config.scene, Scene::Chirp { .. });
        if self.guard > GUARD || (self.guard > 0 && !chirp) {
            return Err(SettingsError::Guard);
        }
        if chirp != (self.drive != Drive::Off) {
            return Err(SettingsError::Drive);
        }
        let sampling = Sampling::plan(tree, self.config.rate_hz, self.iq);
        let sampling = sampling.map_err(SettingsError::Rate)?;
        let length = n as u32 + u32::from(self.guard);
        let config = self.true_config(&sampling, length);
        let plan = if self.iq { config.validate::<Iq>(n) } else { config.validate::<Real>(n) };
        let plan = plan.map_err(SettingsError::Config)?;
        if self.iq && plan.band.low <= OFFSET_BINS && plan.band.high >= -OFFSET_BINS {
            return Err(SettingsError::Offset);
        }
        let mut settings = Settings { config, ..*self };
        let mut waveform = None;
        let mut synthesiser = None;
        if let Scene::Chirp { shape, bandwidth_hz, duration_s, .. } = config.scene {
            match self.drive {
                Drive::Off => {}
                Drive::Dac { low, high } => {
                    let wave = Waveform::plan(shape, length, sampling.rate_hz, [low, high]);
                    waveform = Some(wave.map_err(SettingsError::Waveform)?);
                }
                Drive::Adf4159 { reference_hz, start_hz, divider } => {
                    let divider = f64::from(divider.max(1));
                    let ramps = Ramps {
                        reference_hz,
                        start_hz: start_hz / divider,
                        bandwidth_hz: bandwidth_hz / divider,
                        duration_s,
                        shape,
                        triggered: true,
                    };
                    synthesiser = Some(ramps.words().map_err(SettingsError::Ramps)?);
                }
                Drive::External if sampling.continuous => return Err(SettingsError::Sync),
                Drive::External => {}
            }
        }
        settings.report_every = settings.report_every.max(1);
        let segments = Pattern::of(&config.scene).segments();
        let timing = Timing { period: length, segments };
        Ok(Instrument { settings, sampling, plan, length, timing, waveform, synthesiser })
    }

    /// The configuration with the rate there is, the converter's codes and the ramp's true duration.
    fn true_config(&self, sampling: &Sampling, length: u32) -> Config {
        let ppm = f64::from(self.calibration.clock_ppm);
        let rate_hz = sampling.rate_hz * (1.0 + ppm * 1e-6);
        let mut config = Config { rate_hz, codes: Codes::Unsigned12, ..self.config };
        if let Scene::Chirp { duration_s, .. } = &mut config.scene {
            // A validated rate is above 0. Up by the last bit's rounding, so that a record fits its ramp.
            *duration_s = f64::from(length) / rate_hz * (1.0 + 2.0 * f64::EPSILON);
        }
        config
    }

    /// Bytes of the board's own part.
    const OWN: usize = 48;
    /// Bytes as stored and sent: a capture's header and the board's own part.
    pub const BYTES: usize = Header::BYTES + Self::OWN;

    /// As stored and sent, for blocks of `n` samples.
    pub fn to_bytes(&self, n: usize) -> [u8; Self::BYTES] {
        let header = Header { iq: self.iq, ..Header::of::<Real>(self.config, n as u32, 0) };
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
        let mut rest = &mut bytes[..];
        put(&mut rest, header.to_bytes());
        put(&mut rest, [self.speed as u8, drive, divider, u8::from(self.start)]);
        for word in [self.guard, self.report_every, codes[0], codes[1]] {
            put(&mut rest, word.to_le_bytes());
        }
        put(&mut rest, reference_hz.to_le_bytes());
        put(&mut rest, start_hz.to_le_bytes());
        for number in [clock_ppm, range_offset_m, range_slope] {
            put(&mut rest, number.to_le_bytes());
        }
        bytes
    }

    /// Reads what [`Settings::to_bytes`] wrote: settings and the length of a block. They are not checked further.
    pub fn of_bytes(bytes: &[u8; Self::BYTES]) -> Result<(Self, usize), SettingsError> {
        let mut rest = &bytes[..];
        let header = Header::from_bytes(&take(&mut rest)).map_err(SettingsError::Encoding)?;
        let field = SettingsError::Encoding(HeaderError::Field);
        let [speed, drive, divider, start] = take(&mut rest);
        let [guard, report_every, low, high] =
            [(); 4].map(|()| u16::from_le_bytes(take(&mut rest)));
        let [reference_hz, start_hz] = [(); 2].map(|()| f64::from_le_bytes(take(&mut rest)));
        let [clock_ppm, range_offset_m, range_slope] =
            [(); 3].map(|()| f32::from_le_bytes(take(&mut rest)));
        let settings = Settings {
            speed: match speed {
                0 => Speed::Mhz144,
                1 => Speed::Mhz180,
                _ => return Err(field),
            },
            iq: header.iq,
            config: header.config,
            guard,
            drive: match drive {
                0 => Drive::Off,
                1 => Drive::Dac { low, high },
                2 => Drive::Adf4159 { reference_hz, start_hz, divider },
                3 => Drive::External,
                _ => return Err(field),
            },
            report_every,
            start: start != 0,
            calibration: Calibration { clock_ppm, range_offset_m, range_slope },
        };
        Ok((settings, header.n as usize))
    }

    /// How many segments a chirp has; 1 without.
    pub fn segments(&self) -> u16 {
        match self.config.scene {
            Scene::Chirp { shape, .. } => segments(shape),
            _ => segments(Shape::Sawtooth),
        }
    }
}

fn put<const L: usize>(rest: &mut &mut [u8], field: [u8; L]) {
    if let Some((place, more)) = core::mem::take(rest).split_first_chunk_mut() {
        *place = field;
        *rest = more;
    }
}

fn take<const L: usize>(rest: &mut &[u8]) -> [u8; L] {
    match rest.split_first_chunk() {
        Some((&field, more)) => {
            *rest = more;
            field
        }
        None => [0; L],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::clock::Source;
    use crate::solve::chirp::Target;

    const TREE: Tree = Tree::new(Speed::Mhz180, Source::HsePll);

    fn chirp(shape: Shape, drive: Drive) -> Settings {
        let scene =
            Scene::Chirp { shape, wavelength_m: 0.0125, bandwidth_hz: 200e6, duration_s: 1.0 };
        let config = Config { rate_hz: 500e3, scene, ..Config::default() };
        Settings { config, guard: 64, drive, ..Settings::default() }
    }

    const DAC: Drive = Drive::Dac { low: 0, high: 4095 };
    const HEAD: Drive = Drive::Adf4159 { reference_hz: 80e6, start_hz: 24e9, divider: 2 };

    #[test]
    fn settings_come_back_as_they_were() {
        let calibration = Calibration { clock_ppm: -12.5, range_offset_m: 0.3, range_slope: 1.001 };
        for settings in [
            Settings::default(),
            chirp(Shape::Trapezoid, DAC),
            Settings { iq: true, start: false, calibration, ..chirp(Shape::Triangle, HEAD) },
            Settings { report_every: 999, ..chirp(Shape::Sawtooth, Drive::External) },
        ] {
            let bytes = settings.to_bytes(1024);
            assert_eq!(Settings::of_bytes(&bytes), Ok((settings, 1024)));
        }
        let mut damaged = Settings::default().to_bytes(1024);
        damaged[20] ^= 1;
        let told = Settings::of_bytes(&damaged);
        assert_eq!(told, Err(SettingsError::Encoding(HeaderError::Checksum)));
        let mut unknown = Settings::default().to_bytes(1024);
        unknown[Header::BYTES + 1] = 9;
        assert_eq!(Settings::of_bytes(&unknown), Err(SettingsError::Encoding(HeaderError::Field)));
    }

    #[test]
    fn block_and_segment_are_one() {
        let instrument = chirp(Shape::Trapezoid, DAC).validate(1024, &TREE).unwrap();
        assert_eq!((instrument.length, instrument.timing.period), (1088, 1088));
        assert_eq!(instrument.timing.segments.len(), 3);
        let wave = instrument.waveform.unwrap();
        assert_eq!(u32::from(wave.hold) * u32::from(wave.steps), 1088);
        let Scene::Chirp { duration_s, .. } = instrument.settings.config.scene else {
            panic!("the scene is a chirp");
        };
        let samples = duration_s * instrument.settings.config.rate_hz;
        assert!((samples - 1088.0).abs() < 1e-9, "{samples}");
        assert_eq!(instrument.settings.config.codes, Codes::Unsigned12);
        let head = chirp(Shape::Triangle, HEAD).validate(1024, &TREE).unwrap();
        assert!(head.synthesiser.is_some() && head.waveform.is_none());
    }

    #[test]
    fn without_guard_a_ramp_is_a_record() {
        for (rate_hz, ppm) in [(1.5e6, 0.0), (333_333.0, 17.0), (48e3, -999.0), (7e4, 3.3)] {
            let mut settings = chirp(Shape::Trapezoid, DAC);
            settings.guard = 0;
            settings.config.rate_hz = rate_hz;
            settings.calibration.clock_ppm = ppm;
            settings.validate(1024, &TREE).unwrap();
        }
    }

    #[test]
    fn every_contradiction_is_told_and_has_words() {
        use SettingsError as E;
        let tone = Settings::default();
        let with = |config: Config| Settings { config, ..tone };
        let calibrated = |calibration| Settings { calibration, ..tone };
        let ideal = Calibration::default();
        let prime = Settings { guard: 63, ..chirp(Shape::Trapezoid, DAC) };
        let mut quick = chirp(Shape::Trapezoid, Drive::External);
        quick.config.rate_hz = 1.5e6;
        for (settings, error) in [
            (Settings { guard: 1, ..tone }, E::Guard),
            (Settings { guard: 65, ..chirp(Shape::Triangle, DAC) }, E::Guard),
            (Settings { drive: DAC, ..tone }, E::Drive),
            (chirp(Shape::Triangle, Drive::Off), E::Drive),
            (with(Config { rate_hz: 2e6, ..tone.config }), E::Rate(RateError::Fast)),
            (with(Config { rate_hz: f64::NAN, ..tone.config }), E::Rate(RateError::Slow)),
            (with(Config { false_alarm: 0.0, ..tone.config }), E::Config(ConfigError::FalseAlarm)),
            (
                with(Config { band_hz: Some((3.0, 2.0)), ..tone.config }),
                E::Config(ConfigError::Band),
            ),
            (prime, E::Waveform(WaveformError::Steps)),
            (
                chirp(Shape::Triangle, Drive::Dac { low: 9, high: 9 }),
                E::Waveform(WaveformError::Codes),
            ),
            (
                chirp(
                    Shape::Triangle,
                    Drive::Adf4159 { reference_hz: 1.0, start_hz: 24e9, divider: 2 },
                ),
                E::Ramps(RampError::Reference),
            ),
            (quick, E::Sync),
            (Settings { iq: true, ..tone }, E::Offset),
            (calibrated(Calibration { clock_ppm: f32::NAN, ..ideal }), E::Calibration),
            (calibrated(Calibration { range_slope: 0.1, ..ideal }), E::Calibration),
            (calibrated(Calibration { range_offset_m: f32::INFINITY, ..ideal }), E::Calibration),
        ] {
            assert_eq!(settings.validate(1024, &TREE), Err(error), "{settings:?}");
            let [code, _] = error.code();
            assert_ne!(SettingsError::message_of(code), SettingsError::message_of(0));
        }
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
