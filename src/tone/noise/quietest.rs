//! The noise of places, a quarter of which may hold other lines.

use crate::list::remove;
use heapless::Vec;

/// The mean of the quietest three quarters of some means, and by how many of their standard deviations it lies below the mean of all; `None`
/// for fewer than two. The louder ones are removed.
pub(crate) fn quietest<const ROOM: usize>(means: &mut Vec<f32, ROOM>) -> Option<(f32, f32)> {
    let all = means.len();
    let kept = all - all / 4;
    while means.len() > kept {
        let loudest = means.iter().copied().fold(0.0, f32::max);
        let at = means.iter().position(|&mean| mean == loudest).unwrap_or(0);
        remove(means, at);
    }
    let mean = means.iter().sum::<f32>() / kept.max(1) as f32;
    // The quietest three quarters of many normal numbers are .42 deviations below their mean, of 8 .379, of 4 .343.
    let left_out = if all == kept { 0.0 } else { 0.42 - 0.33 / all as f32 };
    (kept >= 2).then_some((mean, left_out))
}
