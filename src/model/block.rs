//! The joint fit of the bins around a peak: their window, their noise, and whether the line is a tone at all.

use super::{Answer, Noise, Window, measure};
use crate::spectrum::engine::RESIDUE;
use crate::spectrum::neighbourhood::Neighbourhood;
use crate::tone::effort::Effort;
use crate::tone::fit::Fit;
use crate::tone::noise::ring::LocalNoise;
use crate::tone::threshold::{Relaxation, Threshold};

/// The bins around a peak, in codes.
fn window_of(near: &Neighbourhood) -> Window {
    Window::new(near.n, near.iq, near.peak, |i| near.bin(near.peak.wrapping_add(i)))
}

/// The share of a line's power that the integer transform itself leaves in the bins around it.
const TRANSFORM: f32 = RESIDUE as f32;

/// The noise of a bin beside a fit: the ring's, and the engine's own.
fn noise_of(near: &Neighbourhood, fit: &Fit<f32>, beside: &LocalNoise) -> Noise {
    let engine = TRANSFORM * fit.line.norm_sqr() / super::constants::WIDTH as f32;
    let power = beside.noise.power * near.n as f32 + engine;
    Noise { power, dof: beside.noise.dof }
}

/// Whether a line exceeds the largest of three noises: after the last kept cause, in the louder half of the residual beside the line, and
/// on the louder side of the ring. This is a single test, so its threshold is not relaxed.
fn is_detected(
    near: &Neighbourhood,
    beside: &LocalNoise,
    noise: &Noise,
    answer: &Answer,
    threshold: Threshold,
) -> bool {
    let left = noise.power * answer.scale.max(answer.louder);
    let here = left.max(beside.loud * near.n as f32);
    let limit = threshold.between().beside(answer.dof, Relaxation::NOTHING);
    answer.line.norm_sqr() > here * limit
}

/// The joint fit's answer for a line that is not a steady tone, its noise power per sample, and whether the line exceeds this noise: if
/// not, the answer is unresolved. `None` if the effort has no rounds, or nothing can be fitted.
#[inline(never)]
pub fn joint(
    near: &Neighbourhood,
    fit: &Fit<f32>,
    beside: &LocalNoise,
    threshold: Threshold,
    effort: Effort,
    bends: bool,
) -> Option<(Answer, f32, bool)> {
    let most = usize::from(effort.available().rounds());
    if most == 0 {
        return None;
    }
    let noise = noise_of(near, fit, beside);
    let mut answer = measure(&window_of(near), &noise, fit.offset, most, bends);
    // A variance that is NaN is invalid, and an offset beyond the bins beside the peak belongs to another line.
    if !(answer.variance > 0.0 && answer.offset.abs() < FARTHEST) {
        return None;
    }
    let found = is_detected(near, beside, &noise, &answer, threshold);
    answer.unresolved |= !found;
    Some((answer, noise.power * answer.scale / near.n as f32, found))
}

/// The largest offset that the joint fit accepts, bins from the peak.
const FARTHEST: f32 = 1.5;
