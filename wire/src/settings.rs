//! The settings of an instrument, as plain values that every board reads. A board turns them into
//! its own register words and checks them as a whole. It changes nothing before everything fits.
//!
//! ```text
//! version: u8 | samples in a block: u32 | settings: structure
//! ```
//!
//! The bytes travel in frames, lie in flash, and go through the memory between two programs. All three have a checksum of their own.
//! Settings with a field that a program does not know are refused: records would mean something else without it. So are those of
//! another version. A field that is added later and has the value of settings without it is not written, so programs of different times
//! read each other's settings as long as these say nothing new.

use crate::config::EncodingError;
use crate::layout::{Field, Reader, VERSION, Writer, choice, layout};
use crate::settings_error::{FramesError, SettingsError};
use fixed::types::I32F32;
use heapless::Vec;
use picket_dsp::acquire::burst::Trigger;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::config::{Config, Scene};
use picket_dsp::frame::{FrameConfig, FramePlan};
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_dsp::solve::candidates::{Ambiguity, Candidate, Candidates};
use picket_dsp::solve::chirp::Shape;
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_dsp::spectrum::fft::twiddle::supported;
use picket_dsp::tone::effort::Effort;
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

    /// Corrects the range of a measurement, and those of its candidates.
    pub fn apply(&self, measurement: &mut Measurement) {
        if *self == Self::default() {
            return;
        }
        if let Outcome::Target(target) = &mut measurement.result {
            target.range = self.corrected(target.range);
            target.sigma_range *= self.range_slope;
            if let Ambiguity::Several(candidates) = target.ambiguity {
                let candidates = candidates
                    .iter()
                    .map(|one| Candidate { range: self.corrected(one.range), ..*one });
                target.ambiguity = Ambiguity::Several(Candidates::new(candidates));
            }
        }
    }

    #[inline(never)] // once in an image
    fn corrected(&self, range: I32F32) -> I32F32 {
        let range = range.to_num::<f64>() * f64::from(self.range_slope);
        // A cast saturates and turns NaN into 0.
        I32F32::from_bits(((range + f64::from(self.range_offset_m)) * 4_294_967_296.0) as i64)
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
    /// Sawtooth chirps are gathered to frames, and the targets of each are found: see [`picket_dsp::frame`] and [`crate::chirp_frame`]. The
    /// board keeps the bins of `config.band_hz`, else those of the ranges in `config.range_m`, else all.
    Frames {
        /// Chirps of a frame: 8, 16, ... 256.
        chirps: u16,
        /// From one chirp to the next, s, of an external source; `None` for every other, whose chirps follow each other.
        period_s: Option<f64>,
    },
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
    /// How blocks are used. Sums, bursts and frames need a board whose meter has them, and neither tracks nor further tones; sums and bursts
    /// need a scene without a chirp, frames one of sawtooth chirps.
    pub mode: Mode,
    /// One block in `report_every` sends telemetry; all blocks are measured.
    pub report_every: u16,
    /// Tones reported a block, 1 to [`MOST`]. Above 1, all of them follow the block's telemetry with their
    /// phases: see [`crate::lines`]. A board whose meter has no lines refuses that.
    pub most: u8,
    /// The highest order, 2 to 15, of the harmonics from which a fundamental is found in each block: see
    /// [`crate::fundamental`]. 0 for none. As `most`, it needs the feature `lines`.
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
    /// The most rounds of the joint fit; `None` for the most whose worst known block lasts no longer than a block does. A board puts what it
    /// takes into `config.effort`, which it does not read.
    pub effort: Option<Effort>,
    /// Corrections of rate and range.
    pub calibration: Calibration,
    /// What is not known of the sensor: with it each block's telemetry has the whole error beside sigma.
    pub uncertainty: Option<Uncertainty>,
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
            most: 1,
            harmonics: 0,
            slots: 0,
            start: true,
            uncorrected: false,
            worst_case: false,
            effort: None,
            calibration: Calibration::default(),
            uncertainty: None,
        }
    }
}

layout! {
    /// The settings of an instrument.
    Settings {
        /// The core's clock, MHz; 0 for the board's default.
        core_mhz: u16,
        /// Two converters sample in step for I/Q records.
        iq: bool,
        /// The measurement's configuration. A chirp's guard is that of the settings.
        config: Config,
        /// Samples dropped at the start of each segment.
        guard: u16,
        /// What makes the chirp.
        drive: Drive,
        /// How blocks are used.
        mode: Mode,
        /// One block in `report_every` sends telemetry.
        report_every: u16,
        /// Tones reported a block.
        most: u8,
        /// The highest order of harmonics that are sought; 0 for none.
        harmonics: u8,
        /// Blocks in the board's memory; 0 for its usual number.
        slots: u16,
        /// Measures from power-on.
        start: bool,
        /// Leaves the converter's codes uncorrected.
        uncorrected: bool,
        /// The rate must hold for the worst block.
        worst_case: bool,
        /// Corrections of rate and range.
        calibration: Calibration,
        /// The most rounds of the joint fit; without it the most whose worst known block lasts no longer than a block does.
        effort: Option<Effort> = None,
        /// What is not known of the sensor.
        uncertainty: Option<Uncertainty> = None,
    }

    /// What is not known of a sensor, each as one standard deviation.
    Uncertainty {
        /// Of the sample clock, parts per million.
        clock_ppm: f32,
        /// Of the carrier, parts per million.
        carrier_ppm: f32,
        /// Of the sweep's slope, parts per million.
        slope_ppm: f32,
        /// Of the angle between beam and motion, radians.
        angle_rad: f32,
        /// Of the range's offset, m.
        range_offset_m: f32,
        /// Of the phase of a target at 0 m, radians.
        phase_rad: f32,
    }

    /// Corrections from a comparison with known references.
    Calibration {
        /// How much faster than nominal the sample clock runs, parts per million.
        clock_ppm: f32,
        /// Offset of the range, m: true range = slope * measured range + offset.
        range_offset_m: f32,
        /// Slope of the range.
        range_slope: f32,
    }
}

