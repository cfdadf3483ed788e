//! Estimators for bins under Hann's window, where leakage from other lines matters.
//!
//! A tone `d` bins above the peak shows, for large N, `X_i` in proportion to `1 / (u (1 - u^2))`, `u = d - i`. Offsets
//! are in bins from the peak, positive upwards, -1..=1; 0 where there is no signal. The error has a
//! term of order `1/N^4` (7e-10 bin at N = 256).
//!
//! On real samples the mirror image is nearly gone: its floor at N = 1024 is 3e-4 ([`grandke`]) and 7e-5 bin
//! ([`candan_hann`]) at bin 5, 2e-11 at bin 256, where Z-Rife has 1.3e-2 and 4e-4.
//!
//! The window is part of the bins' type. Estimators for one window do not take the other:
//!
//! ```compile_fail,E0308
//! use picket_dsp::acquire::sample::Iq;
//! use picket_dsp::methods::rife::z_rife;
//! use picket_dsp::spectrum::bins::{Bins, Hann};
//! fn wrong(bins: &Bins<f32, Iq, Hann>) -> f32 {
//!     z_rife(bins)
//! }
//! ```
//!
//! ```compile_fail,E0308
//! use picket_dsp::acquire::sample::Real;
//! use picket_dsp::methods::hann::grandke;
//! use picket_dsp::spectrum::bins::{Bins, Rectangular};
//! fn wrong(bins: &Bins<f32, Real, Rectangular>) -> f32 {
//!     grandke(bins)
//! }
//! ```

use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use crate::spectrum::bins::{Bins, Hann};
use crate::tone::within;

/// Grandke's estimator (Grandke 1983), from the magnitudes of the peak and its stronger neighbour: `r (2 a - 1) / (a + 1)`,
/// `a = |X_r| / |X_0|`.
///
/// Valid for a tone, real or complex, at least 3 bins from another line or its own image. Beyond the
/// bins: 6 multiplications, 2 divisions, 2 roots, and Hann's window on the bins. 1.81 to 1.89 times the
/// (rectangular window's) bound.
pub fn grandke<T: Scalar, R: Record>(bins: &Bins<T, R, Hann>) -> T {
    let [left, centre, right] = bins.three().map(|x| x.norm_sqr());
    let up = right > left;
    let a = if up { right } else { left }.root() / centre.root();
    let offset = (a + a - T::one()) / (a + T::one());
    within(if up { offset } else { -offset }, T::one())
}

/// Candan's estimator for three complex bins: `2 Re{(X- - X+) / (2 X0 - X- - X+)}`.
///
/// Jacobsen's form for this window. Candan 2015 gives the factor of its quotient as a derivative computed from the window; for Hann's
/// window the factor is exactly 2 for large N, because `X±/X0 = -(1 ± d) / (2 -+ d)`. Beyond the bins: 4 multiplications, 1 division, no
/// root, and Hann's window on the bins. Valid where [`grandke`] is. 2.10 to 2.18 times the (rectangular window's) bound.
pub fn candan_hann<T: Scalar, R: Record>(bins: &Bins<T, R, Hann>) -> T {
    let [left, centre, right] = bins.three();
    let below = centre + centre - left - right;
    let ratio = ((left - right) * below.conj()).re / below.norm_sqr();
    within(ratio + ratio, T::one())
}
