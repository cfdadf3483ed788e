//! The probability that noise alone makes a line, where the noise may have any smooth spectrum.
//!
//! Bins near a line are as loud as the noise under the line; bins farther away are more, and so tell a noise power more exactly, if they are
//! as loud. So the bins form [`Shell`]s around the line: 3 to 16 bins off, the ring, the band. The noise is alike up to one of the shells,
//! and each further shell has a power of its own. Mean powers of `a` and `b` bins of the same noise have a ratio whose logarithm q has the
//! density
//!
//! ```text
//! gamma(a + b) / (gamma(a) gamma(b)) u^a (1 - u)^b        u = a e^q / (a e^q + b)
//! ```
//!
//! and of two noises any q within 20 dB is as probable. Bayes' rule makes of this the probability of each reach. If the noise is alike in
//! `m` bins of the mean power P, noise makes a line of M possible ones as strong as this one, W, with probability `M (1 + W / (m P))^-m`
//! (see [`detection`](super::detection)). M is the number of bins in these shells: noise that is as loud as this in few bins has few bins to
//! raise. The mean over the reaches is the chance of the line.
//!
//! Near 0 Hz noise of electronics rises with `1/f^b`, b up to 3, and a line may have no quieter bins below it. There the bins of the first
//! shell are also seen divided by `(1 + x/k)^-b`, x bins from the line's bin k, with equal odds for each b before any look.

use super::detection::Detector;
use super::noise::ring::LocalNoise;
use super::observer::{Observer, Statistic};
use crate::math::scalar::Scalar;
use crate::spectrum::bins::REACH;
use num_complex::Complex;

/// The numbers of bins that are 3 to 4, 5 to 8 and 9 to 16 away, with this many bins to the left and to the right; at least one in each
/// group.
#[inline(never)]
pub(super) fn beside(left: i32, right: i32) -> [f32; 3] {
    [(3, 4), (5, 8), (9, 16)].map(|(nearest, farthest): (i32, i32)| {
        let side = |room: i32| (farthest.min(room) - nearest + 1).max(0);
        (side(left) + side(right)).max(1) as f32
    })
}

/// All bins that a fit reads.
pub(super) const WIDTH: usize = 2 * REACH + 1;

/// The mean power of the louder half of the residual in the bins around a peak, 3 to 16 away on each side. The ends of a real spectrum may
/// leave out some of these bins.
#[inline(never)]
pub(crate) fn louder(bins: &[Complex<f32>; WIDTH], iq: bool, n: usize, peak: i32) -> f32 {
    /// With fewer bins the residual decides nothing.
    const FEWEST: usize = 4;
    /// Bins 9 to 16 and 3 to 8 below the peak, and above it.
    const STRETCHES: [(usize, usize); 4] =
        [(0, REACH - 8), (REACH - 8, REACH - 2), (REACH + 3, REACH + 9), (REACH + 9, WIDTH)];
    let last = n as i32 / 2 - 1;
    let room = if iq { [i32::MAX; 2] } else { [peak.wrapping_sub(1), last.wrapping_sub(peak)] };
    let [below, above] = room.map(|room| room.max(0).min(REACH as i32) as usize);
    let (first, end) = (REACH - below, REACH + 1 + above);
    let (mut loudest, mut second) = (0.0, 0.0);
    for (from, to) in STRETCHES {
        let bins = bins.get(from.max(first)..to.min(end)).unwrap_or_default();
        if bins.len() < FEWEST {
            continue;
        }
        let mean = bins.iter().map(Complex::norm_sqr).sum::<f32>() / bins.len() as f32;
        if mean > loudest {
            (second, loudest) = (loudest, mean);
        } else if mean > second {
            second = mean;
        }
    }
    0.5 * (loudest + second)
}

/// Bins on both sides of a line, at about the same distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shell {
    /// The mean power of a bin.
    mean: f32,
    /// The number of independent bins with this accuracy.
    bins: f32,
    /// The number of bins up to here that noise may raise.
    reach: f32,
}

impl Shell {
    /// No bins.
    pub const NONE: Self = Self { mean: 0.0, bins: 0.0, reach: 0.0 };

    /// The bins of a band beside the line and its skirt.
    pub fn floor(mean: f32, bins: u32) -> Self {
        Self { mean, bins: bins as f32, reach: f32::INFINITY }
    }
}

/// The natural logarithm of the probability that noise makes a line of this power in a search of `searched` bins. The shells begin with the
/// nearest.
#[inline(never)]
pub(super) fn ln_chance(power: f32, searched: f32, shells: &[Shell]) -> f32 {
    let (mut sum, mut bins, mut reach) = (0.0, 0.0, 1.0);
    // The probability that the noise is alike up to this shell, and the sum of the chances.
    let (mut alike, mut chance) = (1.0, 0.0);
    let beyond = |sum: f32, bins: f32, reach: f32| {
        reach * exponential(-bins * (1.0 + power / sum).log_e())
    };
    for shell in shells.iter().filter(|shell| shell.bins > 0.0 && shell.mean > 0.0) {
        if bins > 0.0 {
            let own = 1.0 / (1.0 + OWN * exponential(-ln_alike(sum, bins, shell)));
            chance += alike * (1.0 - own) * beyond(sum, bins, reach);
            alike *= own;
        }
        sum += shell.mean * shell.bins;
        bins += shell.bins;
        reach = shell.reach.min(searched);
    }
    if bins > 0.0 {
        chance += alike * beyond(sum, bins, reach);
    }
    chance.max(f32::MIN_POSITIVE).log_e()
}

/// The odds before any look that a shell has another noise power than the bins within it, times the density of its logarithm, of which all
/// within 20 dB louder or quieter are as probable.
const OWN: f32 = 0.25 / (2.0 * 4.605);

