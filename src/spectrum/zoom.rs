//! A few bins of a record without its spectrum, for a tone whose approximate frequency is known: mix, decimate by N/32, transform 32
//! points.
//!
//! With `L = N/32`, centre bin c and block m of L samples,
//!
//! ```text
//! y[m] = sum over n < L of x[m L + n] exp(-j 2 pi c n / N)        Y[c + i] = sum over m of y[m] exp(-j 2 pi (c + i) m / 32)
//! ```
//!
//! The oscillator restarts in each block, so its L factors are a table, and the centre only
//! shifts the index of the transform. Y is the record's spectrum seen through a boxcar of L
//! samples, not the spectrum itself; [`crate::tone::zoomed`] has the exact model. A constant
//! offset falls into one bin: the bin whose index is a multiple of 32.
//!
//! All numbers are integers. The products with Q15 factors are summed exactly and then shifted
//! down, so that no sum of the transform can overflow for any codes. At N = 1024 a point is a
//! multiple of 2^-6 code, a tenth of a percent of the converter's rounding in it. Cores with the
//! DSP extension run the loops of `zoom_dsp`, which give the same bits.

use super::fft::integer::{Pair, Point};
use super::fft::twiddle::{MAX_LENGTH, sin_cos};
use super::layout::Layout;
#[cfg(dsp)]
use super::zoom_dsp as engine;
use crate::acquire::sample::Record;
use crate::math::series::circle;

/// The portable definition, for cores without a faster one.
#[cfg(not(dsp))]
mod engine {
    pub(in crate::spectrum) use super::{mix, transform};
}

/// Points after decimation.
pub const POINTS: usize = 32;

/// The most samples of a block that decimation turns into a point.
pub(super) const LONGEST: usize = MAX_LENGTH / POINTS;

/// A point's magnitude is below two to this power. The transform grows by 32 and halves once, so it
/// stays within 2^30.
const ROOM: u32 = 26;

/// Two numbers in Q15.
pub type Factor = [i16; 2];

/// The factors of one centre.
#[derive(Clone, Debug)]
pub struct Oscillator {
    centre: i32,
    /// Factors with [`ONE`] for 1. I/Q: cos and -sin for each sample. Real: for each pair of samples both cos, then both -sin.
    factors: [Factor; LONGEST],
}

/// Bins about a centre, from [`Oscillator::zoom`].
#[derive(Clone, Debug, PartialEq)]
pub struct Zoom {
    points: [Point; POINTS],
    unit: f32,
}

/// The number of bits by which the sum of a block of N/32 samples is shifted down: codes have at most 16 bits, factors 15.
pub(super) const fn shift<R: Record, const N: usize>() -> u32 {
    (N / POINTS).trailing_zeros() + 15 + 15 + R::IQ as u32 - ROOM
}

impl Oscillator {
    /// The factors for centre bin `centre` of records of `n` samples, 64 to 4096. Cost: n/32 sines.
    pub fn new(centre: i32, &Layout { n, iq, .. }: &Layout) -> Self {
        let mut factors = [[0; 2]; LONGEST];
        let mut sample = 0i32;
        for pair in factors.as_chunks_mut::<2>().0.iter_mut().take(n / POINTS / 2) {
            let [first, second] = [sample, sample.wrapping_add(1)].map(|k| {
                let turn = circle::<f32>(centre.wrapping_mul(k), n as i32);
                [q15(turn.re), q15(-turn.im)]
            });
            *pair =
                if iq { [first, second] } else { [[first[0], second[0]], [first[1], second[1]]] };
            sample = sample.wrapping_add(2);
        }
        Self { centre, factors }
    }

    /// The centre bin.
    pub const fn centre(&self) -> i32 {
        self.centre
    }

    /// Mixes, decimates and transforms a record of N samples. Cost: a product for each part of each sample.
    pub fn zoom<R: Record, const N: usize>(&self, samples: &[R::Sample; N]) -> Zoom {
        let mixed = engine::mix::<R, N>(R::pairs(samples), &self.factors);
        Zoom { points: engine::transform(mixed), unit: const { unit::<R, N>() } }
    }

    /// [`Oscillator::zoom`] by the portable definition, for tests.
    pub fn zoom_portably<R: Record, const N: usize>(&self, samples: &[R::Sample; N]) -> Zoom {
        let mixed = mix::<R, N>(R::pairs(samples), &self.factors);
        Zoom { points: transform(mixed), unit: const { unit::<R, N>() } }
    }
}

/// The blocks of the record, each multiplied by the factors and summed.
pub(super) fn mix<R: Record, const N: usize>(
    pairs: &[Pair],
    factors: &[Factor; LONGEST],
) -> [Point; POINTS] {
    let length = const { (if R::IQ { N } else { N / 2 }) / POINTS };
    mixed(pairs, factors, R::IQ, length, const { shift::<R, N>() })
}

