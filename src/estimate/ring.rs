//! The noise beside a tone: from the bins of a ring around it, where it is as strong as under the tone itself.
//!
//! Noise is seldom white. A filter, a converter's own noise and hum make it as much as a hundred times stronger in one part of a
//! spectrum than in another, so only what is near the tone tells how far the tone may be off. Near it there is its own leakage,
//! and that of whatever moves along with it. Second differences of the bins, which are Hann's window, lessen that by 18 dB
//! an octave, and the tone's own is known and taken away: with c its line, d its offset and x bins from it,
//!
//! ```text
//! (X[k-1] + X[k+1]) / 2 - X[k]  =  noise + c sin(pi d) / (pi x (x^2 - 1))          white noise of power P: 3/2 P
//! ```
//!
//! Every second difference counts, from 7 bins off, in stretches of four. Other lines are no noise: of a side's stretches the
//! loudest third is left out, for which what is left is too weak by a known factor. The geometric mean of both sides takes out
//! any slope in decibels.
//!
//! Four stretches on a side: standard deviation 0.85 dB, as good as fifty independent numbers.

use super::least_squares::fixed::{held, product, quantised, tail};
use super::least_squares::{Fit, line_shape};
use super::measure::Arithmetic;
use super::noise::{self, NOISE_BINS, ROUNDING};
use super::noise_fixed;
use crate::acquire::sample::Record;
use crate::scalar::Scalar as _;
use crate::spectrum::Spectrum;
use crate::spectrum::engine::Engine;
use crate::spectrum::fft::integer::Point;
use core::mem::MaybeUninit;
use num_complex::Complex;

/// The noise at a tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Power per sample (I/Q: of both parts together) in squared codes, not below the converter's rounding.
    pub power: f32,
    /// How many real numbers that is as good as an average of: its relative variance is two over this.
    pub freedom: f32,
    /// The same power on the louder side: what a peak must stand out from.
    pub loud: f32,
}

/// Bins from the tone to the middle of the first difference.
const FIRST: i32 = 7;

/// Differences in a stretch, and bins from one stretch to the next.
const EACH: usize = 4;
const STEP: usize = 2 * EACH;

/// Stretches on each side; a side cut short by an end of the spectrum lends the other at most two: farther away the noise is
/// another one.
const WANTED: usize = 4;
const LENT: usize = 2;
const MOST: usize = WANTED + LENT;

/// Drift has no second difference worth mention from this bin on.
const DRIFT: i32 = 4;

/// For each number of stretches: what is left of white noise's power in the mean of all but the loudest third, and the relative
/// variance of that.
const KEPT: [(f32, f32); WIDE + 1] = [
    (1.0, 1.0),
    (1.0, 0.2600),
    (1.0, 0.1310),
    (0.7798, 0.1136),
    (0.8149, 0.0789),
    (0.8391, 0.0604),
    (0.7499, 0.0577),
    (0.7738, 0.0472),
    (0.7931, 0.0399),
];

/// The bins of a side.
type Window = [MaybeUninit<Point>; STEP * MOST + 1];

/// Stretches on each side of the wide ring, by which it is decided whether a weak peak is one.
const WIDE: usize = 8;
type WideWindow = [MaybeUninit<Point>; STEP * WIDE + 1];

/// The noise beside the tone that `fit` found at bin `peak`. Records of fewer than 256 samples (I/Q: 128) have no room for a ring:
/// theirs is the noise of all bins, see [`noise::power`].
///
/// Cost: up to 66 bins read, 32 differences.
pub fn noise<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: i32,
    fit: &Fit<f32>,
    arithmetic: Arithmetic,
) -> Noise {
    if N < if R::IQ { 128 } else { 256 } {
        let power = match arithmetic {
            Arithmetic::Float => noise::power::<f32, R, N, NOISE_BINS>(spectrum, peak, fit),
            Arithmetic::Fixed => noise_fixed::power::<R, N, NOISE_BINS>(spectrum, peak, fit),
        };
        let freedom = noise::freedom::<R, N, NOISE_BINS>() as f32;
        return Noise { power, freedom, loud: power };
    }
    let room = room(N as i32, R::IQ, peak);
    let places = shared(room);
    let own = Own::new::<R>(peak, N, fit, spectrum.exponent());
    let side = |first: i32, count: usize| {
        let mut window: Window = [MaybeUninit::uninit(); _];
        let window = window.get_mut(..STEP * count + 1).unwrap_or_default();
        own.side(spectrum.fill(first, window), first, arithmetic, count / 3)
    };
    let [left, right] = places;
    let sides = [
        (side(peak - FIRST + 1 - (STEP * left) as i32, left), left),
        (side(peak + FIRST - 1, right), right),
    ];
    // A stretch sums the halves of four differences; a bin's power is N times a sample's.
    let bits = 2 * spectrum.exponent() - N.trailing_zeros() as i32;
    let least = ROUNDING as f32 * if R::IQ { 2.0 } else { 1.0 };
    of_sides(sides, f32::two_to(bits) / 6.0, least)
}