/// The logarithm of the density of this ratio of two mean powers if the noise is alike, with Stirling's formula for the gamma functions.
fn ln_alike(sum: f32, a: f32, shell: &Shell) -> f32 {
    let b = shell.bins;
    let all = a + b;
    let mean = (sum + shell.mean * b) / all;
    let [x, y] = [sum / (a * mean), shell.mean / mean];
    a * x.log_e() + b * y.log_e() + 0.5 * (a * b / (core::f32::consts::TAU * all)).log_e()
}

/// Independent bins per bin of a residual.
const EACH: f32 = 0.9;

/// `exp(x)` for x not above 80.
fn exponential(x: f32) -> f32 {
    libm::expf(x.max(-80.0))
}

/// Decades in a unit of a natural logarithm.
const DECADE: f32 = core::f32::consts::LOG10_E;

/// Bins of a real spectrum below which noise may rise steeply towards 0 Hz.
const STEEP: i32 = 2 * REACH as i32;

/// The powers of frequency that are tried there, beside 0.
const SLOPES: usize = 3;

/// The residual of a fit 3 to 16 bins from its peak: the number of bins, and for each slope the sum of their powers over the slope's and the
/// sum of the slope's logarithms.
pub(super) struct Beside {
    bins: f32,
    sums: [f32; SLOPES + 1],
    logs: f32,
}

impl Beside {
    /// The residual of the bins around a peak.
    pub fn from_bins(bins: &[Complex<f32>; WIDTH], iq: bool, n: usize, peak: i32) -> Self {
        let mut beside = Self { bins: 0.0, sums: [0.0; SLOPES + 1], logs: 0.0 };
        let steep = is_steep(iq, peak);
        let last = n as i32 / 2;
        for (i, bin) in (-(REACH as i32)..).zip(bins) {
            let k = peak + i;
            if i.abs() < 3 || !iq && !(1..last).contains(&k) {
                continue;
            }
            let mut power = bin.norm_sqr();
            beside.bins += 1.0;
            let rise = if steep { k as f32 / peak as f32 } else { 1.0 };
            for sum in &mut beside.sums {
                *sum += power;
                power *= rise;
            }
            if steep {
                beside.logs += rise.log_e();
            }
        }
        beside
    }

    /// The first shell for noise of this slope, and the logarithm of the odds of this slope.
    fn shell(&self, slope: usize) -> (Shell, f32) {
        let sum = self.sums.get(slope).copied().unwrap_or(0.0);
        let mean = sum / self.bins.max(1.0);
        let odds = EACH * (slope as f32 * self.logs - self.bins * mean.log_e());
        (Shell { mean, bins: EACH * self.bins, reach: 2.0 * REACH as f32 }, odds)
    }
}

/// Whether noise may rise steeply towards 0 Hz at a peak.
fn is_steep(iq: bool, peak: i32) -> bool {
    !iq && (1..STEEP).contains(&peak)
}

impl Detector {
    /// Whether a line is far above all noise near it or below the threshold in any noise; `None` if that takes a closer look.
    #[inline(always)]
    pub(super) fn decided(&self, beside: &LocalNoise, floor: &Shell, observer: impl Observer) -> Option<bool> {
        let Self { n, iq, peak, power, ref spread, threshold } = *self;
        let ring = beside.loud * n as f32;
        let mut loudest = if ring > spread.middle { ring } else { spread.middle };
        let steep = is_steep(iq, peak);
        if steep {
            let rise = (peak + REACH as i32) as f32 / peak as f32;
            loudest *= rise * rise * rise;
        }
        if observer.exceeds(Statistic::FarAbove, power / loudest, threshold.far_above()) {
            return Some(true);
        }
        let _ = floor;
        None
    }

    /// Whether the line is more than noise, by its chance.
    #[inline(never)]
    pub(super) fn is_improbable(
        &self,
        residual: &Beside,
        beside: &LocalNoise,
        floor: Shell,
        observer: impl Observer,
    ) -> bool {
        let Self { n, iq, peak, power, threshold, .. } = *self;
        let (asked, searched) = threshold.parts();
        let (near, odds) = residual.shell(0);
        let mean = beside.mean() * n as f32;
        let ring = Shell { mean, bins: 0.5 * beside.noise.dof, reach: f32::INFINITY };
        // The floor of a short record holds all of its bins.
        let ring = if beside.has_sides() || floor.bins == 0.0 { ring } else { Shell::NONE };
        let mut chance = exponential(ln_chance(power, searched, &[near, ring, floor]));
        if is_steep(iq, peak) {
            let mut all = 1.0;
            for slope in 1..=SLOPES {
                let (near, other) = residual.shell(slope);
                let odds = exponential((other - odds).min(30.0));
                chance += odds * exponential(ln_chance(power, searched, &[near]));
                all += odds;
            }
            chance /= all;
        }
        let rare = -DECADE * chance.max(f32::MIN_POSITIVE).log_e();
        observer.exceeds(Statistic::Chance, rare, -DECADE * asked)
    }

    /// The factor on sigma of a line that is found in noise of this power per sample.
    ///
    /// Lines near the threshold are found where noise has raised them, and so look more exact than they are. Measured: the excess of the
    /// factor over 1 falls with the fourth power of the line's power.
    #[inline(never)]
    pub(super) fn selection(&self, noise: f32) -> f32 {
        /// The excess of a line at the threshold.
        const MOST: f32 = 0.5;
        let least = self.threshold.least_power() * noise * self.n as f32;
        let share = least / self.power;
        1.0 + MOST * (share * share) * (share * share)
    }
}
