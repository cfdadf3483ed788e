//! The float FFT: `f32` by the crate microfft, in place, for a core with an FPU. There are no kernels. The bits are the same
//! everywhere, because all it takes are IEEE 754's operations and none is fused.
//!
//! # Scale
//!
//! Codes without their middle are shifted up by `31 - B - log2 M` bits, for B signed bits and the M points of the
//! spectrum, which is exact. Then the powers of all bins of an I/Q record of M samples sum to at most
//! `M sum |x|^2 = 2 (M 2^(B - 1) 2^(31 - B - log2 M))^2 = 2^61`, by Parseval's theorem, and those of a real record of 2M samples
//! to 2^62: less than 2^63 for any record, rounding included. So a part of a bin fits in 32 bits as well, but for bins 0 and N/2 of
//! a real record, which saturate, by one count, where all of it is on a rail.
//!
//! # Points
//!
//! Those of a real record are its bins 0..N/2, already split; bin N/2, which is real as bin 0 is, lies in the imaginary part
//! of that. White noise has the same power in them as in the other engines' points, so [`crate::estimate::noise`] takes
//! their second differences as it is: bin 0 is none that it reads, and near the mirror of the tone's bin it
//! leaves out bins that hold no more than noise, and reads as many others.
//!
//! # Precision
//!
//! Of a full-scale tone the error is the transform's, 136 dB below at N = 1024. A bin is cut to an integer where it is read,
//! towards zero, which is one instruction; of a tone 40 dB weaker that is most of the error, 115 dB below (I/Q: 112). A converter's own
//! rounding is 80 dB more. The figures are asserted in `host-tests/tests/f32.rs`.

use super::integer::{Pair, Point};
use crate::acquire::codes::Codes;
use crate::acquire::sample::Record;
use crate::math::products::power;
use microfft::Complex32;

/// A complex value, real part first, in units of bins.
pub type Float = [f32; 2];

/// Transforms a record of `N` samples in place of `points`. Returns the exponent of the bins.
///
/// Points that do not fit `N` are not transformed; the callers' types rule that out.
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

/// By how much codes are shifted up.
const fn shift<R: Record, const N: usize>(codes: Codes) -> u32 {
    // The middle is away: half the span is left, and a sign.
    let (low, high) = codes.rails();
    let half = ((high as i32 - low as i32 + 2) / 2) as u32;
    let bits = half.next_power_of_two().trailing_zeros() + 1;
    let bits = if bits < 12 { 12 } else { bits };
    let points = if R::IQ { N } else { N / 2 };
    31 - bits - points.trailing_zeros()
}

/// Calls the crate's function for `N` of its values.
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
pub fn bin<R: Record>(points: &[Float], k: usize) -> Point {
    if R::IQ || (k > 0 && k < points.len()) {
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

/// The sum of the powers of half the second difference around every `stride`-th point from the second on, as
/// [`super::integer`]'s.
pub fn bend(points: &[Float], stride: usize) -> u64 {
    let half = |left: f32, centre: f32, right: f32| (0.5 * (left + right) - centre) as i32;
    let (mut sum, mut rest) = (0u64, points);
    while let Some(&[left, centre, right]) = rest.first_chunk() {
        let bent = [half(left[0], centre[0], right[0]), half(left[1], centre[1], right[1])];
        sum = sum.wrapping_add(power(bent));
        rest = rest.get(stride.max(1)..).unwrap_or(&[]);
    }
    sum
}
