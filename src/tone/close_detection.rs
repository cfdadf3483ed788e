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
use core::f32::consts::TAU;
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
    /// The number of bins that noise may raise, if it is as loud as this up to here.
    reach: f32,
    /// The probability before any look that the noise has another power from here on.
    own: f32,
}

/// The probability before any look that noise has another power beyond the first shells, and beyond the ring. It is small because nearly
/// all lines are sought in noise that is alike: 6 % cost a line in white noise less than .1 dB.
const OWN: f32 = 0.06;
/// The probability before any look that noise differs within the first shells, if it is alike beyond, and if it is not.
const HUMP: [f32; 2] = [0.006, 0.5];
/// The width of the natural logarithms of power within 20 dB.
const WITHIN: f32 = 2.0 * 2.0 * core::f32::consts::LN_10;
/// Independent bins per bin of a residual, and per degree of freedom of the ring, a third of which are bins of a fit.
const EACH: f32 = 0.9;
const RING: f32 = 1.0 / 3.0;
/// Decades in a unit of a natural logarithm.
const DECADE: f32 = core::f32::consts::LOG10_E;

impl Shell {
    /// No bins.
    pub const NONE: Self = Self { mean: 0.0, bins: 0.0, reach: 0.0, own: 0.0 };

    /// The bins of a band beside the line and its skirt.
    pub fn floor(mean: f32, bins: u32) -> Self {
        Self { mean, bins: bins as f32, reach: f32::INFINITY, own: OWN }
    }

    /// The bins of the ring in a record of `n` samples.
    fn ring(beside: &LocalNoise, n: usize) -> Self {
        let (mean, bins) = (beside.mean() * n as f32, RING * beside.noise.dof);
        Self { mean, bins, reach: f32::INFINITY, own: OWN }
    }

    /// The sum of the powers.
    fn sum(&self) -> f32 {
        self.mean * self.bins
    }

    /// The probability that this shell has another noise than these bins within it. The density of the ratio of two mean powers of one noise
    /// is taken with Stirling's formula for the gamma functions.
    fn differs(&self, sum: f32, bins: f32) -> f32 {
        let all = bins + self.bins;
        let mean = (sum + self.sum()) / all;
        let [x, y] = [sum / (bins * mean), self.mean / mean];
        let spread = 0.5 * (bins * self.bins / (TAU * all)).log_e();
        let density = bins * x.log_e() + self.bins * y.log_e() + spread;
        let odds = self.own / WITHIN * exponential(-density);
        odds / (1.0 + odds)
    }
}

/// The probability that noise makes a line of this power in a search of `searched` bins. The shells begin with the nearest.
fn chance(power: f32, searched: f32, shells: &[Shell]) -> f32 {
    let (mut sum, mut bins, mut reach) = (0.0, 0.0, 1.0);
    // The probability that the noise is alike up to this shell, and the sum of the chances.
    let (mut alike, mut chance) = (1.0, 0.0);
    let up_to =
        |sum: f32, bins: f32, reach: f32| reach * exponential(-bins * (1.0 + power / sum).log_e());
    for shell in shells.iter().filter(|shell| shell.bins > 0.0 && shell.mean > 0.0) {
        if bins > 0.0 {
            let differs = shell.differs(sum, bins);
            // A hump's power falls with the square of the distance, which doubles from shell to shell: it is louder still at the line.
            let falls = (sum / (bins * shell.mean)).max(1.0).root().root();
            chance += alike * differs * up_to(falls * sum, bins, reach);
            alike *= 1.0 - differs;
        }
        sum += shell.sum();
        bins += shell.bins;
        reach = shell.reach.min(searched);
    }
    if bins > 0.0 {
        chance += alike * up_to(sum, bins, reach);
    }
    chance
}

/// `exp(x)`, held to the range of single precision.
fn exponential(x: f32) -> f32 {
    libm::expf(x.clamp(-80.0, 80.0))
}

/// Bins of a real spectrum below which noise may rise steeply towards 0 Hz.
const STEEP: i32 = 2 * REACH as i32;
/// The powers of frequency that are tried there, beside 0.
const SLOPES: usize = 3;
/// The odds of each before any look.
const SLOPE: f32 = 0.03;

/// Whether noise may rise steeply towards 0 Hz at a peak.
fn is_steep(iq: bool, peak: i32) -> bool {
    !iq && (1..STEEP).contains(&peak)
}

/// The residual of a fit 3 to 16 bins from its peak.
pub(super) struct Residual {
    /// The number of bins 3 to 8 away and 3 to 16 away.
    bins: [f32; 2],
    /// The power of the bins 3 to 8 away.
    near: f32,
    /// The power of all bins over the power of noise of each slope, relative to the peak's bin.
    sums: [f32; SLOPES + 1],
    /// The sum of the logarithms of the bins' frequencies over the peak's.
    logs: f32,
}

