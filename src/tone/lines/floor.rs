//! The search for the bin that exceeds its own neighbourhood most.
//!
//! The second differences of a band are cut into at most [`BLOCKS`] blocks. The floor of a block is the mean power of the quieter two
//! thirds of the blocks around it, so that other lines do not raise it. The candidate is the strongest difference of the block that exceeds
//! its floor by the largest factor, if the factor is beyond the threshold for the floor's degrees of freedom. Between two searches only the
//! blocks that a new tone has changed are read again.

use super::super::noise::rounding;
use super::super::threshold::Relaxation;
use super::leak::{CHUNK, bent};
use super::{BESIDE, DRIFT, Hunt};
use crate::spectrum::fft::integer::Point;
use crate::spectrum::layout::Layout;
use crate::spectrum::peak::Band;
use core::mem::MaybeUninit;
use heapless::Vec;
use num_complex::Complex;

/// The most blocks of bins, and the least number of bins in a block.
const BLOCKS: usize = 64;
const BLOCK: i32 = 8;

/// Blocks on each side that a block's floor is taken from.
const AROUND: usize = 4;

/// The second differences of neighbouring bins.
#[derive(Clone, Copy)]
struct Block {
    /// The mean power of all differences but the strongest.
    mean: f32,
    /// The power of the strongest difference.
    most: f32,
    bin: i32,
    /// The floor, and the ratio of the strongest difference to it: 0 if the strongest does not stand out.
    floor: f32,
    rise: f32,
}

/// The blocks of a band.
pub(super) struct Blocks {
    all: Vec<Block, BLOCKS>,
    low: i32,
    high: i32,
    width: i32,
    /// A bit for each block that has changed, and for each block that stood out when it was read.
    stale: u64,
    risen: u64,
}

/// A bin that stands out.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    pub bin: i32,
    /// The power of the noise's differences near the bin.
    pub floor: f32,
}

impl Blocks {
    #[inline(always)] // a constant would be copied
    pub fn new() -> Self {
        Self { all: Vec::new(), low: 0, high: -1, width: BLOCK, stale: u64::MAX, risen: 0 }
    }

    /// Sets up the blocks of a band, none of them read.
    pub fn start(&mut self, layout: &'static Layout, band: Band) {
        let (low, high) = if layout.iq {
            (band.low, band.high)
        } else {
            (band.low.max(DRIFT), band.high.min(layout.n as i32 / 2 - 2))
        };
        let width = ((high - low) / BLOCKS as i32 + 1).max(BLOCK);
        let mut first = low;
        while first <= high {
            let block = Block { mean: 0.0, most: 0.0, bin: first, floor: 0.0, rise: 0.0 };
            if self.all.push(block).is_err() {
                break;
            }
            first += width;
        }
        (self.low, self.high, self.width) = (low, high, width);
    }

    /// Marks the blocks within `reach` of a bin as changed. Only blocks that stood out can hold a tone: the others are not read again.
    pub fn touch(&mut self, layout: &'static Layout, bin: i32, reach: i32) {
        let n = layout.n as i32;
        self.mark(bin - reach, bin + reach);
        if layout.iq {
            self.mark(bin - reach + n, bin + reach + n);
            self.mark(bin - reach - n, bin + reach - n);
        }
    }

    fn mark(&mut self, first: i32, last: i32) {
        let (first, last) = (first.max(self.low), last.min(self.high));
        if first <= last {
            let [from, to] = [first, last]
                .map(|k| (k - self.low).checked_div(self.width).unwrap_or(0).clamp(0, 63) as u32);
            self.stale |= (u64::MAX << from) & (u64::MAX >> (63 - to)) & self.risen;
        }
    }

    /// The blocks from which the floor of a block is taken.
    fn around(&self, index: usize) -> &[Block] {
        let end = index.saturating_add(AROUND + 1).min(self.all.len());
        self.all.get(index.saturating_sub(AROUND)..end).unwrap_or_default()
    }

    /// The floor of a block: the mean of the quieter two thirds of its neighbours.
    fn floor(&self, index: usize) -> f32 {
        let around = self.around(index);
        // Compared by their bits, as in `quietest_of`.
        const NONE: u32 = f32::INFINITY.to_bits();
        let ([mut first, mut second, mut third], mut count) = ([0; 3], 0);
        for block in around {
            let mean = block.mean.to_bits();
            if mean == NONE {
                continue;
            }
            count += 1;
            if mean > third {
                third = mean.min(second);
                second = mean.max(second).min(first);
                first = mean.max(first);
            }
        }
        if count == 0 {
            return f32::INFINITY;
        }
        let kept = (2 * count / 3).max(1);
        let least = match count - kept {
            0 => NONE,
            1 => first,
            2 => second,
            _ => third,
        };
        // Blocks below the loudest third, and of equal blocks only the number that is kept.
        let (mut sum, mut left) = (0.0, kept);
        for block in around {
            if block.mean.to_bits() < least {
                sum += block.mean;
                left -= 1;
            }
        }
        if left > 0 {
            sum += left as f32 * f32::from_bits(least);
        }
        sum / kept as f32
    }