choice! {
    Drive {
        0 Off {},
        1 Dac {
            /// Code at the lowest frequency.
            low: u16,
            /// Code at the highest frequency.
            high: u16,
        },
        2 Adf4159 {
            /// Frequency of its crystal, Hz.
            reference_hz: f64,
            /// Carrier at the bottom of a ramp, Hz.
            start_hz: f64,
            /// Divider between the carrier and the synthesiser.
            divider: u8,
        },
        3 External {},
    }
    Mode {
        0 Blocks {},
        1 Accumulate {
            /// Blocks of a sum.
            blocks: u32,
            /// Bins that the line moves from block to block.
            drift_bins: f32,
        },
        2 Bursts(trigger: Trigger),
        3 Frames {
            /// Chirps of a frame.
            chirps: u16,
            /// From one chirp to the next, s, of an external source.
            period_s: Option<f64>,
        },
    }
}

impl Settings {
    /// Length of the longest settings, bytes.
    pub const BYTES: usize = 1 + 4 + <Self as Field>::MOST;

    /// The settings as bytes, for blocks of `n` samples.
    // Not inlined: the wire, the flash and the checksum take them.
    #[inline(never)]
    pub fn to_bytes(&self, n: usize) -> Vec<u8, { Self::BYTES }> {
        let mut bytes = [0; Self::BYTES];
        let mut writer = Writer::new(&mut bytes);
        VERSION.put(&mut writer);
        (n as u32).put(&mut writer);
        self.guarded().put(&mut writer);
        // A buffer of this length holds what was written into it.
        Vec::from_slice(writer.written()).unwrap_or_default()
    }

    /// Reads settings and the length of a block from the bytes of [`Settings::to_bytes`], and skips what follows them. The board
    /// checks them further.
    ///
    /// # Errors
    /// The bytes are cut off, of another version or of a later program that says more, or a field has an unknown value.
    #[inline(never)]
    pub fn from_bytes(bytes: &[u8]) -> Result<(Self, usize), SettingsError> {
        let wrong = |error| Err(SettingsError::Encoding(error));
        let mut reader = Reader::new(bytes);
        match u8::take(&mut reader) {
            Some(VERSION) => {}
            Some(_) => return wrong(EncodingError::Version),
            None => return wrong(EncodingError::Field),
        }
        let (n, settings) = (u32::take(&mut reader), <Self as Field>::take(&mut reader));
        let (Some(n), Some(settings)) = (n, settings) else { return wrong(EncodingError::Field) };
        if reader.more {
            return wrong(EncodingError::Version);
        }
        if !supported(n as usize) {
            return wrong(EncodingError::Length);
        }
        let reported = (1..=MOST).contains(&usize::from(settings.most));
        if !(reported && matches!(settings.harmonics, 0 | 2..=15)) {
            return wrong(EncodingError::Field);
        }
        Ok((settings.guarded(), n as usize))
    }

    /// These settings with the chirp's guard that follows from the samples dropped.
    fn guarded(mut self) -> Self {
        if let Scene::Chirp(chirp) = &mut self.config.scene {
            chirp.guard_s = f64::from(self.guard) / self.config.rate_hz;
        }
        self
    }

    /// Tones reported a block beyond the first, at most three.
    pub const fn further(&self) -> u8 {
        match self.most {
            2..=4 => self.most - 1,
            _ => 0,
        }
    }

    /// The highest order of the harmonics that are sought, 2 to 15; 0 for none.
    pub const fn order(&self) -> u8 {
        match self.harmonics {
            2..=15 => self.harmonics,
            _ => 0,
        }
    }

    /// Segments in a chirp; 1 without a chirp.
    pub fn segments(&self) -> u16 {
        self.config.scene.segments().len().max(1) as u16
    }

