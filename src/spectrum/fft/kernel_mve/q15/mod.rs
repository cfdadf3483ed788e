//! The 16-bit transform and its search on cores with Helium. Each kernel equals its portable
//! definition in [`q15`] and [`q15_bins`](crate::spectrum::q15_bins) bit for bit.
//!
//! A vector holds four points as they are stored. `VQDMLSDH` and `VQDMLADHX` give the real and the imaginary part of their products,
//! doubled and floored: `floor(s / 2^15)` of a sum s of two products. Halved and rounded this becomes `floor((s + 2^15) / 2^16)`, a turned
//! point. Nothing saturates while no point exceeds 32752, which the growth bound guarantees for codes between the rails. Samples beyond the
//! rails go through the definition.
//!
//! The sticky flag QC tests the headroom: `VQSHL` by 2 sets it if a part is large.

mod bins;
mod factors;
mod first;
mod passes;
mod powers;
mod search;

pub use bins::window;
pub use powers::powers;
pub use search::{scan, scan_iq};

use crate::acquire::codes::Codes;
use crate::spectrum::fft::integer::Pair;
use crate::spectrum::fft::q15;

/// The kernels for [`q15::transform`].
pub fn transform<const M: usize>(pairs: &[Pair], codes: Codes, points: &mut [Pair]) -> i32 {
    let power = first::strongest(pairs, codes.middle());
    let fits = pairs.len() == M && points.len() == M && is_bounded::<M>(pairs, codes, power);
    if !fits || !is_aligned(points) {
        return q15::transform::<M>(pairs, codes, points);
    }
    let shift = q15::shift::<M>(codes, power);
    let mut large = first::pass::<M>(pairs, codes, shift, points);
    let mut exponent = -shift - q15::FRACTION as i32;
    macro_rules! pass {
        ($($length:literal)*) => {$(
            if const { q15::has_pass(M, $length) } {
                exponent += 1 + i32::from(large);
                // SAFETY: `points` are M aligned points, and M has a pass of this length.
                large = unsafe { passes::pass::<M, $length>(points.as_mut_ptr(), large) };
            }
        )*};
    }
    pass!(4 8 16 32 64 128 256 512 1024);
    let _ = large;
    exponent
}

/// Whether kernels can read and write these points as words.
pub fn is_aligned(points: &[Pair]) -> bool {
    points.as_ptr().cast::<u32>().is_aligned()
}

/// Whether the growth bound holds for these samples: it does for all samples between the rails.
fn is_bounded<const M: usize>(pairs: &[Pair], codes: Codes, power: u32) -> bool {
    if q15::is_narrow(codes) {
        power <= const { q15::allowed(M) }
    } else {
        let (low, _) = codes.rails();
        first::largest(pairs, codes.middle()) <= i32::from(codes.middle()) - i32::from(low)
    }
}
