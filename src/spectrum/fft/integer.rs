//! The integer FFT: `i32` data and packed Q15 twiddles; transforms of 2048 points and more have Q31
//! twiddles. This portable code defines the target's arithmetic. The
//! kernels of `kernel_dsp` and `kernel_thumb1` equal it bit for bit.
//!
//! A real record of N samples is transformed as N/2 pairs. Its bins are split from the result when
//! they are read ([`Spectrum::bin`](crate::spectrum::Spectrum::bin)), and never stored.
//!
//! # Growth bound
//!
//! The first pass (radix 8 or 4) grows by 8 or 4. Every later radix-4 pass grows by at most 4 and
//! halves once: the product with a factor keeps the upper half, and the operand without a factor is
//! shifted. So a record grows by `g = 8 2^P` or `4 2^P` over `P` later passes. Codes of `B` signed
//! bits are first shifted up by `31 - B - log2 g` bits, so that the largest part times `g` is
//! `2^30`.
//!
//! A part of a complex point is `sum(re cos + im sin)`, at most `4/pi` times the largest part for each term, so no point exceeds
//! `4/pi 2^30 < 2^31` after any pass. A real record of N samples grows as N/2 points do. After its split, a part of a bin is `sum(x cos)`,
//! at most `2/pi 2^31`. Bins 0, N/4 and N/2 are exceptions. Bin N/4 is a point's part. Bins 0 and N/2 are sums of two such parts, which
//! reach 2^31 only for a record on the negative rail; they saturate, by one count. Sums inside a butterfly wrap, which is exact if the
//! result fits. The tests drive every length with the extremes.
//!
//! # Precision
//!
//! The factors cause the error. With Q15 factors a bin has the relative error of its passes, 5e-6 each. This error is equal in every record
//! of a tone, so averaging does not remove it: at 60 dB it would move a tone by .17 sigma (real) and .23 sigma (I/Q) at N = 4096. So
//! transforms of 2048 points and more have Q31 factors in every pass, and bins of real records of 4096 samples are split by Q31 factors
//! ([`twiddle::sines`]); only the search, which compares powers, has Q15 there. The factor sqrt(1/2) of the first pass has an error of 1e-6
//! at every length. A product is floored to an integer, which lies 2^-12 or more below a 12-bit code before the passes' scaling.
//!
//! `host-tests/tests/fft.rs` asserts the signal-to-error ratios: at least 90 dB at N = 1024 for a
//! full-scale line and for one at -40 dBFS. `host-tests/tests/least_squares.rs` asserts that less
//! than .08 sigma is left at N = 4096.

use super::twiddle::{self, Fine, FineTriple, Packed, Triple};
use core::mem::MaybeUninit;
use core::ops::Range;

/// A complex value, real part first.
pub type Point = [i32; 2];
/// Two codes: a sample and its quadrature, or two neighbouring real samples.
pub type Pair = [i16; 2];

/// The scaling of codes of `bits` signed bits (12..=16) in an `M`-point transform.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// The radix of the first pass: 8 or 4.
    pub first: usize,
    /// The number of bits by which the codes are shifted up.
    pub shift: u32,
    /// The exponent: a stored value times `2^exponent` is in codes.
    pub exponent: i32,
}

impl Scale {
    /// The scale of a transform of `m` points, 32 to 4096.
    pub const fn new(m: usize, bits: u32) -> Self {
        let odd = !m.trailing_zeros().is_multiple_of(2);
        let first = if odd { 8 } else { 4 };
        let halvings = (m / first).trailing_zeros() / 2;
        let growth = if odd { 3 } else { 2 } + halvings;
        let room = 31u32.saturating_sub(bits + growth);
        let shift = if room < 15 { room } else { 15 };
        Scale { first, shift, exponent: halvings as i32 - shift as i32 }
    }
}

/// An `M`-point complex transform, decimation in time, of `M` pairs of samples of `bits` signed
/// bits (12..=16). Returns the exponent of the stored values.
///
/// Slices that do not hold `M` elements leave `points` unchanged; the callers' types rule such slices out.
pub fn transform<const M: usize>(pairs: &[Pair], bits: u32, points: &mut [Point]) -> i32 {
    let scale = Scale::new(M, bits);
    first_pass::<M>(pairs, &scale, bits, points);
    let mut length = scale.first;
    while length < M {
        match factors::<M>() {
            Factors::Short(table) => radix4(points, length, table, table.len() / length.max(1)),
            Factors::Fine(table) => {
                radix4_finely(points, length, table, table.len() / length.max(1))
            }
        }
        length *= 4;
    }
    scale.exponent
}

