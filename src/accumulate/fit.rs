//! A line fitted to the sums of products of bins.

use super::detection::Peak;
use super::sums::{LAGS, Sums};
use crate::math::scalar::Scalar as _;
use crate::math::series::sinc;
use crate::tone::fit::descent::Descent;
use crate::tone::fit::normal::Products;

/// Bins on each side of the line.
const SIDE: i32 = 4;
const BINS: usize = 2 * SIDE as usize + 1;
/// The most steps of the fit; it ends when a step is small compared with sigma.
const STEPS: u32 = 8;
/// The mean square of the residuals over its expectation in noise, above which the line is not one steady line. A steady line exceeds it in
/// fewer than one of a hundred sums (host-tests, `accumulate`).
const WIDE: f32 = 3.0;

/// The result of the fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    /// The offset from the place's bin, bins.
    pub offset: f32,
    /// The variance of the offset, squared bins.
    pub variance: f32,
    /// The line's mean power over the noise of one bin.
    pub power: f32,
    /// Whether the bins hold more than one line as narrow as the record allows.
    pub wide: bool,
}

/// `D(u) = sin(pi u) / (n sin(pi u / n))` for |u| below 6: the value of a line in a bin u bins off.
fn kernel(u: f32, n: usize) -> f32 {
    if u.abs() < 1e-3 {
        return 1.0;
    }
    let x = u * core::f32::consts::PI;
    let narrow = x / n.max(1) as f32;
    f32::unit(0.5 * u).im / (x * sinc(narrow * narrow))
}

/// The divisor of a sum of the products of bins k and `k + lag` that moves the origin of time to the record's middle, where the sign of a
/// line's products is the kernel's.
///
/// The turn of bins by `exp(j pi k (N - 1) / N)` multiplies a product by `(-1)^lag exp(-j pi lag / N)`. The real part of a line's product
/// is too small by the cosine of this angle.
fn turn(lag: usize, n: usize) -> f32 {
    let cosine = f32::unit(0.5 * lag as f32 / n.max(1) as f32).re;
    if lag & 1 == 0 { cosine } else { -cosine }
}

/// The entries of a symmetric matrix within [`LAGS`] of its diagonal.
pub(super) type Entries = [[f32; LAGS + 1]; BINS];

/// The sum over the matrix of products of entries.
fn inner(a: &Entries, b: &Entries) -> f32 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        let products = a.iter().zip(b).map(|(a, b)| a * b);
        for (lag, product) in products.enumerate() {
            sum += if lag == 0 { product } else { 2.0 * product };
        }
    }
    sum
}

/// Entries made of the indices of their row and their lag.
fn entries(mut of: impl FnMut(usize, usize) -> f32) -> Entries {
    let mut made = Entries::default();
    for (row, lags) in made.iter_mut().enumerate() {
        for (lag, entry) in lags.iter_mut().enumerate() {
            if row + lag < BINS {
                *entry = of(row, lag);
            }
        }
    }
    made
}

/// The entries around a place in units of the noise of one bin and block, less that noise.
pub(super) fn data(sums: &Sums, place: &Peak) -> Entries {
    let (n, blocks) = (sums.layout.n, sums.scale.blocks.max(1) as f32);
    let unit = blocks / place.noise;
    let turns: [f32; LAGS + 1] = core::array::from_fn(|lag| turn(lag, n));
    entries(|row, lag| {
        let sum = sums.product(place.bin - SIDE + row as i32, lag) as f32;
        let entry = unit * (sum / turns.get(lag).copied().unwrap_or(1.0));
        if lag == 0 { entry - blocks } else { entry }
    })
}

/// The values of a line `at` bins beyond the middle of the entries, in each bin.
fn shape(at: f32, n: usize) -> [f32; BINS] {
    core::array::from_fn(|i| kernel(at + (SIDE - i as i32) as f32, n))
}

/// The number of blocks plus the power of the best line at an offset from a place, in units whose variance in noise is one for each block,
/// like the power of a bin.
pub(super) fn evidence(data: &Entries, blocks: u32, n: usize, offset: f32) -> f32 {
    let g = shape(offset, n);
    let at = |i: usize| g.get(i).copied().unwrap_or(0.0);
    let line = entries(|i, lag| at(i) * at(i + lag));
    let power = inner(data, &line) / libm::sqrtf(inner(&line, &line));
    power + blocks as f32
}

