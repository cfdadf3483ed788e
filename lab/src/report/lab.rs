//! What every part of the report works with, and what it hands in.

use super::outcomes::Outcomes;
use crate::estimator::parse;
use crate::exact::Numbers;
use crate::plot::chart::Chart;
use crate::simulate::{Kind, Width};
use crate::sweep::{Offsets, Row, Sweep};
use indicatif::ProgressBar;
use picket_dsp::tone::fit::Reach;
use serde::Serialize;

/// How much is simulated, from which seed, and which bar shows the progress.
#[derive(Debug)]
pub struct Lab {
    /// Few trials: figures are rougher, and their bars wider.
    pub quick: bool,
    /// The seed of everything.
    pub seed: u64,
    /// Advances by one for each sweep.
    pub bar: ProgressBar,
}

impl Lab {
    /// The number of trials.
    pub const fn trials(&self, full: usize, quick: usize) -> usize {
        if self.quick { quick } else { full }
    }

    /// A sweep of methods in 64-bit floats: N = 1024, about bin 64, offset uniform, samples not rounded.
    pub fn sweep(&self, methods: &str, trials: usize) -> Result<Sweep, String> {
        Ok(Sweep {
            estimators: parse(methods, Reach::Sixteen)?,
            numbers: Numbers::F64,
            n: 1024,
            bin: 64.0,
            offsets: Offsets::Uniform,
            trials,
            width: Width::Float,
            amplitude: None,
            dc: 0.0,
            seed: self.seed,
        })
    }

    /// Runs a sweep at one signal-to-noise ratio.
    pub fn run<R: Kind>(&self, sweep: &Sweep, snr_db: f64) -> Result<Vec<Row>, String> {
        let rows = sweep.run::<R>(snr_db, &ProgressBar::hidden())?;
        self.bar.inc(1);
        Ok(rows)
    }
}

/// A part of the report.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// Its heading.
    pub title: &'static str,
    /// What is seen, and where the paper errs: paragraphs.
    pub text: Vec<String>,
    /// Pictures.
    pub charts: Vec<Chart>,
    /// A picture of outcomes.
    pub outcomes: Option<Outcomes>,
    /// Tables.
    pub tables: Vec<Table>,
    /// What must hold.
    pub checks: Vec<Check>,
}

/// A table, its first column of words, the others of numbers.
#[derive(Clone, Debug)]
pub struct Table {
    /// The heads of the columns.
    pub head: Vec<String>,
    /// The rows.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    pub fn new<S: Into<String>>(head: impl IntoIterator<Item = S>) -> Self {
        Table { head: head.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }
}

/// A figure and the bar it must keep to.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    /// What it is, with its unit.
    pub figure: String,
    /// What the run found.
    pub measured: f64,
    /// Its standard error; 0 where nothing is random.
    pub error: f64,
    /// The least it may be, four standard errors aside.
    pub low: f64,
    /// The most.
    pub high: f64,
    /// Whether it is so.
    pub holds: bool,
}

impl Check {
    /// Between two limits, except for four standard errors.
    pub fn between(
        figure: impl Into<String>,
        measured: f64,
        error: f64,
        low: f64,
        high: f64,
    ) -> Self {
        let error = if error.is_finite() { error } else { 0.0 };
        let holds = measured >= low - 4.0 * error && measured <= high + 4.0 * error;
        Check { figure: figure.into(), measured, error, low, high, holds }
    }

    /// A stated figure, good to a relative `tolerance`.
    pub fn near(
        figure: impl Into<String>,
        measured: f64,
        error: f64,
        stated: f64,
        tolerance: f64,
    ) -> Self {
        let margin = stated.abs() * tolerance;
        Self::between(figure, measured, error, stated - margin, stated + margin)
    }
}

/// A number with three digits that count.
pub fn digits(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        "-".into()
    } else if size == 0.0 {
        "0".into()
    } else if (1e-3..1e6).contains(&size) {
        let digits = (2 - size.log10().floor() as i32).max(0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.1e}")
    }
}

/// A share in per cent with its standard error, which all or none of a few have as well: by one more of each kind.
pub fn share(count: usize, of: usize) -> String {
    let near = (count + 1) as f64 / (of + 2) as f64;
    let error = (near * (1.0 - near) / of as f64).sqrt();
    plus_minus(100.0 * count as f64 / of as f64, 100.0 * error)
}

/// A number and its standard error.
pub fn plus_minus(value: f64, error: f64) -> String {
    if !(error > 0.0 && error.is_finite()) {
        return digits(value);
    }
    let places = (1 - error.log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.places$} ± {error:.places$}")
}
