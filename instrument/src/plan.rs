//! The checks of settings that all boards share.

use crate::checksum;
use picket_dsp::accumulate::MOST_BLOCKS;
use picket_dsp::acquire::burst::Trigger;
use picket_dsp::acquire::frontend::Timing;
use picket_dsp::config::{Config, Scene};
use picket_dsp::plan::EitherPlan;
use picket_dsp::solve::equations::Chirp;
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
        Basis { settings, clock, effort: self.plan.options.effort.number() }
    }

    /// Checks settings for a board that can neither make a chirp nor follow one, and whose worst block nobody has searched for.
    ///
    /// # Errors
    /// The errors of [`Plan::new`], and settings with a drive, or with a rate that must hold for the worst block.
    pub fn undriven(settings: &Settings, rate_hz: f64) -> Result<Self, SettingsError> {
        match settings.drive {
            Drive::Off if settings.worst_case => Err(SettingsError::Rate(RateError::Unsearched)),
            Drive::Off => Self::new(settings, rate_hz),
            _ => Err(SettingsError::Drive),
        }
    }
}

/// Whether the mode is compatible with the other settings: sums and bursts have one tone, and no tracks.
fn is_possible(settings: &Settings, chirp: bool) -> bool {
    let numbers = match settings.mode {
        Mode::Blocks => return true,
        Mode::Accumulate { blocks, drift_bins } => {
            (1..=MOST_BLOCKS).contains(&blocks) && drift_bins.is_finite()
        }
        Mode::Bursts(Trigger { ratio, .. }) => {
            ratio.is_none_or(|ratio| ratio >= Trigger::LEAST_RATIO && ratio.is_finite())
        }
    };
    let alone = settings.config.following.most == 0 && settings.further() + settings.order() == 0;
    numbers && alone && !chirp
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
