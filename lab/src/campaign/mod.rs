//! The campaign: estimators on disturbed records, compared with the truth.
//!
//! As in a sweep every method sees the same records, and the digits are the same on any number of threads.

mod cell;
pub mod command;

pub use cell::Cell;

use crate::arithmetic::{Arithmetic, Engine, engine, whole};
use crate::estimator::Estimator;
use crate::impair::{Impaired, Impairment, Setup};
use crate::simulate::{Kind, Width, generator};
use crate::trials::Trials;
use cell::Tally;
use clap::ValueEnum;
use indicatif::ProgressBar;
use picket_dsp::tone::effort::Effort;
use picket_dsp::tone::sigma::bound_bins;

/// An answer that may be used within sigma by its verdict, and is off by more sigmas than this, is overconfident.
pub const LIE_SIGMAS: f64 = 5.0;

/// What is true of a tone that changes within the block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Truth {
    /// The mean frequency over the block
    #[default]
    Mean,
    /// The frequency it had without chirp, walk or step
    Nominal,
}

/// What is measured.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// The methods; each must be right for the kind of record and the arithmetic.
    pub estimators: Vec<Estimator>,
    /// The arithmetic.
    pub arithmetic: Arithmetic,
    /// The effort spent on a line that is not a steady tone.
    pub effort: Effort,
    /// Samples in a record.
    pub n: usize,
    /// Records of each impairment at each signal-to-noise ratio.
    pub trials: usize,
    /// The converter.
    pub width: Width,
    /// Amplitude in codes; `None` for [`Setup`]'s.
    pub amplitude: Option<f64>,
    /// Bins between which the tone lies; `None` for the impairment's own.
    pub bins: Option<(f64, f64)>,
    /// Which frequency is the true one.
    pub truth: Truth,
    /// The seed of the generator.
    pub seed: u64,
}

/// Trials that one task takes, and sums in order.
const CHUNK: usize = 50;

impl Campaign {
    /// All records of an impairment at one signal-to-noise ratio, over all cores: a cell for each method. `bar`
    /// advances by one for each record.
    pub fn run<R: Kind>(
        &self,
        impairment: &Impairment,
        snr_db: f64,
        bar: &ProgressBar,
    ) -> Result<Vec<Cell>, String> {
        self.run_either(R::IQ, impairment, snr_db, bar)
    }

    /// Not generic, so that it is compiled here, once.
    fn run_either(
        &self,
        iq: bool,
        impairment: &Impairment,
        snr_db: f64,
        bar: &ProgressBar,
    ) -> Result<Vec<Cell>, String> {
        with_kind!(iq, R => self.run_all::<R>(impairment, snr_db, bar))
    }

    fn run_all<R: Kind>(
        &self,
        impairment: &Impairment,
        snr_db: f64,
        bar: &ProgressBar,
    ) -> Result<Vec<Cell>, String> {
        let mut plan = whole::<R>(self.n, self.width.codes())?;
        plan.options.effort = self.effort;
        let make = || engine::<R>(self.arithmetic, self.n, plan);
        let snr_db = if impairment.noisy() { snr_db } else { f64::INFINITY };
        let mut setup = Setup::new(self.n, snr_db);
        (setup.width, setup.amplitude, setup.bins) = (self.width, self.amplitude, self.bins);
        let trials = Trials { count: self.trials, chunk: CHUNK, bar };
        let methods = self.estimators.len();
        let tallies = trials.sums(methods, make, |engine, number, tallies: &mut [Tally]| {
            let mut rng = generator(self.seed, number as u64);
            let record = impairment.record::<R>(&setup, &mut rng);
            self.judge::<R>(engine, &record, tallies);
        })?;
        let cells = self.estimators.iter().zip(tallies).map(|(estimator, total)| {
            let severities = impairment.severities().map(|(key, value)| (key, value.into()));
            Cell {
                impair: impairment.name(),
                severities: severities.collect(),
                severity: impairment.label(),
                method: estimator.name(),
                kind: R::NAME,
                n: self.n,
                snr_db: snr_db.is_finite().then_some(snr_db),
                arith: self.arithmetic.name(),
                trials: self.trials,
                ..total.cell()
            }
        });
        Ok(cells.collect())
    }

    fn judge<R: Kind>(&self, engine: &mut dyn Engine, record: &Impaired, tallies: &mut [Tally]) {
        let n = self.n as f64;
        let truth = match self.truth {
            Truth::Mean => record.bins,
            Truth::Nominal => record.nominal_bins,
        };
        let snr = 10f64.powf(record.local_snr_db / 10.0);
        let bound = f64::from(bound_bins(R::IQ, self.n, snr as f32));
        let answers = engine.measure(&record.samples, &self.estimators, false);
        for (tally, answer) in tallies.iter_mut().zip(answers) {
            let error = match R::IQ {
                // Round the circle, the shorter way.
                true => (answer.bins - truth + n / 2.0).rem_euclid(n) - n / 2.0,
                false => answer.bins - truth,
            };
            tally.push(answer.verdict, error, answer.sigma_bins, bound);
        }
    }
}
