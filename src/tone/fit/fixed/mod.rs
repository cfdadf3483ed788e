//! Both fits for cores without an FPU. The sums over the bins are integers. The numbers that follow from the sums have a format that is
//! cheaper there than floats. Only the [`Fit`](super::Fit) itself is `f32`.
//!
//! Formats: offsets, p and angles in Q30; frequencies u in Q23 (their differences stay below 256);
//! h in Q26, h' in Q22, sines in Q26; bins as the FFT stores them, less two bits. The rms
//! difference from `f32` is 0.02 of the Cramer-Rao bound at 60 dB and N = 4096, and less
//! elsewhere.

mod equations;
mod inverse;
mod iq;
mod near;
mod real;
pub(crate) mod scaled;
mod tail;
mod trigonometry;

use crate::math::scalar::Scalar as _;
use crate::spectrum::fft::integer::Point;
use crate::spectrum::layout::nearest;
pub(super) use iq::fit as fit_iq;
pub(super) use real::fit as fit_real;
use scaled::Scaled;
pub(crate) use tail::tail;

/// The bits by which the FFT's bins are shifted down.
pub(crate) const ROOM: u32 = 2;

/// 1 in Q30.
const ONE: i32 = 1 << 30;

/// The bin `away` from the middle one.
fn around(bins: &[Point], away: i32) -> Option<[i32; 2]> {
    let place = usize::try_from((bins.len() / 2) as i32 + away).ok()?;
    bins.get(place).map(|&[re, im]| [re >> ROOM, im >> ROOM])
}

/// `x` with this many fractional bits, saturated.
pub(crate) fn quantised(x: f32, bits: u32) -> i32 {
    (x * (1u32 << bits) as f32) as i32
}

/// The whole product.
#[inline(always)]
pub(crate) fn product(a: i32, b: i32) -> i64 {
    if cfg!(short_products) {
        // Without a multiply-long instruction a library would multiply 64 bits by 64.
        let [a, b] = [a, b].map(|x| [x >> 16, x & 0xffff]);
        let low = (a[1] as u32).wrapping_mul(b[1] as u32);
        let middle = i64::from(a[0].wrapping_mul(b[1])) + i64::from(a[1].wrapping_mul(b[0]));
        return (i64::from(a[0].wrapping_mul(b[0])) << 32) + (middle << 16) + i64::from(low);
    }
    i64::from(a) * i64::from(b)
}

/// The product of two numbers, shifted down by K bits, 16 to 31. The size of `a` is at most 2^30.
#[inline(always)]
pub(crate) fn shifted<const K: u32>(a: i32, b: i32) -> i32 {
    if cfg!(short_products) { by_halves::<K>(a, b) } else { (product(a, b) >> K) as i32 }
}

/// The whole product of a number with itself.
#[inline(always)]
pub(crate) fn square(a: i32) -> i64 {
    if cfg!(short_products) {
        let [high, low] = [a >> 16, a & 0xffff];
        let lower = (low as u32).wrapping_mul(low as u32);
        let middle = i64::from(high.wrapping_mul(low)) << 17;
        return (i64::from(high.wrapping_mul(high)) << 32) + middle + i64::from(lower);
    }
    product(a, a)
}

/// The number of zero bits above the highest set one. The number must not be 0.
#[inline(always)]
fn zeros(x: u32) -> u32 {
    if cfg!(short_products) { zeros_by_table(x) } else { x.leading_zeros() }
}

/// [`zeros`] in half the time of a library's search, for cores without an instruction for it. The function sets all bits below the highest;
/// a product identifies which of the 32 such numbers results.
#[inline(always)]
fn zeros_by_table(x: u32) -> u32 {
    /// A de Bruijn sequence: five successive bits of it differ at each of its 32 places.
    const FACTOR: u32 = 0x07c4_acdd;
    /// The number of zeros by these five bits.
    const TABLE: [u8; 32] = {
        let mut table = [0; 32];
        let mut bits = 1;
        while bits <= 32 {
            let filled = (((1u64 << bits) - 1) as u32).wrapping_mul(FACTOR);
            // This runs at compile time: an index out of range would not compile.
            #[allow(clippy::indexing_slicing)]
            {
                table[(filled >> 27) as usize] = 32 - bits;
            }
            bits += 1;
        }
        table
    };
    let x = x | x >> 1;
    let x = x | x >> 2;
    let x = x | x >> 4;
    let x = x | x >> 8;
    let x = x | x >> 16;
    TABLE.get((x.wrapping_mul(FACTOR) >> 27) as usize).map_or(32, |&zeros| zeros.into())
}

