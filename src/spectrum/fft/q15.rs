//! The 16-bit FFT: block floating point, packed Q15 twiddles, half the memory of
//! [`super::integer`]. This portable code is the definition; the kernels of `kernel_q15` and of
//! `kernel_mve::q15` equal it bit for bit.
//!
//! A record is shifted so that its strongest point just fills 12 bits. A pass of radix 8 or 4 and then
//! passes of radix 4 follow. Every later pass halves once, or twice if a part of its input needs
//! more than 14 bits. Products and halved sums are rounded to nearest.
//!
//! # Growth bound
//!
//! Let m be the largest `|z|` of all points z. The record is shifted so that m is at most 4090, or 4091.5 where shifting down rounds a code
//! and the centre. A first pass of radix 8 adds eight points: m is at most 32732. (A first pass of radix 4 takes points twice as large, and
//! adds four.) A later pass adds four points, each halved: m doubles. A pass doubles m only if every part was within -2^13..2^13, so that m
//! was at most 11585; otherwise the sums are halved again, and m stays. Rounding, and factors whose magnitude exceeds 1 by 2^-16, add less
//! than 4 a pass, and there are at most five passes. So `|z|` never exceeds 32752, nor does a sum of two halved points inside a butterfly,
//! and no part reaches 32767. Sums wrap, which is exact if the result fits.
//!
//! # Bins
//!
//! The stored points have 16 bits. A bin is split from them in 32 bits, ten bits finer
//! ([`FRACTION`]), so the split adds hardly any rounding of its own. A split bin is at most sqrt 2
//! times the larger of its two points, and all powers sum to less than `4096 2^30 2^20 = 2^62`.

use super::integer::Pair;
use super::twiddle::{self, Packed, Triple};
use crate::acquire::codes::Codes;

/// The number of bits by which a bin is finer than a stored point.
pub const FRACTION: u32 = 10;

/// The largest magnitude of a point that a first pass of radix 8 takes; a first pass of radix 4 takes twice this.
const LARGEST: u32 = 4090;

/// sqrt(1/2) in Q15.
pub(super) const DIAGONAL: i32 = 23170;

/// An `M`-point complex transform of `M` pairs of samples. Returns the exponent of the bins.
///
/// Slices that do not hold `M` elements leave `points` unchanged; the callers' types rule such slices out.
pub fn transform<const M: usize>(pairs: &[Pair], codes: Codes, points: &mut [Pair]) -> i32 {
    let shift = shift_of::<M>(pairs, codes);
    let mut large = first_pass::<M>(pairs, codes, shift, points);
    let table = const { twiddle::passes(M) };
    let (mut exponent, mut length) = (-shift, first_radix(M));
    while length < M {
        exponent += 1 + i32::from(large);
        large = radix4(points, length, table, table.len() / length.max(1), large);
        length *= 4;
    }
    exponent - FRACTION as i32
}

/// The radix of the first pass: 8 or 4.
pub(super) const fn first_radix(m: usize) -> usize {
    if m.trailing_zeros().is_multiple_of(2) { 4 } else { 8 }
}

/// The largest power of a point that the first pass takes.
pub(super) const fn allowed(m: usize) -> u32 {
    let largest = LARGEST * 8 / first_radix(m) as u32;
    largest * largest
}

/// The most bits by which a record is shifted up.
pub(super) const MOST: i32 = 11;

/// The number of bits by which a record is shifted up: the most that its strongest point allows. A negative number shifts down; narrow
/// codes never need a shift down.
pub(super) fn shift_of<const M: usize>(pairs: &[Pair], codes: Codes) -> i32 {
    shift::<M>(codes, strongest(pairs, codes))
}

/// [`shift_of`] of a record whose strongest point has this power.
#[inline(always)]
pub(super) fn shift<const M: usize>(codes: Codes, power: u32) -> i32 {
    let mut shift = if is_narrow(codes) { 0 } else { -4 };
    while shift < MOST && u64::from(power) << (2 * shift + 10) <= u64::from(allowed(M)) << 8 {
        shift += 1;
    }
    worthwhile::<M>(shift)
}

/// Whether a point of the farthest codes still fits without a shift down: two parts of 2892.
pub(super) const fn is_narrow(codes: Codes) -> bool {
    let low = codes.rails().0 as i32;
    codes.middle() as i32 - low <= 2892
}

/// `shift`, or one bit less if the last bit gains nothing: if four points are added, the pass after a shift by one bit would halve twice.
pub(super) const fn worthwhile<const M: usize>(shift: i32) -> i32 {
    if shift == 1 && first_radix(M) == 4 { 0 } else { shift }
}

/// The power of the strongest point about the centre.
fn strongest(pairs: &[Pair], codes: Codes) -> u32 {
    let square = |part: i16| u32::from(part.wrapping_sub(codes.middle()).unsigned_abs()).pow(2);
    pairs.iter().fold(0, |most, &[re, im]| most.max(square(re).wrapping_add(square(im))))
}

