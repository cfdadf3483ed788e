//! The results of a method on many records of one impairment at one signal-to-noise ratio.

use super::LIE_SIGMAS;
use crate::sweep::OUTLIER_BINS;
use picket_dsp::tone::{Usable, Verdict};
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::ops::AddAssign;

/// Sums over records.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    verdicts: BTreeMap<&'static str, u64>,
    right: u64,
    flagged: u64,
    overconfident: u64,
    false_flag: u64,
    near: Sums,
    flagged_near: Sums,
    good: Sums,
}

/// Sums of squares: of errors, of errors over sigma, of bounds.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: u64,
    error2: f64,
    z2: f64,
    bound2: f64,
}

impl Sums {
    fn push(&mut self, error: f64, sigma: f64, bound: f64) {
        self.count += 1;
        self.error2 += error * error;
        self.z2 += (error / sigma).powi(2);
        self.bound2 += bound * bound;
    }

    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.error2 += other.error2;
        self.z2 += other.z2;
        self.bound2 += other.bound2;
    }

    fn mean(&self, sum: f64) -> Option<f64> {
        (self.count > 0).then(|| sum / self.count as f64).filter(|mean| mean.is_finite())
    }

    fn ratio(&self) -> Option<f64> {
        (self.count > 0 && self.bound2 > 0.0).then(|| (self.error2 / self.bound2).sqrt())
    }
}

impl AddAssign<&Tally> for Tally {
    fn add_assign(&mut self, other: &Self) {
        for (verdict, count) in &other.verdicts {
            *self.verdicts.entry(verdict).or_default() += count;
        }
        self.right += other.right;
        self.flagged += other.flagged;
        self.overconfident += other.overconfident;
        self.false_flag += other.false_flag;
        self.near.add(&other.near);
        self.flagged_near.add(&other.flagged_near);
        self.good.add(&other.good);
    }
}

impl Tally {
    pub(super) fn push(&mut self, verdict: Verdict, error: f64, sigma: f64, bound: f64) {
        let usable = verdict.usable() <= Usable::WithinSigma;
        *self.verdicts.entry(verdict.name()).or_default() += 1;
        let within = error.abs() <= LIE_SIGMAS * sigma;
        match (usable, within) {
            (true, true) => self.right += 1,
            (true, false) => self.overconfident += 1,
            (false, within) => {
                self.flagged += 1;
                self.false_flag += u64::from(within);
            }
        }
        if verdict == Verdict::Good {
            self.good.push(error, sigma, bound);
        }
        if error.abs() <= OUTLIER_BINS {
            self.near.push(error, sigma, bound);
            if !usable {
                self.flagged_near.push(error, sigma, bound);
            }
        }
    }

    /// The figures; what they are of stands empty.
    pub(super) fn cell(self) -> Cell {
        let all: u64 = self.verdicts.values().sum();
        let share = |count: u64| count as f64 / all.max(1) as f64;
        Cell {
            outliers: all - self.near.count,
            right: self.right,
            flagged: self.flagged,
            overconfident: self.overconfident,
            false_flag: self.false_flag,
            right_share: share(self.right),
            flagged_share: share(self.flagged),
            overconfident_share: share(self.overconfident),
            false_flag_share: share(self.false_flag),
            rmse_bins: self.near.mean(self.near.error2).map(f64::sqrt),
            bound_bins: self.near.mean(self.near.bound2).map(f64::sqrt),
            ratio: self.near.ratio(),
            flagged_ratio: self.flagged_near.ratio(),
            rms_z: self.near.mean(self.near.z2).map(f64::sqrt),
            z2_good: self.good.mean(self.good.z2),
            verdicts: self.verdicts,
            ..Cell::default()
        }
    }
}

/// The outcome of one method. The keys are those of the JSON lines.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Cell {
    /// The impairment; of a pair both, joined by a plus.
    pub impair: String,
    /// Its severities, each by its key with the unit.
    #[serde(flatten)]
    pub severities: Map<String, Value>,
    /// The severities as a user would type them.
    #[serde(skip)]
    pub severity: String,
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
    /// Records.
    pub trials: usize,
    /// Answers that say they may be used within sigma ([`Usable::WithinSigma`] or better) and are within 5 sigma.
    pub right: u64,
    /// Answers that say they may not.
    pub flagged: u64,
    /// Answers that say they may be used within sigma and are off by more than 5.
    pub overconfident: u64,
    /// Of those flagged: within 5 sigma.
    pub false_flag: u64,
    /// Share of all records.
    pub right_share: f64,
    /// Share of all records.
    pub flagged_share: f64,
    /// Share of all records.
    pub overconfident_share: f64,
    /// Share of all records.
    pub false_flag_share: f64,
    /// Records without an answer within 1.5 bins; the next five figures leave them out.
    pub outliers: u64,
    /// Root mean square of the error.
    pub rmse_bins: Option<f64>,
    /// The Cramer-Rao bound of a pure tone in white noise as dense as this noise is at the tone.
    pub bound_bins: Option<f64>,
    /// RMSE over that bound.
    pub ratio: Option<f64>,
    /// This ratio for the flagged answers: near 1 they were flagged without need.
    pub flagged_ratio: Option<f64>,
    /// Root mean square of error over sigma.
    pub rms_z: Option<f64>,
    /// Mean of the square of error over sigma of those called `good`, lies included.
    pub z2_good: Option<f64>,
    /// How often each verdict was given.
    pub verdicts: BTreeMap<&'static str, u64>,
}