/// The error in bins that this transform and the fit's `f32` add to the frequency of a strong line in a record of `n` samples, see
/// [`View::error`](crate::spectrum::view::View::error).
pub(crate) const fn error(n: usize, iq: bool) -> f32 {
    match (n, iq) {
        // Transforms of 2,048 points and more have factors of 32 bits.
        (4096, true) => 7.7e-8,
        (4096, false) | (2048, true) => 1.2e-7,
        (2048, false) => 1.85e-6,
        (_, false) => 1.7e-6,
        (_, true) => 1.6e-6,
    }
}

/// The factors of a transform, of 16 or of 32 bits.
pub(super) enum Factors {
    Short(&'static [Triple]),
    Fine(&'static [FineTriple]),
}

/// The factors of an M-point transform. Every pass takes them from one table.
pub(super) const fn factors<const M: usize>() -> Factors {
    let fine = const { twiddle::fine_passes(M) };
    if fine.is_empty() { Factors::Short(const { twiddle::passes(M) }) } else { Factors::Fine(fine) }
}

/// The first pass, of radix 4 or 8.
pub(super) fn first_pass<const M: usize>(
    pairs: &[Pair],
    scale: &Scale,
    bits: u32,
    points: &mut [Point],
) {
    // The compiler knows an array's length, so it checks no index below.
    let Ok(pairs) = <&[Pair; M]>::try_from(pairs) else {
        return;
    };
    match scale.first {
        8 if bits <= 13 => first8::<M, true>(pairs, scale.shift, points),
        8 => first8::<M, false>(pairs, scale.shift, points),
        _ => first4(pairs, scale.shift, points),
    }
}

/// The position of `group` among `count = 4^d` groups: its digits in base 4, reversed.
pub fn reversed(group: usize, count: usize) -> usize {
    let bits = count.trailing_zeros();
    if bits == 0 {
        return 0;
    }
    let swapped = (group as u32).reverse_bits() >> (32 - bits);
    (((swapped & 0x5555_5555) << 1) | ((swapped >> 1) & 0x5555_5555)) as usize
}

/// First pass in groups of four. It reads the record in digit-reversed order and multiplies
/// nothing.
fn first4<const M: usize>(pairs: &[Pair; M], shift: u32, points: &mut [Point]) {
    let quarter = M / 4;
    for (group, out) in points.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let at = reversed(group, quarter) & (quarter - 1);
        let x = |leg: usize| widen(pairs.get(at + leg * quarter), shift);
        *out = dft4(x(0), x(1), x(2), x(3));
    }
}

/// First pass in groups of eight. Only the four diagonal products are inexact.
///
/// `NARROW` is true if the codes have at most 13 bits, so that the diagonal products fit in 32.
fn first8<const M: usize, const NARROW: bool>(pairs: &[Pair; M], shift: u32, points: &mut [Point]) {
    let eighth = M / 8;
    for (group, out) in points.as_chunks_mut::<8>().0.iter_mut().enumerate() {
        let at = reversed(group, eighth) & (eighth - 1);
        let x = |leg: usize| widen(pairs.get(at + leg * eighth), 0);
        let [e0, e1, e2, e3] = dft4(x(0), x(2), x(4), x(6)).map(|e| up(e, shift));
        let [o0, [a, b], o2, [c, d]] = dft4(x(1), x(3), x(5), x(7));
        let (o0, o2) = (up(o0, shift), up([o2[1], -o2[0]], shift));
        let diagonal = |x: i32| diagonal::<NARROW>(x, shift);
        let (o1, o3) = ([diagonal(a + b), diagonal(b - a)], [diagonal(d - c), -diagonal(c + d)]);
        *out = [
            add(e0, o0),
            add(e1, o1),
            add(e2, o2),
            add(e3, o3),
            sub(e0, o0),
            sub(e1, o1),
            sub(e2, o2),
            sub(e3, o3),
        ];
    }
}

/// Defines a radix-4 pass over sub-transforms of `length` points, which halves once. Its factors are every `stride`-th of `table`. A macro
/// instead of a generic function, because the compiler makes a pass of the latter that is a tenth slower on the M3.
macro_rules! radix4 {
    ($name:ident, $triple:ty, $turn:ident) => {
        pub(super) fn $name(points: &mut [Point], length: usize, table: &[$triple], stride: usize) {
            let mut rest = points;
            while let Some((block, tail)) = rest.split_at_mut_checked(4 * length) {
                rest = tail;
                let Some((low, high)) = block.split_at_mut_checked(2 * length) else {
                    return;
                };
                let Some((a, b)) = low.split_at_mut_checked(length) else {
                    return;
                };
                let Some((c, d)) = high.split_at_mut_checked(length) else {
                    return;
                };
                let mut legs = a.iter_mut().zip(b).zip(c.iter_mut().zip(d));
                if let Some(((a, b), (c, d))) = legs.next() {
                    [*a, *b, *c, *d] = butterfly(half(*a), half(*b), half(*c), half(*d));
                }
                let mut index = stride;
                for ((a, b), (c, d)) in legs {
                    let Some(&[w1, w2, w3]) = table.get(index) else {
                        return;
                    };
                    index += stride;
                    [*a, *b, *c, *d] =
                        butterfly(half(*a), $turn(*b, w1), $turn(*c, w2), $turn(*d, w3));
                }
            }
        }
    };
}

radix4!(radix4, Triple, turn);
radix4!(radix4_finely, FineTriple, turn_finely);

/// Bin `k`, 0..=M, of a real record. `points` are the M points of its transform as pairs, `table`
/// is [`twiddle::splits`].
///
/// With s = Z[k] + Z*[M-k] and d = Z[k] - Z*[M-k]: X[k] = s/2 - j d/2 exp(-j 2 pi k/N).
#[inline]
pub(crate) fn split(points: &[Point], table: &[Packed], k: usize) -> Point {
    let (length, middle) = (points.len(), points.len() / 2);
    let mirror = length.wrapping_sub(k);
    if k == 0 || mirror == 0 {
        // Bins 0 and N/2 are real.
        let Some(&[re, im]) = points.first() else {
            return [0; 2];
        };
        return [if k == 0 { re.saturating_add(im) } else { re.saturating_sub(im) }, 0];
    }
    let (Some(&here), Some(&there)) = (points.get(k), points.get(mirror)) else {
        return [0; 2];
    };
    if k == middle {
        // Bin N/4 needs no product: X = conj Z.
        return [here[0], here[1].wrapping_neg()];
    }
    let factor = |k: usize| table.get(k).copied().unwrap_or(0);
    if k < middle {
        split_pair(here, there, factor(k))[0]
    } else {
        split_pair(there, here, factor(mirror))[1]
    }
}

/// [`split`] with factors of 32 bits; `sines` is [`twiddle::sines`].
#[inline]
pub(crate) fn split_finely(points: &[Point], sines: &[i32], k: usize) -> Point {
    let (mirror, middle) = (points.len().wrapping_sub(k), points.len() / 2);
    if k == 0 || k == middle || mirror == 0 {
        // Bins 0, N/4 and N/2 need no factor.
        return split(points, &[], k);
    }
    let (Some(&here), Some(&there)) = (points.get(k), points.get(mirror)) else {
        return [0; 2];
    };
    let sine = |k: usize| sines.get(k).copied().unwrap_or(0);
    // The cosine is the sine of the complement to a quarter of a turn, or of the excess over it.
    if k < middle {
        split_here(here, there, [sine(middle.wrapping_sub(k)), sine(k)])
    } else {
        split_here(here, there, [sine(k.wrapping_sub(middle)).wrapping_neg(), sine(mirror)])
    }
}

/// [`window`] with factors of 32 bits; `sines` is [`twiddle::sines`].
#[cfg_attr(dsp, allow(dead_code))]
pub(crate) fn window_finely<'a>(
    points: &[Point],
    sines: &[i32],
    first: usize,
    places: &'a mut [MaybeUninit<Point>],
) -> &'a [Point] {
    filled(places, (first..).map(|k| split_finely(points, sines, k)))
}

