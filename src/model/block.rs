//! The model of the bins around a peak: its window, its noise, and whether the line is a tone at all.

use super::{Answer, Effort, Noise, Window, measure};
use crate::acquire::sample::Record;
use crate::spectrum::neighbourhood::Neighbourhood;
use crate::tone::arithmetic::Arithmetic;
use crate::tone::detection::{Less, Threshold};
use crate::tone::fit::{Course, Fit, Reach, fit_near};
use crate::tone::noise::ring::{self, Beside};

/// What a block's model says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Of the tone.
    pub answer: Answer,
    /// The line exceeds the noise.
    pub detected: bool,
    /// The noise of a bin by the ring.
    pub noise: Noise,
}

/// The bins around a peak, in codes.
pub fn window_of(near: &Neighbourhood) -> Window {
    Window::new(near.n, near.iq, near.peak, |i| near.bin(near.peak.wrapping_add(i)))
}

/// The share of a line's power that the integer transform itself leaves in the bins around it.
const TRANSFORM: f32 = 1e-9;

/// The noise of a bin beside a fit: the ring's, and the engine's own.
pub fn noise_of(near: &Neighbourhood, fit: &Fit<f32>, beside: &Beside) -> Noise {
    let unseen = ring::unseen_rounding(near, beside);
    let engine = TRANSFORM * fit.line.norm_sqr() / super::constants::WIDTH as f32;
    let power = (beside.noise.power + unseen) * near.n as f32 + engine;
    Noise { power, freedom: beside.noise.freedom }
}

/// Whether a line exceeds the noise after the last kept cause, and that of the louder side of the ring: one test.
pub fn is_detected(
    near: &Neighbourhood,
    beside: &Beside,
    noise: &Noise,
    answer: &Answer,
    threshold: Threshold,
) -> bool {
    let here = (noise.power * answer.scale).max(beside.loud * near.n as f32);
    let limit = threshold.between().beside(answer.freedom, Less::NOTHING);
    answer.line.norm_sqr() > here * limit
}

/// Measures the tone at a peak; `None` if nothing can be fitted.
pub fn measure_near<R: Record, const N: usize>(
    near: &Neighbourhood,
    threshold: Threshold,
    effort: Effort,
) -> Option<Seen> {
    let fit = fit_near::<R, N>(near, Arithmetic::Float, Reach::Sixteen, Course::Usual)?;
    let beside = ring::beside::<R, N>(near, &fit, Arithmetic::Float);
    let noise = noise_of(near, &fit, &beside);
    let answer = measure(&window_of(near), &noise, fit.offset, effort, true);
    let detected = is_detected(near, &beside, &noise, &answer, threshold);
    Some(Seen { answer, detected, noise })
}
