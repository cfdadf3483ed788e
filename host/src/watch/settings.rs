//! A device's settings as JSON, for people to read and edit.

use super::{WatchError, io};
use picket_dsp::Effort;
use picket_dsp::acquire::burst::Trigger;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier;
use picket_dsp::config::{Config, Following, Scene};
use picket_dsp::methods::registry::Method;
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_dsp::tone::fit::Reach;
use picket_dsp::tone::lines::MOST;
use picket_wire::settings::{Calibration, Drive, Mode, Settings};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The fields; those left out have their defaults.
#[derive(Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Fields {
    n: usize,
    core_mhz: u16,
    iq: bool,
    rate_hz: f64,
    band_hz: Option<(f64, f64)>,
    range_m: Option<(f64, f64)>,
    velocity_mps: Option<(f64, f64)>,
    method: String,
    reach: u8,
    effort: Rounds,
    false_alarm: f64,
    scene: Scenes,
    most: u8,
    harmonics: u8,
    follow: Following,
    carrier: Carrier,
    drive: Drives,
    mode: Modes,
    guard: u16,
    report_every: u16,
    slots: u16,
    start: bool,
    uncorrected: bool,
    worst_case: bool,
    clock_ppm: f32,
    range_offset_m: f32,
    range_slope: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    uncertainty: Option<Uncertainty>,
}