/// Fits `C = S g g' + 1` by least squares, S and the frequency unknown, all in units of the noise.
///
/// `g g'` is the one column of the normal equations. H is its change with the frequency less its part along `g g'`. With M blocks
/// of noise of power 1
///
/// ```text
/// var f = (M tr(H^2) + 2 M S |H g|^2) / (M S tr(H dG/df))^2
/// ```
///
/// which is 1.00 to 1.10 times the bound for lines of random phases. The mean of the residuals' squares over their expectation widens the
/// variance where it exceeds 1: for a line that is broad, or moves, or has a neighbour.
pub(super) fn fit(sums: &Sums, place: &Peak) -> Option<Fit> {
    let (n, blocks) = (sums.layout.n, sums.scale.blocks.max(1) as f32);
    let data = data(sums, place);
    let descent = Descent {
        start: place.offset,
        steps: STEPS,
        longest: 0.25,
        limits: [-1.0, 1.0],
        further: false,
    };
    let mut fitted: Option<Fit> = None;
    let end = descent.to_the_end(|offset| {
        let g = shape(offset, n);
        /// Half the step of the derivative. The zero of the projection does not depend on it.
        const STEP: f32 = 1.0 / 64.0;
        let (above, below) = (shape(offset + STEP, n), shape(offset - STEP, n));
        let at = |g: &[f32; BINS], i: usize| g.get(i).copied().unwrap_or(0.0);
        let slope = |i: usize| (at(&above, i) - at(&below, i)) / (2.0 * STEP);
        let line = entries(|i, lag| at(&g, i) * at(&g, i + lag));
        let change = entries(|i, lag| slope(i) * at(&g, i + lag) + at(&g, i) * slope(i + lag));
        let (own, lean) = (inner(&line, &line), inner(&line, &change));
        let [r, q] = [&line, &change].map(|column| inner(&data, column));
        let step = Products::real(own, lean, inner(&change, &change), r, q).step();
        let total = step.line.re;
        let gain = step.information / total;
        // A line of no power has no frequency.
        if gain.is_nan() || gain <= 0.0 {
            return (0.0, f32::INFINITY, ());
        }
        let (power, along) = (total / blocks, lean / own);
        let mut applied = [0.0f32; BINS];
        for (row, (line, change)) in line.iter().zip(&change).enumerate() {
            for (lag, (&line, &change)) in line.iter().zip(change).enumerate() {
                let value = change - along * line;
                let mut give = |to: usize, from: usize| {
                    if let Some(sum) = applied.get_mut(to) {
                        *sum += value * at(&g, from);
                    }
                };
                give(row, row + lag);
                if lag > 0 {
                    give(row + lag, row);
                }
            }
        }
        let moved = applied.iter().map(|x| x * x).sum::<f32>();
        let scatter = blocks * (gain / total) + 2.0 * blocks * power * moved;
        let misfit = misfit(&data, &g, total, blocks);
        let variance = scatter / (gain * gain);
        fitted =
            Some(Fit { offset, variance: variance * misfit.max(1.0), power, wide: misfit > WIDE });
        (step.forward(1.0), 1e-2 * variance.root(), ())
    });
    let fitted = fitted.map(|fit| Fit { offset: end.at, ..fit });
    fitted.filter(|fit| fit.offset.is_finite() && fit.variance.is_finite())
}

/// The mean over all entries of the squared residual divided by its variance.
fn misfit(data: &Entries, g: &[f32; BINS], total: f32, blocks: f32) -> f32 {
    let power = total / blocks;
    let (mut sum, mut count) = (0.0, 0.0);
    for (i, row) in data.iter().enumerate() {
        for (lag, &value) in row.iter().enumerate() {
            let (Some(a), Some(b)) = (g.get(i), g.get(i + lag)) else {
                continue;
            };
            let left = value - total * a * b;
            let noise = 1.0 + power * (a * a + b * b);
            let variance = if lag == 0 { blocks * noise } else { 0.5 * blocks * noise };
            sum += left * left / variance;
            count += 1.0;
        }
    }
    // The line's power and its frequency were fitted.
    sum / (count - 2.0)
}