/// The same from any bins of which the tone has been taken away: `rest(k)` is the square of the size of
/// `(X[k-1] + X[k+1]) / 2 - X[k]` for a record of `n` samples, whatever their number. Not below the smallest float.
pub fn of_rest(n: usize, iq: bool, peak: i32, rest: impl Fn(i32) -> f32) -> Noise {
    let [left, right] = shared(room(n as i32, iq, peak));
    let side = |towards: i32, count: usize| {
        let mut stretches = [0.0f32; MOST];
        for (index, stretch) in stretches.iter_mut().take(count).enumerate() {
            let first = FIRST + (STEP * index) as i32;
            *stretch = (0..EACH as i32).map(|i| rest(peak + towards * (first + 2 * i))).sum();
        }
        stretches.sort_unstable_by(f32::total_cmp);
        let empty = MOST.saturating_sub(count);
        let kept = count.saturating_sub(count / 3);
        let sum: f32 = stretches.iter().skip(empty).take(kept).sum();
        (sum / kept.max(1) as f32, count)
    };
    of_sides([side(-1, left), side(1, right)], 1.0 / (6.0 * n.max(1) as f32), f32::MIN_POSITIVE)
}

/// The noise in a ring twice as wide. A peak that is hardly stronger asks for more than a quiet ring beside it.
///
/// Cost: up to 130 bins read, 64 differences.
#[inline(never)]
pub fn loud<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: i32,
    fit: &Fit<f32>,
    arithmetic: Arithmetic,
) -> Option<Noise> {
    if N < if R::IQ { 128 } else { 256 } {
        return None;
    }
    let own = Own::new::<R>(peak, N, fit, spectrum.exponent());
    let [left, right] = room(N as i32, R::IQ, peak).map(|room| room.min(WIDE));
    let side = |first: i32, count: usize| {
        let mut window: WideWindow = [MaybeUninit::uninit(); _];
        let window = window.get_mut(..STEP * count + 1).unwrap_or_default();
        let mean = own.side(spectrum.fill(first, window), first, arithmetic, count / 3);
        let &(share, variance) = KEPT.get(count).unwrap_or(&KEPT[0]);
        if count == 0 { (0.0, 0.0) } else { (mean / share, 2.0 / variance) }
    };
    let left = side(peak - FIRST + 1 - (STEP * left) as i32, left);
    let right = side(peak + FIRST - 1, right);
    let bits = 2 * spectrum.exponent() - N.trailing_zeros() as i32;
    let least = ROUNDING as f32 * if R::IQ { 2.0 } else { 1.0 };
    let power = (left.0.max(right.0) * f32::two_to(bits) / 6.0).max(least);
    let freedom = left.1 + right.1;
    (freedom > 0.0).then_some(Noise { power, freedom, loud: power })
}

/// How many stretches there are on each side of a tone.
fn room(n: i32, iq: bool, peak: i32) -> [usize; 2] {
    let half = n / 2;
    // A spectrum of I/Q is a circle, of which the tone's far side is left out.
    let room = if iq {
        [half - STEP as i32 - FIRST; 2]
    } else {
        [peak - FIRST - DRIFT + 2, half - peak - FIRST]
    };
    room.map(|room| (room.max(0) / STEP as i32) as usize)
}

/// How many stretches each side gives, of those that it has.
fn shared([left, right]: [usize; 2]) -> [usize; 2] {
    let lent = |other: usize| WANTED.saturating_sub(other).min(LENT);
    [left.min(WANTED + lent(right)), right.min(WANTED + lent(left))]
}

/// Both sides together, each with the mean of its quieter stretches and their number.
fn of_sides(sides: [(f32, usize); 2], scale: f32, least: f32) -> Noise {
    let [left, right] = sides.map(|(mean, count)| {
        let &(share, variance) = KEPT.get(count).unwrap_or(&KEPT[0]);
        (mean * scale / share, variance)
    });
    let [none, nothing] = sides.map(|(_, count)| count == 0);
    let (power, variance, loud) = if none || nothing {
        let (power, variance) = if none { right } else { left };
        (power, variance, power)
    } else {
        let variance = (left.1 + right.1) * 0.25;
        // A quarter of the variance makes the mean right; the rest halves what it adds to that of (error / sigma)^2.
        let middle = (left.0 * right.0).root() * (1.0 + 0.75 * variance);
        (middle, variance, left.0.max(right.0))
    };
    Noise { power: power.max(least), freedom: 2.0 / variance, loud: loud.max(least) }
}

/// What the tone itself has in second differences.
struct Own {
    /// `line sin(pi d) / pi` in stored units, and what its mirror image has for it.
    value: Complex<f32>,
    image: Complex<f32>,
    /// The tone's bin and its offset; the bin from which the image's distance counts, 0 or N, and the sign of that.
    peak: i32,
    offset: f32,
    mirror: Option<i32>,
}

