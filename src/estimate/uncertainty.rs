//! How far a frequency may be off: the Cramer-Rao bound.

use crate::acquire::sample::Record;

/// The Cramer-Rao bound of a tone's frequency, as a standard deviation in bins.
///
/// Asymptotic: for real records it holds away from DC and Nyquist. `snr` per sample as in
/// [`super::tone::Tone::snr`]. Complex: `sqrt(6 / (4 pi^2 N snr))`; real: `sqrt(12 / (4 pi^2 N snr))`
/// (Rife and Boorstyn 1974, for N^2 - 1 close to N^2).
pub fn bound_bins<R: Record>(n: usize, snr: f32) -> f32 {
    let share = if R::IQ { 0.151_981_78 } else { 0.303_963_55 };
    libm::sqrtf(share / (n as f32 * snr))
}
