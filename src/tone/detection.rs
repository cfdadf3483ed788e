//! Decides whether a peak is a tone, or the largest of many bins of noise: the threshold, and the two comparisons that decide most lines.
//! A line must exceed the floor of its band. If it is far above the loudest noise next to it, no other test is needed; otherwise
//! `close_detection` has the tests that it must pass.
//!
//! [`threshold`](super::threshold) has the threshold.

use super::close_detection::louder_half;
use super::detector::{Detector, HUMPED};
use super::fit::Fit;
use super::noise::ring::{self, LocalNoise};
use super::observer::Tap;
use super::options::Options;
use super::threshold::Threshold;
use crate::math::scalar::Scalar as _;
use crate::spectrum::neighbourhood::{Neighbourhood, has_ring};
use crate::spectrum::peak::Peak;
use crate::spectrum::view::View;

/// Tests whether the line at a peak exceeds the floor of its band, the noise of the louder side, and the fit's residual from 3 bins on.
/// Returns the factor by which sigma must grow because noise may have raised the line, or `None` if the line is not detected.
pub(super) fn stands_out(
    view: &View,
    near: &Neighbourhood,
    peak: &Peak,
    fit: &Fit<f32>,
    beside: &LocalNoise,
    options: &Options,
    observer: impl Tap,
) -> Option<f32> {
    let &Neighbourhood { n, iq, exponent, .. } = near;
    let threshold = options.threshold;
    let arithmetic = options.arithmetic.available();
    let detector = Detector::from_peak(n, iq, peak, fit, exponent, threshold, observer)?;
    if let Some(decided) = detector.decided(beside, observer) {
        return decided.then_some(1.0);
    }
    let wide = ring::loud(view, near, fit, beside, arithmetic).unwrap_or(*beside);
    let floor = peak.floor as f32 * f32::two_to(2 * exponent) / peak.floor_bins.max(1) as f32;
    let tested = detector.tested(&wide, Threshold::has_floor(peak).then_some(floor));
    let exceeds = detector.exceeds(beside, &wide, tested, observer)
        && (!(n < HUMPED && has_ring(n, iq) && beside.has_sides())
            || detector.exceeds_half(louder_half(near, fit), tested.then_some(floor), observer));
    exceeds.then(|| detector.selection(beside.noise.power))
}
