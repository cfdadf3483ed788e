//! Is a line one steady tone? What a fit leaves in its bins, against the noise beside them.
//!
//! Another tone, a jump of the phase or a sweep leaves power in the few bins nearest the peak, leakage of something far in all of
//! them: so there are tests at several scales, and one of the five directions in which a tone's amplitude and frequency change
//! over the record (see [`super::least_squares::Rest`]). Noise alone fires one of them in a block of a million.
//!
//! What fires them is a tone that moves if those directions explain it, else several tones. Sigma is widened by what goes along with a
//! wrong frequency, and a little before anything fires: what is suspicious need not be improbable.

use super::least_squares::Fit;
use super::noise::ring::Beside;
use super::tone::Rise;
use crate::math::scalar::Scalar as _;

/// What a line is, by its rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
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

impl Judgement {
    /// Nothing is suspicious.
    pub const STEADY: Self = Self { line: Line::Steady, widening: 1.0 };
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

/// So much power in two directions has one block of noise in a hundred, and one in four hundred.
const ODD: f32 = 9.0;
const LIKELY: f32 = 12.0;

/// The numbers free in the bins up to 2, 4 and 8 from the peak, and directions of change.
const SCALES: [f32; 3] = [7.0, 15.0, 31.0];
const DIRECTIONS: f32 = 5.0;

/// The share of the squares of the three functions (see [`super::least_squares::Rest`]) in bins beyond 8 from the peak, over the
/// square of a sine or cosine; and beyond 4.
const BEYOND: [f32; 2] = [0.0238, 0.045];

/// The part of the first of them in bins up to 16.
const OUTSIDE: f32 = 0.485;

/// The most that the power along a function is, over the square of the sum along it: one over the sum of the function's squares.
const MOST: [f32; 3] = [3.23, 5.68, 8.40];

/// Judges the fit of a record of `n` samples. Cost: some thirty operations where nothing is suspicious.
#[inline(never)]
pub fn judge(fit: &Fit<f32>, n: usize, beside: &Beside) -> Judgement {
    let Beside { noise, .. } = beside;
    // In units of half the power of a bin of noise: each free number leaves 1.
    let unit = 2.0 / (noise.power * n as f32);
    let rest = &fit.rest;
    let free = fit.freedom.max(1) as f32;
    let along: f32 = rest.along.iter().zip(MOST).map(|(along, most)| along.norm_sqr() * most).sum();
    let [two, four, _] = rest.within;
    // No number of bins of noise makes less improbable, and less in the directions widens nothing: most blocks need no more.
    if along * unit < SUSPICIOUS
        && two * unit < 35.0
        && four * unit < 50.0
        && fit.residual * unit < 2.0 * free
    {
        return Judgement::STEADY;
    }
    judge_closely(fit, n, beside)
}

#[inline(never)]
fn judge_closely(fit: &Fit<f32>, n: usize, beside: &Beside) -> Judgement {
    let Beside { noise, loud, .. } = beside;
    let unit = 2.0 / (noise.power * n as f32);
    let size = fit.line.norm_sqr();
    let transform = TRANSFORM * size;
    let rest = |power: f32| (power - transform).max(0.0) * unit;
    let [two, four, eight] = fit.rest.within.map(rest);
    let all = rest(fit.residual);
    let free = fit.freedom.max(1) as f32;
    let [free2, free4, free8] = SCALES;
    let Changes { amplitude: [a1, a2, a3], phase: [p2, p3], outside, fourth, .. } =
        Changes::of(fit);
    let [a1, a2, a3, p2, p3] = [a1, a2, a3, p2, p3].map(|power| power * unit);
    let moved = (a1 + a2 + a3 + p2 + p3 - transform * unit).max(0.0);
    let soft = 1.0 + HIDDEN * (moved - SUSPICIOUS).max(0.0);
    let tail = |deviations| Tail { deviations, noise: noise.freedom };
    let fires = tail(FIRES);
    // The widest scale is as wide as the ring: where noise has an edge it is the louder side's.
    if !(fires.beyond(moved, DIRECTIONS)
        || fires.beyond(two, free2)
        || fires.beyond(four, free4)
        || fires.beyond(all * (noise.power / loud), free))
    {
        return Judgement { line: Line::Steady, widening: soft };
    }
    let (clean, left) = (tail(CLEAN), free - DIRECTIONS);
    let explained = moved + fourth * unit;
    let outside = if free > 2.0 * free8 { outside * unit } else { 0.0 };
    let beyond = (all - explained - outside - left).max(0.0);
    let strange = clean.beyond(eight - explained, free8 - DIRECTIONS)
        || clean.beyond(all - explained - outside, left);
    if strange && beyond > SHARE * moved {
        let most = (moved - DIRECTIONS).max(four - free4).max(0.0);
        return Judgement { line: Line::Unresolved, widening: 1.0 + HIDDEN * most };
    }
    // Two lines have changes of the amplitude of order 2 and of the phase of order 3 along with a wrong frequency; but not the one
    // without the other, as a tone of a changing level has.
    let odd = (a2 + p3 - ODD).max(0.0);
    let odd = if beyond > 3.0 * (2.0 * left).root() { odd + beyond } else { odd };
    let odd = odd.min(PAIRED * (p2 + p3 - LIKELY).max(0.0));
    Judgement { line: Line::Moving, widening: 1.0 + HIDDEN * odd }
}

/// What is left of a line along the ways in which a tone changes, as powers.
struct Changes {
    /// Of the amplitude, order 1 to 3.
    amplitude: [f32; 3],
    /// Of the phase, order 2 and 3.
    phase: [f32; 2],
    /// What they have in bins 9 to 16 from the peak.
    outside: f32,
    /// What a phase of order 2 has in amplitudes of order 4, see [`Changes::of`].
    fourth: f32,
    /// The phase of order 2, in radians, and the power of one radian.
    bent: f32,
    second: f32,
}

impl Rise {
    /// Of a fit to a record of `n` samples in noise of this power per sample.
    pub(super) fn of(fit: &Fit<f32>, n: usize, power: f32) -> Self {
        let Changes { bent, second, .. } = Changes::of(fit);
        // A rise of r bins is a phase of pi/6 r of order 2.
        let cycles = 6.0 / core::f32::consts::PI / n as f32;
        Self { cycles: cycles * bent, sigma: cycles * (0.5 * power * n as f32 / second).root() }
    }
}

impl Changes {
    /// A phase that is not small has a square: of b times Legendre's second polynomial, P2, that is, as
    /// `P2^2 = 1/5 + 2/7 P2 + 18/35 P4`, an amplitude of -b^2/7 of order 2, which is no change of the tone's, and -9/35 b^2 of
    /// order 4.
    fn of(fit: &Fit<f32>) -> Self {
        let cosine2 = fit.rest.cosine_squared;
        let sine2 = 1.0 - cosine2;
        let [narrow, wide] = BEYOND;
        let beyond = if fit.freedom > 2 * 9 { narrow } else { wide };
        let size = fit.line.norm_sqr();
        let [n1, n2, n3] = [
            1.0 / 3.0 - beyond * cosine2,
            1.0 / 5.0 - beyond * sine2,
            1.0 / 7.0 - beyond * cosine2,
        ];
        // Components as shares of the line; order 1 and 3 are a quarter turn on.
        let back = fit.line.conj() / size;
        let [a1, a2, a3] = fit.rest.along;
        let [w1, w2, w3] = [(a1, n1), (a2, n2), (a3, n3)].map(|(a, n)| back * a / n);
        let bent = w2.im * w2.im;
        let level = bent * (1.0 / 7.0) - w2.re;
        let [s1, s2, s3] = [n1, n2, n3].map(|n| n * size);
        let odd = w1.im * w1.im + w3.norm_sqr();
        Self {
            amplitude: [w1.im * w1.im * s1, level * level * s2, w3.im * w3.im * s3],
            phase: [bent * s2, w3.re * w3.re * s3],
            outside: OUTSIDE * beyond * size * (odd * cosine2 + (bent + level * level) * sine2),
            fourth: bent * bent * size * (81.0 / 1225.0 / 9.0),
            bent: -w2.im,
            second: s2,
        }
    }
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
