//! The factors of a pass, four of a kind in a vector, in the order in which the loop reads them.

use crate::spectrum::fft::twiddle::{q15, q31, sin_cos};

/// The factors of four butterflies in a row: cosine and sine of legs 1, 3 and 2.
///
/// A factor 1 is `2^31 - 1`, which halves an odd number exactly as a shift does: the passes leave the points that have this factor odd.
pub(super) type Vectors = [[i32; 4]; 6];

/// The legs in the order of [`Vectors`].
const LEGS: [usize; 3] = [1, 3, 2];
/// The factor 1.
const ONE: i32 = i32::MAX;

/// The factors of 16 bits, each in the upper half of its lane, of a pass over sub-transforms of
/// `length` points: `exp(-j 2 pi q i / (4 length))`, with the sine negated.
pub(super) const fn short(length: usize) -> &'static [Vectors] {
    match length {
        4 => &SHORT_4,
        8 => &SHORT_8,
        16 => &SHORT_16,
        32 => &SHORT_32,
        64 => &SHORT_64,
        128 => &SHORT_128,
        256 => &SHORT_256,
        _ => &[],
    }
}

/// The factors of 32 bits of a pass, in the order of [`short`], with the sine not negated.
pub(super) const fn fine(length: usize) -> &'static [Vectors] {
    match length {
        4 => &FINE_4,
        8 => &FINE_8,
        16 => &FINE_16,
        32 => &FINE_32,
        64 => &FINE_64,
        128 => &FINE_128,
        256 => &FINE_256,
        512 => &FINE_512,
        1024 => &FINE_1024,
        _ => &[],
    }
}

static SHORT_4: [Vectors; 1] = vectors::<1, false>();
static SHORT_8: [Vectors; 2] = vectors::<2, false>();
static SHORT_16: [Vectors; 4] = vectors::<4, false>();
static SHORT_32: [Vectors; 8] = vectors::<8, false>();
static SHORT_64: [Vectors; 16] = vectors::<16, false>();
static SHORT_128: [Vectors; 32] = vectors::<32, false>();
static SHORT_256: [Vectors; 64] = vectors::<64, false>();

static FINE_4: [Vectors; 1] = vectors::<1, true>();
static FINE_8: [Vectors; 2] = vectors::<2, true>();
static FINE_16: [Vectors; 4] = vectors::<4, true>();
static FINE_32: [Vectors; 8] = vectors::<8, true>();
static FINE_64: [Vectors; 16] = vectors::<16, true>();
static FINE_128: [Vectors; 32] = vectors::<32, true>();
static FINE_256: [Vectors; 64] = vectors::<64, true>();
static FINE_512: [Vectors; 128] = vectors::<128, true>();
static FINE_1024: [Vectors; 256] = vectors::<256, true>();

// Const functions cannot use `get_mut`. An index out of range would be a compile error.
#[allow(clippy::indexing_slicing)]
const fn vectors<const V: usize, const FINE: bool>() -> [Vectors; V] {
    let mut table = [[[0; 4]; 6]; V];
    let mut index = 0;
    while index < 4 * V {
        let mut leg = 0;
        while leg < 3 {
            let (sin, cos) = sin_cos(LEGS[leg] * index, 16 * V);
            let factor = match (index, FINE) {
                (0, _) => [ONE, 0],
                (_, true) => [q31(cos), q31(sin)],
                (_, false) => [(q15(cos) as i32) << 16, (q15(-sin) as i32) << 16],
            };
            table[index / 4][2 * leg][index % 4] = factor[0];
            table[index / 4][2 * leg + 1][index % 4] = factor[1];
            leg += 1;
        }
        index += 1;
    }
    table
}
