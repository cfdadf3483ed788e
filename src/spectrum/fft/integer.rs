//! The integer FFT: `i32` data, packed Q15 twiddles. This portable code is the definition of the
//! target's arithmetic; a faster kernel must equal it bit for bit.
//!
//! # Growth bound
//!
//! The first pass (radix 8 or 4) grows freely by 8 or 4. Every later radix-4 pass grows by at most 4 and
//! halves once: the product with a Q15 factor keeps the upper half, the untwiddled operand is
//! shifted. So a record grows by `g = 8 2^P` or `4 2^P` over `P` later passes, and codes of `B` signed
//! bits are shifted up first so that the largest part times `g` is `2^30`: by `31 - B - log2 g`.
//!
//! A part of a complex point is `sum(re cos + im sin)`, at most `4/pi` times the largest part for each
//! term, so no point exceeds `4/pi 2^30 < 2^31` after any pass. A real record of N samples has the
//! growth of N/2 points; after its split, a part of a bin is `sum(x cos)`, at most `2/pi 2^31`,
//! except at bins 0, N/4 and N/2, where it is a point's part (N/4) or a sum of two that reaches
//! 2^31 only for a record on the negative rail: those two saturate, by one count. Sums inside a butterfly
//! wrap, which is exact where the result fits. The tests drive every length with the extremes.
//!
//! # Precision
//!
//! The error is that of the Q15 factors; a product is floored to an integer, which lies 2^-12 or more below
//! a 12-bit code before the passes' scaling. The signal-to-error ratios are asserted in
//! `host-tests/tests/fft.rs`: at least 90 dB at N = 1024 for a full-scale line and for one at -40 dBFS.

use super::twiddle::{self, Packed, Triple};

type Point = [i32; 2];
type Pair = [i16; 2];

/// Transforms a real record given as `N/2` pairs of neighbouring samples of `bits` signed bits
/// (12..=16). Result: bins 1..N/2-1 in their cells, bins 0 and N/2 (both real) in cell 0.
/// Returns the exponent of the stored values: bin = cell x 2^exponent, in codes.
///
/// Lengths that do not fit `N` leave `points` as they are; the callers' types rule that out.
pub fn real<const N: usize>(pairs: &[Pair], bits: u32, points: &mut [Point]) -> i32 {
    let exponent = match N / 2 {
        32 => passes::<32>(pairs, bits, points),
        64 => passes::<64>(pairs, bits, points),
        128 => passes::<128>(pairs, bits, points),
        256 => passes::<256>(pairs, bits, points),
        512 => passes::<512>(pairs, bits, points),
        1024 => passes::<1024>(pairs, bits, points),
        _ => passes::<2048>(pairs, bits, points),
    };
    split(points, twiddle::splits(N));
    exponent
}

/// Transforms an I/Q record of `N` pairs; otherwise as [`real`]. Result: bins 0..N in their cells.
pub fn complex<const N: usize>(pairs: &[Pair], bits: u32, points: &mut [Point]) -> i32 {
    passes::<N>(pairs, bits, points)
}

/// An `M`-point complex transform, decimation in time. Returns the exponent.
fn passes<const M: usize>(pairs: &[Pair], bits: u32, points: &mut [Point]) -> i32 {
    let table = const { twiddle::passes(M) };
    let odd = !M.trailing_zeros().is_multiple_of(2);
    let first = if odd { 8 } else { 4 };
    let halvings = (M / first).trailing_zeros() / 2;
    let growth = if odd { 3 } else { 2 } + halvings;
    let shift = 31u32.saturating_sub(bits + growth).min(15);
    if odd {
        first8(pairs, shift, points);
    } else {
        first4(pairs, shift, points);
    }
    let mut length = first;
    while length < M {
        radix4(points, length, table, M / 4 / length);
        length *= 4;
    }
    halvings as i32 - shift as i32
}

/// The position, among `count = 4^d` groups, that the digits of `group` in base 4 read backwards.
fn reversed(group: usize, count: usize) -> usize {
    let bits = count.trailing_zeros();
    if bits == 0 {
        return 0;
    }
    let swapped = (group as u32).reverse_bits() >> (32 - bits);
    (((swapped & 0x5555_5555) << 1) | ((swapped >> 1) & 0x5555_5555)) as usize
}