/// [`mix`], compiled once for all kinds and lengths of records.
fn mixed(
    pairs: &[Pair],
    factors: &[Factor; LONGEST],
    iq: bool,
    length: usize,
    shift: u32,
) -> [Point; POINTS] {
    let mut points = [[0; 2]; POINTS];
    let mut rest = pairs;
    for point in &mut points {
        let Some((block, tail)) = rest.split_at_checked(length) else {
            break;
        };
        rest = tail;
        let sum = if iq { turned(block, factors) } else { weighed(block, factors) };
        *point = sum.map(|part| (part >> shift) as i32);
    }
    points
}

/// The exact sum of I/Q samples times their factors. Two products together are below 2^31.
fn turned(block: &[Pair], factors: &[Factor]) -> [i64; 2] {
    let mut sum = [0i64; 2];
    for (sample, factor) in block.iter().zip(factors) {
        let ([i, q], [cos, sin]) = (sample.map(i32::from), factor.map(i32::from));
        sum[0] = sum[0].wrapping_add((i * cos - q * sin).into());
        sum[1] = sum[1].wrapping_add((i * sin + q * cos).into());
    }
    sum
}

/// The exact sum of real samples times their factors, two at a time.
fn weighed(block: &[Pair], factors: &[Factor]) -> [i64; 2] {
    let mut sum = [0i64; 2];
    for (samples, parts) in block.iter().zip(factors.as_chunks::<2>().0) {
        let [a, b] = samples.map(i32::from);
        for (sum, factor) in sum.iter_mut().zip(parts) {
            let [first, second] = factor.map(i32::from);
            *sum = sum.wrapping_add((a * first + b * second).into());
        }
    }
    sum
}

impl Zoom {
    /// Bin k of the record, near the centre, in stored units.
    #[inline]
    pub fn bin(&self, k: i32) -> Point {
        self.points.get(k as usize % POINTS).copied().unwrap_or([0; 2])
    }

    /// One stored unit in codes.
    pub const fn unit(&self) -> f32 {
        self.unit
    }
}

/// The transform halves once.
const fn unit<R: Record, const N: usize>() -> f32 {
    (2u32 << shift::<R, N>()) as f32 / ONE
}

/// A factor of 1. 16 bits do not hold 2^15.
const ONE: f32 = 32767.0;

fn q15(x: f32) -> i16 {
    libm::rintf(x * ONE) as i16
}

/// Half the transform of 32 points: eight transforms of four, then four of eight.
pub(super) fn transform(mut points: [Point; POINTS]) -> [Point; POINTS] {
    let (rows, _) = points.as_chunks_mut::<8>();
    if let [a, b, c, d] = rows {
        let columns = a.iter_mut().zip(b).zip(c).zip(d).zip(&FACTORS);
        for ((((a, b), c), d), factors) in columns {
            let [zero, one, two, three] = four([*a, *b, *c, *d]);
            *a = zero.map(|part| part >> 1);
            for (place, value, factor) in
                [(b, one, &factors[0]), (c, two, &factors[1]), (d, three, &factors[2])]
            {
                *place = turn(value, factor);
            }
        }
    }
    let mut bins = [[0; 2]; POINTS];
    for (row, points) in points.as_chunks::<8>().0.iter().enumerate() {
        for (bin, value) in bins.iter_mut().skip(row).step_by(4).zip(eight(points)) {
            *bin = value;
        }
    }
    bins
}

fn plus(a: Point, b: Point) -> Point {
    [a[0].wrapping_add(b[0]), a[1].wrapping_add(b[1])]
}

fn minus(a: Point, b: Point) -> Point {
    [a[0].wrapping_sub(b[0]), a[1].wrapping_sub(b[1])]
}

/// A number times -j.
fn back([re, im]: Point) -> Point {
    [im, re.wrapping_neg()]
}

/// The transform of four points.
fn four([a, b, c, d]: [Point; 4]) -> [Point; 4] {
    let (even, odd) = (plus(a, c), plus(b, d));
    let (lean, bend) = (minus(a, c), back(minus(b, d)));
    [plus(even, odd), plus(lean, bend), minus(even, odd), minus(lean, bend)]
}

/// The transform of eight points.
fn eight(&[a, b, c, d, e, f, g, h]: &[Point; 8]) -> [Point; 8] {
    let even = four([a, c, e, g]);
    let [zero, one, two, three] = four([b, d, f, h]);
    // Times an odd eighth of a turn: half the product, rounded, twice.
    let eighth = |[re, im]: Point| {
        [re.wrapping_add(im), im.wrapping_sub(re)].map(|part| half(part, DIAGONAL).wrapping_mul(2))
    };
    let odd = [zero, eighth(one), back(two), back(eighth(three))];
    let [p, q, r, s] = even;
    let [t, u, v, w] = odd;
    [
        plus(p, t),
        plus(q, u),
        plus(r, v),
        plus(s, w),
        minus(p, t),
        minus(q, u),
        minus(r, v),
        minus(s, w),
    ]
}

