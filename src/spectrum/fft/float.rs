//! The float FFT: `f32` by the crate microfft, in place, for a core with an FPU. It has no kernels.
//! The bits are the same everywhere, because it uses only IEEE 754's operations and fuses none.
//!
//! # Scale
//!
//! Codes without their middle are shifted up by `31 - B - log2 M` bits, for B signed bits and the M points of the spectrum, which is exact.
//! By Parseval's theorem, the powers of all bins of an I/Q record of M samples then sum to at most
//! `M sum |x|^2 = 2 (M 2^(B - 1) 2^(31 - B - log2 M))^2 = 2^61`, and the powers of a real record of 2M samples to at most 2^62. Both are
//! below 2^63 for any record, rounding included. So every part of a bin fits in 32 bits, except for bins 0 and N/2 of a real record: they
//! saturate by one count if the whole record lies on a rail.
//!
//! # Points
//!
//! The points of a real record are its bins 0..N/2, already split. Bin N/2 is real, as bin 0 is, and lies in the imaginary part of bin 0.
//! White noise has the same power in these points as in the other engines' points, so [`crate::tone::noise`] takes their second differences
//! unchanged. The noise estimate does not read bin 0. Near the mirror of the tone's bin it leaves out bins that hold only noise, and reads
//! an equal number of others.
//!
//! # Precision
//!
//! The error of a full-scale tone comes from the transform: 136 dB below the tone at N = 1024. A bin is cut to an integer when it is read,
//! towards zero, in one instruction. The cut is most of the error of a tone 40 dB weaker: 115 dB below it (I/Q: 112). A converter's own
//! rounding is 80 dB more. `host-tests/tests/f32.rs` asserts the figures.

use super::integer::{Pair, Point};
use crate::acquire::codes::Codes;
use crate::acquire::sample::Record;
use microfft::Complex32;

/// The error in bins that the transform and the fit's `f32` add to the frequency of a strong line, see
/// [`View::error`](crate::spectrum::view::View::error).
pub const ERROR: f32 = 7.3e-8;

/// A complex value, real part first, in units of bins.
pub type Float = [f32; 2];

/// Transforms a record of `N` samples into `points`, in place. Returns the exponent of the bins.
///
/// Points that do not fit `N` stay untransformed; the callers' types rule such points out.
#[inline]
pub fn transform<R: Record, const N: usize>(
    pairs: &[Pair],
    codes: Codes,
    points: &mut [Float],
) -> i32 {
    let shift = shift::<R, N>(codes);
    let middle = i32::from(codes.middle());
    let scaled = |code: i16| ((i32::from(code) - middle) << shift) as f32;
    for (point, &pair) in points.iter_mut().zip(pairs) {
        *point = pair.map(scaled);
    }
    if R::IQ {
        complex::<N>(bytemuck::must_cast_slice_mut(points));
    } else {
        real::<N>(points.as_flattened_mut());
    }
    -(shift as i32)
}

/// The number of bits by which the codes are shifted up.
const fn shift<R: Record, const N: usize>(codes: Codes) -> u32 {
    // Without the middle, half the span and a sign remain.
    let (low, high) = codes.rails();
    let half = ((high as i32 - low as i32 + 2) / 2) as u32;
    let bits = half.next_power_of_two().trailing_zeros() + 1;
    let bits = if bits < 12 { 12 } else { bits };
    let points = if R::IQ { N } else { N / 2 };
    31 - bits - points.trailing_zeros()
}

/// Calls the crate's function for `N` values.
macro_rules! by_length {
    ($module:ident, $values:ident, $($n:literal $function:ident)*) => {
        match N {
            $($n => if let Ok(values) = $values.try_into() {
                let _ = microfft::$module::$function(values);
            },)*
            _ => {}
        }
    };
}

fn real<const N: usize>(samples: &mut [f32]) {
    by_length!(real, samples, 64 rfft_64 128 rfft_128 256 rfft_256 512 rfft_512 1024 rfft_1024 2048 rfft_2048 4096 rfft_4096);
}

fn complex<const N: usize>(samples: &mut [Complex32]) {
    by_length!(complex, samples, 64 cfft_64 128 cfft_128 256 cfft_256 512 cfft_512 1024 cfft_1024 2048 cfft_2048 4096 cfft_4096);
}

/// Bin `k` of an I/Q record, or bin 0..=N/2 of a real one.
pub fn bin(points: &[Float], iq: bool, k: usize) -> Point {
    if iq || (k > 0 && k < points.len()) {
        return points.get(k).copied().map_or([0; 2], whole);
    }
    // Bins 0 and N/2 are real.
    let [first, last] = points.first().copied().map_or([0; 2], whole);
    [if k == 0 { first } else { last }, 0]
}

/// A point as an integer.
#[inline(always)]
pub fn whole(point: Float) -> Point {
    point.map(|part| part as i32)
}
