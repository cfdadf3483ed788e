//! The noise of places, a quarter of which may hold other lines.

use super::Noise;
use crate::list::remove;
use heapless::Vec;

/// The share of a mean's degrees of freedom that are left when the loudest quarter is left out (simulated: .77 to .9 for means of 1 to 400
/// powers).
const LEFT: f32 = 0.82;

/// The noise in some means of `each` exponential powers, of which the loudest quarter is left out; `None` for fewer than two means, and
/// where they are 0. The louder ones are removed from the list.
pub(crate) fn quietest<const ROOM: usize>(means: &mut Vec<f32, ROOM>, each: f32) -> Option<Noise> {
    let all = means.len();
    let kept = all - all / 4;
    while means.len() > kept {
        let loudest = means.iter().copied().fold(0.0, f32::max);
        let at = means.iter().position(|&mean| mean == loudest).unwrap_or(0);
        remove(means, at);
    }
    let mean = means.iter().sum::<f32>() / kept.max(1) as f32;
    // The quietest three quarters of many normal numbers are .42 deviations below their mean, of 8 .379, of 4 .343.
    let below = if all == kept { 0.0 } else { 0.42 - 0.33 / all as f32 };
    let power = mean / (1.0 - below / libm::sqrtf(each));
    (kept >= 2 && power > 0.0).then_some(Noise { power, dof: 2.0 * LEFT * each * all as f32 })
}
