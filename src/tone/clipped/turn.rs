//! Turns of a tone by integers alone, for cores without an FPU.

pub(super) use super::super::noise::whole_fixed::Turn;
use crate::tone::fit::fixed::times;

/// 1 in Q30.
pub(super) const ONE: i32 = 1 << 30;

/// Terms of the cosine's series and of the sine's, the last first, and a quarter of a turn in radians less 1.
const COSINE: [i32; 4] = terms([1.0 / 40320.0, -1.0 / 720.0, 1.0 / 24.0, -1.0 / 2.0]);
const SINE: [i32; 4] = terms([1.0 / 362_880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0]);
const QUARTER: [i32; 1] = terms([core::f64::consts::FRAC_PI_2 - 1.0]);

// Const functions cannot use `get_mut`. An index out of range would be a compile error.
#[allow(clippy::indexing_slicing)]
const fn terms<const T: usize>(exact: [f64; T]) -> [i32; T] {
    let mut terms = [0; T];
    let mut i = 0;
    while i < T {
        terms[i] = (exact[i] * ONE as f64) as i32;
        i += 1;
    }
    terms
}

/// Cosine and sine of an angle in turns of 2^32, to some 2^-25. Cost: eleven products.
#[inline(never)]
pub(super) fn from_angle(angle: i32) -> Turn {
    // An eighth of a turn to each side of a quarter, in radians.
    let quarter = angle.wrapping_add(1 << 29) >> 30;
    let rest = angle.wrapping_sub(quarter << 30);
    let [more] = QUARTER;
    let x = rest + times(rest, more);
    let z = times(x, x);
    let series =
        |terms: [i32; 4]| times(z, terms.iter().fold(0, |sum, &term| times(z, sum) + term));
    let (cos, sin) = (ONE + series(COSINE), x + times(x, series(SINE)));
    match quarter & 3 {
        0 => [cos, sin],
        1 => [-sin, cos],
        2 => [-cos, -sin],
        _ => [sin, -cos],
    }
}

/// A pair of numbers turned on. The product loses the last bit.
#[inline]
pub(super) fn turned([a, b]: Turn, [c, d]: [i32; 2]) -> [i32; 2] {
    [times(a, c).wrapping_sub(times(b, d)), times(a, d).wrapping_add(times(b, c))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::scalar::Scalar;
    use num_complex::Complex;

    #[test]
    fn turns_are_cosines_and_sines() {
        let mut angle = i32::MIN;
        for _ in 0..100_000 {
            let exact = f64::unit(f64::from(angle) / 4_294_967_296.0);
            let [cos, sin] = from_angle(angle).map(|x| f64::from(x) / f64::from(ONE));
            let error = (Complex::new(cos, sin) - exact).norm_sqr();
            assert!(error < 2f64.powi(-50), "{angle}: {error:e}");
            angle = angle.wrapping_add(1_073_741_824 / 25 + 12_345);
        }
    }
}