/// The bins from `first` on, all within 1..M, equal to [`split`] of each.
#[cfg_attr(dsp, allow(dead_code))]
pub(crate) fn window<'a>(
    points: &[Point],
    table: &[Packed],
    first: usize,
    places: &'a mut [MaybeUninit<Point>],
) -> &'a [Point] {
    let (length, middle) = (points.len(), points.len() / 2);
    let last = first.saturating_add(places.len());
    if first >= 1 && last <= length {
        // The bins on one side of the middle come from pairs in sequence.
        let (low, near, far) = (last <= middle, first..last, length + 1 - last..length + 1 - first);
        let (near, mirrored) = if low { (near, far) } else { (far, near) };
        let pairs = points.get(near.clone()).zip(points.get(mirrored)).zip(table.get(near));
        if let Some(((near, mirrored), table)) = pairs {
            if low {
                let pairs = near.iter().zip(mirrored.iter().rev()).zip(table);
                return filled(places, pairs.map(|((&p, &q), &w)| split_pair(p, q, w)[0]));
            }
            if first > middle {
                let pairs = near.iter().rev().zip(mirrored).zip(table.iter().rev());
                return filled(places, pairs.map(|((&p, &q), &w)| split_pair(p, q, w)[1]));
            }
        }
    }
    filled(places, (first..).map(|k| split(points, table, k)))
}