impl Residual {
    /// The residual of the bins around a peak.
    pub fn from_bins(bins: &[Complex<f32>; WIDTH], iq: bool, n: usize, peak: i32) -> Self {
        let mut residual = Self { bins: [0.0; 2], near: 0.0, sums: [0.0; SLOPES + 1], logs: 0.0 };
        let (steep, last) = (is_steep(iq, peak), n as i32 / 2);
        let each = if steep { 1.0 / peak as f32 } else { 0.0 };
        for (i, bin) in (-(REACH as i32)..).zip(bins) {
            let k = peak.wrapping_add(i);
            if i.abs() < 3 || !iq && !(1..last).contains(&k) {
                continue;
            }
            let mut power = bin.norm_sqr();
            if i.abs() <= 8 {
                residual.near += power;
                residual.bins[0] += 1.0;
            }
            residual.bins[1] += 1.0;
            if !steep {
                residual.sums[0] += power;
                continue;
            }
            let rise = k as f32 * each;
            residual.logs += rise.log_e();
            for sum in &mut residual.sums {
                *sum += power;
                power *= rise;
            }
        }
        residual
    }

    /// The shells of bins 3 to 8 and 9 to 16 away.
    fn shells(&self) -> [Shell; 2] {
        let ([near, all], [sum, ..]) = (self.bins, self.sums);
        let shell = |sum: f32, bins: f32, reach: f32| Shell {
            mean: sum / bins.max(1.0),
            bins: EACH * bins,
            reach,
            own: 0.0,
        };
        [shell(self.near, near, 16.0), shell(sum - self.near, all - near, 32.0)]
    }

    /// All bins as one shell for noise of this slope, and the logarithm of the likelihood of the slope.
    fn sloping(&self, slope: usize) -> (Shell, f32) {
        let (sum, [_, bins]) = (self.sums.get(slope).copied().unwrap_or(0.0), self.bins);
        let mean = sum / bins.max(1.0);
        let likely = EACH * (slope as f32 * self.logs - bins * mean.log_e());
        (Shell { mean, bins: EACH * bins, reach: 32.0, own: 0.0 }, likely)
    }
}

impl Detector {
    /// Whether the line is far above all noise near it, or below the threshold in any; `None` if it takes a closer look. Most lines end here.
    #[inline(always)]
    pub(super) fn decided(
        &self,
        beside: &LocalNoise,
        floor: &Shell,
        observer: impl Observer,
    ) -> Option<bool> {
        let Self { n, iq, peak, power, ref spread, threshold } = *self;
        let (steep, ring) = (is_steep(iq, peak), beside.loud * n as f32);
        let mut loudest = if ring > spread.middle { ring } else { spread.middle };
        if steep {
            let rise = (peak + REACH as i32) as f32 / peak as f32;
            loudest *= rise * rise * rise;
        }
        if observer.exceeds(Statistic::FarAbove, power / loudest, threshold.far_above()) {
            return Some(true);
        }
        if steep {
            return None;
        }
        // No mean of some of these powers is less than the least.
        let mut quietest = spread.least.min(beside.mean() * n as f32);
        if floor.bins > 0.0 {
            quietest = quietest.min(floor.mean);
        }
        let limit = threshold.least_of(16.0);
        (!observer.exceeds(Statistic::AnyNoise, power / quietest, limit)).then_some(false)
    }

    /// Whether the line is more than noise, by its chance.
    #[inline(never)]
    pub(super) fn is_improbable(
        &self,
        residual: &Residual,
        beside: &LocalNoise,
        floor: Shell,
        observer: impl Observer,
    ) -> bool {
        let Self { n, iq, peak, power, threshold, .. } = *self;
        let (asked, searched) = threshold.parts();
        let [near, next] = residual.shells();
        // Each bin counts once: the floor holds the second shell, the floor of a short record all bins.
        let floor = Shell { bins: (floor.bins - next.bins).max(0.0), ..floor };
        let ring = Shell::ring(beside, n);
        let ring = if beside.has_sides() || floor.bins == 0.0 { ring } else { Shell::NONE };
        let outer = if ring.bins > 0.0 { ring } else { floor };
        let falls = if outer.bins > 0.0 {
            outer.differs(near.sum() + next.sum(), near.bins + next.bins)
        } else {
            0.0
        };
        let [alike, hump] = HUMP;
        let next = Shell { own: alike + hump * falls, ..next };
        let mut chance = chance(power, searched, &[near, next, ring, floor]);
        if is_steep(iq, peak) {
            let (_, level) = residual.sloping(0);
            let mut all = 1.0;
            for slope in 1..=SLOPES {
                let (shell, likely) = residual.sloping(slope);
                let odds = SLOPE * exponential(likely - level);
                chance += odds * self::chance(power, searched, &[shell]);
                all += odds;
            }
            chance /= all;
        }
        let rare = -chance.max(f32::MIN_POSITIVE).log_e();
        observer.exceeds(Statistic::Chance, DECADE * rare, -DECADE * asked)
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
