//! How often noise alone does what a signal would do. All detections and all tests of a residual ask here.
//!
//! - [`ratio`]: two mean squares, of a residual and of the noise around it.
//! - [`over_mean`]: the largest of many powers over a mean of others.
//! - [`ln_of_sum`]: the line of most evidence in a sum of spectra.
//! - [`ln_of_map`]: the target of most evidence in a map of ranges and velocities.
//!
//! The last two search all places, not only bins. In noise the evidence is a smooth field over the places, and the variance of its slope
//! follows from that of the time within a record or a frame, a twelfth of its square. The field exceeds a level as often as it crosses it.

use crate::math::scalar::{Scalar as _, larger};
use core::f32::consts::FRAC_PI_3;

/// The ratio of two mean squares, with these degrees of freedom, that noise exceeds as often as a normal number exceeds `deviations`. The
/// ratio follows Fisher's distribution, whose cube root is nearly normal (Wilson and Hilferty 1931). The degrees of freedom of a noise that
/// is known exactly are infinite.
#[inline(never)]
pub(crate) fn ratio(deviations: f32, free: f32, noise: f32) -> f32 {
    let (a, b) = (2.0 / (9.0 * free), 2.0 / (9.0 * noise));
    let (mean, other, square) = (1.0 - a, 1.0 - b, deviations * deviations);
    let below = other * other - square * b;
    let inside = a * other * other + b * mean * mean - a * b * square;
    let root = (mean * other + deviations * larger(inside, 0.0).root()) / below;
    if below > 0.0 { root * root * root } else { f32::INFINITY }
}

/// The ratio to the mean of `others` powers of noise that a power of noise exceeds with the probability `exp(-log)`: powers of bins are
/// exponential, so it is `m (exp(L / m) - 1)` for a mean of m (Finn and Johnson 1968). A noise estimate of F degrees of freedom counts as
/// F/2 powers.
#[inline(always)]
pub(crate) fn over_mean(log: f32, others: f32) -> f32 {
    others * exp_m1(log / others)
}

/// `exp(x) - 1` for x >= 0: by the series up to 1/8, by squaring above.
fn exp_m1(x: f32) -> f32 {
    let (mut small, mut squarings) = (x.min(100.0), 0);
    while small > 0.125 {
        small *= 0.5;
        squarings += 1;
    }
    let series = 1.0 + small * (0.25 + small * (1.0 / 20.0));
    let mut y = small * (1.0 + small * (0.5 + small * (1.0 / 6.0) * series));
    for _ in 0..squarings {
        y *= y + 2.0;
    }
    y
}

/// The natural logarithm of the probability that a sum of `blocks` spectra of noise reaches this evidence somewhere in `width` bins; 0 where
/// that is not improbable. The noise estimate has `dof` degrees of freedom.
///
/// The power of the line that fits best at a frequency is, in noise of power P, a sum of M exponential numbers of mean P. Over all
/// frequencies the power over P is a chi-squared process, and its crossings of a level x are as frequent as Rice's formula says
/// (Lindgren 2012, *Stationary Stochastic Processes*, chapter 8): for each bin
///
/// ```text
/// sqrt(pi / 3) x^(M - 1/2) exp(-x) / (M - 1)!
/// ```
///
/// P scatters as a mean of `a` exponential numbers does, half of its degrees of freedom; averaged over it, `x^(M - 1/2) exp(-x)` becomes
/// `x^(M - 1/2) a^a gamma(a + M - 1/2) / (gamma(a) (a + x)^(a + M - 1/2))`.
pub(crate) fn ln_of_sum(evidence: f32, blocks: u32, width: u32, dof: f32) -> f32 {
    let (m, x) = (f64::from(blocks), f64::from(evidence));
    if x <= m {
        return 0.0;
    }
    let a = 0.5 * f64::from(dof);
    let ln = 0.5 * libm::log(core::f64::consts::FRAC_PI_3)
        + libm::log(f64::from(width.max(1)))
        + (m - 0.5) * libm::log(x)
        - libm::lgamma(m)
        + a * libm::log(a)
        - libm::lgamma(a)
        + libm::lgamma(a + m - 0.5)
        - (a + m - 0.5) * libm::log(a + x);
    ln.min(0.0) as f32
}

