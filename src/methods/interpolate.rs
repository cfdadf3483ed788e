//! Interpolation of three bins in closed form, for a rectangular window.
//!
//! Offsets are in bins from the peak, positive upwards, -1..=1; 0 where there is no signal. Valid
//! for a single tone, complex, or real and far from DC and Nyquist.

use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use crate::spectrum::bins::{Bins, Rectangular};
use crate::tone::within;

/// Jacobsen's estimator (Jacobsen and Kootsookos 2007, eq 3):
/// `Re{(X- - X+) / (2 X0 - X- - X+)}`.
///
/// Beyond the FFT: 4 multiplications, 1 division. 1.5 times the bound on complex tones; biased by
/// `(pi^2/3) d (1 - d^2) / N^2` at offset `d`.
pub fn jacobsen<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> T {
    within(ratio(bins), T::one())
}

/// Candan's estimator (Candan 2013), which is Jacobsen's without its bias: `(N/pi) atan(tan(pi/N) j)`.
///
/// Beyond the FFT: 6 multiplications, 4 divisions, 1 arc tangent, and the sine and cosine of `pi/N`.
/// 1.5 times the bound on complex tones; on real samples the nearest of the three-bin forms to the image-free
/// answer (1.9e-3 bin at bin 5, 1.7e-6 at 256 of 1024).
pub fn candan<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> T {
    let half_turn = T::unit(T::new(0.5) / bins.length());
    let tangent = half_turn.im / half_turn.re;
    let scale = bins.length() / T::new(core::f64::consts::PI);
    within(scale * (tangent * ratio(bins)).arctan(), T::one())
}

fn ratio<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> T {
    let [left, centre, right] = bins.three();
    let below = centre + centre - left - right;
    ((left - right) * below.conj()).re / below.norm_sqr()
}

/// Macleod's estimator (Macleod 1998, three samples): with `R± = Re{X± conj(X0)}` and
/// `g = (R- - R+) / (2 |X0|^2 + R- + R+)`, `(sqrt(1 + 8 g^2) - 1) / (4 g)`.
///
/// Computed as `2 g / (sqrt(1 + 8 g^2) + 1)`, which is equal and does not cancel. Beyond the FFT: 8 multiplications, 2 divisions, 1 root.
/// 1.14 to 1.19 times the bound on complex tones.
pub fn macleod<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> T {
    let [left, centre, right] = bins.three();
    let lower = (left * centre.conj()).re;
    let upper = (right * centre.conj()).re;
    let power = centre.norm_sqr();
    let g = (lower - upper) / (power + power + lower + upper);
    let root = (T::one() + T::new(8.0) * g * g).root();
    within((g + g) / (root + T::one()), T::one())
}

/// The vertex of a parabola through three log magnitudes, `(a - c) / (2 (a - 2 b + c))`.
///
/// Widespread (the "QIFFT" of audio work) and meant for windowed data; on a rectangular window its bias of up to 0.17 bin grows from 4
/// times the bound at -10 dB to 10000 times at 60 dB. Included for comparison. Beyond the FFT: 7 multiplications, 1 division, 3 logarithms.
pub fn parabolic<T: Scalar, R: Record>(bins: &Bins<T, R, Rectangular>) -> T {
    // The factor by which log power exceeds log magnitude cancels.
    let [a, b, c] = bins.three().map(|x| x.norm_sqr().max(T::min_positive_value()).log_e());
    within((a - c) / (T::new(2.0) * (a - b - b + c)), T::one())
}
