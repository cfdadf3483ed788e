//! The bins around a peak, read once. Fit, noise and verdict are plain functions of a [`Neighbourhood`], and need not know the spectrum's
//! type.

use super::bins::REACH;
use super::fft::integer::Point;
use super::layout::Layout;
use super::view::View;
use crate::math::scalar::Scalar as _;
use core::mem::MaybeUninit;
use num_complex::Complex;

/// Bins from a peak to the first second difference of its ring: the guard interval.
pub const GUARD: i32 = 7;

/// Bins in a group of the ring, which holds half as many second differences, one at every other bin.
pub const GROUP: usize = 8;

/// Groups on each side of the ring.
pub const GROUPS: usize = 4;

/// The most extra groups of one side where an end of the spectrum cuts the other short.
pub const LENT: usize = 2;

/// No group begins below this bin. From it on the second difference of a drift is negligible.
const DRIFT: i32 = 4;

/// Bins on each side of the peak, with room on both.
const SIDE: i32 = GUARD - 1 + (GROUP * GROUPS) as i32;
/// All bins of a fit and its ring: a side that lends groups takes the room of the other.
const RING: usize = 2 * SIDE as usize + 1;

/// All bins of a record without a ring, and the mirrored bins of a fit next to an end.
const SHORT: usize = 128 / 2 - 1 + REACH;

/// Room for the bins of a [`Neighbourhood`].
#[derive(Debug)]
pub struct Places([MaybeUninit<Point>; SHORT]);

impl Places {
    /// Room for bins, none of them read.
    #[inline(always)] // it writes nothing
    pub const fn new() -> Self {
        Self([MaybeUninit::uninit(); SHORT])
    }
}

impl Default for Places {
    fn default() -> Self {
        Self::new()
    }
}

/// The bins around a peak, in stored units.
#[derive(Clone, Debug)]
pub struct Neighbourhood<'a> {
    /// The record's length and kind, with their tables.
    pub layout: &'static Layout,
    /// Samples of the record.
    pub n: usize,
    /// Whether the record is of I/Q pairs.
    pub iq: bool,
    /// The peak's bin.
    pub peak: i32,
    /// The exponent: a stored value times `2^exponent` is in codes.
    pub exponent: i32,
    /// The error in bins that the engine adds to a frequency, see [`View::error`].
    pub engine_error: f32,
    /// The three bins around minus the peak, where an I/Q front end makes an image.
    pub image: [Point; 3],
    /// The ring's groups below the peak and above it.
    pub groups: [usize; 2],
    first: i32,
    bins: &'a [Point],
}

impl<'a> Neighbourhood<'a> {
    /// Reads the bins around the peak; an I/Q record's without its offset. Cost: 77 bins, and three more for I/Q.
    pub fn read(view: &View, peak: i32, places: &'a mut Places) -> Self {
        let Layout { n, iq, .. } = *view.layout;
        let groups = groups(n, iq, peak);
        let (first, count) = if has_ring(n, iq) {
            (peak.wrapping_sub(below(groups)), RING)
        } else {
            let (reach, width) = (REACH as i32, SHORT as i32 - 1);
            (1.max(peak.wrapping_add(reach - width)).min(peak.wrapping_sub(reach)), SHORT)
        };
        let bins = view.fill_beside_offset(first, places.0.get_mut(..count).unwrap_or_default());
        let image = [-1, 0, 1].map(|i: i32| {
            if !iq {
                return [0; 2];
            }
            let Complex { re, im } = view.bin(i.wrapping_sub(peak));
            [re, im]
        });
        Self {
            layout: view.layout,
            n,
            iq,
            peak,
            exponent: view.exponent,
            engine_error: view.error(),
            image,
            groups,
            first,
            bins,
        }
    }

    /// One stored unit in codes.
    pub fn unit(&self) -> f32 {
        f32::two_to(self.exponent)
    }

