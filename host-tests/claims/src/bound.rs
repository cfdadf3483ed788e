//! The exact Cramer-Rao bounds of tones in white noise.

use picket_dsp::Record;
use std::f64::consts::{PI, TAU};

/// A line: its frequency in bins, its amplitude in codes, its phase at the first sample in radians.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Cycles in the record.
    pub bins: f64,
    /// Codes.
    pub amplitude: f64,
    /// Radians.
    pub phase: f64,
}

/// The bounds of the frequencies of real tones, bins: amplitudes, phases and DC unknown as well. Near 0 Hz and half of the rate they depend on
/// the phases.
pub fn real(n: usize, lines: &[Line], sigma: f64) -> Vec<f64> {
    // Parameters: every frequency, then every A cos, A sin, then DC.
    let count = 3 * lines.len() + 1;
    let mut g = vec![vec![0.0f64; count]; count];
    let mut row = vec![1.0; count];
    for i in 0..n {
        let t = TAU * i as f64 / n as f64;
        for (j, line) in lines.iter().enumerate() {
            let (sin, cos) = (t * line.bins).sin_cos();
            let (s, c) = line.phase.sin_cos();
            row[j] = -line.amplitude * t * (sin * c + cos * s);
            row[lines.len() + 2 * j] = cos;
            row[lines.len() + 2 * j + 1] = sin;
        }
        for (line, a) in g.iter_mut().zip(&row) {
            line.iter_mut().zip(&row).for_each(|(cell, b)| *cell += a * b);
        }
    }
    // The inverse by Gauss and Jordan, in place; the matrix is positive definite.
    for p in 0..count {
        let pivot = std::mem::replace(&mut g[p][p], 1.0);
        g[p].iter_mut().for_each(|x| *x /= pivot);
        let row = g[p].clone();
        for a in (0..count).filter(|&a| a != p) {
            let factor = std::mem::replace(&mut g[a][p], 0.0);
            g[a].iter_mut().zip(&row).for_each(|(cell, x)| *cell -= factor * x);
        }
    }
    (0..lines.len()).map(|j| sigma * g[j][j].sqrt()).collect()
}

/// The bound of the frequency of a tone alone, bins.
pub fn tone<R: Record>(n: usize, line: Line, sigma: f64) -> f64 {
    if R::IQ { iq(n, line.amplitude, sigma) } else { real(n, &[line], sigma).iter().sum() }
}

/// The bound of a complex tone's frequency, bins; `sigma` of each part.
pub fn iq(n: usize, amplitude: f64, sigma: f64) -> f64 {
    let n2 = (n * n) as f64;
    // Noise power 2 sigma^2 over both parts.
    (6.0 / (TAU * TAU) * n2 / (n as f64 * (n2 - 1.0)) * 2.0).sqrt() * sigma / amplitude
}

/// The bound of the phase at the middle, turns.
pub fn phase(n: usize, iq: bool, amplitude: f64, sigma: f64) -> f64 {
    let parts = if iq { 1.0 } else { 2.0 };
    (parts / n as f64).sqrt() * sigma / amplitude / TAU
}

/// The bound of a burst's frequency with its Gaussian envelope known, bins; `deviation` in samples.
pub fn burst(n: usize, iq: bool, amplitude: f64, deviation: f64, sigma: f64) -> f64 {
    // A real tone's phase is half as well known as that of an I/Q tone in the same noise of each part.
    let parts = if iq { 1.0 } else { 0.5 };
    let sum = parts * PI.sqrt() / 2.0 * deviation.powi(3);
    n as f64 * sigma / (TAU * amplitude * sum.sqrt())
}
