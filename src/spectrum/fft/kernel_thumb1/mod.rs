//! The transform and the search on Armv6-M, which multiplies 32 bits by 32 to 32 and has eight
//! registers for most instructions. The loops are assembly: they split a number into halves once
//! for all its products, and keep constants and sums in the other registers. Each kernel equals its
//! portable definition in [`super::integer`] and [`crate::spectrum::scan`] bit for bit, for every
//! record.
//!
//! The functions are naked: they change only the registers and memory that their instructions name.

// This comes before its users. The caller owns r8 to r11, and only the low registers can be pushed
// and popped.
macro_rules! high_to_low {
    () => {
        "mov r4, r8
         mov r5, r9
         mov r6, r10
         mov r7, r11\n"
    };
}
macro_rules! low_to_high {
    () => {
        "mov r8, r4
         mov r9, r5
         mov r10, r6
         mov r11, r7\n"
    };
}

mod bins;
mod first;
mod passes;

use super::integer::{self, Factors, Pair, Point, Scale, split_pair};
use super::twiddle::{Packed, Triple};
use crate::math::products::power;
use crate::spectrum::scan::{SPARSE, Scan, worth};
use bins::{Outwards, pairs_outwards};
use first::eights;
use passes::pass;

pub(crate) use integer::{window, window_finely};

/// The kernels for [`integer::transform`].
pub fn transform<const M: usize>(pairs: &[Pair], bits: u32, points: &mut [Point]) -> i32 {
    let scale = Scale::new(M, bits);
    if pairs.len() != M || points.len() != M {
        return scale.exponent;
    }
    first_pass::<M>(pairs, &scale, bits, points);
    let mut length = scale.first;
    while length < M {
        match integer::factors::<M>() {
            Factors::Short(table) => {
                let stride = table.len() / length.max(1) * size_of::<Triple>();
                let range = points.as_mut_ptr_range();
                // SAFETY: `points` holds M points, and 4 `length` divides M; the table holds the
                // factors of 4 `length` or of a multiple.
                unsafe {
                    pass(
                        range.start,
                        range.end,
                        length * size_of::<Point>(),
                        table.as_ptr(),
                        stride,
                    )
                }
            }
            Factors::Fine(table) => {
                integer::radix4_finely(points, length, table, table.len() / length.max(1))
            }
        }
        length *= 4;
    }
    scale.exponent
}

/// Codes that leave room for seven additions in 16 bits are processed two at a time if they are
/// aligned to words; the core does not load unaligned ones.
fn first_pass<const M: usize>(pairs: &[Pair], scale: &Scale, bits: u32, points: &mut [Point]) {
    let (from, to) = (pairs.as_ptr(), points.as_mut_ptr());
    let fits = bits <= 13 && from.cast::<u32>().is_aligned();
    // SAFETY: both slices hold M elements, and a kernel for M reads and writes M. The kernel is selected by its built-in shift.
    unsafe {
        match scale.shift {
            14 if fits && const { shifts(M, 14) } => eights::<M, 14>(from, to),
            13 if fits && const { shifts(M, 13) } => eights::<M, 13>(from, to),
            12 if fits && const { shifts(M, 12) } => eights::<M, 12>(from, to),
            11 if fits && const { shifts(M, 11) } => eights::<M, 11>(from, to),
            _ => integer::first_pass::<M>(pairs, scale, bits, points),
        }
    }
}

/// Whether an `m`-point transform with a first pass of radix 8 shifts codes of 12 or 13 bits by `shift`. So an image links no kernel that
/// it cannot use.
const fn shifts(m: usize, shift: u32) -> bool {
    let [short, long] = [Scale::new(m, 12), Scale::new(m, 13)];
    short.first == 8 && (short.shift == shift || long.shift == shift)
}

/// The kernel for [`crate::spectrum::scan::real`].
///
/// It adds up the powers of pairs, and stops after a pair that may hold the strongest bin.
pub fn scan(points: &[Point], table: &[Packed], outermost: usize) -> Scan {
    let middle = points.len() / 2;
    let mut scan = Scan::from(middle);
    if middle == 0 || table.len() < middle {
        return scan;
    }
    scan.see(middle, points.get(middle).map_or(0, |&x| power(x)));
    let sure = sure(points, outermost);
    let mut state = Outwards::new(points, outermost);
    loop {
        state.least = worth(scan.power.max(sure));
        // SAFETY: the state holds all points.
        let found = unsafe { pairs_outwards(&mut state) };
        let Some((lower, upper)) = found.then(|| state.last(points)) else {
            break;
        };
        let pair = points.get(lower).zip(points.get(upper)).zip(table.get(lower));
        if let Some(((&p, &q), &w)) = pair {
            scan.split(lower, points.len(), split_pair(p, q, w));
        }
    }
    Scan { total: scan.total.wrapping_add(state.total), ..scan }
}

/// The bound of `scan::sure`, from the largest part of some of the pairs of points, because a power is slow here. The strongest bin has at
/// least half the square of a part, less the rounding of factors and products.
fn sure(points: &[Point], outermost: usize) -> u64 {
    let size = |part: i32| (part ^ (part >> 31)) as u32;
    let mut most = 0;
    let first = outermost.max(1).div_ceil(SPARSE) * SPARSE;
    for lower in (first..points.len() / 2).step_by(SPARSE) {
        for k in [lower, points.len().wrapping_sub(lower)] {
            if let Some(&[re, im]) = points.get(k) {
                most = most.max(size(re)).max(size(im));
            }
        }
    }
    let part = (most - (most >> 12)).saturating_sub(6);
    power([part as i32, 0]) >> 1
}