    /// The bins within `reach` of the peak, at most 16, in ascending order.
    pub fn within(&self, reach: usize) -> &'a [Point] {
        let reach = reach.min(REACH);
        self.from(self.peak.wrapping_sub(reach as i32), 2 * reach + 1)
    }

    /// `count` bins from `first` on; none where the neighbourhood does not hold them all.
    pub fn from(&self, first: i32, count: usize) -> &'a [Point] {
        let start = usize::try_from(first.wrapping_sub(self.first)).unwrap_or(usize::MAX);
        self.bins.get(start..start.saturating_add(count)).unwrap_or_default()
    }

    /// Bin `k` of a record without a ring, in stored units. The neighbourhood holds all bins of such a short record.
    pub fn point(&self, k: i32) -> Point {
        let (n, away) = (self.n as i32, k.wrapping_sub(self.first));
        // An I/Q spectrum is a circle.
        let away = if self.iq { away & (n - 1) } else { away };
        self.bins.get(away as usize).copied().unwrap_or_default()
    }

    /// Bin `k` in codes; zero where the neighbourhood does not hold it.
    pub fn bin(&self, k: i32) -> Complex<f32> {
        let [re, im] = self.from(k, 1).first().copied().unwrap_or_default();
        Complex::new(re as f32, im as f32) * self.unit()
    }

    /// Bins from the peak to the nearer end of a real spectrum. An I/Q spectrum has no end: the distance is large.
    pub fn from_end(&self) -> i32 {
        if self.iq { i32::MAX } else { self.peak.min(self.n as i32 / 2 - self.peak).max(1) }
    }
}

/// Whether a record of `n` samples has room for a ring.
pub const fn has_ring(n: usize, iq: bool) -> bool {
    n >= if iq { 128 } else { 256 }
}

/// The groups that fit below a peak and above it.
pub(crate) fn room(n: usize, iq: bool, peak: i32) -> [usize; 2] {
    let half = n as i32 / 2;
    // A spectrum of I/Q is a circle. The side away from the tone is left out.
    let room = if iq {
        [half - GROUP as i32 - GUARD; 2]
    } else {
        [peak - GUARD - DRIFT + 2, half - peak - GUARD]
    };
    room.map(|room| (room.max(0) / GROUP as i32) as usize)
}

/// The groups of the ring below a peak and above it.
pub fn groups(n: usize, iq: bool, peak: i32) -> [usize; 2] {
    let [left, right] = room(n, iq, peak);
    let lent = |other: usize| GROUPS.saturating_sub(other).min(LENT);
    [left.min(GROUPS + lent(right)), right.min(GROUPS + lent(left))]
}

/// Bins to read below a peak with these groups of its ring: all groups of both sides and the bins of a fit are within a whole ring's number
/// of bins.
fn below([left, right]: [usize; 2]) -> i32 {
    let outermost = |groups: usize| (GUARD - 1 + (GROUP * groups) as i32).max(REACH as i32);
    if right > GROUPS { RING as i32 - 1 - outermost(right) } else { outermost(left.max(GROUPS)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both sides of a ring and the bins of a fit are among the bins that are read, wherever the peak is.
    #[test]
    fn every_group_of_a_ring_is_read() {
        for n in [64, 128, 256, 512, 1024, 4096] {
            for (iq, peak) in
                [false, true].into_iter().flat_map(|iq| (1..n as i32 / 2).map(move |k| (iq, k)))
            {
                let groups = groups(n, iq, peak);
                if !has_ring(n, iq) {
                    continue;
                }
                let below = below(groups);
                let above = RING as i32 - 1 - below;
                let [left, right] = groups.map(|groups| GUARD - 1 + (GROUP * groups) as i32);
                assert!(below >= REACH as i32 && above >= REACH as i32, "{n} {peak}");
                assert!(groups[0] == 0 || below >= left, "{n} {iq} {peak} {groups:?} {below}");
                assert!(groups[1] == 0 || above >= right, "{n} {iq} {peak} {groups:?} {above}");
            }
        }
    }
}