/// [`shifted`] without the whole product. Halves are signed, the upper ones rounded, so that the
/// mixed products and the carry together fit in 32 bits.
#[inline(always)]
fn by_halves<const K: u32>(a: i32, b: i32) -> i32 {
    let [(a, b), (c, d)] = [a, b].map(halves);
    let middle = a.wrapping_mul(d).wrapping_add(b.wrapping_mul(c));
    let middle = middle.wrapping_add(b.wrapping_mul(d) >> 16);
    (a.wrapping_mul(c) << (32 - K)).wrapping_add(middle >> (K - 16))
}

/// [`product`] if the size of `a` is at most 2^30.
#[inline(always)]
fn product_by_halves(a: i32, b: i32) -> i64 {
    let [(a, b), (c, d)] = [a, b].map(halves);
    let middle = a.wrapping_mul(d).wrapping_add(b.wrapping_mul(c));
    let high = a.wrapping_mul(c).wrapping_add(middle >> 16);
    let both = i64::from(high) << 32 | i64::from((middle << 16) as u32);
    both.wrapping_add(i64::from(b.wrapping_mul(d)))
}

/// The upper half, rounded, and the signed rest.
#[inline(always)]
fn halves(x: i32) -> (i32, i32) {
    (((x >> 15) + 1) >> 1, i32::from(x as i16))
}

/// The product of two numbers in Q30. If one number has another format, so has the product.
#[inline(always)]
pub(crate) fn times(a: i32, b: i32) -> i32 {
    shifted::<30>(a, b)
}

#[allow(clippy::manual_clamp)] // `clamp` checks its bounds
pub(crate) fn held(x: i64) -> i32 {
    x.max(i64::from(i32::MIN)).min(i64::from(i32::MAX)) as i32
}

/// Reciprocal of a number in 1..2^11, and the left shift of the dividend that lets [`times`] yield a quotient with ten fractional bits. The
/// dividend is less than the number times 2^20.
pub(crate) fn inverted(number: u32) -> (i32, u32) {
    let room = zeros(number).wrapping_sub(1) & 31;
    ((inverse::of(number << room) >> 1) as i32, room.saturating_sub(20))
}

/// h in Q26 and h' in Q22, for p and u in Q23. A frequency nearer than 1/16 bin counts as 1/16 bin
/// away, so that nothing overflows.
#[inline(always)]
fn shape(p: i32, u: i32) -> (i32, i32) {
    let difference = p.wrapping_sub(u);
    let size = difference.unsigned_abs().max((1 << 19) + 1).min(i32::MAX as u32);
    let room = zeros(size).wrapping_sub(1) & 31;
    // 1/(size 2^room) = inverse / 2^61 and 1/|p - u| = 2^(23 + room) / (size 2^room): in Q26, inverse >> (12 - room).
    let inverse = (inverse::of(size << room) >> 12u32.saturating_sub(room)) as i32;
    let inverse = if difference < 0 { -inverse } else { inverse };
    let h = shifted::<23>(p, inverse);
    let slope = shifted::<30>(inverse, (1 << 26) - h);
    (h, slope)
}

/// Adds the product of two numbers to the sum of others. The size of `a` is at most 2^30.
#[inline(always)]
fn add(sum: &mut i64, a: i32, b: i32) {
    let product = if cfg!(short_products) { product_by_halves(a, b) } else { product(a, b) };
    *sum = sum.wrapping_add(product);
}

/// The square root of a positive number in Q28.
fn root(square: i32) -> Scaled {
    Scaled::from_float((square.max(1) as f32).root(), -14)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_by_halves_are_the_whole_ones_shifted() {
        let mut state = 1u32;
        let mut draw = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state as i32 >> (state >> 9 & 15)
        };
        let ends = [i32::MIN, i32::MIN + 0x8000, -0x8000, -1, 0, 0x7fff, 0x8000, i32::MAX];
        let check = |a: i32, b: i32| {
            let wide = i64::from(a) * i64::from(b);
            assert_eq!(product(a, b), wide, "{a} {b}");
            assert_eq!(square(b), product(b, b), "{b}");
            if b != 0 {
                assert_eq!(zeros_by_table(b as u32), b.leading_zeros(), "{b}");
            }
            assert_eq!(product_by_halves(a, b), wide, "{a} {b}");
            assert_eq!(by_halves::<16>(a, b), (wide >> 16) as i32, "{a} {b}");
            assert_eq!(by_halves::<23>(a, b), (wide >> 23) as i32, "{a} {b}");
            assert_eq!(by_halves::<31>(a, b), (wide >> 31) as i32, "{a} {b}");
        };
        for b in ends {
            for a in ends.map(|a| a >> 1).into_iter().chain([-(1 << 30), 1 << 30]) {
                check(a, b);
            }
        }
        for _ in 0..100_000 {
            check(draw() >> 1, draw());
        }
    }
}
