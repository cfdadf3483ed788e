//! The factors of a pass, four of a kind in a vector, in the order in which the loop reads them.

use crate::spectrum::fft::twiddle::{Packed, factor};

/// The factors of four butterflies in a row: of legs 1, 3 and 2, each packed as `cos | -sin << 16`. The very first factor is 1, which no
/// loop reads.
pub(super) type Vectors = [[Packed; 4]; 3];

/// The legs in the order of [`Vectors`].
const LEGS: [usize; 3] = [1, 3, 2];

/// The factors of a pass over sub-transforms of `length` points: `exp(-j 2 pi q i / (4 length))`.
pub(super) const fn factors(length: usize) -> &'static [Vectors] {
    match length {
        4 => &OF_4,
        8 => &OF_8,
        16 => &OF_16,
        32 => &OF_32,
        64 => &OF_64,
        128 => &OF_128,
        256 => &OF_256,
        512 => &OF_512,
        1024 => &OF_1024,
        _ => &[],
    }
}

static OF_4: [Vectors; 1] = vectors();
static OF_8: [Vectors; 2] = vectors();
static OF_16: [Vectors; 4] = vectors();
static OF_32: [Vectors; 8] = vectors();
static OF_64: [Vectors; 16] = vectors();
static OF_128: [Vectors; 32] = vectors();
static OF_256: [Vectors; 64] = vectors();
static OF_512: [Vectors; 128] = vectors();
static OF_1024: [Vectors; 256] = vectors();

// Const functions cannot use `get_mut`. An index out of range would be a compile error.
#[allow(clippy::indexing_slicing)]
const fn vectors<const V: usize>() -> [Vectors; V] {
    let mut table = [[[0; 4]; 3]; V];
    let mut index = 0;
    while index < 4 * V {
        let mut leg = 0;
        while leg < 3 {
            table[index / 4][leg][index % 4] = factor(LEGS[leg] * index, 16 * V);
            leg += 1;
        }
        index += 1;
    }
    table
}
