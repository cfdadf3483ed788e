//! The louder half of a residual.

use crate::spectrum::bins::REACH;
use num_complex::Complex;

/// The bins on both sides of a peak, and the peak.
pub(crate) const WIDTH: usize = 2 * REACH + 1;

/// The mean power of the louder half of the residual in the bins around a peak, 3 to 16 away on each side. The ends of a real spectrum may
/// leave out some of these bins.
#[inline(never)]
pub(crate) fn louder(bins: &[Complex<f32>; WIDTH], iq: bool, n: usize, peak: i32) -> f32 {
    /// With fewer bins the residual decides nothing.
    const FEWEST: usize = 4;
    /// Bins 9 to 16 and 3 to 8 below the peak, and above it.
    const STRETCHES: [(usize, usize); 4] =
        [(0, REACH - 8), (REACH - 8, REACH - 2), (REACH + 3, REACH + 9), (REACH + 9, WIDTH)];
    let last = n as i32 / 2 - 1;
    let room = if iq { [i32::MAX; 2] } else { [peak.wrapping_sub(1), last.wrapping_sub(peak)] };
    let [below, above] = room.map(|room| room.max(0).min(REACH as i32) as usize);
    let (first, end) = (REACH - below, REACH + 1 + above);
    let (mut loudest, mut second) = (0.0, 0.0);
    for (from, to) in STRETCHES {
        let bins = bins.get(from.max(first)..to.min(end)).unwrap_or_default();
        if bins.len() < FEWEST {
            continue;
        }
        let mean = bins.iter().map(Complex::norm_sqr).sum::<f32>() / bins.len() as f32;
        if mean > loudest {
            (second, loudest) = (loudest, mean);
        } else if mean > second {
            second = mean;
        }
    }
    0.5 * (loudest + second)
}
