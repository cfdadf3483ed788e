//! The width of a tone itself: a laser's linewidth, and the bandwidth of speckle.
//!
//! Both bend the phase within a block, and one block cannot distinguish such a bend from another frequency. So the user states the width,
//! from a data sheet or a measurement, and sigma covers it.
//!
//! **Linewidth.** The phase of a laser of linewidth `w` (Lorentzian, full width at half maximum) walks: its variance grows by `2 pi w`
//! each second. Least squares takes the slope of the phase over a block of `T` seconds. The slope of a line fitted to a walk of
//! variance `D t` has the variance `6 D / (5 T)`, so that the frequency has
//!
//! ```text
//! v  =  6 / (5 2 pi) w / T                 in squared bins:  0.191 w T
//! ```
//!
//! and the errors of two blocks are independent.
//!
//! **Speckle.** The echo of a rough surface that moves across a beam has a random envelope: complex and Gaussian, with a Gaussian spectrum of
//! full width `b` at half of its height, which is `2.355` standard deviations. Its mean `a0` over a block and its slope `a1` within the block
//! are independent, and the frequency is off by `Im(a1 / a0) / 2 pi` cycles. With `B = b T / 2.355` bins, an envelope of mean power `P` and a
//! block's tone of power `A^2`,
//!
//! ```text
//! v  =  g P / (2 A^2)    in squared bins,        g = B^2 / (1 + pi^2 B^2 / 3)
//! ```
//!
//! where `g` is the ratio of both variances, within 7 % of the integrals of the autocorrelation `exp(-2 pi^2 (b t / 2.355)^2)` over the block.
//! So a block in a fade is off the most. One block does not know `P`: its `P / A^2` is one over an exponential number, and the error over
//! `sqrt(g / 2)` has Student's distribution with two degrees of freedom, which has no variance. A block's sigma is `sqrt(2 g)`: one block
//! of a hundred is then off by more than five sigma.
//!
//! A spot of diameter `d` (where the intensity is down by `exp(-2)`) on a surface of speed `u` has an envelope with the autocorrelation
//! `exp(-(2 u t / d)^2)`: `b = 4 sqrt(ln 2) / pi` times `u / d`, or `1.06 u / d`.

use core::f32::consts::{FRAC_1_PI, PI};

/// The standard deviation of a Gaussian over its full width at half maximum: `1 / sqrt(8 ln 2)`.
const DEVIATION: f32 = 0.424_660_9;

/// The tone's own width. The default is a tone without any width.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Carrier {
    /// The source's linewidth, Hz: Lorentzian, full width at half maximum. At most half the sample rate.
    pub linewidth_hz: f32,
    /// The bandwidth of the echo's envelope, Hz: full width at half maximum of a Gaussian spectrum; for speckle 1.06 times the surface's speed
    /// over the spot's diameter. At most half the sample rate.
    pub envelope_hz: f32,
}

/// The effect of a tone's own width on the frequency of one block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Width {
    /// The variance by the walk of the phase, squared bins.
    pub walk: f32,
    /// The number `g` of the envelope, squared bins.
    pub envelope: f32,
    /// The number of blocks whose errors are correlated: the sum of a block's correlations with all blocks, `1 / (2 sqrt(pi) B)`, at least
    /// 1.
    pub together: f32,
}

impl Carrier {
    /// The effect on blocks of `n` samples; `None` if a width is negative, NaN, or more than half the rate.
    pub fn width(&self, n: usize, rate_hz: f64) -> Option<Width> {
        let bins_per_hz = (n as f64 / rate_hz) as f32;
        let [walk, envelope] = [self.linewidth_hz, self.envelope_hz].map(|hz| hz * bins_per_hz);
        // Half the rate is half as many bins as there are samples.
        let right = |bins: f32| bins >= 0.0 && bins <= 0.5 * n as f32;
        if !(right(walk) && right(envelope)) {
            return None;
        }
        let deviation = DEVIATION * envelope;
        let square = deviation * deviation;
        Some(Width {
            walk: 0.6 * FRAC_1_PI * walk,
            envelope: square / (1.0 + PI * PI / 3.0 * square),
            // The sum over k of exp(-4 pi^2 B^2 k^2), by Poisson's formula.
            together: (HALF_ROOT / deviation).max(1.0),
        })
    }
}

/// `1 / (2 sqrt(pi))`.
const HALF_ROOT: f32 = 0.282_094_8;

impl Width {
    /// No width: all zeros.
    pub const NONE: Self = Self { walk: 0.0, envelope: 0.0, together: 0.0 };

    /// The variance of a single block, squared bins.
    pub const fn of_block(&self) -> f32 {
        self.walk + 2.0 * self.envelope
    }

