//! A tone and its phase.

use crate::math::scalar::Scalar as _;
use crate::tone::Tone;
use crate::tone::fit::{Fit, Reach};
use core::f32::consts::PI;

/// A tone and its phase in the middle of the record.
///
/// There the frequency does not disturb the phase: both errors are independent, and the phase is as exact as if the frequency were known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ToneWithPhase {
    /// The tone.
    pub tone: Tone,
    /// The phase at sample `N/2`, radians, -pi..=pi: the samples are `A cos(phase + 2 pi f (n - N/2))`, f in cycles per sample. For
    /// unresolved tones and tones of a wrong sign the phase has no meaning.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::number"))]
    pub phase: f32,
    /// One standard deviation of the phase, radians.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::sigma"))]
    pub sigma_phase: f32,
}

/// The phase of a fit at bin `peak` and its standard deviation, for a noise power per sample of
/// `noise` squared codes: `sqrt(N noise / (2 |line|^2))`, which is the Cramer-Rao bound. A fit that
/// reads `reach` bins on each side loses `2 sin^2(pi d) / (pi^2 (reach + 1/2))` of a line's power.
pub(super) fn phase(
    iq: bool,
    fit: &Fit<f32>,
    peak: i32,
    n: usize,
    reach: Reach,
    noise: f32,
) -> [f32; 2] {
    let d = fit.offset;
    // A line is turned by pi d, an I/Q line by (1 - 1/N) pi d. The middle is pi (peak + d) on.
    let rest = if iq { d * PI / n.max(1) as f32 } else { 0.0 };
    let half = if peak & 1 == 0 { 0.0 } else { PI };
    let phase = f32::angle(fit.line) + rest + half;
    let phase = if phase > PI { phase - 2.0 * PI } else { phase };
    let sine = PI * d * crate::math::series::line_shape(d);
    let lost = 2.0 * sine * sine / (PI * PI * (reach.bins() as f32 + 0.5));
    let variance = 0.5 * n as f32 * noise / fit.line.norm_sqr() / (1.0 - lost);
    [phase, variance.root()]
}