/// The natural logarithm of the probability that noise exceeds this power, in units of the noise, somewhere among these cells of a map.
///
/// The power of the target that fits best at a place is exponential in noise. Over all places it exceeds a level x as often as the mean
/// Euler characteristic of the places above x says (Adler and Taylor 2007, *Random Fields and Geometry*, chapter 15): for each cell
///
/// ```text
/// (pi / 3) (x - 1/2) exp(-x)
/// ```
///
/// The map is a cylinder, closed over the rows, so its two ends add `sqrt(pi x / 3) exp(-x)` for each row. The noise is a mean of `F`
/// cells, half of its degrees of freedom, over which `exp(-x)` becomes `(1 + x / F)^-F`.
#[inline(never)] // once in an image
pub(crate) fn ln_of_map(power: f32, cells: f32, rows: f32, dof: f32) -> f32 {
    if power <= 1.0 {
        return 0.0;
    }
    let noise_cells = 0.5 * dof;
    let held = power / (1.0 + power / noise_cells);
    let places = cells * FRAC_PI_3 * (held - 0.5).max(0.5) + rows * libm::sqrtf(FRAC_PI_3 * held);
    (libm::logf(places) - noise_cells * libm::log1pf(power / noise_cells)).min(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of Fisher's distribution.
    #[test]
    fn quantiles_of_fishers() {
        for (deviations, free, noise, exact) in [
            (5.026, 5.0, 52.0, 11.145),
            (5.026, 7.0, 52.0, 9.168),
            (5.026, 15.0, 52.0, 6.329),
            (5.026, 63.0, 52.0, 4.138),
            (5.026, 15.0, 30.0, 8.924),
            (3.291, 31.0, 52.0, 2.803),
            (1.534, 5.0, 52.0, 2.260),
        ] {
            let limit = ratio(deviations, free, noise);
            assert!((0.98 * exact..1.06 * exact).contains(&limit), "{free} {noise}: {limit}");
        }
    }

    /// Against the integral of Fisher's distribution, at one in a hundred.
    #[test]
    fn a_ratio_is_exceeded_as_often_as_is_said() {
        for (free, noise) in [(2.0f64, 50.0f64), (5.0, 12.0), (16.0, 16.0), (31.0, 50.0)] {
            let x = f64::from(super::ratio(2.326_348, free as f32, noise as f32));
            let (a, b) = (0.5 * noise, 0.5 * free);
            let log = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b);
            // The regularized beta function up to this number.
            let end = noise / (noise + free * x);
            let steps = 10_000;
            let sum: f64 = (0..steps)
                .map(|step| end * (f64::from(step) + 0.5) / f64::from(steps))
                .map(|t| libm::exp(log + (a - 1.0) * libm::log(t) + (b - 1.0) * libm::log(1.0 - t)))
                .sum();
            let share = sum * end / f64::from(steps) / 0.01;
            // The cube root of the ratio is only nearly normal.
            assert!((0.975..1.005).contains(&share), "{free} {noise}: {share}");
        }
    }

    #[test]
    fn exponentials() {
        for x in [0.0, 1e-4, 0.02, 0.124, 0.126, 0.5, 1.0, 3.0, 20.0, 80.0] {
            let ratio = super::exp_m1(x) / libm::expm1f(x);
            assert!(x == 0.0 || (ratio - 1.0).abs() < 2e-5, "{x}: {ratio}");
        }
        assert_eq!(super::exp_m1(f32::INFINITY), f32::INFINITY);
    }

    #[test]
    fn a_target_far_above_the_noise_is_no_chance() {
        let chance = |power| ln_of_map(power, 8192.0, 64.0, 480.0);
        assert_eq!(chance(0.5), 0.0);
        // One in a million frames of 8192 cells.
        assert!((chance(26.6 + 26.6 * 26.6 / 480.0) + 13.8).abs() < 0.6, "{}", chance(28.0));
        assert!(chance(100.0) < -60.0 && chance(1e6) < -1000.0);
    }
}
