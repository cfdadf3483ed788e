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

use super::whole::{self, NOISE_BINS};
use super::{Noise, rounding, whole_fixed};
use crate::acquire::sample::Record;
use crate::estimate::least_squares::Fit;
use crate::estimate::least_squares::fixed::{product, quantised, square, tail};
use crate::estimate::measure::Arithmetic;
use crate::math::scalar::Scalar as _;
use crate::math::series::line_shape;
use crate::spectrum::Spectrum;
use crate::spectrum::engine::Engine;
use crate::spectrum::fft::integer::Point;
use core::mem::MaybeUninit;
use num_complex::Complex;

/// The noise beside a tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beside {
    /// As strong as under the tone.
    pub noise: Noise,
    /// The power on the louder side: what a peak must stand out from.
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
/// theirs is the noise of all bins, see [`whole::power`].
///
/// Cost: up to 66 bins read, 32 differences.
pub fn beside<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: i32,
    fit: &Fit<f32>,
    arithmetic: Arithmetic,
) -> Beside {
    if N < if R::IQ { 128 } else { 256 } {
        let power = match arithmetic {
            Arithmetic::Float => whole::power::<f32, R, N, NOISE_BINS>(spectrum, peak, fit),
            Arithmetic::Fixed => whole_fixed::power::<R, N, NOISE_BINS>(spectrum, peak, fit),
        };
        let freedom = whole::freedom::<R, N, NOISE_BINS>() as f32;
        return Beside { noise: Noise { power, freedom }, loud: power };
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
    let least = rounding::<R>();
    of_sides(sides, f32::two_to(bits) / 6.0, least)
}

/// The same from any bins of which the tone has been taken away: `rest(k)` is the square of the size of
/// `(X[k-1] + X[k+1]) / 2 - X[k]` for a record of `n` samples, whatever their number. Not below the smallest float.
pub fn of_rest(n: usize, iq: bool, peak: i32, rest: impl Fn(i32) -> f32) -> Beside {
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
) -> Option<Beside> {
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
    let least = rounding::<R>();
    let power = (left.0.max(right.0) * f32::two_to(bits) / 6.0).max(least);
    let freedom = left.1 + right.1;
    (freedom > 0.0).then_some(Beside { noise: Noise { power, freedom }, loud: power })
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
fn of_sides(sides: [(f32, usize); 2], scale: f32, least: f32) -> Beside {
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
    let noise = Noise { power: power.max(least), freedom: 2.0 / variance };
    Beside { noise, loud: loud.max(least) }
}

/// What the tone itself has in second differences.
struct Own {
    /// `line sin(pi d) / pi` in stored units, and what its mirror image has for it.
    value: Complex<f32>,
    image: Complex<f32>,
    /// The tone's bin and its offset.
    peak: i32,
    offset: f32,
    /// By how much both turn from bin to bin.
    turn: f32,
    /// The sum of the tone's bin and its image's: 0 or N. `None` where the image is far.
    mirror: Option<i32>,
}

/// Tones nearer than this to an end of the spectrum have an image among their ring's bins.
const MIRRORED: i32 = 40;

/// So far from the image its leakage is nothing.
const REACHED: i32 = 60;

impl Own {
    fn new<R: Record>(peak: i32, n: usize, fit: &Fit<f32>, exponent: i32) -> Self {
        let turn = core::f32::consts::PI / n as f32;
        let (n, d) = (n as i32, fit.offset);
        let value = fit.line * (d * line_shape(d) * f32::two_to(-exponent));
        let near = peak.min(n / 2 - peak);
        let low = peak < n / 4;
        let mirror = (!R::IQ && near < MIRRORED).then_some(if low { 0 } else { n });
        let image = if low { value.conj() } else { -value.conj() };
        Self { value, image, peak, offset: d, turn, mirror }
    }

    /// The mean of a side's stretches but for the loudest ones, none to two; its bins start at `first`.
    #[inline(never)]
    fn side(&self, bins: &[Point], first: i32, arithmetic: Arithmetic, without: usize) -> f32 {
        match arithmetic {
            Arithmetic::Float => quiet(bins, first, without, |bins, k| self.power(bins, k)),
            Arithmetic::Fixed => {
                let own = Whole::of(self);
                quiet(bins, first, without, |bins, k| own.power(bins, k))
            }
        }
    }

    /// The power of a stretch, whose first difference is around bin `k`.
    #[inline(always)]
    fn power(&self, bins: &[Point; STEP + 1], k: i32) -> f32 {
        let tail = |x: f32| 1.0 / (x * (x * x - 1.0));
        // A leakage turns with the distance, all of a stretch as its middle.
        let turned = |z: Complex<f32>, distance: f32| {
            let angle = distance * self.turn;
            Complex::new(z.re - z.im * angle, z.im + z.re * angle)
        };
        const MIDDLE: f32 = EACH as f32 - 1.0;
        let mut x = (self.peak - k) as f32 + self.offset;
        let value = turned(self.value, MIDDLE - x);
        let mut differences = bends(bins).map(|[re, im]| {
            let tail = tail(x);
            x -= 2.0;
            [re as f32 - value.re * tail, im as f32 - value.im * tail]
        });
        if let Some(mirror) = self.mirror {
            let mut s = (self.peak + k - mirror) as f32 + self.offset;
            let image = turned(self.image, s + MIDDLE);
            for [re, im] in &mut differences {
                let tail = tail(s.abs());
                s += 2.0;
                *re -= image.re * tail;
                *im -= image.im * tail;
            }
        }
        differences.into_iter().map(|[re, im]| re * re + im * im).sum()
    }
}

/// [`Own`] in integers.
struct Whole {
    value: Point,
    image: Point,
    peak: i32,
    /// In Q25.
    offset: i32,
    /// In Q28.
    turn: i32,
    mirror: Option<i32>,
}

impl Whole {
    fn of(own: &Own) -> Self {
        let integers = |z: Complex<f32>| [z.re as i32, z.im as i32];
        let (value, image) = (integers(own.value), integers(own.image));
        let offset = quantised(own.offset, 25);
        let turn = quantised(own.turn, 28);
        Self { value, image, peak: own.peak, offset, turn, mirror: own.mirror }
    }

    /// As [`Own::power`].
    #[inline(always)]
    fn power(&self, bins: &[Point; STEP + 1], k: i32) -> f32 {
        const ONE: i32 = 1 << 25;
        let turned = |[re, im]: Point, distance: i32| {
            let angle = distance.wrapping_mul(self.turn);
            let [more, less] = [re, im].map(|part| (product(angle, part) >> 28) as i32);
            [re.wrapping_sub(less), im.wrapping_add(more)]
        };
        const MIDDLE: i32 = EACH as i32 - 1;
        let mut x = (self.peak - k).wrapping_mul(ONE).wrapping_add(self.offset);
        let value = turned(self.value, k + MIDDLE - self.peak);
        let mut mirrored = self.mirror.map(|mirror| {
            let s = self.peak + k - mirror;
            (s, turned(self.image, s + MIDDLE))
        });
        let mut sum = 0u64;
        for mut rest in bends(bins) {
            let mut less = |value: Point, tail: i32| {
                for (rest, part) in rest.iter_mut().zip(value) {
                    *rest = rest.wrapping_sub((product(tail, part) >> 36) as i32);
                }
            };
            less(value, tail(x));
            x = x.wrapping_sub(2 * ONE);
            if let Some((s, image)) = &mut mirrored {
                if s.abs() < REACHED {
                    let away = s.wrapping_mul(ONE).wrapping_add(self.offset).wrapping_abs();
                    less(*image, tail(away));
                }
                *s += 2;
            }
            let [re, im] = rest.map(|part| square(part) as u64);
            sum = sum.wrapping_add(re).wrapping_add(im);
        }
        sum as f32
    }
}

/// The mean of the powers of a side's stretches but for the loudest ones, none to two.
#[inline(always)]
fn quiet(
    bins: &[Point],
    first: i32,
    without: usize,
    power: impl Fn(&[Point; STEP + 1], i32) -> f32,
) -> f32 {
    let (mut sum, mut loudest, mut second) = (0.0f32, 0.0f32, 0.0f32);
    let (mut count, mut rest, mut centre) = (0, bins, first + 1);
    while let Some(bins) = rest.first_chunk() {
        let power = power(bins, centre);
        rest = rest.get(STEP..).unwrap_or(&[]);
        centre += STEP as i32;
        count += 1;
        sum += power;
        second = second.max(power.min(loudest));
        loudest = loudest.max(power);
    }
    let loud = match without {
        0 => 0.0,
        1 => loudest,
        _ => loudest + second,
    };
    (sum - loud) / (count - without as i32).max(1) as f32
}

/// The second differences in a stretch, halved.
#[inline(always)]
fn bends(bins: &[Point; STEP + 1]) -> [Point; EACH] {
    let &[a, b, c, d, e, f, g, h, i] = bins;
    let bent = |a: Point, b: Point, c: Point| {
        let part = |a: i32, b: i32, c: i32| (a >> 1).wrapping_sub(b).wrapping_add(c >> 1);
        [part(a[0], b[0], c[0]), part(a[1], b[1], c[1])]
    };
    [bent(a, b, c), bent(c, d, e), bent(e, f, g), bent(g, h, i)]
}
