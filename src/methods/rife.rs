//! Rife and phase-criterion Rife ("Z-Rife").
//!
//! Both read the peak and its stronger, or phase-chosen, neighbour and take the offset from the
//! ratio of the two magnitudes: `delta = r |X_r| / (|X_r| + |X_0|)`, `r` the direction, +1 or -1.
//! Valid for a single tone seen through a rectangular window, complex, or real and far from DC and
//! Nyquist.

use crate::acquire::sample::Record;
use crate::math::products;
use crate::math::scalar::Scalar;
use crate::spectrum::bins::{Bins, Rectangular};
use fixed::types::I2F30;
use num_complex::Complex;

/// Rife's estimator (Rife and Vincent 1970): the direction points to the stronger neighbour.
///
/// Offset in bins, -0.5..=0.5; 0 where there is no signal. Beyond the FFT: 1 division, 2 roots, 6
/// multiplications. Near offset 0 noise often picks the wrong neighbour: 3.5 to 20 times the
/// Cramer-Rao bound.
pub fn rife<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> T {
    let [left, centre, right] = bins.three();
    let up = right.norm_sqr() > left.norm_sqr();
    ratio(left, centre, right, up)
}

/// Phase-criterion Rife (Ye et al. 2022, eqs 15 and 16): the direction points to the neighbour whose phase opposes the peak's.
///
/// The two angles of the paper fold into the sign of one real part, `Re{(X_- - X_+) conj X_0} > 0` for +1: no arc tangent, no unwrapping
/// (the paper's eq 10 compares phase differences and is right only if they are wrapped). Offset and cost like [`rife`]. 1.25 to 1.36 times
/// the bound on complex tones; on real samples the error stops at an image floor (1.4e-2 bin at bin 5, 4e-4 at bin 256 of 1024).
pub fn z_rife<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> T {
    let [left, centre, right] = bins.three();
    let up = ((left - right) * centre.conj()).re > T::zero();
    ratio(left, centre, right, up)
}

/// A-P-Rife (Ye et al. 2022, reference 10, of which only the abstract was at hand: the threshold 1/3 is a
/// reconstruction): [`rife`] where its offset is at least 1/3, else the ratio in the direction of the
/// phase criterion (eq 10 with wrapped differences): the neighbour whose phase is further
/// from the peak's.
///
/// The wrapped angles are compared by their cosines, so no arc tangent is needed. Offset like [`rife`]. Beyond the FFT: 12 multiplications,
/// 2 divisions, 4 roots. 1.25 to 1.40 times the bound on complex tones.
pub fn a_p_rife<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> T {
    let offset = rife(bins);
    if offset.abs() >= T::new(1.0 / 3.0) {
        return offset;
    }
    let [left, centre, right] = bins.three();
    let lower = (left * centre.conj()).re * right.norm_sqr().root();
    let upper = (right * centre.conj()).re * left.norm_sqr().root();
    ratio(left, centre, right, upper < lower)
}

/// The offset from two magnitudes, in the given direction.
pub(crate) fn ratio<T: Scalar>(
    left: Complex<T>,
    centre: Complex<T>,
    right: Complex<T>,
    up: bool,
) -> T {
    let neighbour = if up { right } else { left }.norm_sqr().root();
    let sum = neighbour + centre.norm_sqr().root();
    if sum <= T::zero() {
        return T::zero();
    }
    let offset = neighbour / sum;
    if up { offset } else { -offset }
}

/// [`rife`] in integers throughout, as the target runs it.
pub fn rife_integer(three: [Complex<i32>; 3]) -> I2F30 {
    let [left, centre, right] = three;
    ratio_integer(left, centre, right, power(right) > power(left))
}

/// [`z_rife`] in integers throughout, as the target runs it. The two real parts of eqs 15 and 16 are compared in the form of the paper: the
/// folded form's difference has 33 bits, four products of 64 are exact.
pub fn z_rife_integer(three: [Complex<i32>; 3]) -> I2F30 {
    let [left, centre, right] = three;
    let part = |x: Complex<i32>| {
        let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
        product(x.re, centre.re).saturating_add(product(x.im, centre.im))
    };
    ratio_integer(left, centre, right, part(left) > part(right))
}

/// `|z|^2`.
const fn power(z: Complex<i32>) -> u64 {
    products::power([z.re, z.im])
}

/// The ratio by two integer square roots and one division. Weak bins are scaled up first, so that their roots are not rounded to whole
/// counts.
fn ratio_integer(left: Complex<i32>, centre: Complex<i32>, right: Complex<i32>, up: bool) -> I2F30 {
    let (near, far) = (power(centre), power(if up { right } else { left }));
    if near | far == 0 {
        return I2F30::ZERO;
    }
    // An even number of leading zeros, so that the root scales by a whole power of two.
    let room = (near | far).leading_zeros() & !1;
    let (near, far) = ((near << room).isqrt(), (far << room).isqrt());
    let sum = near + far;
    let offset = ((far << 30) + sum / 2).checked_div(sum).unwrap_or(0);
    let offset = I2F30::from_bits(offset as i32);
    if up { offset } else { -offset }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acquire::sample::Iq;

    /// A small generator (xorshift), seeded in the test.
    fn noise(state: &mut u64) -> u64 {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        *state
    }

    /// Ye et al. 2022, eqs 15 and 16 as a textbook would compute them: the two real parts `Re{X_- conj X_0}` and `Re{X_+ conj X_0}` apart;
    /// the direction is opposite to the larger one.
    fn textbook([left, centre, right]: [Complex<i32>; 3]) -> bool {
        let part = |x: Complex<i32>| {
            i128::from(x.re) * i128::from(centre.re) + i128::from(x.im) * i128::from(centre.im)
        };
        part(left) > part(right)
    }

    fn both_forms_agree(three: [Complex<i32>; 3]) {
        let up = textbook(three);
        let offset = z_rife_integer(three);
        assert!(if up { offset >= 0 } else { offset <= 0 }, "{three:?}: {offset}");
        let bins = Bins::<f64, Iq, Rectangular>::gather(64, 8, |k| {
            let x = k.checked_sub(7).and_then(|i| three.get(i)).copied().unwrap_or_default();
            Complex::new(x.re.into(), x.im.into())
        });
        let folded = z_rife(&bins);
        assert!(if up { folded >= 0.0 } else { folded <= 0.0 }, "{three:?}: {folded}");
        assert!((folded - offset.to_num::<f64>()).abs() < 2e-9, "{three:?}: {folded} {offset}");
    }

    #[test]
    fn the_folded_direction_is_that_of_eqs_15_and_16() {
        let mut state = 0x5EED_0003;
        for _ in 0..200_000 {
            // 24 bits: all products and sums are exact in f64, too.
            let mut part = || (noise(&mut state) as i32) >> 8;
            both_forms_agree(std::array::from_fn(|_| Complex::new(part(), part())));
        }
    }

    #[test]
    fn extreme_bins_do_not_overflow() {
        let parts = [i32::MIN, i32::MAX, -1, 0, 1];
        for a in parts {
            for b in parts {
                for c in parts {
                    let three = [Complex::new(a, b), Complex::new(b, c), Complex::new(c, a)];
                    for offset in [rife_integer(three), z_rife_integer(three)] {
                        assert!(offset.abs() <= 1, "{three:?}: {offset}");
                    }
                }
            }
        }
    }
}
