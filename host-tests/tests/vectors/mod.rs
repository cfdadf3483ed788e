//! The reference's golden records: integer codes and what every estimator makes of them in float64.
#![allow(dead_code)]

use num_complex::Complex;
use picket_dsp::acquire::sample::Record;
use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Deserialize)]
pub struct Golden {
    pub cases: Vec<Case>,
    pub solver: Vec<Beats>,
    pub m_opt: Vec<Lag>,
}

/// A record: `re`, and `im` of kind "c", are codes.
#[derive(Deserialize)]
pub struct Case {
    pub id: String,
    /// "r" or "c".
    pub kind: String,
    #[serde(rename = "N")]
    pub n: usize,
    pub amp: f64,
    /// None without noise.
    pub snr_db: Option<f64>,
    pub f_true: f64,
    pub phase: f64,
    /// The peak bin.
    pub km: i32,
    pub re: Vec<i16>,
    pub im: Option<Vec<i16>>,
    pub snr13_db: Option<f64>,
    /// Answers in bins by the reference's names.
    pub expect_bins: BTreeMap<String, Option<f64>>,
}

/// A target and its beats.
#[derive(Deserialize)]
#[allow(non_snake_case)]
pub struct Beats {
    pub L_m: f64,
    pub V_mps: f64,
    pub f1_hz: f64,
    pub f2_hz: f64,
    pub f3_hz: f64,
}

/// A lag of Yang et al. 2011, eq 9.
#[derive(Deserialize)]
pub struct Lag {
    pub snr: f64,
    #[serde(rename = "N")]
    pub n: usize,
    pub m: usize,
}

/// The reference's records, targets and lags.
pub fn golden() -> Golden {
    serde_json::from_str(include_str!("../../data/golden.json")).unwrap()
}

impl Case {
    pub fn iq(&self) -> bool {
        self.kind == "c"
    }

    /// The parts of sample `n`.
    pub fn parts(&self, n: usize) -> [i16; 2] {
        [self.re[n], self.im.as_ref().map_or(0, |im| im[n])]
    }

    /// The samples as numbers.
    pub fn values(&self) -> Vec<Complex<f64>> {
        let value = |n| {
            let [re, im] = self.parts(n).map(f64::from);
            Complex::new(re, im)
        };
        (0..self.n).map(value).collect()
    }

    /// The samples as a record of kind `R`.
    pub fn samples<R: Record, const N: usize>(&self) -> [R::Sample; N] {
        std::array::from_fn(|n| R::from_parts(self.parts(n)))
    }
}