/// The most rounds of the joint fit, or the board's own choice.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", untagged)]
enum Rounds {
    Most(u8),
    Board(Auto),
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Auto {
    Auto,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Scenes {
    Tone,
    Doppler {
        wavelength_m: f64,
        angle_rad: f64,
        #[serde(default = "usual_before_doppler")]
        mixing: String,
    },
    Chirp {
        shape: Shape,
        wavelength_m: f64,
        bandwidth_hz: f64,
        #[serde(default = "usual_before_chirp")]
        mixing: String,
        #[serde(default)]
        sweep_curvature: f64,
    },
}

fn usual_before_doppler() -> String {
    Mixing::RxConjTx.name().into()
}

fn usual_before_chirp() -> String {
    Mixing::default().name().into()
}

fn mixing_of(name: &str) -> Result<Mixing, String> {
    Mixing::from_name(name).ok_or_else(|| {
        let [one, other] = Mixing::ALL.map(Mixing::name);
        format!("there is no mixing {name}: write {one} or {other}, docs/board.md says how to check which")
    })
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Drives {
    Off,
    Dac { low: u16, high: u16 },
    Adf4159 { reference_hz: f64, start_hz: f64, divider: u8 },
    External,
}

/// What is made of the blocks.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Modes {
    #[default]
    Blocks,
    Accumulate {
        blocks: u32,
        #[serde(default)]
        drift_bins: f32,
    },
    Bursts(Trigger),
    Frames {
        chirps: u16,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        period_s: Option<f64>,
    },
}

impl Default for Fields {
    fn default() -> Self {
        Self::of(&Settings::default(), 1024)
    }
}

impl Fields {
    fn of(settings: &Settings, n: usize) -> Self {
        let Settings { config, calibration, .. } = settings;
        Self {
            n,
            core_mhz: settings.core_mhz,
            iq: settings.iq,
            rate_hz: config.rate_hz,
            band_hz: config.band_hz,
            range_m: config.range_m,
            velocity_mps: config.velocity_mps,
            method: config.method.name().into(),
            reach: config.reach.bins() as u8,
            effort: match settings.effort {
                Some(effort) => Rounds::Most(effort.rounds()),
                None => Rounds::Board(Auto::Auto),
            },
            false_alarm: config.false_alarm,
            scene: match config.scene {
                Scene::Doppler { wavelength_m, angle_rad, mixing } => {
                    Scenes::Doppler { wavelength_m, angle_rad, mixing: mixing.name().into() }
                }
                Scene::Chirp(chirp) => {
                    let Chirp {
                        shape, wavelength_m, bandwidth_hz, mixing, sweep_curvature, ..
                    } = chirp;
                    let mixing = mixing.name().into();
                    Scenes::Chirp { shape, wavelength_m, bandwidth_hz, mixing, sweep_curvature }
                }
                _ => Scenes::Tone,
            },
            most: settings.most,
            harmonics: settings.harmonics,
            follow: config.following,
            carrier: config.carrier,
            drive: match settings.drive {
                Drive::Off => Drives::Off,
                Drive::Dac { low, high } => Drives::Dac { low, high },
                Drive::Adf4159 { reference_hz, start_hz, divider } => {
                    Drives::Adf4159 { reference_hz, start_hz, divider }
                }
                Drive::External => Drives::External,
            },
            mode: match settings.mode {
                Mode::Blocks => Modes::Blocks,
                Mode::Accumulate { blocks, drift_bins } => Modes::Accumulate { blocks, drift_bins },
                Mode::Bursts(trigger) => Modes::Bursts(trigger),
                Mode::Frames { chirps, period_s } => Modes::Frames { chirps, period_s },
            },
            guard: settings.guard,
            report_every: settings.report_every,
            slots: settings.slots,
            start: settings.start,
            uncorrected: settings.uncorrected,
            worst_case: settings.worst_case,
            clock_ppm: calibration.clock_ppm,
            range_offset_m: calibration.range_offset_m,
            range_slope: calibration.range_slope,
            uncertainty: settings.uncertainty,
        }
    }

    fn settings(self) -> Result<(Settings, usize), String> {
        let reach = match self.reach {
            4 => Reach::Four,
            8 => Reach::Eight,
            16 => Reach::Sixteen,
            other => return Err(format!("reach is 4, 8 or 16, not {other}")),
        };
        if !(1..=MOST as u8).contains(&self.most) {
            return Err(format!("most is 1 to {MOST} tones a block, not {}", self.most));
        }
        if !matches!(self.harmonics, 0 | 2..=15) {
            return Err(format!(
                "harmonics is their highest order, 2 to 15, or 0, not {}",
                self.harmonics
            ));
        }
        let method = Method::ALL.iter().find(|method| method.name() == self.method);
        let method = *method.ok_or_else(|| format!("there is no method {}", self.method))?;
        let scene = match self.scene {
            Scenes::Tone => Scene::Tone,
            Scenes::Doppler { wavelength_m, angle_rad, ref mixing } => {
                let mixing = mixing_of(mixing)?;
                Scene::Doppler { wavelength_m, angle_rad, mixing }
            }
            Scenes::Chirp { shape, wavelength_m, bandwidth_hz, ref mixing, sweep_curvature } => {
                if sweep_curvature.is_nan() || sweep_curvature.abs() >= 0.25 {
                    return Err(format!(
                        "sweep_curvature is a share of the bandwidth above -0.25 and below 0.25, not {sweep_curvature}"
                    ));
                }
                let mixing = mixing_of(mixing)?;
                // Duration and guard are the device's own: those of block and guard samples.
                Scene::Chirp(Chirp {
                    shape,
                    wavelength_m,
                    bandwidth_hz,
                    duration_s: 0.0,
                    mixing,
                    sweep_curvature,
                    ..Chirp::default()
                })
            }
        };
        let effort = match self.effort {
            Rounds::Board(Auto::Auto) => None,
            Rounds::Most(rounds) => Some(Effort::from_rounds(rounds).ok_or_else(|| {
                format!("effort is a number of rounds from 0 to 3, or \"auto\", not {rounds}")
            })?),
        };
        let drive = match self.drive {
            Drives::Off => Drive::Off,
            Drives::Dac { low, high } => Drive::Dac { low, high },
            Drives::Adf4159 { reference_hz, start_hz, divider } => {
                Drive::Adf4159 { reference_hz, start_hz, divider }
            }
            Drives::External => Drive::External,
        };
        let config = Config {
            rate_hz: self.rate_hz,
            codes: Codes::unsigned::<12>(),
            band_hz: self.band_hz,
            range_m: self.range_m,
            velocity_mps: self.velocity_mps,
            method,
            reach,
            false_alarm: self.false_alarm,
            scene,
            following: self.follow,
            carrier: self.carrier,
            ..Config::new(1.0, Codes::signed::<12>())
        };
        let calibration = Calibration {
            clock_ppm: self.clock_ppm,
            range_offset_m: self.range_offset_m,
            range_slope: self.range_slope,
        };
        let mode = match self.mode {
            Modes::Blocks => Mode::Blocks,
            Modes::Accumulate { blocks, drift_bins } => Mode::Accumulate { blocks, drift_bins },
            Modes::Bursts(trigger) => Mode::Bursts(trigger),
            Modes::Frames { chirps, period_s } => Mode::Frames { chirps, period_s },
        };
        let settings = Settings {
            core_mhz: self.core_mhz,
            iq: self.iq,
            config,
            guard: self.guard,
            drive,
            mode,
            report_every: self.report_every,
            most: self.most,
            harmonics: self.harmonics,
            slots: self.slots,
            start: self.start,
            uncorrected: self.uncorrected,
            worst_case: self.worst_case,
            effort,
            calibration,
            uncertainty: self.uncertainty,
        };
        Ok((settings, self.n))
    }
}

/// Settings and length of a block from a JSON file.
pub fn read(path: &Path) -> Result<(Settings, usize), WatchError> {
    let text = std::fs::read_to_string(path).map_err(io(path.display()))?;
    from_json(&text).map_err(|what| WatchError::Settings(format!("{}: {what}", path.display())))
}

/// Settings and length of a block from JSON.
///
/// # Errors
/// In one line, what is wrong with them.
pub fn from_json(text: &str) -> Result<(Settings, usize), String> {
    let fields: Fields = serde_json::from_str(text).map_err(|error| error.to_string())?;
    fields.settings()
}

/// Settings as JSON.
pub fn to_json(settings: &Settings, n: usize) -> String {
    serde_json::to_string_pretty(&Fields::of(settings, n)).unwrap_or_default()
}

/// The settings of a board whose clock is off by this much, ppm. Its timers count as before, so the rate is stated by the new error.
pub fn with_clock(settings: &Settings, ppm: f64) -> Settings {
    let before = settings.calibration.true_hz(1.0);
    let calibration = Calibration { clock_ppm: ppm as f32, ..settings.calibration };
    let mut settings = Settings { calibration, ..*settings };
    settings.config.rate_hz *= calibration.true_hz(1.0) / before;
    settings
}

/// The settings in an answer's body, if it holds some.
pub fn from_answer(body: &[u8]) -> Option<(Settings, usize)> {
    Settings::from_bytes(body).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_come_back_from_json() {
        let scene = Scene::Chirp(Chirp {
            shape: Shape::Triangle,
            wavelength_m: 0.0125,
            bandwidth_hz: 2e8,
            duration_s: 0.0,
            mixing: Mixing::RxConjTx,
            sweep_curvature: 0.01,
            ..Chirp::default()
        });
        let following = Following { most: 1, refresh: 16, ..Following::default() };
        let config = Config { scene, following, ..Settings::default().config };
        let drive = Drive::Adf4159 { reference_hz: 8e7, start_hz: 24e9, divider: 2 };
        for settings in [
            Settings::default(),
            Settings { config, drive, guard: 9, iq: true, ..Settings::default() },
            Settings {
                config: Config {
                    carrier: Carrier { linewidth_hz: 0.1, envelope_hz: 12.5 },
                    ..config
                },
                ..Settings::default()
            },
            Settings { uncorrected: true, ..Settings::default() },
            Settings { worst_case: true, ..Settings::default() },
            Settings { effort: Some(Effort::TWO), ..Settings::default() },
            Settings {
                mode: Mode::Accumulate { blocks: 100, drift_bins: -0.5 },
                ..Settings::default()
            },
            Settings { mode: Mode::Bursts(Trigger::default()), ..Settings::default() },
            Settings {
                mode: Mode::Bursts(Trigger { ratio: Some(2.5), hold_off: 7, least: 9 }),
                ..Settings::default()
            },
            Settings { mode: Mode::Frames { chirps: 64, period_s: None }, ..Settings::default() },
            Settings {
                mode: Mode::Frames { chirps: 128, period_s: Some(1.2e-3) },
                ..Settings::default()
            },
        ] {
            let fields: Fields = serde_json::from_str(&to_json(&settings, 1024)).unwrap();
            assert_eq!(fields.settings(), Ok((settings, 1024)));
        }
        assert!(serde_json::from_str::<Fields>(r#"{"rat_hz": 3}"#).is_err());
        let sparse: Fields = serde_json::from_str(r#"{"rate_hz": 1e5}"#).unwrap();
        assert_eq!(sparse.settings().unwrap().0.config.rate_hz, 1e5);
        let mode = |text: &str| {
            let fields: Fields = serde_json::from_str(&format!("{{\"mode\": {text}}}")).unwrap();
            fields.settings().map(|(settings, _)| settings.mode)
        };
        assert_eq!(mode(r#""blocks""#), Ok(Mode::Blocks));
        assert_eq!(mode(r#"{"bursts": {}}"#), Ok(Mode::Bursts(Trigger::default())));
        let sums = Mode::Accumulate { blocks: 9, drift_bins: 0.0 };
        assert_eq!(mode(r#"{"accumulate": {"blocks": 9}}"#), Ok(sums));
        let frames = Mode::Frames { chirps: 64, period_s: None };
        assert_eq!(mode(r#"{"frames": {"chirps": 64}}"#), Ok(frames));
        let scene = |text: &str| {
            let fields: Fields = serde_json::from_str(&format!("{{\"scene\": {text}}}")).unwrap();
            fields.settings().map(|(settings, _)| settings.config.scene)
        };
        // What was written before mixing had a name means the usual one.
        let doppler = scene(r#"{"doppler": {"wavelength_m": 0.01, "angle_rad": 0.0}}"#);
        let mixing = Mixing::RxConjTx;
        assert_eq!(doppler, Ok(Scene::Doppler { wavelength_m: 0.01, angle_rad: 0.0, mixing }));
        let chirp = r#""shape": "triangle", "wavelength_m": 0.0125, "bandwidth_hz": 2e8"#;
        let Ok(Scene::Chirp(usual)) = scene(&format!(r#"{{"chirp": {{{chirp}}}}}"#)) else {
            panic!("a chirp");
        };
        assert_eq!((usual.mixing, usual.sweep_curvature), (Mixing::TxConjRx, 0.0));
        for (field, cure) in [
            (r#""mixing": "up""#, "there is no mixing up: write tx-conj-rx or rx-conj-tx"),
            (
                r#""sweep_curvature": 0.25"#,
                "sweep_curvature is a share of the bandwidth above -0.25",
            ),
        ] {
            let told = scene(&format!(r#"{{"chirp": {{{chirp}, {field}}}}}"#)).unwrap_err();
            assert!(told.starts_with(cure) && !told.contains('\n'), "{told}");
        }
    }
}
