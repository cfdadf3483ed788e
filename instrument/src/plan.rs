//! The checks of settings that all boards share.

use crate::checksum;
use picket_dsp::accumulate::MOST_BLOCKS;
use picket_dsp::acquire::burst::Trigger;
use picket_dsp::acquire::frontend::Timing;
use picket_dsp::config::{Config, Scene};
use picket_dsp::plan::EitherPlan;
use picket_dsp::solve::equations::Chirp;
use picket_dsp::{Effort, Method};
use picket_wire::boot::Clock;
use picket_wire::settings::{Calibration, Drive, GUARD, Mode, Settings};
use picket_wire::settings_error::{RateError, SettingsError};
use picket_wire::telemetry::Basis;

/// Checked settings, and the values that follow from them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan<const N: usize> {
    /// The settings with clock, rate and duration as the board makes them.
    pub settings: Settings,
    /// The pipeline's plan.
    pub plan: EitherPlan<N>,
    /// Samples in a segment: block and guard.
    pub length: u32,
    /// The timing of the blocks.
    pub timing: Timing,
}

impl<const N: usize> Plan<N> {
    /// Checks settings for blocks of `N` samples. `rate_hz` is the board's rate nearest to the wanted one. The codes are taken from the
    /// settings, which the instrument sets to its board's.
    ///
    /// # Errors
    /// The settings contradict each other, or cannot be measured.
    pub fn new(settings: &Settings, rate_hz: f64) -> Result<Self, SettingsError> {
        let Calibration { clock_ppm, range_offset_m, range_slope } = settings.calibration;
        let right = clock_ppm.abs() <= Calibration::MOST_PPM && range_offset_m.is_finite();
        if !(right && (0.5..=2.0).contains(&range_slope)) {
            return Err(SettingsError::Calibration);
        }
        let chirp = matches!(settings.config.scene, Scene::Chirp(_));
        if settings.guard > GUARD || (settings.guard > 0 && !chirp) {
            return Err(SettingsError::Guard);
        }
        if chirp != (settings.drive != Drive::Off) {
            return Err(SettingsError::Drive);
        }
        if !is_possible(settings, chirp) {
            return Err(SettingsError::Mode);
        }
        let length = N as u32 + u32::from(settings.guard);
        let config = true_config(settings, rate_hz, length);
        let plan = if settings.iq {
            config.plan().map(EitherPlan::Iq)
        } else {
            config.plan().map(EitherPlan::Real)
        };
        let plan = plan.map_err(SettingsError::Config)?;
        let timing = Timing { period: length, segments: config.scene.segments() };
        let report_every = settings.report_every.max(1);
        let settings = Settings { config, report_every, ..*settings };
        Ok(Plan { settings, plan, length, timing })
    }

    /// The basis of the measurements, for their records.
    pub fn basis(&self, clock: Clock) -> Basis {
        let settings = checksum::of_bytes(&self.settings.to_bytes(N));
        Basis { settings, clock, effort: self.plan.options.effort.available().rounds() }
    }

    /// Checks settings for a board that can neither make a chirp nor follow one, and whose worst block is not known.
    ///
    /// # Errors
    /// The errors of [`Plan::new`], and settings with a drive, or with a rate that must hold for the worst block.
    pub fn undriven(settings: &Settings, rate_hz: f64) -> Result<Self, SettingsError> {
        match settings.drive {
            Drive::Off => {
                check_worst(settings, 0, None, 0).and_then(|()| Self::new(settings, rate_hz))
            }
            _ => Err(SettingsError::Drive),
        }
    }
}

/// Checks that a block of `cycles` holds the worst block that is known, where the settings want that. `worst` has the cycles of that block
/// with 0 rounds and with 2, `None` where it is not known; `target` has the cycles for the target of a sawtooth. The
/// searches know one tone of a block, by least squares. The lines that a triangle and a trapezoid look for beside it are not searched.
///
/// # Errors
/// The worst block is longer, or unknown.
pub fn check_worst(
    settings: &Settings,
    cycles: u64,
    worst: Option<[u64; 2]>,
    target: u64,
) -> Result<(), SettingsError> {
    let Config { following, method, effort, scene, .. } = settings.config;
    let usual = matches!(method, Method::LeastSquares | Method::LeastSquaresReal);
    let alone = settings.mode == Mode::Blocks && settings.further() + settings.order() == 0;
    let alone = alone && settings.segments() == 1;
    let most = match (worst, effort) {
        _ if !settings.worst_case => return Ok(()),
        (Some([look, _]), Effort::LOOK) if usual && alone && following.most == 0 => look,
        (Some([_, two]), Effort::ONE | Effort::TWO) if usual && alone && following.most == 0 => two,
        _ => return Err(SettingsError::Rate(RateError::Unsearched)),
    };
    let target = if matches!(scene, Scene::Chirp(_)) { target } else { 0 };
    if cycles < most + target { Err(SettingsError::Rate(RateError::Worst)) } else { Ok(()) }
}

/// Whether the mode is compatible with the other settings: sums and bursts have one tone, and no tracks, and further tones and a fundamental
/// are those of a block that is searched whole.
fn is_possible(settings: &Settings, chirp: bool) -> bool {
    let one = settings.further() + settings.order() == 0;
    let free = settings.config.following.most == 0;
    let numbers = match settings.mode {
        Mode::Blocks => return one || free,
        Mode::Accumulate { blocks, drift_bins } => {
            (1..=MOST_BLOCKS).contains(&blocks) && drift_bins.is_finite()
        }
        Mode::Bursts(Trigger { ratio, .. }) => {
            ratio.is_none_or(|ratio| ratio >= Trigger::LEAST_RATIO && ratio.is_finite())
        }
    };
    numbers && one && free && !chirp
}

/// The configuration with the board's rate, and the ramp's true duration and guard.
fn true_config(settings: &Settings, rate_hz: f64, length: u32) -> Config {
    let rate_hz = settings.calibration.true_hz(rate_hz);
    let mut config = Config { rate_hz, ..settings.config };
    if let Scene::Chirp(Chirp { duration_s, guard_s, .. }) = &mut config.scene {
        // A board's rate is above 0.
        *duration_s = f64::from(length) / rate_hz;
        *guard_s = f64::from(settings.guard) / rate_hz;
    }
    config
}
