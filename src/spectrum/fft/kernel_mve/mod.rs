//! The transform and the search on cores with Helium, the vectors of M-profile cores (MVE with integers: Cortex-M55, M85). Each kernel
//! equals its portable definition in [`super::integer`] and [`crate::spectrum::scan`] bit for bit, on every input; the tests on an emulated
//! core drive both.
//!
//! `VMULH.S32` by a factor in the upper half of its lane is `SMULWB`: a vector holds four real parts or four imaginary ones. A factor 1 has
//! no path of its own. It is `2^31 - 1`, and for an odd x the upper word of `x (2^31 - 1)` is `x >> 1`. So every pass sets the lowest bit
//! of each number that the next pass multiplies by 1: only its half is read. Numbers that the next pass would only halve are halved in its
//! additions.
//!
//! The functions are naked: they change only the registers and memory that their instructions name. They leave no predicate and no loop
//! behind. An interrupt needs no care beyond the stacking of the FPU's registers, lazy or not, which holds the vectors' state, too: the
//! image `kernels` interrupts them everywhere by a handler that runs them.

/// Instructions, each with its own line end.
macro_rules! lines {
    ($($line:expr),* $(,)?) => { concat!($($line, "\n"),*) };
}

/// Saves the registers that a kernel may change.
macro_rules! enter {
    () => {
        "push {{r4-r12, lr}}\n vpush {{d8-d15}}\n"
    };
}

/// Returns.
macro_rules! leave {
    () => {
        "vpop {{d8-d15}}\n pop {{r4-r12, pc}}\n"
    };
}

pub mod bins;
mod factors;
#[macro_use]
mod first;
mod passes;
pub mod rails;
mod search;
mod wide;

pub use search::{alone, powers, scan, scan_iq};

use super::integer::{self, Pair, Point, Scale};
use super::twiddle::{self, Packed};

/// The kernels for [`integer::transform`].
pub fn transform<const M: usize>(pairs: &[Pair], bits: u32, points: &mut [Point]) -> i32 {
    let scale = Scale::new(M, bits);
    if pairs.len() != M || points.len() != M {
        return scale.exponent;
    }
    first_pass::<M>(pairs, &scale, bits, points);
    macro_rules! pass {
        ($($length:literal)*) => {$(
            if const { has_pass(M, $length) } {
                let (leg, blocks) = (size_of::<Point>() * $length, M / 4 / $length);
                // SAFETY: `points` are M points, the tables hold the factors of this length, and M has a pass of this length.
                unsafe {
                    if const { is_fine(M) } {
                        let table = const { factors::fine($length) };
                        passes::fine(points.as_mut_ptr(), leg, table.as_ptr(), blocks);
                    } else {
                        let table = const { factors::short($length) };
                        passes::short(points.as_mut_ptr(), leg, table.as_ptr(), blocks);
                    }
                }
            }
        )*};
    }
    pass!(4 8 16 32 64 128 256 512 1024);
    scale.exponent
}

/// Whether there is a pass over sub-transforms of `length` points.
const fn has_pass(m: usize, length: usize) -> bool {
    let (first, blocks) = (Scale::new(m, 12).first, m / length / 4);
    length >= first && blocks >= 1 && blocks.trailing_zeros().is_multiple_of(2)
}

/// Whether the passes have factors of 32 bits.
const fn is_fine(m: usize) -> bool {
    !twiddle::fine_passes(m).is_empty()
}

/// The first pass, with points in the form that [`passes`] takes.
fn first_pass<const M: usize>(pairs: &[Pair], scale: &Scale, bits: u32, points: &mut [Point]) {
    let (from, to) = (pairs.as_ptr(), points.as_mut_ptr());
    let places = const { first::places(M) }.as_ptr();
    // SAFETY: both slices hold M elements. Codes of at most 13 bits are shifted by 8 to 15. The table belongs to M.
    unsafe {
        match (scale.first, bits <= 13) {
            (8, true) if const { M > 32 } => first::eights(from, to, M, scale.shift, places),
            (8, false) if const { M > 32 } => wide::eights(from, to, M, scale.shift, places),
            (4, true) => first::fours(from, to, M, scale.shift, places),
            (4, false) => wide::fours(from, to, M, scale.shift, places),
            _ => {
                integer::first_pass::<M>(pairs, scale, bits, points);
                prepare(points, scale.first);
            }
        }
    }
}

/// Halves the groups that are a leg 0 of the next pass, and makes the first point of the others odd.
fn prepare(points: &mut [Point], group: usize) {
    for (index, group) in points.chunks_exact_mut(group.max(1)).enumerate() {
        if index % 4 == 0 {
            group.iter_mut().for_each(|point| *point = point.map(|part| part >> 1));
        } else if let Some(point) = group.first_mut() {
            *point = point.map(|part| part | 1);
        }
    }
}
