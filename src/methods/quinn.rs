//! Quinn's two estimators.
//!
//! Both take two offsets from the peak and its neighbours, `d+ = -a+ / (1 - a+)` and `d- = a- / (1 - a-)` with
//! `a± = Re{X± conj(X0)} / |X0|^2`, and differ in the way of joining them. Valid for a single tone seen through a rectangular window,
//! complex, or real and far from DC and Nyquist; the offset is in bins from the peak, positive upwards, -1..=1; 0 where there is no signal.

use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use crate::spectrum::bins::{Bins, Rectangular};
use crate::tone::within;

/// Quinn's first estimator (Quinn 1994): `d+` where both offsets are positive, else `d-`.
///
/// Beyond the FFT: 6 multiplications, 4 divisions. 1.26 to 1.35 times the bound on complex tones.
pub fn quinn1<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> T {
    let [lower, upper] = both(bins);
    within(if lower > T::zero() && upper > T::zero() { upper } else { lower }, T::one())
}

/// Quinn's second estimator (Quinn 1997): `(d+ + d-)/2 + k(d+^2) - k(d-^2)`, with
/// `k(x) = ln(3x^2 + 6x + 1)/4 - (sqrt 6/24) ln((x + 1 - sqrt(2/3)) / (x + 1 + sqrt(2/3)))`.
///
/// Beyond the FFT: 19 multiplications, 6 divisions, 4 logarithms. 1.13 to 1.18 times the bound on
/// complex tones.
pub fn quinn2<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> T {
    let [lower, upper] = both(bins);
    let middle = (lower + upper) * T::new(0.5);
    within(middle + kappa(upper * upper) - kappa(lower * lower), T::one())
}

/// The two offsets `[d-, d+]`.
fn both<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> [T; 2] {
    let [left, centre, right] = bins.three();
    let power = centre.norm_sqr();
    let lower = (left * centre.conj()).re / power;
    let upper = (right * centre.conj()).re / power;
    [lower / (T::one() - lower), -upper / (T::one() - upper)]
}

fn kappa<T: Scalar>(x: T) -> T {
    let one = T::one();
    let root = T::new(0.816_496_580_927_726); // sqrt(2/3)
    let quadratic = T::new(3.0) * x * x + T::new(6.0) * x + one;
    let quotient = (x + one - root) / (x + one + root);
    let weight = T::new(0.102_062_072_615_965_76); // sqrt(6)/24
    T::new(0.25) * quadratic.log_e() - weight * quotient.log_e()
}