/// Fills `places` from an iterator and returns the places it filled.
#[inline(always)]
pub(crate) fn filled(
    places: &mut [MaybeUninit<Point>],
    bins: impl Iterator<Item = Point>,
) -> &mut [Point] {
    let mut count = 0;
    for (place, bin) in places.iter_mut().zip(bins) {
        place.write(bin);
        count += 1;
    }
    let written = places.get_mut(..count).unwrap_or_default();
    // SAFETY: this many places were written.
    unsafe { written.assume_init_mut() }
}

/// Fills `places` from its middle: `row` fills the places of the range, and each other place is `other` of its index and of the row.
/// Returns `None` if `row` does not fill the whole range.
#[inline(always)]
pub(crate) fn filled_from_middle(
    places: &mut [MaybeUninit<Point>],
    middle: Range<usize>,
    row: impl FnOnce(&mut [MaybeUninit<Point>]) -> &[Point],
    other: impl Fn(usize, &[Point]) -> Point,
) -> Option<&[Point]> {
    let (lower, rest) = places.split_at_mut_checked(middle.start)?;
    let (within, upper) = rest.split_at_mut_checked(middle.len())?;
    let start = within.as_ptr().cast::<Point>();
    let row = row(within);
    if row.len() != middle.len() || row.as_ptr() != start {
        return None;
    }
    filled(lower, (0..).map(|place| other(place, row)));
    filled(upper, (middle.end..).map(|place| other(place, row)));
    // SAFETY: all three parts were written.
    Some(unsafe { places.assume_init_ref() })
}

/// Bins k and M-k of a real record from points k and M-k; `w` is `-cos | -sin << 16`.
#[inline(always)]
pub(crate) fn split_pair(p: Point, q: Point, w: Packed) -> [Point; 2] {
    let (er, ei) = (p[0].wrapping_add(q[0]), p[1].wrapping_sub(q[1]));
    let (dr, di) = (p[0].wrapping_sub(q[0]), p[1].wrapping_add(q[1]));
    let re = high(dr, w).wrapping_sub(low(di, w));
    let im = high(di, w).wrapping_add(low(dr, w));
    let (er, ei) = (er >> 1, ei >> 1);
    [[er.wrapping_add(re), ei.wrapping_add(im)], [er.wrapping_sub(re), im.wrapping_sub(ei)]]
}

/// Bin k of a real record from points k and M-k, for `[cos, sin]` of `2 pi k / N`, by the formula of [`split_pair`]. Every product is
/// floored by itself.
#[inline(always)]
fn split_here(p: Point, q: Point, [cos, sin]: Fine) -> Point {
    let (er, ei) = (p[0].wrapping_add(q[0]), p[1].wrapping_sub(q[1]));
    let (dr, di) = (p[0].wrapping_sub(q[0]), p[1].wrapping_add(q[1]));
    let re = upper(di, cos).wrapping_add(upper_of_negative(dr, sin));
    let im = upper_of_negative(di, sin).wrapping_add(upper_of_negative(dr, cos));
    [(er >> 1).wrapping_add(re), (ei >> 1).wrapping_add(im)]
}

