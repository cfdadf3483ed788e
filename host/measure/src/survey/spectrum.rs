//! The power over the bins, and the floor below the lines.

use picket_transform::Transform;
use picket_transform::num_complex::Complex;
use std::f64::consts::TAU;

/// Records that it is the mean of, or so.
const RECORDS: usize = 32;

/// The mean power of each bin through Hann's window, in dB of a sine from -32768 to 32767.
/// Records begin at multiples of `row`.
pub(super) fn powers(samples: &[Complex<f64>], n: usize, row: usize) -> Vec<f64> {
    let window = |k: usize| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / n as f64).cos();
    let transform = f64::forward(n);
    let mut sum = vec![0.0; n];
    let hop = ((samples.len() - n) / RECORDS).max(n / 2).div_ceil(row) * row;
    for record in samples.windows(n).step_by(hop) {
        let mean = record.iter().sum::<Complex<f64>>() / n as f64;
        let mut spectrum: Vec<Complex<f64>> =
            record.iter().enumerate().map(|(k, x)| (x - mean) * window(k)).collect();
        transform.process(&mut spectrum);
        sum.iter_mut().zip(&spectrum).for_each(|(sum, x)| *sum += x.norm_sqr());
    }
    let records = samples.windows(n).step_by(hop).count() as f64;
    let full = (n as f64 / 4.0 * 32768.0).powi(2);
    sum.iter().map(|power| 10.0 * (power / records / full + 1e-30).log10()).collect()
}

/// Frequency, power and floor of each bin, in the order of the frequencies. The floor is the median of some bins around.
pub(super) fn floored(powers: &[f64], rate_hz: f64, iq: bool) -> Vec<(f64, f64, f64)> {
    let n = powers.len();
    let order: Vec<i64> = match iq {
        true => (-(n as i64) / 2..n as i64 / 2).collect(),
        false => (0..=n as i64 / 2).collect(),
    };
    let at = |k: i64| powers[k.rem_euclid(n as i64) as usize];
    let around = (order.len() / 64).clamp(8, 100);
    // A floor for a few bins together: a median of each would be the same.
    let block = around / 4;
    let floor = |index: usize| {
        let middle = index / block * block;
        let from = middle.saturating_sub(around);
        let to = (middle + around).min(order.len());
        let mut near: Vec<f64> = order[from..to].iter().map(|&k| at(k)).collect();
        near.sort_by(f64::total_cmp);
        near[near.len() / 2]
    };
    let floors: Vec<f64> = (0..order.len()).step_by(block).map(floor).collect();
    let point =
        |(index, &k): (usize, &i64)| (k as f64 * rate_hz / n as f64, at(k), floors[index / block]);
    order.iter().enumerate().map(point).collect()
}