/// The first pass, of radix 4 or 8. Returns true if a part is large (see [`Large`]).
pub(super) fn first_pass<const M: usize>(
    pairs: &[Pair],
    codes: Codes,
    shift: i32,
    points: &mut [Pair],
) -> bool {
    // The compiler knows an array's length, so it checks no index below.
    let Ok(pairs) = <&[Pair; M]>::try_from(pairs) else {
        return false;
    };
    let centre = [first_centre::<M>(codes, shift); 2];
    let load = |at: usize| scaled(pairs.get(at).copied().unwrap_or_default(), shift);
    if first_radix(M) == 8 {
        first8::<M>(load, centre, points)
    } else {
        first4::<M>(load, centre, points)
    }
}

/// The centre of the first point of each group of the first pass. That point sums all codes of the
/// group and their centres; the other points are differences, without a centre.
pub(super) const fn first_centre<const M: usize>(codes: Codes, shift: i32) -> i16 {
    let middle = codes.middle() as i32;
    // Shifted as `scaled` shifts the codes.
    let middle = match shift {
        0.. => middle << shift,
        _ => {
            let down = if shift < -15 { 15 } else { -shift };
            (middle + (1 << (down - 1))) >> down
        }
    };
    // Sums wrap around, and so does the centre: their difference does not.
    (middle * first_radix(M) as i32) as i16
}

/// Whether there is a pass over sub-transforms of `length` points.
#[cfg_attr(not(dsp), allow(dead_code))]
pub(super) const fn has_pass(m: usize, length: usize) -> bool {
    let blocks = m / length / 4;
    length >= first_radix(m) && blocks >= 1 && blocks.trailing_zeros().is_multiple_of(2)
}

/// A pair shifted up, or shifted down and rounded.
#[inline(always)]
fn scaled(pair: Pair, shift: i32) -> Pair {
    if shift >= 0 {
        return pair.map(|part| part << shift);
    }
    let down = shift.unsigned_abs().min(15);
    pair.map(|part| ((i32::from(part) + (1 << (down - 1))) >> down) as i16)
}

fn first4<const M: usize>(load: impl Fn(usize) -> Pair, centre: Pair, points: &mut [Pair]) -> bool {
    let (quarter, mut large) = (M / 4, Large::default());
    for (group, out) in points.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let at = super::integer::reversed(group, quarter) & (quarter - 1);
        let x = |leg: usize| load(at + leg * quarter);
        let [y0, y1, y2, y3] = dft4(x(0), x(1), x(2), x(3));
        *out = [sub(y0, centre), y1, y2, y3];
        large.look(out);
    }
    large.seen()
}

/// Only the four diagonal products are inexact.
fn first8<const M: usize>(load: impl Fn(usize) -> Pair, centre: Pair, points: &mut [Pair]) -> bool {
    let (eighth, mut large) = (M / 8, Large::default());
    for (group, out) in points.as_chunks_mut::<8>().0.iter_mut().enumerate() {
        let at = super::integer::reversed(group, eighth) & (eighth - 1);
        let x = |leg: usize| load(at + leg * eighth);
        let [e0, e1, e2, e3] = dft4(x(0), x(2), x(4), x(6));
        let [o0, o1, o2, o3] = dft4(x(1), x(3), x(5), x(7));
        let (o1, o3) = (diagonal(o1), diagonal(o3));
        *out = [
            sub(add(e0, o0), centre),
            add(e1, o1),
            back(e2, o2),
            back(e3, o3),
            sub(e0, o0),
            sub(e1, o1),
            forward(e2, o2),
            forward(e3, o3),
        ];
        large.look(out);
    }
    large.seen()
}

/// A radix-4 pass over sub-transforms of `length` points, which halves once or twice. Its factors are every `stride`-th of `table`. Returns
/// true if a part of the result is large.
pub(super) fn radix4(
    points: &mut [Pair],
    length: usize,
    table: &[Triple],
    stride: usize,
    twice: bool,
) -> bool {
    let (mut rest, mut large) = (points, Large::default());
    while let Some((block, tail)) = rest.split_at_mut_checked(4 * length) {
        rest = tail;
        let Some((low, high)) = block.split_at_mut_checked(2 * length) else {
            return large.seen();
        };
        let Some((a, b)) = low.split_at_mut_checked(length) else {
            return large.seen();
        };
        let Some((c, d)) = high.split_at_mut_checked(length) else {
            return large.seen();
        };
        let mut legs = a.iter_mut().zip(b).zip(c.iter_mut().zip(d));
        let mut count = 0u32;
        let mut finish =
            |a: &mut Pair, b: &mut Pair, c: &mut Pair, d: &mut Pair, turned: [Pair; 3]| {
                let out = butterfly(*a, turned, twice, count & 2 == 0);
                count += 1;
                large.look(&out);
                [*a, *b, *c, *d] = out;
            };
        if let Some(((a, b), (c, d))) = legs.next() {
            let halved = [*b, *c, *d].map(|x| half(x, 1));
            finish(a, b, c, d, halved);
        }
        let mut index = stride;
        for ((a, b), (c, d)) in legs {
            let Some(&[w1, w2, w3]) = table.get(index) else {
                return large.seen();
            };
            index += stride;
            let turned = [turn(*b, w1), turn(*c, w2), turn(*d, w3)];
            finish(a, b, c, d, turned);
        }
    }
    large.seen()
}