/// The radix-4 butterfly of four points, already turned and halved.
#[inline(always)]
fn butterfly(a: Point, b: Point, c: Point, d: Point) -> [Point; 4] {
    let (sum, difference) = (add(b, d), sub(b, d));
    let (even, odd) = (add(a, c), sub(a, c));
    [
        add(even, sum),
        [odd[0].wrapping_add(difference[1]), odd[1].wrapping_sub(difference[0])],
        sub(even, sum),
        [odd[0].wrapping_sub(difference[1]), odd[1].wrapping_add(difference[0])],
    ]
}

/// The four-point transform.
#[inline(always)]
fn dft4(a: Point, b: Point, c: Point, d: Point) -> [Point; 4] {
    butterfly(a, b, c, d)
}

/// x (cos - j sin) / 2, with the factor packed as `cos | -sin << 16`.
#[inline(always)]
fn turn(x: Point, w: Packed) -> Point {
    [low(x[0], w).wrapping_sub(high(x[1], w)), low(x[1], w).wrapping_add(high(x[0], w))]
}

/// x (cos - j sin) / 2, with a factor `[cos, sin]` of 32 bits (SMMUL, then SMMLA or SMMLS).
#[inline(always)]
fn turn_finely(x: Point, [cos, sin]: Fine) -> Point {
    [
        upper(x[0], cos).wrapping_add(upper(x[1], sin)),
        upper(x[1], cos).wrapping_add(upper_of_negative(x[0], sin)),
    ]
}

/// The upper word of a product, which is thereby floored (SMMUL).
#[inline(always)]
fn upper(x: i32, factor: i32) -> i32 {
    ((i64::from(x) * i64::from(factor)) >> 32) as i32
}

/// The upper word of a product's negative, floored, too: the addend of SMMLS.
#[inline(always)]
fn upper_of_negative(x: i32, factor: i32) -> i32 {
    ((i64::from(x) * i64::from(factor)).wrapping_neg() >> 32) as i32
}

/// x times the low Q15 half of `w`, halved and floored (SMULWB).
#[inline(always)]
fn low(x: i32, w: Packed) -> i32 {
    scaled(x, (w << 16) as i32)
}

/// x times the high Q15 half of `w`, halved and floored (SMULWT).
#[inline(always)]
fn high(x: i32, w: Packed) -> i32 {
    scaled(x, (w & 0xffff_0000) as i32)
}

/// x times a Q15 number in the upper half of a word, halved and floored: the upper word of the
/// product. A core without an instruction for that word takes two products of half the width.
#[inline(always)]
fn scaled(x: i32, factor: i32) -> i32 {
    if cfg!(short_products) {
        let factor = factor >> 16;
        let rest = (x & 0xffff).wrapping_mul(factor) >> 16;
        return (x >> 16).wrapping_mul(factor).wrapping_add(rest);
    }
    upper(x, factor)
}

/// sqrt(1/2) in units of 2^-16, within 1.1e-6. A sum of eight codes of 13 bits times this number fits in 32 bits.
pub const DIAGONAL: i32 = 46341;

/// x times [`DIAGONAL`], shifted up by `shift` and floored. Both ways give equal bits.
#[inline(always)]
fn diagonal<const NARROW: bool>(x: i32, shift: u32) -> i32 {
    if NARROW {
        return x.wrapping_mul(DIAGONAL) >> (16 - shift);
    }
    let x = x << (shift + 1);
    if cfg!(short_products) {
        // Both products fit: the first factor has 15 bits and a sign, the second 16.
        let rest = (x as u32 & 0xffff).wrapping_mul(DIAGONAL as u32) >> 16;
        return (x >> 16).wrapping_mul(DIAGONAL).wrapping_add(rest as i32) >> 1;
    }
    upper(x, DIAGONAL << 15)
}

#[inline(always)]
fn widen(pair: Option<&Pair>, shift: u32) -> Point {
    pair.map_or([0; 2], |p| up([i32::from(p[0]), i32::from(p[1])], shift))
}

#[inline(always)]
fn up(x: Point, shift: u32) -> Point {
    [x[0] << shift, x[1] << shift]
}

#[inline(always)]
fn half(x: Point) -> Point {
    [x[0] >> 1, x[1] >> 1]
}

#[inline(always)]
fn add(a: Point, b: Point) -> Point {
    [a[0].wrapping_add(b[0]), a[1].wrapping_add(b[1])]
}

#[inline(always)]
fn sub(a: Point, b: Point) -> Point {
    [a[0].wrapping_sub(b[0]), a[1].wrapping_sub(b[1])]
}
