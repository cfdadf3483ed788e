//! What a user tells of a radar beside its ramps: how its chirps repeat, its calibration, and what is not known of it.

use super::known;
use crate::{band, cli, views};
use clap::Args;
use picket_dsp::Chirp;
use picket_dsp::solve::phase_range::{Calibration, PhaseRanging};
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_wire::view;
use std::path::PathBuf;

/// Options of radars whose chirps repeat.
#[derive(Args, Clone, Debug, Default)]
pub struct Told {
    /// Chirps of a frame, 8, 16, ... 256: gives several targets with range and velocity, also weak ones. 1 measures each chirp by itself
    /// [default: as many as an array has; 1 of other recordings]
    #[arg(long, value_name = "COUNT", value_parser = chirps, requires = "chirp_s")]
    pub chirps: Option<usize>,
    /// From one chirp's start to the next, s [default: the ramp]
    #[arg(long, value_name = "S", value_parser = cli::positive, requires = "chirp_s")]
    pub period_s: Option<f64>,
    /// The channel or column with a pulse that begins each chirp: the ramps are cut by its rising edges
    #[arg(long, value_name = "C", value_parser = cli::count::<256>, requires = "chirp_s", conflicts_with_all = ["period_s", "known_m", "displacement"])]
    pub trigger: Option<usize>,
    /// Finds a sawtooth's ramps in a continuous recording: their period by the comb that they make, and where they begin
    #[arg(long, requires = "chirp_s", conflicts_with_all = ["period_s", "trigger", "known_m", "displacement"])]
    pub find_ramps: bool,
    /// From one chirp's start to the next, samples, where it was found.
    #[arg(skip)]
    pub found: Option<f64>,
    /// From a ramp's start to its record's first sample, s [default: by the record's place]
    #[arg(long, value_name = "S", value_parser = cli::number, requires = "chirp_s")]
    pub guard_s: Option<f64>,
    /// The height of a ramp's middle above the straight line between its ends, as a share of the bandwidth: above -0.25 and below 0.25
    #[arg(long, value_name = "SHARE", value_parser = curvature, allow_negative_numbers = true, default_value_t = 0.0, requires = "chirp_s")]
    pub curvature: f64,
    /// The ranges that targets may have, m
    #[arg(long, value_name = "LO:HI", value_parser = band::parse, allow_hyphen_values = true, requires = "chirp_s")]
    pub range_m: Option<(f64, f64)>,
    /// Ranges by phase beside those by frequency: micrometres, where the cycle is sure
    #[arg(long, requires = "chirp_s")]
    pub phase: bool,
    /// The recording is of a target at rest at this range, m, with one standard deviation behind a colon: gives the phase at 0 m and the range's
    /// offset, for --calibration
    #[arg(long, value_name = "M[:SIGMA]", value_parser = known::parse, requires = "chirp_s", conflicts_with_all = ["calibration", "displacement"])]
    pub known_m: Option<(f64, f64)>,
    /// Keeps the calibration of --known-m in this file
    #[arg(long, value_name = "FILE", requires = "known_m")]
    pub save: Option<PathBuf>,
    /// What --known-m --save wrote at another distance: gives the slope of the sweep as well
    #[arg(long, value_name = "FILE", requires = "known_m")]
    pub first: Option<PathBuf>,
    /// What --known-m --save wrote: the phase at 0 m and the range's offset
    #[arg(long, value_name = "FILE", requires = "chirp_s")]
    pub calibration: Option<PathBuf>,
    /// What is not known of the radar, one standard deviation each, as clock_ppm=20,slope_ppm=100,range_offset_m=1e-3: gives the whole
    /// uncertainty beside sigma
    #[arg(long, value_name = "NAME=SIGMA,...", value_parser = uncertainty)]
    pub uncertainty: Option<Uncertainty>,
    /// The way of the strongest target by its phase, block by block or chirp by chirp, and the lines of its spectrum; with --carrier-hz
    #[arg(long, requires = "carrier_hz")]
    pub displacement: bool,
}

fn curvature(text: &str) -> Result<f64, String> {
    let share = cli::number(text).ok().filter(|share| share.abs() < 0.25);
    share.ok_or_else(|| "give a share of the bandwidth above -0.25 and below 0.25".into())
}

fn chirps(text: &str) -> Result<usize, String> {
    let count = text.parse().ok();
    let right = |count: &usize| *count == 1 || (8..=256).contains(count) && count.is_power_of_two();
    count.filter(right).ok_or_else(|| "give 8, 16, 32, 64, 128 or 256 chirps, or 1".into())
}

/// Standard deviations by their names.
///
/// # Errors
/// A name that is not known, or a value that is no standard deviation.
pub fn uncertainty(text: &str) -> Result<Uncertainty, String> {
    let pair = |part: &str| {
        let (name, value) = part.split_once('=')?;
        Some((name.trim().to_owned(), value.trim().parse::<f64>().ok()?))
    };
    let pairs: Option<Vec<_>> = text.split(',').map(pair).collect();
    let pairs = pairs.ok_or("give names with numbers: clock_ppm=20,slope_ppm=100")?;
    let told: view::Uncertainty = views::told(pairs.iter().map(|(name, x)| (name.as_str(), *x)))?;
    let known = Uncertainty::from(&told);
    known.is_valid().then_some(known).ok_or_else(|| "a standard deviation is 0 or more".into())
}

impl Told {
    /// The calibration in the file; without one the phase at 0 m is unknown: any turn is as probable.
    ///
    /// # Errors
    /// The file cannot be read, or is no calibration.
    pub fn calibration(&self) -> Result<Calibration, String> {
        let Some(path) = &self.calibration else {
            if self.phase {
                eprintln!(
                    "the phase at 0 m is unknown, so that no range by phase is sure: --known-m calibrates, --calibration reads it"
                );
            }
            let sigma_phase_rad = std::f32::consts::PI / 3f32.sqrt();
            return Ok(Calibration { sigma_phase_rad, ..Calibration::default() });
        };
        let (calibration, all) = known::read(path)?;
        if let Some(line) = known::made(path, &all) {
            eprintln!("{line}");
        }
        Ok(calibration)
    }

    /// The solver of ranges by phase with this calibration, where they are asked for.
    ///
    /// # Errors
    /// Those of [`Told::calibration`], or the chirp has no ranges by phase.
    pub fn ranging(
        &self,
        chirp: &Chirp,
        rate_hz: f64,
        n: usize,
        iq: bool,
    ) -> Result<Option<PhaseRanging>, String> {
        let calibration = self.calibration()?;
        let ranging = || PhaseRanging::new(chirp, rate_hz, n, iq, calibration);
        self.phase.then(ranging).transpose().map_err(super::text)
    }
}
