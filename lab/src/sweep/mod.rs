//! Monte Carlo: the errors of methods over many simulated records.
//!
//! Every method sees the same records. A trial's record depends on the seed and the trial's number alone, and
//! sums are taken in the order of trials, so a sweep gives the same digits on any number of threads.

pub mod command;

use crate::arithmetic::{Frequencies, whole};
use crate::estimator::Estimator;
use crate::exact::{Numbers, frequencies};
use crate::simulate::{Kind, Line, Signal, Width, generator};
use crate::trials::Trials;
use indicatif::ProgressBar;
use picket_dsp::tone::sigma::bound_bins;
use rand::RngExt;
use serde::Serialize;
use std::ops::AddAssign;

/// An error beyond this, in bins, is an outlier: the peak was not the tone.
pub const OUTLIER_BINS: f64 = 1.5;

/// Where the tone lies with respect to the peak bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Offsets {
    /// This number of points from -0.5 to +0.5 bin, both included; each point has all trials.
    Points(usize),
    /// Anew for each trial, uniform in -0.5..0.5.
    Uniform,
    /// Always this one.
    Fixed(f64),
}

impl Offsets {
    /// How many times the number of trials is made.
    pub const fn points(self) -> usize {
        match self {
            Offsets::Points(points) => points,
            _ => 1,
        }
    }
}

/// What is simulated.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The methods; each must be right for the kind of record and the numbers.
    pub estimators: Vec<Estimator>,
    /// The numbers in which they work.
    pub numbers: Numbers,
    /// Samples in a record.
    pub n: usize,
    /// The bin the offsets are counted from.
    pub bin: f64,
    /// Where the tone lies.
    pub offsets: Offsets,
    /// Records at each offset.
    pub trials: usize,
    /// The converter.
    pub width: Width,
    /// Amplitude in codes; `None` for [`full_amplitude`].
    pub amplitude: Option<f64>,
    /// Constant offset in codes.
    pub dc: f64,
    /// The seed of the generator.
    pub seed: u64,
}

/// The largest amplitude at which four standard deviations of noise do not touch the rails, in
/// codes; of a float converter that of 12 bits.
pub fn full_amplitude(width: Width, snr_db: f64) -> f64 {
    let rail = match width {
        Width::Codes(codes) if codes.bits() == 16 => 32760.0,
        _ => 2040.0,
    };
    rail / (1.0 + 4.0 * (0.5 / 10f64.powf(snr_db / 10.0)).sqrt())
}

/// Sums of errors in bins, outliers left out.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    outliers: u64,
    error: f64,
    magnitude: f64,
    square: f64,
    fourth: f64,
}

impl Sums {
    fn push(&mut self, error: f64) {
        // A record without an answer is an outlier too.
        if error.is_nan() || error.abs() > OUTLIER_BINS {
            self.outliers += 1;
            return;
        }
        self.count += 1.0;
        self.error += error;
        self.magnitude += error.abs();
        self.square += error * error;
        self.fourth += error.powi(4);
    }
}

impl AddAssign<&Sums> for Sums {
    fn add_assign(&mut self, other: &Self) {
        self.count += other.count;
        self.outliers += other.outliers;
        self.error += other.error;
        self.magnitude += other.magnitude;
        self.square += other.square;
        self.fourth += other.fourth;
    }
}

/// The errors of one method at one signal-to-noise ratio. The keys are those of the JSON lines.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The method.
    pub method: &'static str,
    /// "real" or "complex".
    pub kind: &'static str,
    /// Samples in a record.
    pub n: usize,
    /// Signal-to-noise ratio in dB; `None` for no noise.
    pub snr_db: Option<f64>,
    /// The arithmetic.
    pub arith: &'static str,
    /// Records, outliers included.
    pub trials: usize,
    /// Records whose error exceeds [`OUTLIER_BINS`]; the other figures leave them out.
    pub outliers: u64,
    /// Root mean square of the error.
    pub rmse_bins: f64,
    /// Standard error of that.
    pub rmse_se_bins: f64,
    /// Mean of the error's magnitude.
    pub mean_abs_bins: f64,
    /// Standard error of that.
    pub mean_abs_se_bins: f64,
    /// Mean of the error.
    pub bias_bins: f64,
    /// Standard error of that.
    pub bias_se_bins: f64,
    /// The Cramer-Rao bound.
    pub bound_bins: f64,
    /// RMSE over the bound; `None` without noise.
    pub ratio: Option<f64>,
    /// Standard error of that.
    pub ratio_se: Option<f64>,
}

