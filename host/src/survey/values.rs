//! What the samples of a recording are.

use picket_transform::num_complex::Complex;

/// The samples' values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Values {
    pub low: f64,
    pub high: f64,
    pub mean: f64,
    pub rms: f64,
    /// The step between codes, where all are whole numbers.
    pub step: Option<f64>,
    /// The share that lies at either end.
    pub clipped: f64,
}

pub(super) fn values(samples: &[Complex<f64>]) -> Values {
    let parts = || samples.iter().flat_map(|sample| [sample.re, sample.im]);
    let iq = samples.iter().any(|sample| sample.im != 0.0);
    let used = || parts().step_by(if iq { 1 } else { 2 });
    let count = used().count() as f64;
    let low = used().fold(f64::INFINITY, f64::min);
    let high = used().fold(f64::NEG_INFINITY, f64::max);
    let mean = used().sum::<f64>() / count;
    let rms = (used().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count).sqrt();
    let whole = used().all(|x| x.fract() == 0.0 && x.abs() < 1e9);
    let divisor = |a: u64, b: u64| {
        let (mut a, mut b) = (a, b);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let step =
        whole.then(|| used().fold(0, |step, x| divisor(step, (x - low) as u64)).max(1) as f64);
    // A sine is at its ends for a while: what clips stays there for two samples and more.
    let mut last = f64::NAN;
    let held = used().filter(|&x| (x == low || x == high) && std::mem::replace(&mut last, x) == x);
    let clipped = if high > low { held.count() as f64 / count } else { 0.0 };
    Values { low, high, mean, rms, step, clipped }
}