/// Tones nearer than this to an end of the spectrum have an image among their ring's bins.
const MIRRORED: i32 = 64;

impl Own {
    fn new<R: Record>(peak: i32, n: usize, fit: &Fit<f32>, exponent: i32) -> Self {
        let (n, d) = (n as i32, fit.offset);
        let value = fit.line * (d * line_shape(d) * f32::two_to(-exponent));
        let near = peak.min(n / 2 - peak);
        let low = peak < n / 4;
        let mirror = (!R::IQ && near < MIRRORED).then_some(if low { 0 } else { n });
        let image = if low { value.conj() } else { -value.conj() };
        Self { value, image, peak, offset: d, mirror }
    }

    /// The mean of a side's stretches but for the loudest ones, none to two; its bins start at `first`.
    #[inline(always)]
    fn side(&self, bins: &[Point], first: i32, arithmetic: Arithmetic, without: usize) -> f32 {
        let (mut sum, mut loudest, mut second) = (0.0f32, 0.0f32, 0.0f32);
        let count = bins.len() / STEP;
        let mut rest = bins;
        for stretch in 0..count {
            let centre = first + (STEP * stretch) as i32 + 1;
            let bins = rest.first_chunk::<{ STEP + 1 }>().unwrap_or(&[[0; 2]; _]);
            let power = match arithmetic {
                Arithmetic::Float => self.float(bins, centre),
                Arithmetic::Fixed => self.fixed(bins, centre),
            };
            rest = rest.get(STEP..).unwrap_or(&[]);
            sum += power;
            second = second.max(power.min(loudest));
            loudest = loudest.max(power);
        }
        let loud = match without {
            0 => 0.0,
            1 => loudest,
            _ => loudest + second,
        };
        (sum - loud) / count.saturating_sub(without).max(1) as f32
    }

    /// The power of a stretch, whose first difference is around bin `k`.
    #[inline(always)]
    fn float(&self, bins: &[Point; STEP + 1], k: i32) -> f32 {
        let tail = |x: f32| 1.0 / (x * (x * x - 1.0));
        let mut x = (self.peak - k) as f32 + self.offset;
        let mut mirrored = self.mirror.map(|end| {
            let distance = self.peak + k - end;
            distance.abs() as f32 + if end == 0 { self.offset } else { -self.offset }
        });
        let mut sum = 0.0;
        for [a, b, c] in bins.array_windows::<3>().step_by(2) {
            let half = |part: usize| {
                let [a, b, c] = [a, b, c].map(|bin| if part == 0 { bin[0] } else { bin[1] } as f32);
                (a + c) * 0.5 - b
            };
            let mut rest = Complex::new(half(0), half(1)) - self.value * tail(x);
            x -= 2.0;
            if let (Some(s), Some(end)) = (mirrored, self.mirror) {
                rest -= self.image * tail(s);
                mirrored = Some(if end == 0 { s + 2.0 } else { s - 2.0 });
            }
            sum += rest.norm_sqr();
        }
        sum
    }

    /// The same in integers.
    #[inline(always)]
    fn fixed(&self, bins: &[Point; STEP + 1], k: i32) -> f32 {
        const ONE: i32 = 1 << 25;
        let integers = |z: Complex<f32>| [z.re as i32, z.im as i32];
        let (value, image) = (integers(self.value), integers(self.image));
        let offset = quantised(self.offset, 25);
        let mut x = (self.peak - k).wrapping_mul(ONE).wrapping_add(offset);
        let mut mirrored = self.mirror.map(|end| {
            let distance = (self.peak + k - end).abs();
            (distance, if end == 0 { offset } else { -offset }, if end == 0 { 2 } else { -2 })
        });
        let mut sum = 0u64;
        for [a, b, c] in bins.array_windows::<3>().step_by(2) {
            let half = |part: usize| {
                let [a, b, c] = [a, b, c].map(|bin| if part == 0 { bin[0] } else { bin[1] });
                (a >> 1).wrapping_add(c >> 1).wrapping_add(a & c & 1).wrapping_sub(b)
            };
            let mut rest = [half(0), half(1)];
            let mut less = |value: [i32; 2], tail: i32| {
                for (rest, part) in rest.iter_mut().zip(value) {
                    *rest = rest.wrapping_sub(held(product(tail, part) >> 36));
                }
            };
            less(value, tail(x));
            x = x.wrapping_sub(2 * ONE);
            if let Some((s, offset, step)) = mirrored {
                // Farther away it has nothing.
                if s < MIRRORED - 2 {
                    less(image, tail(s.wrapping_mul(ONE).wrapping_add(offset)));
                }
                mirrored = Some((s + step, offset, step));
            }
            let [re, im] = rest.map(|part| product(part, part) as u64);
            sum = sum.saturating_add(re).saturating_add(im);
        }
        sum as f32
    }
}
