//! Rife and phase-criterion Rife ("Z-Rife").
//!
//! Both read the peak and its stronger, or phase-chosen, neighbour and take the offset from the
//! ratio of the two magnitudes: `delta = r |X_r| / (|X_r| + |X_0|)`, `r` the direction, +1 or -1.
//! Valid for a single tone seen through a rectangular window, complex, or real and far from DC and
//! Nyquist.

use crate::acquire::sample::Record;
use crate::scalar::Scalar;
use crate::spectrum::bins::{Bins, Rectangular};
use crate::spectrum::power;
use fixed::types::I2F30;
use num_complex::Complex;

/// Rife's estimator (Rife and Vincent 1970): the direction is that of the stronger neighbour.
///
/// Offset in bins, -0.5..=0.5; 0 where there is no signal. Beyond the FFT: 1 division, 2 roots, 6
/// multiplications. Near offset 0 noise often picks the wrong neighbour: 3.5 to 20 times the
/// Cramer-Rao bound.
pub fn rife<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> T {
    let [left, centre, right] = bins.three();
    let up = right.norm_sqr() > left.norm_sqr();
    ratio(left, centre, right, up)
}

/// Phase-criterion Rife (Ye et al. 2022, eqs 15 and 16): the direction is that of the neighbour
/// whose phase opposes the peak's.
///
/// The two angles of the paper fold into the sign of one real part,
/// `Re{(X_- - X_+) conj X_0} > 0` for +1: no arc tangent, no unwrapping (the paper's eq 10 compares
/// phase differences and is right only if they are wrapped). Offset and cost as [`rife`], plus 2
/// multiplications. 1.25 to 1.36 times the bound on complex tones; on real samples it stops at an image
/// floor (1.4e-2 bin at bin 5, 4e-4 at bin 256 of 1024).
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
/// The wrapped angles are compared by their cosines, so no arc tangent is needed. Offset as [`rife`]. Beyond
/// the FFT: 12 multiplications, 1 division, 2 roots. 1.25 to 1.40 times the bound on complex tones.
pub fn a_p_rife<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> T {
    let offset = rife(bins);
    if offset.abs() >= T::of(1.0 / 3.0) {
        return offset;
    }
    let [left, centre, right] = bins.three();
    let lower = (left * centre.conj()).re * right.norm_sqr().sqrt();
    let upper = (right * centre.conj()).re * left.norm_sqr().sqrt();
    ratio(left, centre, right, upper < lower)
}

/// The offset from two magnitudes, in the direction given.
pub(crate) fn ratio<T: Scalar>(
    left: Complex<T>,
    centre: Complex<T>,
    right: Complex<T>,
    up: bool,
) -> T {
    let neighbour = if up { right } else { left }.norm_sqr().sqrt();
    let sum = neighbour + centre.norm_sqr().sqrt();
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

/// [`z_rife`] in integers throughout, as the target runs it.
pub fn z_rife_integer(three: [Complex<i32>; 3]) -> I2F30 {
    let [left, centre, right] = three;
    // A difference has 33 bits: halve it, so that the sum of two products fits 64.
    let part = |a: i32, b: i32, c: i32| ((i64::from(a) - i64::from(b)) >> 1) * i64::from(c);
    let up =
        part(left.re, right.re, centre.re).saturating_add(part(left.im, right.im, centre.im)) > 0;
    ratio_integer(left, centre, right, up)
}

/// Two integer square roots and one division. Weak bins are scaled up first, so that their roots
/// are not rounded to whole counts.
fn ratio_integer(left: Complex<i32>, centre: Complex<i32>, right: Complex<i32>, up: bool) -> I2F30 {
    let (near, far) = (power(centre), power(if up { right } else { left }));
    // An even number of leading zeros, so that the root scales by a whole power of two.
    let room = (near | far).leading_zeros() & !1;
    let (near, far) = ((near << room).isqrt(), (far << room).isqrt());
    let sum = near + far;
    if sum == 0 {
        return I2F30::ZERO;
    }
    let offset = ((far << 30) + sum / 2) / sum;
    let offset = I2F30::from_bits(offset as i32);
    if up { offset } else { -offset }
}