    /// The variance that the envelope adds to a block of the mean power in a filter that forgets a share `gain` with each block, squared
    /// bins. It includes the correlation between blocks: the filter alone averages `(2 - gain) / gain` blocks; within a fifth the shorter
    /// of the two memories counts, by their inverses.
    pub const fn followed(&self, gain: f32) -> f32 {
        // One over zero is infinite where there is no envelope.
        let blocks = 1.0 / (gain / (2.0 - gain) + 1.0 / self.together);
        0.5 * self.envelope * blocks.max(1.0)
    }

    /// The variance of a sum of `blocks` blocks by their powers, which weighs each block with its own power, squared bins. In a sum that is
    /// longer than the correlation, `c` blocks, the blocks at the ends have less of it: `c - c^2 / (pi M)`.
    pub const fn of_sum(&self, blocks: u32) -> f32 {
        let (all, some) = (blocks as f32, self.together);
        let together = if some < all { some - some * some * FRAC_1_PI / all } else { all };
        (self.walk + 0.5 * self.envelope * together.max(1.0)) / all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The variance of the slope of a least-squares line through a walk, and the variance of the envelope's slope over the variance of its
    /// mean, by sums over their correlations.
    #[test]
    fn variances_are_those_of_the_slopes() {
        const M: usize = 200;
        let place = |i: usize| (i as f64 + 0.5) / M as f64 - 0.5;
        let mean = |of: &dyn Fn(f64, f64) -> f64| {
            let pairs = (0..M).flat_map(|i| (0..M).map(move |j| (place(i), place(j))));
            pairs.map(|(a, b)| of(a, b)).sum::<f64>() / (M * M) as f64
        };
        // A walk of variance 2 pi w t; 12 mean(u phase) is the slope.
        let walk = mean(&|a, b| 144.0 * a * b * (a.min(b) + 0.5)) / core::f64::consts::TAU;
        let of = |linewidth_hz, envelope_hz| {
            Carrier { linewidth_hz, envelope_hz }.width(1000, 1000.0).unwrap()
        };
        assert!((f64::from(of(1.0, 0.0).walk) / walk - 1.0).abs() < 1e-3, "{walk}");
        for bins in [0.02f32, 0.2, 0.7, 2.0, 7.0] {
            let turn = core::f64::consts::TAU * f64::from(DEVIATION * bins);
            let correlation =
                |a: f64, b: f64| libm::exp(-0.5 * (turn * (a - b)) * (turn * (a - b)));
            let slope = mean(&|a, b| 144.0 * a * b * correlation(a, b));
            let exact = slope / mean(&correlation) / core::f64::consts::TAU.powi(2);
            let found = f64::from(of(0.0, bins).envelope);
            assert!((found / exact - 1.0).abs() < 0.075, "{bins}: {found}, {exact}");
        }
    }

    /// The memories against sums over pairs of blocks.
    #[test]
    fn blocks_hang_together() {
        for bins in [0.01f32, 0.07, 0.24, 0.7] {
            let carrier = Carrier { linewidth_hz: 0.0, envelope_hz: bins };
            let width = carrier.width(1000, 1000.0).unwrap();
            let turn = core::f32::consts::TAU * DEVIATION * bins;
            let correlation = |k: i32| libm::expf(-(turn * k as f32) * (turn * k as f32));
            for gain in [0.13f32, 0.27, 0.54] {
                let pair = |k| 2.0 * (1.0 - gain).powi(k) * correlation(k);
                let exact = 1.0 + (1..200).map(pair).sum::<f32>();
                let found = width.followed(gain) / (0.5 * width.envelope);
                assert!((found / exact - 1.0).abs() < 0.2, "{bins} {gain}: {found}, {exact}");
            }
            for blocks in [4u32, 16, 100, 1000] {
                let pair = |k| 2.0 * (1.0 - k as f32 / blocks as f32) * correlation(k);
                let exact = 1.0 + (1..blocks as i32).map(pair).sum::<f32>();
                let found = width.of_sum(blocks) * blocks as f32 / (0.5 * width.envelope);
                assert!(
                    found / exact > 0.9 && found / exact < 1.6,
                    "{bins} {blocks}: {found}, {exact}"
                );
            }
        }
        assert_eq!(Width::NONE.followed(0.3), 0.0);
    }

    #[test]
    fn a_width_is_within_the_spectrum() {
        for wrong in [-1.0, 501.0, f32::NAN, f32::INFINITY] {
            let (line, envelope) = (
                Carrier { linewidth_hz: wrong, ..Carrier::default() },
                Carrier { envelope_hz: wrong, ..Carrier::default() },
            );
            assert_eq!([line, envelope].map(|c| c.width(64, 1e3)), [None; 2], "{wrong}");
        }
        let none = Carrier::default().width(64, 1e3).unwrap();
        assert_eq!((none.of_block(), none.of_sum(100)), (0.0, 0.0));
    }
}
