//! The transform and the search on cores with the DSP extension. The loops are assembly, because a
//! radix-4 butterfly needs all fourteen registers and the compiler gives inline assembly twelve.
//! Each kernel equals its portable definition in [`super::integer`] and [`crate::spectrum::scan`]
//! bit for bit, on every input; the tests on emulated cores drive both. Only the search branches on
//! data: when a pair may hold the maximum.
//!
//! The functions are naked: they change only the registers and memory that their instructions name.
//! All save `r4` to `r11` and return by `pop`.

// This module is first because a macro is known only to the code after it.
#[macro_use]
mod butterfly;

pub(super) mod bins;
mod first;
mod passes;
#[cfg(not(mve))]
mod rails;

use super::integer::{self, DIAGONAL, Factors, Pair, Point, Scale};
#[cfg(mve)]
use super::kernel_mve::{
    bins::{span_above, span_below},
    rails::{all_outside, any_outside},
};
use super::twiddle::{FineTriple, Packed, Triple};
use crate::math::products::power;
use crate::spectrum::scan::{Scan, sure};
use bins::{Seen, fine_above, fine_below, pairs_outwards};
#[cfg(not(mve))]
use bins::{alone_above, alone_below, span_above, span_below};
use core::mem::MaybeUninit;
use core::ops::Range;
use first::{eights, fours};
use passes::{even, fine, long, near, short, short_finely};
#[cfg(not(mve))]
use rails::{all_outside, first_outside, first_strong};

/// The kernels for [`integer::transform`].
pub fn transform<const M: usize>(pairs: &[Pair], bits: u32, points: &mut [Point]) -> i32 {
    let scale = Scale::new(M, bits);
    if pairs.len() != M || points.len() != M {
        return scale.exponent;
    }
    first_pass::<M>(pairs, &scale, bits, points);
    let mut length = scale.first;
    while length < M {
        // SAFETY: `points` holds M points and `length` divides M; the tables hold the factors of M.
        unsafe {
            match integer::factors::<M>() {
                Factors::Short(table) => pass::<M>(points.as_mut_ptr(), length, table),
                Factors::Fine(table) => fine_pass::<M>(points.as_mut_ptr(), length, table),
            }
        }
        length *= 4;
    }
    scale.exponent
}

/// Codes that leave room for three additions in 16 bits are processed two at a time.
fn first_pass<const M: usize>(pairs: &[Pair], scale: &Scale, bits: u32, points: &mut [Point]) {
    let (from, to) = (pairs.as_ptr(), points.as_mut_ptr());
    // One shifted up must fit in half a word.
    let (narrow, one) = (bits <= 13 && scale.shift <= 14, 1u32.wrapping_shl(scale.shift));
    // SAFETY: both slices hold M elements, and a kernel for M reads and writes M.
    unsafe {
        match scale.first {
            8 if narrow => eights::<M>(from, to, DIAGONAL << scale.shift, one),
            4 if narrow && M <= 1024 => fours::<M>(from, to, one),
            _ => integer::first_pass::<M>(pairs, scale, bits, points),
        }
    }
}

/// A radix-4 pass over sub-transforms of `length` points.
///
/// # Safety
/// `points` must be M points. `table` must be the factors of M or of a shorter transform of at
/// least 4 `length` points. `length` must be a power of two of at most M/4.
unsafe fn pass<const M: usize>(points: *mut Point, length: usize, table: &[Triple]) {
    let leg = length * size_of::<Point>();
    let blocks = M / 4 / length.max(1);
    let stride = table.len() / length.max(1) * size_of::<Triple>();
    let table = table.as_ptr();
    // SAFETY: the caller guarantees it; the blocks of 4 `length` points fill M points.
    unsafe {
        let end = points.add(M);
        match (length, blocks) {
            // With at least four blocks, the factors stay in registers over all of them. M decides
            // which lengths occur after the first pass, so an image for one length holds no other
            // kernels.
            (4, 2..) if const { is_even(M) } => short::<4>(points, end, table, stride),
            (8, 2..) if const { !is_even(M) } => short::<8>(points, end, table, stride),
            (16, 2..) if const { is_even(M) } => short::<16>(points, end, table, stride),
            _ => {
                let mut block = points;
                while block < end {
                    match (length, blocks) {
                        (32, 1) if const { M == 128 } => near::<1>(block, table),
                        (32, _) if const { M == 512 } => near::<4>(block, table),
                        _ if const { M == 512 } => even(block, table),
                        (_, 1) => long::<1>(block, leg, table),
                        _ => long::<4>(block, leg, table),
                    }
                    block = block.add(4 * length);
                }
            }
        }
    }
}