/// The radix-4 butterfly of one point and three points already turned and halved.
///
/// The first point is rounded up twice, then down twice, and so on, and with it the sums that are halved again. With one rounding
/// direction, all these sums would be off by an eighth to a quarter on average. A constant over the bins is a pulse at the record's start;
/// a noise estimate under Hann's window does not see such a pulse, but a fit does.
#[inline(always)]
fn butterfly(a: Pair, [b, c, d]: [Pair; 3], twice: bool, first: bool) -> [Pair; 4] {
    let a = half(a, if first { 1 } else { second(twice) });
    let (sum, difference) = (add(b, d), sub(b, d));
    let (even, odd) = (add(a, c), sub(a, c));
    if !twice {
        return [add(even, sum), back(odd, difference), sub(even, sum), forward(odd, difference)];
    }
    let minus = |x: i16| -i32::from(x);
    let plus = |x: i16| i32::from(x);
    let mean = |x: Pair, y: [i32; 2]| {
        [(plus(x[0]) + y[0]) >> 1, (plus(x[1]) + y[1]) >> 1].map(|x| x as i16)
    };
    [
        mean(even, sum.map(plus)),
        mean(odd, [plus(difference[1]), minus(difference[0])]),
        mean(even, sum.map(minus)),
        mean(odd, [minus(difference[1]), plus(difference[0])]),
    ]
}

/// The rounding of the first point in every second pair of butterflies.
pub(super) const fn second(twice: bool) -> i32 {
    if twice { 2 } else { 0 }
}

/// The four-point transform.
#[inline(always)]
fn dft4(a: Pair, b: Pair, c: Pair, d: Pair) -> [Pair; 4] {
    let (sum, difference) = (add(b, d), sub(b, d));
    let (even, odd) = (add(a, c), sub(a, c));
    [add(even, sum), back(odd, difference), sub(even, sum), forward(odd, difference)]
}

/// x exp(-j pi/4), rounded.
#[inline(always)]
fn diagonal([re, im]: Pair) -> Pair {
    let (re, im) = (i32::from(re), i32::from(im));
    [((re + im) * DIAGONAL + 0x4000) >> 15, ((im - re) * DIAGONAL + 0x4000) >> 15].map(|x| x as i16)
}

/// x (cos - j sin) / 2, rounded, with the factor packed as `cos | -sin << 16`.
#[inline(always)]
fn turn([re, im]: Pair, w: Packed) -> Pair {
    let (re, im) = (i32::from(re), i32::from(im));
    let (cos, sin) = (i32::from(w as i16), w as i32 >> 16);
    let rounded = |x: i32| (x.wrapping_add(0x8000) >> 16) as i16;
    [rounded((re * cos).wrapping_sub(im * sin)), rounded((re * sin).wrapping_add(im * cos))]
}

#[inline(always)]
fn half(x: Pair, more: i32) -> Pair {
    x.map(|part| ((i32::from(part) + more) >> 1) as i16)
}

#[inline(always)]
fn add(a: Pair, b: Pair) -> Pair {
    [a[0].wrapping_add(b[0]), a[1].wrapping_add(b[1])]
}

#[inline(always)]
fn sub(a: Pair, b: Pair) -> Pair {
    [a[0].wrapping_sub(b[0]), a[1].wrapping_sub(b[1])]
}

/// a - j b
#[inline(always)]
fn back(a: Pair, b: Pair) -> Pair {
    [a[0].wrapping_add(b[1]), a[1].wrapping_sub(b[0])]
}

/// a + j b
#[inline(always)]
fn forward(a: Pair, b: Pair) -> Pair {
    [a[0].wrapping_sub(b[1]), a[1].wrapping_add(b[0])]
}

/// Whether a part has been outside -2^13..2^13.
#[derive(Default)]
struct Large(u16);

impl Large {
    #[inline(always)]
    fn look(&mut self, points: &[Pair]) {
        for part in points.as_flattened() {
            self.0 |= part.wrapping_add(1 << 13) as u16;
        }
    }

    const fn seen(&self) -> bool {
        self.0 >= 1 << 14
    }
}
