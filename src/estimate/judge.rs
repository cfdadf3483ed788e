//! Is a line one steady tone? What a fit leaves in its bins, against the noise beside them.
//!
//! Another tone, a jump of the phase or a sweep leaves power in the few bins nearest the peak, leakage of something far in all of
//! them: so there are tests at several scales, and one of the five directions in which a tone's amplitude and frequency change
//! over the record (see [`super::least_squares::Rest`]). Noise alone fires one of them in a block of a million.
//!
//! What fires them is a tone that moves if those directions explain it, else several tones. Sigma is widened by what goes along with a
//! wrong frequency, and a little before anything fires: what is suspicious need not be improbable.

use super::least_squares::Fit;
use super::ring::Noise;
use crate::scalar::Scalar as _;

/// What a line is, by its rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// One tone, as far as can be seen.
    Steady,
    /// One tone whose frequency or level changes.
    Moving,
    /// More than that.
    Unresolved,
}

/// What the tests say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judgement {
    /// What the line is.
    pub line: Line,
    /// By how many times the variance is more than the noise beside the tone makes it.
    pub widening: f32,
}

/// The share of a line that the integer transform leaves itself.
const TRANSFORM: f32 = 1e-9;

/// Each of four tests fires by chance in 2.5e-7 of all blocks. So many normal deviations.
const FIRES: f32 = 5.026;

/// What the directions leave is clean if each of two tests on it is less rare than 5e-4.
const CLEAN: f32 = 3.291;

/// Or if they explain all but this share.
const SHARE: f32 = 0.1;

/// Beyond this, three blocks of noise in a hundred, the power in the five directions widens sigma.
const SUSPICIOUS: f32 = 12.37;

/// How many times the power that a disturbance leaves in the residual it has in the direction of the frequency: 3 for a jump of the
/// phase in the middle of a record, 5 for a second tone half a bin away.
const HIDDEN: f32 = 5.0;

/// How many times the power along changes of the phase two lines may have along those of the amplitude, at most.
const PAIRED: f32 = 12.0;

/// The numbers free in the bins up to 2, 4 and 8 from the peak, and directions of change.
const SCALES: [f32; 3] = [7.0, 15.0, 31.0];
const DIRECTIONS: f32 = 5.0;

/// Judges the fit of a record of `n` samples. Cost: a dozen multiplications where nothing is suspicious.
#[inline(never)]
pub fn judge(fit: &Fit<f32>, n: usize, noise: &Noise) -> Judgement {
    // In units of half the power of a bin of noise: each free number leaves 1.
    let unit = 2.0 / (noise.power * n as f32);
    let transform = TRANSFORM * fit.line.norm_sqr();
    let rest = |power: f32| (power - transform).max(0.0) * unit;
    let [two, four, eight] = fit.rest.within.map(rest);
    let [a1, a2, a3] = fit.rest.amplitude.map(|power| power * unit);
    let [p2, p3] = fit.rest.phase.map(|power| power * unit);
    let all = rest(fit.residual);
    let moved = (a1 + a2 + a3 + p2 + p3 - transform * unit).max(0.0);
    let free = fit.freedom.max(1) as f32;
    let [free2, free4, free8] = SCALES;
    let soft = 1.0 + HIDDEN * (moved - SUSPICIOUS).max(0.0);
    let steady = Judgement { line: Line::Steady, widening: soft };
    // No number of bins of noise makes less improbable: most blocks need no more.
    if two < 35.0 && four < 50.0 && all < 2.0 * free && moved < 30.0 {
        return steady;
    }
    let tail = |deviations| Tail { deviations, noise: noise.freedom };
    let fires = tail(FIRES);
    // The widest scale is as wide as the ring: where noise has an edge it is the louder side's.
    if !(fires.beyond(moved, DIRECTIONS)
        || fires.beyond(two, free2)
        || fires.beyond(four, free4)
        || fires.beyond(all * (noise.power / noise.loud), free))
    {
        return steady;
    }
    let (clean, left) = (tail(CLEAN), free - DIRECTIONS);
    let explained = moved + fit.rest.fourth * unit;
    let outside = if free > 2.0 * free8 { fit.rest.beyond * unit } else { 0.0 };
    let beyond = (all - explained - outside - left).max(0.0);
    let strange = clean.beyond(eight - explained, free8 - DIRECTIONS)
        || clean.beyond(all - explained - outside, left);
    if strange && beyond > SHARE * moved {
        let most = (moved - DIRECTIONS).max(four - free4).max(0.0);
        return Judgement { line: Line::Unresolved, widening: 1.0 + HIDDEN * most };
    }
    // Two lines have changes of the amplitude of order 2 and of the phase of order 3 along with a wrong frequency; but not the one
    // without the other, as a tone of a changing level has.
    let odd = (a2 + p3 - 2.0).max(0.0);
    let odd = if beyond > 3.0 * (2.0 * left).root() { odd + beyond } else { odd };
    let odd = odd.min(PAIRED * (p2 + p3 - 4.0).max(0.0));
    Judgement { line: Line::Moving, widening: 1.0 + HIDDEN * odd }
}

/// What is improbable against noise that is known as well as an average of so many numbers.
struct Tail {
    deviations: f32,
    noise: f32,
}

impl Tail {
    /// Whether so much power in so many free numbers is beyond it. The ratio of two estimates of noise follows Fisher's
    /// distribution; its cube root is nearly normal (Wilson and Hilferty 1931).
    #[inline(never)]
    fn beyond(&self, power: f32, free: f32) -> bool {
        let (a, b) = (2.0 / (9.0 * free), 2.0 / (9.0 * self.noise));
        let (mean, other, square) = (1.0 - a, 1.0 - b, self.deviations * self.deviations);
        let below = other * other - square * b;
        let inside = a * other * other + b * mean * mean - a * b * square;
        let root = (mean * other + self.deviations * inside.root()) / below;
        below > 0.0 && power > free * root * root * root
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of Fisher's distribution, of probability 2.5e-7 and 5e-4.
    #[test]
    fn tails_are_fishers() {
        for (deviations, noise, free, exact) in [
            (FIRES, 52.0, 5.0, 11.145),
            (FIRES, 52.0, 7.0, 9.168),
            (FIRES, 52.0, 15.0, 6.329),
            (FIRES, 52.0, 63.0, 4.138),
            (FIRES, 30.0, 15.0, 8.924),
            (CLEAN, 52.0, 31.0, 2.803),
        ] {
            let tail = Tail { deviations, noise };
            assert!(!tail.beyond(0.99 * exact * free, free), "{noise} {free}");
            assert!(tail.beyond(1.06 * exact * free, free), "{noise} {free}");
        }
    }
}