/// First pass in groups of four: reads the record in digit-reversed order, no multiplications.
fn first4(pairs: &[Pair], shift: u32, points: &mut [Point]) {
    let quarter = pairs.len() / 4;
    for (group, out) in points.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let at = reversed(group, quarter);
        let x = |leg: usize| widen(pairs.get(at + leg * quarter), shift);
        *out = dft4(x(0), x(1), x(2), x(3));
    }
}

/// First pass in groups of eight. Only the four diagonal products are inexact.
fn first8(pairs: &[Pair], shift: u32, points: &mut [Point]) {
    let eighth = pairs.len() / 8;
    for (group, out) in points.as_chunks_mut::<8>().0.iter_mut().enumerate() {
        let at = reversed(group, eighth);
        let x = |leg: usize| widen(pairs.get(at + leg * eighth), 0);
        let [e0, e1, e2, e3] = dft4(x(0), x(2), x(4), x(6)).map(|e| up(e, shift));
        let [o0, o1, o2, o3] = dft4(x(1), x(3), x(5), x(7));
        let o0 = up(o0, shift);
        let o1 = [diagonal(o1[0] + o1[1], shift), diagonal(o1[1] - o1[0], shift)];
        let o2 = up([o2[1], -o2[0]], shift);
        let o3 = [diagonal(o3[1] - o3[0], shift), diagonal(o3[0] + o3[1], shift).wrapping_neg()];
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

/// A radix-4 pass over sub-transforms of `length` points; halves once. Its factors are every
/// `stride`-th of `table`.
fn radix4(points: &mut [Point], length: usize, table: &[Triple], stride: usize) {
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
            [*a, *b, *c, *d] = butterfly(half(*a), turn(*b, w1), turn(*c, w2), turn(*d, w3));
        }
    }
}

/// Splits the transform of `z = even + j odd` into that of the real record, in place.
///
/// With s = Z[k] + Z*[M-k] and d = Z[k] - Z*[M-k]: X[k] = s/2 - j d/2 exp(-j 2 pi k/N).
fn split(points: &mut [Point], table: &[Packed]) {
    let middle = points.len() / 2;
    if let Some(centre) = points.get_mut(middle) {
        // Bin N/4 needs no product: X = conj Z.
        centre[1] = centre[1].wrapping_neg();
    }
    let Some((first, rest)) = points.split_first_mut() else {
        return;
    };
    *first = [first[0].saturating_add(first[1]), first[0].saturating_sub(first[1])];
    let Some((low, high)) = rest.split_at_mut_checked(middle) else {
        return;
    };
    for ((p, q), &w) in low.iter_mut().zip(high.iter_mut().rev()).zip(table.iter().skip(1)) {
        [*p, *q] = split_pair(*p, *q, w);
    }
}

/// Bins k and M-k of a real record from the points k and M-k; `w` is `-cos | -sin << 16`.
#[inline(always)]
fn split_pair(p: Point, q: Point, w: Packed) -> [Point; 2] {
    let (er, ei) = (p[0].wrapping_add(q[0]), p[1].wrapping_sub(q[1]));
    let (dr, di) = (p[0].wrapping_sub(q[0]), p[1].wrapping_add(q[1]));
    let re = high(dr, w).wrapping_sub(low(di, w));
    let im = high(di, w).wrapping_add(low(dr, w));
    let (er, ei) = (er >> 1, ei >> 1);
    [[er.wrapping_add(re), ei.wrapping_add(im)], [er.wrapping_sub(re), im.wrapping_sub(ei)]]
}

/// The radix-4 butterfly of four points already turned and halved.
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

/// x (cos - j sin) / 2 by a factor packed `cos | -sin << 16`.
#[inline(always)]
fn turn(x: Point, w: Packed) -> Point {
    [low(x[0], w).wrapping_sub(high(x[1], w)), low(x[1], w).wrapping_add(high(x[0], w))]
}

/// x times the low Q15 half of `w`, halved and floored (SMULWB).
#[inline(always)]
fn low(x: i32, w: Packed) -> i32 {
    ((i64::from(x) * i64::from(w as i16)) >> 16) as i32
}

/// x times the high Q15 half of `w`, halved and floored (SMULWT).
#[inline(always)]
fn high(x: i32, w: Packed) -> i32 {
    ((i64::from(x) * i64::from((w >> 16) as i16)) >> 16) as i32
}

/// x times sqrt(1/2) in Q15, shifted up by `shift`.
#[inline(always)]
fn diagonal(x: i32, shift: u32) -> i32 {
    ((i64::from(x) * 23170) >> (15 - shift)) as i32
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
