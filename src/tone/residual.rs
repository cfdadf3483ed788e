//! The power that a fit leaves in its bins.

use super::fit::Fit;
use super::noise::Noise;
use crate::chance::ratio;
use crate::math::scalar::Scalar;
use crate::spectrum::engine::RESIDUE;

/// The noise power per sample in a fit's own residual.
pub fn residual<T: Scalar>(fit: &Fit<T>, n: usize) -> T {
    fit.residual / expected(fit, n)
}

/// The residual in a fit's bins for noise of power 1 per sample: half the degrees of freedom times the power of a bin, `n`.
pub(super) fn expected<T: Scalar>(fit: &Fit<T>, n: usize) -> T {
    T::from_i32((n as i32 / 2).wrapping_mul(fit.dof.max(1) as i32))
}

/// The ratio of the residual to the noise power in a record of `n` samples, if less than one record in 10^6 reaches this ratio by chance;
/// otherwise 1. Above 1 the line is not a single tone: another is near, or its frequency moves.
///
/// The integer FFT itself leaves a share of the line.
pub fn excess_over<T: Scalar>(fit: &Fit<T>, n: usize, noise: Noise) -> T {
    let expected = T::new(noise.power.into()) * expected(fit, n);
    // No fit has enough degrees of freedom to make twice the noise improbable.
    if fit.residual <= expected + expected {
        return T::one();
    }
    let rest = fit.residual - T::new(RESIDUE) * fit.line.norm_sqr();
    let excess = rest / expected;
    if excess > T::new(excess_limit(fit.dof, noise).into()) { excess } else { T::one() }
}

/// The ratio of a residual with these degrees of freedom to the noise power, exceeded by chance in one record of 10^6.
pub fn excess_limit(dof: u32, noise: Noise) -> f32 {
    /// A normal number exceeds this many deviations with this probability.
    const DEVIATIONS: f32 = 4.753;
    ratio(DEVIATIONS, dof.max(1) as f32, noise.dof)
}