/// Whether the first pass of an `m`-point transform is of radix 4.
const fn is_even(m: usize) -> bool {
    Scale::new(m, 12).first == 4
}

/// [`pass`] with factors of 32 bits.
///
/// # Safety
/// The conditions of [`pass`].
unsafe fn fine_pass<const M: usize>(points: *mut Point, length: usize, table: &[FineTriple]) {
    let leg = length * size_of::<Point>();
    let stride = table.len() / length.max(1) * size_of::<FineTriple>();
    // SAFETY: the caller guarantees it; the blocks of 4 `length` points fill M points.
    unsafe {
        let end = points.add(M);
        // Like `pass`, with at least four blocks.
        match length {
            4 if const { is_even(M) } => {
                return short_finely::<4>(points, end, table.as_ptr(), stride);
            }
            8 if const { !is_even(M) } => {
                return short_finely::<8>(points, end, table.as_ptr(), stride);
            }
            16 if const { is_even(M) } => {
                return short_finely::<16>(points, end, table.as_ptr(), stride);
            }
            _ => {}
        }
        let mut block = points;
        while block < end {
            fine(block, leg, table.as_ptr(), stride);
            block = block.add(4 * length);
        }
    }
}

/// The kernel for [`crate::spectrum::scan::real`].
pub fn scan(points: &[Point], table: &[Packed], outermost: usize) -> Scan {
    let middle = points.len() / 2;
    if table.len() < middle || !(1..=middle).contains(&outermost) {
        return Scan::from(middle);
    }
    let centre = points.get(middle).map_or(0, |&x| power(x));
    let mut seen =
        Seen { best: centre.max(sure(points, outermost)), total: centre, at: points.as_ptr() };
    // SAFETY: the pairs from middle-1 and middle+1 to `outermost` and its mirror lie inside `points`,
    // their factors inside `table`.
    unsafe {
        let start = points.as_ptr();
        seen.at = start.add(middle);
        let factors = table.as_ptr().add(middle - 1);
        pairs_outwards(&mut seen, start.add(outermost - 1), start.add(middle), factors);
    }
    let bin = (seen.at as usize).wrapping_sub(points.as_ptr() as usize) / size_of::<Point>();
    Scan { power: seen.best, total: seen.total, ..Scan::from(bin) }
}

/// The kernel for `pairs::alone` of the bins of [`integer::window`].
#[cfg(not(mve))]
pub fn alone(points: &[Point], table: &[Packed], bins: Range<usize>) -> Scan {
    let (length, middle) = (points.len(), points.len() / 2);
    let Range { start: first, end } = bins;
    if first < 1 || first >= end || end > length || table.len() < middle {
        return Scan::from(first);
    }
    let (from, factors) = (points.as_ptr(), table.as_ptr());
    let mut seen = Seen { best: 0, total: 0, at: from.wrapping_add(first + 1) };
    // SAFETY: the bins lie within 1..length, and so do their mirrors. The factor of each lies before the
    // middle.
    unsafe {
        let low = end.min(middle);
        if first < low {
            let (here, there) = (from.add(first), from.add(length - first));
            alone_below(&mut seen, here, there, factors.add(first), from.add(low));
        }
        if first <= middle && middle < end {
            let power = power(quarter(points));
            seen.total = seen.total.wrapping_add(power);
            if power > seen.best {
                (seen.best, seen.at) = (power, from.add(middle + 1));
            }
        }
        let high = first.max(middle + 1);
        if high < end {
            let mirror = length - high;
            let (here, there) = (from.add(high), from.add(mirror));
            alone_above(&mut seen, here, there, factors.add(mirror), from.add(end));
        }
    }
    let next = (seen.at as usize).wrapping_sub(from as usize) / size_of::<Point>();
    Scan { power: seen.best, total: seen.total, ..Scan::from(next.wrapping_sub(1)) }
}

