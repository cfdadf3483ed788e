//! The place of the strongest line in a sum, and the probability that noise alone looks like it.
//!
//! Nine bins and their products up to lag 3 capture all of a centred line's power, and 97 % of that of a line half a bin off; a single bin
//! captures 41 %. The [chance](crate::chance) of such evidence in noise decides.

use super::sums::{Sums, bins};
use crate::chance::ln_of_sum;
use crate::spectrum::layout::Layout;
use crate::spectrum::peak::Band;
use crate::tone::noise::Noise;
use crate::tone::noise::quietest::quietest;
use heapless::Vec;

/// Bins in a group of cells of the noise's reference.
const GROUP: i32 = 8;
/// The most groups on each side, in addition to one on each side that may hold the line's skirt.
const SIDE: i32 = 16;
/// Of four groups the loudest is left out: it may hold another line, or its skirt.
const CELLS: usize = 2 * SIDE as usize;
/// The number of groups on each side for this many blocks. An error of the noise raises the threshold: with 8 groups of 8 bins and 4 blocks
/// by .3 dB. Where many blocks are added fewer bins are accurate enough, and nearer to the line.
const fn side(blocks: u32) -> i32 {
    match blocks {
        0..8 => SIDE,
        8..32 => SIDE / 2,
        _ => SIDE / 4,
    }
}

/// The number of places that are searched closely.
const CANDIDATES: usize = 4;

/// A place where a line is sought.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Peak {
    /// The nearest bin.
    pub bin: i32,
    /// The line's approximate distance beyond the bin, -0.5 to 0.5.
    pub offset: f32,
    /// The mean power of a bin of noise, summed over the blocks.
    pub noise: f32,
    /// The noise's degrees of freedom.
    dof: f32,
    /// The power of line and noise together, over that of the noise, summed over the blocks.
    evidence: f32,
}

impl Peak {
    /// The place of most evidence in the band; `None` where all sums are 0 or no bin is free for the noise.
    pub fn strongest(sums: &Sums, band: Band) -> Option<Self> {
        let Layout { n, iq, .. } = *sums.layout;
        let group = if n >= 256 { GROUP } else { GROUP / 2 };
        let bins = bins(sums.layout);
        let count = (bins.high - bins.low + 1) / group;
        let mut best = Vec::<(f32, Peak), CANDIDATES>::new();
        for index in 0..count {
            let Some(Noise { power: noise, dof }) = noise(sums, index, count, group) else {
                continue;
            };
            let first = bins.low + index * group;
            // The last group includes the remaining bins.
            let last = if index + 1 == count { bins.high } else { first + group - 1 };
            for k in first..=last {
                // An I/Q band may count from below 0.
                let inside = |k| (band.low..=band.high).contains(&k);
                if !(inside(k) || iq && inside(k - n as i32)) {
                    continue;
                }
                // The line in the bin, and half a bin above, where two bins hold 81 %.
                let here = sums.power(k) as f32;
                let both = here + sums.power(k + 1) as f32 - 2.0 * sums.product(k, 1) as f32;
                let half = 0.5 / 0.81 * both;
                let (size, offset) = if half > here { (half, 0.5) } else { (here, 0.0) };
                let ratio = size / noise;
                let place = Peak { bin: k, offset, noise, dof, evidence: 0.0 };
                keep(&mut best, ratio, place);
            }
        }
        let places = best.iter().map(|(_, place)| place.refined(sums));
        places.max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    }

    /// The place near this one where a line fits best.
    fn refined(&self, sums: &Sums) -> Self {
        /// Steps of an eighth of a bin: between two of them a line's power falls by at most .6 %.
        const STEPS: i32 = 6;
        let mut best = *self;
        let data = super::fit::data(sums, self);
        for step in -STEPS..=STEPS {
            let offset = self.offset + 0.125 * step as f32;
            let evidence = super::fit::evidence(&data, sums.scale.blocks, sums.layout.n, offset);
            if evidence > best.evidence {
                best.evidence = evidence;
                let nearest = libm::rintf(offset);
                best.bin = self.bin + nearest as i32;
                best.offset = offset - nearest;
            }
        }
        best
    }

    /// The natural logarithm of the probability that noise reaches this evidence somewhere in `width` bins.
    pub fn ln_chance(&self, blocks: u32, width: u32) -> f32 {
        ln_of_sum(self.evidence, blocks, width, self.dof)
    }
}

/// Keeps a place among the best if no better one is within four bins of it.
fn keep(best: &mut Vec<(f32, Peak), CANDIDATES>, ratio: f32, place: Peak) {
    const APART: i32 = 4;
    if best.iter().any(|(other, at)| (at.bin - place.bin).abs() < APART && *other >= ratio) {
        return;
    }
    best.retain(|(_, at)| (at.bin - place.bin).abs() >= APART);
    if best.is_full() {
        let least = best.iter().fold(f32::INFINITY, |least, (other, _)| least.min(*other));
        if least >= ratio {
            return;
        }
        let mut taken = false;
        best.retain(|(other, _)| {
            let keep = taken || *other > least;
            taken |= !keep;
            keep
        });
    }
    // There is room.
    let _ = best.push((ratio, place));
}

/// The mean of the sums of bins of noise next to group `index`.
fn noise(sums: &Sums, index: i32, count: i32, group: i32) -> Option<Noise> {
    let low = bins(sums.layout).low;
    let mut means = Vec::<f32, CELLS>::new();
    for distance in 2..2 + side(sums.scale.blocks) {
        for other in [index - distance, index + distance] {
            let other =
                if sums.layout.iq { other.checked_rem_euclid(count).unwrap_or(0) } else { other };
            if !(0..count).contains(&other) {
                continue;
            }
            let first = low + other * group;
            let sum: u64 = (first..first + group).map(|k| u64::from(sums.power(k))).sum();
            // There is room.
            let _ = means.push(sum as f32 / group as f32);
        }
    }
    quietest(&mut means, (group as u32 * sums.scale.blocks.max(1)) as f32)
}