/// `x w / 2` for w in Q31, rounded to the nearest.
fn half(x: i32, w: i32) -> i32 {
    ((i64::from(x) * i64::from(w) + HALF) >> 32) as i32
}

/// Half of x turned by a factor; both products are rounded.
fn turn([re, im]: Point, &[cos, sin]: &Point) -> Point {
    // The instruction rounds the negated product, so this line does, too.
    let less = ((HALF - i64::from(im) * i64::from(sin)) >> 32) as i32;
    [half(re, cos).wrapping_add(less), half(re, sin).wrapping_add(half(im, cos))]
}

const HALF: i64 = 1 << 31;

/// `sqrt(1/2)` in Q31.
pub(super) const DIAGONAL: i32 = q31(core::f64::consts::FRAC_1_SQRT_2);

/// `exp(-j 2 pi k b / 32)` in Q31, for b = 0..8 and k = 1, 2, 3.
pub(super) static FACTORS: [[Point; 3]; 8] = factors();

// Const functions cannot use `get_mut`; an index out of range would be a compile error.
#[allow(clippy::indexing_slicing)]
const fn factors() -> [[Point; 3]; 8] {
    let mut table = [[[0; 2]; 3]; 8];
    let mut b = 0;
    while b < 8 {
        let mut k = 1;
        while k < 4 {
            let (sin, cos) = sin_cos(k * b, POINTS);
            table[b][k - 1] = [q31(cos), q31(-sin)];
            k += 1;
        }
        b += 1;
    }
    table
}

/// Rounds to the nearest. 1 becomes one step less, because 32 bits do not hold it.
const fn q31(x: f64) -> i32 {
    let scaled = x * 2_147_483_648.0;
    // The cast saturates.
    (if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 }) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acquire::sample::{Iq, Real};
    use crate::math::scalar::Scalar;
    use num_complex::Complex;

    /// The definition in the module's text, in f64.
    fn exact<const N: usize>(x: &[Complex<f64>], centre: i32, i: i32) -> Complex<f64> {
        let length = N / POINTS;
        let mut sum = Complex::new(0.0, 0.0);
        for (index, x) in x.iter().enumerate() {
            let (m, n) = (index / length, index % length);
            let turns = f64::from(centre) * n as f64 / N as f64
                + f64::from(centre + i) * m as f64 / POINTS as f64;
            sum += x * f64::unit(-turns.fract());
        }
        sum
    }

    fn check<R: Record, const N: usize>(centre: i32) {
        let tone = |n: usize| {
            let z = f64::unit((f64::from(centre) + 0.3) * n as f64 / N as f64 % 1.0) * 1900.0;
            Complex::new(z.re.round(), if R::IQ { z.im.round() } else { 0.0 })
        };
        let x: std::vec::Vec<_> = (0..N).map(tone).collect();
        let samples = core::array::from_fn(|n| R::from_parts([x[n].re as i16, x[n].im as i16]));
        let zoom = Oscillator::new(centre, Layout::of::<R, N>()).zoom::<R, N>(&samples);
        for i in -8..=8 {
            let [re, im] = zoom.bin(centre + i).map(f64::from);
            let got = Complex::new(re, im) * f64::from(zoom.unit());
            let error = (got - exact::<N>(&x, centre, i)).norm_sqr().sqrt();
            assert!(error < 1900.0 * N as f64 * 1e-4, "N {N}, centre {centre}, {i}: {error}");
        }
    }

    #[test]
    fn bins_are_those_of_the_definition() {
        for centre in [9, 20, 25] {
            check::<Real, 64>(centre);
            check::<Iq, 64>(centre);
        }
        for centre in [12, 100, 490] {
            check::<Real, 1024>(centre);
            check::<Iq, 1024>(-centre);
        }
        check::<Real, 4096>(1000);
        check::<Iq, 4096>(-1000);
    }

    #[test]
    fn rails_do_not_overflow() {
        let samples = [-32768i16; 4096];
        let zoom = Oscillator::new(16, Layout::of::<Real, 4096>()).zoom::<Real, 4096>(&samples);
        // Bin 0 holds the whole offset.
        let [re, im] = zoom.bin(0).map(|part| f64::from(part) * f64::from(zoom.unit()));
        assert!(re.hypot(im) > 8e7);
        // The strongest possible tone, at the centre.
        let strongest = core::array::from_fn(|n| {
            let z =
                f64::unit(100.0 * n as f64 / 1024.0 % 1.0) * 32767.0 * core::f64::consts::SQRT_2;
            [z.re, z.im].map(|part| part.round().clamp(-32768.0, 32767.0) as i16)
        });
        let zoom = Oscillator::new(100, Layout::of::<Iq, 1024>()).zoom::<Iq, 1024>(&strongest);
        let [re, im] = zoom.bin(100).map(|part| f64::from(part) * f64::from(zoom.unit()));
        assert!((re.hypot(im) / 1024.0 / 32767.0 - 1.22).abs() < 0.1, "{}", re.hypot(im));
    }
}