    /// Compares the blocks that have changed, and the blocks whose floor depends on them. A block that does not exceed its floor by the
    /// factor `least` does not stand out.
    fn compare(&mut self, changed: u64, least: f32) {
        // No floor is below the quietest block.
        let quietest = quietest_of(&self.all);
        let mut near = changed;
        for _ in 0..AROUND {
            near |= (near << 1) | (near >> 1);
        }
        let bar = least * quietest;
        while let Some(index) = next_of(&mut near) {
            let Some(block) = self.all.get_mut(index) else { return };
            let most = block.most;
            (block.floor, block.rise) = (f32::INFINITY, 0.0);
            // No floor is below the quietest block around, either, which rules out nearly all blocks.
            if most <= bar || most <= least * quietest_of(self.around(index)) {
                continue;
            }
            let floor = self.floor(index);
            if let Some(block) = self.all.get_mut(index) {
                let rise = if most > least * floor { most / floor } else { 0.0 };
                (block.floor, block.rise) = (floor, rise);
            }
            self.risen |= 1 << (index as u32 & 63);
        }
    }

    /// The block that stands out most.
    fn highest(&self) -> Option<&Block> {
        let mut highest: Option<&Block> = None;
        let mut risen = self.risen;
        while let Some(index) = next_of(&mut risen) {
            if let Some(block) = self.all.get(index)
                && block.rise > highest.map_or(0.0, |highest| highest.rise)
            {
                highest = Some(block);
            }
        }
        highest
    }
}

/// Clears the lowest bit that is set, and returns its index.
fn next_of(bits: &mut u64) -> Option<usize> {
    let lowest = bits.trailing_zeros();
    *bits &= bits.wrapping_sub(1);
    (lowest < u64::BITS).then_some(lowest as usize)
}

/// The least mean of these blocks.
fn quietest_of(blocks: &[Block]) -> f32 {
    // Numbers above 0 are ordered as their bits, which are compared in fewer instructions.
    let least = blocks.iter().map(|block| block.mean.to_bits());
    f32::from_bits(least.fold(f32::INFINITY.to_bits(), u32::min))
}

impl Hunt<'_> {
    /// The bin that exceeds its neighbourhood most, if noise alone does not explain the bin.
    pub(super) fn search(&mut self) -> Option<Candidate> {
        let stale = core::mem::take(&mut self.blocks.stale);
        let (count, width) = (self.blocks.all.len(), self.blocks.width);
        // The most neighbours for which there is room at once.
        let room = (CHUNK as i32 / width.max(1)).max(1) as usize;
        let mut left = stale;
        while let index = left.trailing_zeros() as usize
            && index < count
        {
            let run = ((left >> (index as u32 & 63)).trailing_ones() as usize).min(room);
            let run = run.min(count - index);
            self.renew(index, run);
            left &= u64::MAX.checked_shl((index + run) as u32).unwrap_or(0);
        }
        // Degrees of freedom of the floor, which is a mean over six blocks of eight or more bins.
        const DOF: f32 = 80.0;
        self.blocks.compare(stale, self.options.threshold.beside(DOF, Relaxation::SOME));
        let &Block { bin, floor, .. } = self.blocks.highest()?;
        Some(Candidate { bin: self.summit(bin), floor })
    }

    /// The strongest bin up the slope from this one: the slope of a strong tone may stand out of its block more than the neighbouring
    /// block's tone.
    fn summit(&self, bin: i32) -> i32 {
        let (mut summit, mut here) = (bin, self.power(bin));
        for _ in 0..BLOCK {
            let stronger = |k: i32| {
                let power = self.power(k);
                (!self.is_hidden(k) && power > here).then_some((k, power))
            };
            match [summit - 1, summit + 1].into_iter().find_map(stronger) {
                Some(next) => (summit, here) = next,
                None => break,
            }
        }
        summit
    }

    /// Reads `run` blocks from `index` on.
    fn renew(&mut self, index: usize, run: usize) {
        let Blocks { low, high, width, .. } = self.blocks;
        let mut places = [MaybeUninit::uninit(); CHUNK + 2];
        let mut differences = Vec::<_, CHUNK>::new();
        let first = low + index as i32 * width;
        let end = (first + run as i32 * width).min(high + 1);
        let least = rounding(self.layout.iq) * 1.5 * self.layout.n as f32;
        let unit = self.rest.unit;
        // A chunk has whole blocks, or is a part of one.
        let whole = width <= CHUNK as i32;
        let (mut next, mut index) = (first, index);
        let mut block = Gathered::new(next);
        while next < end {
            let count = (end - next).min(CHUNK as i32);
            let hidden = self.hides(next, count);
            let points = self.near(next, count as usize, &mut places);
            let reached =
                hidden || self.leaks.iter().any(|leak| leak.reaches(self.layout, next, count));
            if reached {
                self.bend(points, &mut differences);
                self.less_leaks(next, &mut differences);
                self.clear_hidden(next, &mut differences);
            }
            let mut from = 0;
            while from < count as usize {
                let to = (from + width.max(1) as usize).min(count as usize);
                if reached {
                    block.add(next, differences.get(from..to).unwrap_or_default(), hidden);
                } else {
                    block.add_plain(next, points.get(from..to + 2).unwrap_or_default(), unit);
                }
                next += (to - from) as i32;
                from = to;
                if next == end || whole {
                    if let Some(place) = self.blocks.all.get_mut(index) {
                        *place = block.block(least);
                    }
                    index += 1;
                    block = Gathered::new(next);
                }
            }
        }
    }

    /// Calls `see` for every hidden bin, with the number of hidden bins on each side.
    fn each_hidden(&self, mut see: impl FnMut(i32, i32)) {
        let n = self.layout.n as i32;
        let mut each = |bin: i32, width: i32| {
            see(bin, width);
            if self.layout.iq {
                see(bin - n, width);
                see(bin + n, width);
            }
        };
        self.rest.found.iter().for_each(|found| each(found.peak, BESIDE));
        self.hidden.iter().for_each(|hidden| each(hidden.bin, hidden.width));
        if self.layout.iq {
            each(0, DRIFT - 1);
        }
    }

    /// Whether one of `count` bins from `first` on is hidden.
    fn hides(&self, first: i32, count: i32) -> bool {
        let mut any = false;
        self.each_hidden(|bin, width| any |= bin + width >= first && bin - width < first + count);
        any
    }

    /// Clears the differences around hidden bins.
    fn clear_hidden(&self, first: i32, differences: &mut [Complex<f32>]) {
        self.each_hidden(|bin, width| {
            let (from, to) = (bin - width - first, bin + width + 1 - first);
            if to > 0 && from < differences.len() as i32 {
                let (from, to) = (from.max(0) as usize, (to as usize).min(differences.len()));
                differences.get_mut(from..to).unwrap_or_default().fill(Complex::new(0.0, 0.0));
            }
        });
    }
}