/// The kernels for [`integer::window`].
pub fn window<'a>(
    points: &[Point],
    table: &[Packed],
    first: usize,
    places: &'a mut [MaybeUninit<Point>],
) -> &'a [Point] {
    let (length, middle) = (points.len(), points.len() / 2);
    if first < 1 || first.saturating_add(places.len()) > length || table.len() < middle {
        return &[];
    }
    let (from, factors) = (points.as_ptr(), table.as_ptr());
    let Range { start, end } = places.as_mut_ptr_range();
    let (mut to, end) = (start.cast::<Point>(), end.cast::<Point>());
    let mut next = first;
    // SAFETY: the bins from `first` on lie within 1..length, and so do their mirrors. Every place
    // is written: the bins below the middle, then the middle if it is among them, then the rest.
    // The factor of each lies before the middle.
    unsafe {
        if next < middle && to < end {
            let below = to.add(places.len().min(middle - next));
            span_below(from.add(next), from.add(length - next), factors.add(next), to, below);
            next += below.offset_from_unsigned(to);
            to = below;
        }
        if next == middle && to < end {
            to.write(quarter(points));
            next += 1;
            to = to.add(1);
        }
        if to < end {
            let mirror = length - next;
            span_above(from.add(next), from.add(mirror), factors.add(mirror), to, end);
        }
        places.assume_init_ref()
    }
}

/// Bin N/4, which needs no product. It is in few windows.
#[cold]
#[inline(never)]
fn quarter(points: &[Point]) -> Point {
    integer::split(points, &[], points.len() / 2)
}

/// The kernels for [`integer::window_finely`].
pub fn window_finely<'a>(
    points: &[Point],
    sines: &[i32],
    first: usize,
    places: &'a mut [MaybeUninit<Point>],
) -> &'a [Point] {
    let (length, middle) = (points.len(), points.len() / 2);
    if first < 1 || first.saturating_add(places.len()) > length || sines.len() <= middle {
        return &[];
    }
    let (from, sines) = (points.as_ptr(), sines.as_ptr());
    let Range { start, end } = places.as_mut_ptr_range();
    let (mut to, end) = (start.cast::<Point>(), end.cast::<Point>());
    let mut next = first;
    // SAFETY: as in `window`; the sines run from 0 to `middle`, and no bin is further from the middle.
    unsafe {
        if next < middle && to < end {
            let below = to.add(places.len().min(middle - next));
            let (here, there) = (from.add(next), from.add(length - next));
            fine_below(here, there, sines.add(next), sines.add(middle - next), to, below);
            next += below.offset_from_unsigned(to);
            to = below;
        }
        if next == middle && to < end {
            to.write(quarter(points));
            next += 1;
            to = to.add(1);
        }
        if to < end {
            let (here, there) = (from.add(next), from.add(length - next));
            fine_above(here, there, sines.add(next - middle), sines.add(length - next), to, end);
        }
        places.assume_init_ref()
    }
}

/// The number of parts of pairs that are at or beyond a rail. The kernel reads whole groups of eight pairs.
pub fn touching(pairs: &[Pair], low: i16, high: i16) -> u32 {
    // Codes with a smaller square are inside.
    #[cfg(not(mve))]
    let pairs = beyond_weak(pairs, i32::from(high.min(low.saturating_neg())));
    let both = |code: i16| u32::from(code as u16) * 0x1_0001;
    let (low, high) = (both(low.saturating_add(1)), both(high.saturating_sub(1)));
    let groups = pairs.as_chunks::<8>().0.as_ptr_range();
    if groups.is_empty() {
        return 0;
    }
    // SAFETY: the range is inside `pairs`, and not empty.
    unsafe {
        let (from, to) = (groups.start.cast(), groups.end.cast());
        #[cfg(not(mve))]
        let from = first_outside(from, to, low, high);
        #[cfg(mve)]
        let from = if any_outside(from, to, low, high) == 0 { to } else { from };
        if from == to { 0 } else { all_outside(from, to, low, high) }
    }
}

/// The pairs from the first group of 32 on that holds a pair whose squares add up to `least^2` or more.
#[cfg(not(mve))]
fn beyond_weak(pairs: &[Pair], least: i32) -> &[Pair] {
    let groups = pairs.as_chunks::<32>().0;
    if least < 1 || groups.is_empty() {
        return pairs;
    }
    let range = groups.as_ptr_range();
    // SAFETY: the range is inside `pairs`, and not empty; the result is in it, or its end.
    let weak = unsafe {
        let room = (i32::MAX - least * least).wrapping_add(1);
        let strong = first_strong(range.start.cast(), range.end.cast(), room);
        strong.cast::<Pair>().offset_from_unsigned(pairs.as_ptr())
    };
    pairs.get(weak..).unwrap_or_default()
}