impl Row {
    /// RMSE over the bound, and its standard error; both NaN without noise.
    pub fn over_bound(&self) -> (f64, f64) {
        (self.ratio.unwrap_or(f64::NAN), self.ratio_se.unwrap_or(f64::NAN))
    }
}

/// Trials that one task takes, and sums in order.
const CHUNK: usize = 200;

impl Sweep {
    /// All trials of one signal-to-noise ratio, over all cores: a row for each method. `bar` advances by one
    /// for each trial.
    pub fn run<R: Kind>(&self, snr_db: f64, bar: &ProgressBar) -> Result<Vec<Row>, String> {
        self.run_either(R::IQ, snr_db, bar)
    }

    /// Not generic, so that it is compiled here, once.
    fn run_either(&self, iq: bool, snr_db: f64, bar: &ProgressBar) -> Result<Vec<Row>, String> {
        with_kind!(iq, R => self.run_all::<R>(snr_db, bar))
    }

    fn run_all<R: Kind>(&self, snr_db: f64, bar: &ProgressBar) -> Result<Vec<Row>, String> {
        let plan = whole::<R>(self.n, self.width.codes())?;
        let make = || frequencies::<R>(self.numbers, self.n, plan);
        let trials = Trials { count: self.trials * self.offsets.points(), chunk: CHUNK, bar };
        let methods = self.estimators.len();
        let sums = trials.sums(methods, make, |engine, number, sums: &mut [Sums]| {
            let errors = self.trial::<R>(engine, snr_db, number);
            sums.iter_mut().zip(errors).for_each(|(sums, error)| sums.push(error));
        })?;
        let rows = self.estimators.iter().zip(&sums);
        let row = |(estimator, sums): (&Estimator, &Sums)| {
            self.row::<R>(estimator.name(), snr_db, trials.count, sums)
        };
        Ok(rows.map(row).collect())
    }

    fn trial<R: Kind>(&self, engine: &mut dyn Frequencies, snr_db: f64, trial: usize) -> Vec<f64> {
        let mut rng = generator(self.seed, trial as u64);
        let delta = match self.offsets {
            Offsets::Points(1) => 0.0,
            Offsets::Points(points) => (trial % points) as f64 / (points - 1) as f64 - 0.5,
            Offsets::Uniform => rng.random_range(-0.5..0.5),
            Offsets::Fixed(delta) => delta,
        };
        let bins = self.bin + delta;
        let amplitude = self.amplitude.unwrap_or_else(|| full_amplitude(self.width, snr_db));
        let signal = Signal {
            lines: vec![Line { bins, amplitude, phase: None }],
            snr_db,
            dc: [self.dc; 2],
            width: self.width,
        };
        let record = signal.record::<R>(self.n, &mut rng);
        let n = self.n as f64;
        let error = |found: f64| match R::IQ {
            // Round the circle, the shorter way.
            true => (found - bins + n / 2.0).rem_euclid(n) - n / 2.0,
            false => found - bins,
        };
        engine.frequencies(&record, &self.estimators).into_iter().map(error).collect()
    }

    fn row<R: Kind>(&self, method: &'static str, snr_db: f64, trials: usize, sums: &Sums) -> Row {
        let mean = |sum: f64| sum / sums.count;
        let (square, fourth) = (mean(sums.square), mean(sums.fourth));
        let rmse = square.sqrt();
        let deviation =
            |mean_value: f64| ((square - mean_value * mean_value).max(0.0) / sums.count).sqrt();
        let rmse_se = ((fourth - square * square).max(0.0) / sums.count).sqrt() / (2.0 * rmse);
        let bound = f64::from(bound_bins(R::IQ, self.n, 10f64.powf(snr_db / 10.0) as f32));
        let noisy = |x: f64| (bound > 0.0).then_some(x / bound);
        Row {
            method,
            kind: R::NAME,
            n: self.n,
            snr_db: snr_db.is_finite().then_some(snr_db),
            arith: self.numbers.name(),
            trials,
            outliers: sums.outliers,
            rmse_bins: rmse,
            rmse_se_bins: rmse_se,
            mean_abs_bins: mean(sums.magnitude),
            mean_abs_se_bins: deviation(mean(sums.magnitude)),
            bias_bins: mean(sums.error),
            bias_se_bins: deviation(mean(sums.error)),
            bound_bins: bound,
            ratio: noisy(rmse),
            ratio_se: noisy(rmse_se),
        }
    }
}
