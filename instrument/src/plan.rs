//! The checks of settings that all boards share.

use crate::checksum;
use picket_dsp::accumulate::MOST_BLOCKS;
use picket_dsp::acquire::burst::Trigger;
use picket_dsp::acquire::frontend::Timing;
use picket_dsp::config::{Config, Scene};
use picket_dsp::pipeline::Measurement;
use picket_dsp::plan::EitherPlan;
use picket_dsp::solve::equations::Chirp;
use picket_dsp::solve::uncertainty::Total;
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
        let told = settings.uncertainty.is_none_or(|known| known.is_valid());
        if !(right && told && (0.5..=2.0).contains(&range_slope)) {
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
        Settings { config, ..*settings }.frames(N)?;
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

    /// The whole error of a measurement, if the settings tell what is not known of the sensor.
    pub fn total(&self, measurement: &Measurement) -> Option<Total> {
        let angle_rad = match self.settings.config.scene {
            Scene::Doppler { angle_rad, .. } => angle_rad as f32,
            _ => 0.0,
        };
        self.settings.uncertainty.map(|known| measurement.total(&known, angle_rad))
    }

    /// Checks settings for a board that can neither make a chirp nor follow one, and whose worst block is not known: where the settings leave
    /// the effort to it, it takes no round.
    ///
    /// # Errors
    /// The errors of [`Plan::new`], and settings with a drive, or with a rate that must hold for the worst block.
    pub fn undriven(settings: &Settings, rate_hz: f64) -> Result<Self, SettingsError> {
        match settings.drive {
            Drive::Off if settings.worst_case => Err(SettingsError::Rate(RateError::Unsearched)),
            Drive::Off => {
                let effort = settings.effort.unwrap_or(Effort::LOOK);
                let config = Config { effort, ..settings.config };
                Self::new(&Settings { config, ..*settings }, rate_hz)
            }
            _ => Err(SettingsError::Drive),
        }
    }
}

/// What a board knows of the time that a block takes, in cycles of its core.
#[derive(Clone, Copy, Debug)]
pub struct Load {
    /// What a block lasts.
    pub block: u64,
    /// What a usual block of these settings takes, whatever it is used for.
    pub usual: u64,
    /// What the worst known block takes with 0, 1, 2 and 3 rounds, all of which the image must have; `None` if there was no search.
    pub worst: Option<[u64; 4]>,
    /// What the target of a sawtooth takes.
    pub target: u64,
}

impl Load {
    /// The effort for these settings: theirs, or the most rounds whose worst block lasts no longer than a block does. The searches know one
    /// tone of a block, by least squares; otherwise the rounds of each tone are added to what a usual block takes.
    ///
    /// # Errors
    /// The rate must hold for the worst block, and that block is longer, or unknown. The lines that a triangle and a trapezoid look for
    /// beside a tone are not searched.
    pub fn effort(&self, settings: &Settings) -> Result<Effort, SettingsError> {
        let Config { following, method, scene, .. } = settings.config;
        let usual = matches!(method, Method::LeastSquares | Method::LeastSquaresReal);
        let tones = u64::from(settings.further()) + 1 + u64::from(following.most);
        let searched = usual
            && settings.mode == Mode::Blocks
            && settings.order() == 0
            && tones == 1
            && settings.segments() == 1;
        let target = if matches!(scene, Scene::Chirp(_)) { self.target } else { 0 };
        let holds = |effort: Effort| {
            self.worst.is_some_and(|worst| {
                let most = worst.get(usize::from(effort.rounds())).copied().unwrap_or(u64::MAX);
                let rounds = most.saturating_sub(worst[0]).saturating_mul(tones);
                let all = if searched { most } else { self.usual.saturating_add(rounds) };
                all.saturating_add(target) <= self.block
            })
        };
        let most = || Effort::ALL.iter().rev().copied().find(|&effort| holds(effort));
        let effort = settings.effort.or_else(most).unwrap_or(Effort::LOOK);
        match settings.worst_case {
            true if !searched || self.worst.is_none() => {
                Err(SettingsError::Rate(RateError::Unsearched))
            }
            true if !holds(effort) => Err(SettingsError::Rate(RateError::Worst)),
            _ => Ok(effort),
        }
    }
}

/// Whether the mode is compatible with the other settings: sums and bursts have one tone, and no tracks, and further tones and a fundamental
/// are those of a block that is searched whole.
fn is_possible(settings: &Settings, chirp: bool) -> bool {
    let one = settings.further() + settings.order() == 0;
    let free = settings.config.following.most == 0;
    let numbers = match settings.mode {
        Mode::Blocks => return one || free,
        // Checked with their plan.
        Mode::Frames { .. } => return true,
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
