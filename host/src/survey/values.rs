//! What the samples of a recording are.

use picket_transform::num_complex::Complex;
use std::collections::HashMap;
use std::f64::consts::FRAC_2_PI;

/// What clips spends this share of the samples at either end, and twice what a sine does that does not.
const CLIPPED: f64 = 0.002;

/// The samples' values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Values {
    pub low: f64,
    pub high: f64,
    pub mean: f64,
    pub rms: f64,
    /// The step between codes, where all are whole numbers.
    pub step: Option<f64>,
    /// The share that lies at either end, where that is more than a sine spends there.
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
    let mut times = HashMap::<u64, u32>::new();
    used().for_each(|x| *times.entry(x.to_bits()).or_default() += 1);
    let at = |x: f64| f64::from(times.get(&x.to_bits()).copied().unwrap_or(0));
    let ends = [low, high].map(f64::to_bits);
    let between = times.iter().filter(|(value, _)| !ends.contains(value)).map(|(_, &times)| times);
    // A whole sine of so many steps spends this share of its time in the outermost two. In step with the clock it comes there
    // more often, but then to other values as well.
    let amplitude = (high - low) / 2.0;
    let sine = (1.0 - step.unwrap_or(0.0) / amplitude).max(-1.0).acos() * FRAC_2_PI;
    let share = (at(low) + at(high)) / count;
    let often = at(low).max(at(high)) > 4.0 * f64::from(between.max().unwrap_or(0));
    let clipped = if high > low && often && share > CLIPPED + 2.0 * sine { share } else { 0.0 };
    Values { low, high, mean, rms, step, clipped }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn sine(cycles: f64, amplitude: f64, rail: f64) -> Vec<Complex<f64>> {
        let part = |n: u32| amplitude * (TAU * cycles * f64::from(n)).sin();
        let code = |n: u32| part(n).round().clamp(-rail, rail);
        (0..20_000).map(|n| Complex::new(code(n), 0.0)).collect()
    }

    /// Slow and fast, of few codes and of many.
    #[test]
    fn what_clips_is_told_from_what_is_whole() {
        for cycles in [0.0005, 0.01, 0.025_720_2, 0.1, 0.234_567, 0.412_345] {
            for amplitude in [5.0, 100.0, 9000.0, 30_000.0] {
                let whole = values(&sine(cycles, amplitude, 32_767.0)).clipped;
                assert_eq!(whole, 0.0, "{cycles} cycles a sample, {amplitude} codes");
            }
        }
        // What is in step with the clock has few values, clipped or whole.
        for cycles in [0.000_513, 0.010_037, 0.025_720_2, 0.100_073, 0.234_567, 0.412_345] {
            for amplitude in [110.0, 9000.0] {
                let clipped = values(&sine(cycles, amplitude, 0.8 * amplitude)).clipped;
                assert!(clipped > 0.2, "{cycles} cycles a sample, {amplitude} codes: {clipped}");
            }
        }
    }
}