    /// The plan of a frame of chirps of `n` samples, if the settings ask for frames. Their rate and the ramp's duration are the board's.
    ///
    /// # Errors
    /// Frames that cannot be gathered.
    #[inline(never)] // once in an image: it is checked, and then used
    pub fn frames(&self, n: usize) -> Result<Option<FramePlan>, SettingsError> {
        let Mode::Frames { chirps, period_s } = self.mode else { return Ok(None) };
        let &Self { iq, config, drive, .. } = self;
        let Config { rate_hz, band_hz, range_m, velocity_mps, false_alarm, .. } = config;
        let alone = self.further() + self.order() == 0 && config.following.most == 0;
        let chirp = match config.scene {
            Scene::Chirp(chirp) if alone && chirp.shape == Shape::Sawtooth => chirp,
            _ => return Err(SettingsError::Frames(FramesError::Scene)),
        };
        let period_s = match (drive, period_s) {
            (Drive::External, Some(period_s)) => period_s,
            (Drive::Dac { .. } | Drive::Adf4159 { .. }, None) => chirp.duration_s,
            _ => return Err(SettingsError::Frames(FramesError::Period)),
        };
        let frames = FrameConfig::new(chirp, rate_hz, n, iq, chirps.into(), period_s);
        let frames = FrameConfig { false_alarm, range_m, velocity_mps, ..frames };
        let frames = match band_hz {
            Some(band) => Ok(frames.in_band(band)),
            None => frames.in_ranges(),
        };
        let plan = frames.and_then(|frames| frames.plan());
        plan.map(Some).map_err(SettingsError::Config)
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
            Settings { effort: Some(Effort::ONE), ..Settings::default() },
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
            assert_eq!(Settings::from_bytes(&settings.to_bytes(1024)), Ok((settings, 1024)));
        }
        let trigger = Trigger { ratio: Some(2.5), hold_off: 100, least: 9 };
        for mode in [
            Mode::Accumulate { blocks: 100, drift_bins: -0.25 },
            Mode::Bursts(Trigger::default()),
            Mode::Bursts(trigger),
            Mode::Frames { chirps: 64, period_s: None },
            Mode::Frames { chirps: 8, period_s: Some(1.2e-3) },
        ] {
            let settings = Settings { mode, ..Settings::default() };
            let bytes = settings.to_bytes(1024);
            assert_eq!(Settings::from_bytes(&bytes), Ok((settings, 1024)));
            for end in 0..bytes.len() {
                let cut = Settings::from_bytes(&bytes[..end]);
                assert_eq!(cut, Err(SettingsError::Encoding(EncodingError::Field)), "{end}");
            }
        }
        for most in 1..=4 {
            let settings = Settings { most, harmonics: 11 + most, ..Settings::default() };
            assert_eq!(Settings::from_bytes(&settings.to_bytes(1024)), Ok((settings, 1024)));
        }
    }

    /// The longest settings fit into an order, and what nobody knows here is refused, and not passed over.
    #[test]
    fn settings_that_say_more_are_refused() {
        const { assert!(2 + Settings::BYTES <= crate::frame::PAYLOAD) };
        let uncertainty = Some(Uncertainty { clock_ppm: 20.0, ..Uncertainty::default() });
        let settings = Settings { effort: Some(Effort::ONE), uncertainty, ..Settings::default() };
        let bytes = settings.to_bytes(1024);
        let told = |place: usize, value: u8| {
            let mut bytes = bytes.clone();
            bytes[place] = value;
            Settings::from_bytes(&bytes)
        };
        assert_eq!(told(0, 9), Err(SettingsError::Encoding(EncodingError::Version)));
        assert_eq!(told(1, 1), Err(SettingsError::Encoding(EncodingError::Length)));
        // Whether two converters sample.
        assert_eq!(told(8, 9), Err(SettingsError::Encoding(EncodingError::Field)));
        let mut later = bytes.clone();
        later.push(7).unwrap();
        assert_eq!(Settings::from_bytes(&later), Ok((settings, 1024)));
        later[5] += 1;
        let later = Settings::from_bytes(&later);
        assert_eq!(later, Err(SettingsError::Encoding(EncodingError::Version)));
    }

    #[test]
    fn calibration_moves_ranges_and_nothing_else() {
        let mut measurement = Measurement::default();
        let calibration = Calibration { clock_ppm: 0.0, range_offset_m: -0.25, range_slope: 1.01 };
        calibration.apply(&mut measurement);
        assert_eq!(measurement, Measurement::default());
        let ranges = [10.0, 20.0].map(I32F32::from_num);
        let candidates = ranges.map(|range| Candidate { range, ..Candidate::default() });
        let ambiguity = Ambiguity::Several(Candidates::new(candidates));
        let target = Target { range: ranges[0], sigma_range: 0.5, ambiguity, ..Target::default() };
        measurement.result = Outcome::Target(target);
        calibration.apply(&mut measurement);
        let Outcome::Target(target) = measurement.result else { panic!("still a target") };
        assert!((target.range.to_num::<f64>() - 9.85).abs() < 1e-6);
        assert_eq!(target.sigma_range, 0.5 * 1.01);
        let candidates = target.ambiguity.candidates();
        assert_eq!(candidates[0].range, target.range);
        assert!((candidates[1].range.to_num::<f64>() - 19.95).abs() < 1e-6);
        let before = measurement;
        Calibration::default().apply(&mut measurement);
        assert_eq!(measurement, before);
    }
}
