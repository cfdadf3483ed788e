//! Standard deviations of a frequency.

use crate::frequency::Frequency;
use crate::math::scalar::Scalar;
use crate::tone::fit::Fit;

/// The Cramer-Rao bound of a tone's frequency, as a standard deviation in bins.
///
/// Asymptotic: for real records it holds away from DC and Nyquist. `snr` is per sample, like [`crate::tone::Tone::snr`]. Complex:
/// `sqrt(6 / (4 pi^2 N snr))`; real: `sqrt(12 / (4 pi^2 N snr))` (Rife and Boorstyn 1974, for N^2 - 1 close to N^2).
pub fn bound_bins(iq: bool, n: usize, snr: f32) -> f32 {
    let share = if iq { 0.151_981_78 } else { 0.303_963_55 };
    (share / (n as f32 * snr)).root()
}

/// One standard deviation of a fit's offset in bins, for a noise power per sample of `noise` squared
/// codes (see [`super::noise`]): `sqrt(N noise / (2 information))`.
///
/// Sigma comes from the fit's own denominator. So it holds at the edges of the spectrum, where the
/// bound depends on the phase, for every K and at every offset. The mean of `(error / sigma)^2` is
/// within 0.88..1.15 from 2 dB above the threshold to 60 dB.
pub fn sigma_bins<T: Scalar>(fit: &Fit<T>, n: usize, noise: T) -> T {
    (T::from_i32(n as i32 / 2) * noise / fit.information).root()
}

/// A standard deviation in bins, of a record of `n` samples, widened by the errors that do not show as noise: a variance `unseen` of
/// squared bins, such as [`Engine::error`](crate::spectrum::engine::Engine::error), and the rounding of a [`Frequency`]'s last step.
pub(crate) fn with_rounding(sigma: f32, unseen: f32, n: usize) -> f32 {
    let step = n as f32 * Frequency::ROUNDING;
    (sigma * sigma + (unseen + step * step)).root()
}

/// From this share of clipped samples on a tone is [`crate::tone::Verdict::Clipped`].
pub const CLIPPED: f32 = 0.01;

/// The standard deviation in bins of a record in which a share `clipped` of the samples touches a rail. This allowance serves where nothing
/// better is known (see [`CensoredFit`](crate::tone::clipped::CensoredFit)): for one of several tones, and if the rails leave too few
/// samples.
///
/// The allowance is coarse and adds in quadrature: 1e-3 bin above 1 %, 1e-2 bin above 5 %. It
/// covers the harmonics of a tone of which a fifth is clipped, at the worst frequencies (2e-3 bin
/// at 5 %, 0.021 bin at 20 %). At most frequencies it is far too large.
pub fn widened(sigma: f32, clipped: f32) -> f32 {
    if clipped <= CLIPPED {
        return sigma;
    }
    let bias = if clipped > 0.05 { 1e-2 } else { 1e-3 };
    (sigma * sigma + bias * bias).root()
}