/// A block while it grows.
struct Gathered {
    sum: f32,
    most: f32,
    bin: i32,
    count: i32,
}

impl Gathered {
    fn new(bin: i32) -> Self {
        Self { sum: 0.0, most: 0.0, bin, count: 0 }
    }

    /// Adds the differences around the bins from `first` on. Differences that are 0 may be hidden.
    fn add(&mut self, first: i32, differences: &[Complex<f32>], hidden: bool) {
        let (mut sum, mut most, mut bin, mut k) = (self.sum, self.most, self.bin, first);
        for difference in differences {
            let power = difference.norm_sqr();
            sum += power;
            if power > most {
                (most, bin) = (power, k);
            }
            k += 1;
        }
        self.bin = bin;
        let shown = |difference: &&Complex<f32>| difference.re != 0.0 || difference.im != 0.0;
        let count =
            if hidden { differences.iter().filter(shown).count() } else { differences.len() };
        (self.sum, self.most, self.count) = (sum, most, self.count + count as i32);
    }

    /// Adds the differences of points around the bins from `first` on, for bins that no tone reaches.
    fn add_plain(&mut self, first: i32, points: &[Point], unit: f32) {
        let [Some(&before), Some(&here)] = [points.first(), points.get(1)] else { return };
        let ([mut a, mut b], [mut c, mut d]) = (before, here);
        let (mut sum, mut most, mut bin, mut k) = (0.0, 0.0, first, first);
        for &[e, f] in points.get(2..).unwrap_or_default() {
            let [re, im] = bent([a, b], [c, d], [e, f]);
            let power = re as f32 * re as f32 + im as f32 * im as f32;
            (a, b, c, d) = (c, d, e, f);
            sum += power;
            if power > most {
                (most, bin) = (power, k);
            }
            k += 1;
        }
        let scale = unit * unit;
        if scale * most > self.most {
            (self.most, self.bin) = (scale * most, bin);
        }
        (self.sum, self.count) = (self.sum + scale * sum, self.count + k - first);
    }

    /// The block, its mean not below `least`. A block with few visible bins has no floor.
    #[inline]
    fn block(&self, least: f32) -> Block {
        let mean = (self.sum - self.most) / (self.count - 1).max(1) as f32;
        let mean = if self.count < BLOCK / 2 { f32::INFINITY } else { mean.max(least) };
        Block { mean, most: self.most, bin: self.bin, floor: f32::INFINITY, rise: 0.0 }
    }
}
