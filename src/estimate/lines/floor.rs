//! The search for the bin that stands out of its own neighbourhood most.

use super::super::detection::Less;
use super::super::noise::rounding;
use super::super::several::first;
use super::leak::LEAKS;
use super::{DRIFT, Hunt, apart};
use crate::acquire::sample::Record;
use crate::spectrum::engine::Engine;
use crate::spectrum::fft::integer::Point;
use core::mem::MaybeUninit;
use heapless::Vec;

/// The most blocks of bins, and the least bins of a block.
pub(super) const BLOCKS: usize = 64;
const BLOCK: i32 = 8;

/// No block has a tone whose strongest difference exceeds its floor by less.
const LEAST: f32 = 5.0;

/// Blocks on each side that a block's floor is taken from.
const AROUND: usize = 4;

/// The second differences of neighbouring bins.
#[derive(Clone, Copy, Default)]
pub(super) struct Block {
    /// The mean power of all but the strongest.
    mean: f32,
    /// The strongest one.
    most: f32,
    bin: i32,
    /// Whether no tone reaches it, so that it stays as it is.
    plain: bool,
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

    fn add(&mut self, k: i32, power: f32) {
        (self.sum, self.count) = (self.sum + power, self.count + 1);
        if power > self.most {
            (self.most, self.bin) = (power, k);
        }
    }

    /// The block in units of `scale`, its mean not below `least`. A block of which little is left is no
    /// floor.
    fn block(&self, scale: f32, least: f32, plain: bool) -> Block {
        let mean = (self.sum - self.most) / (self.count - 1).max(1) as f32;
        let mean = (scale * mean).max(least);
        let mean = if self.count < BLOCK / 2 { f32::INFINITY } else { mean };
        Block { mean, most: scale * self.most, bin: self.bin, plain }
    }
}

impl<R: Record, const N: usize, E: Engine> Hunt<'_, R, N, E> {
    /// The bin that exceeds its neighbourhood most, if noise does not.
    pub(super) fn search(&mut self) -> Option<i32> {
        let before = core::mem::take(&mut self.blocks);
        self.blocks = self.renewed(&before);
        let (mut highest, mut best) = (LEAST, None);
        for (index, block) in self.blocks.iter().enumerate() {
            // The floor is not below the quietest of its blocks.
            let around = around(&self.blocks, index);
            let quietest = around.iter().map(|block| block.mean).fold(f32::INFINITY, f32::min);
            if block.most <= highest * quietest {
                continue;
            }
            let floor = floor(around);
            if block.most > highest * floor {
                (highest, best) = (block.most / floor, Some(block.bin));
            }
        }
        // The floor is that of six blocks of eight or more.
        const FREEDOM: f32 = 80.0;
        let detected = self.options.threshold.detects_beside(highest, FREEDOM, Less::Some);
        best.filter(|_| detected).map(|bin| self.summit(bin))
    }

    /// The strongest bin up the slope from this one: the slope of a strong tone may stand out of its
    /// block more than the tone of the next.
    fn summit(&self, bin: i32) -> i32 {
        let mut summit = bin;
        for _ in 0..BLOCK {
            let here = self.power(summit);
            let stronger = |k: &i32| !self.is_hidden(*k) && self.power(*k) > here;
            match [summit - 1, summit + 1].into_iter().find(stronger) {
                Some(next) => summit = next,
                None => break,
            }
        }
        summit
    }

    /// The blocks of the band. Those of the last search that no tone reaches are taken over.
    fn renewed(&self, before: &[Block]) -> Vec<Block, BLOCKS> {
        let (low, high) = if R::IQ {
            (self.band.low, self.band.high)
        } else {
            (self.band.low.max(DRIFT), self.band.high.min(N as i32 / 2 - 2))
        };
        let width = ((high - low) / BLOCKS as i32 + 1).max(BLOCK);
        let mut blocks = Vec::new();
        let mut next = low;
        while next <= high {
            let end = next.saturating_add(width).min(high + 1);
            let plain = self.is_plain(next, end);
            let same = before.get(blocks.len()).filter(|block| block.plain && plain);
            let block = same.copied().unwrap_or_else(|| self.block(next, end, plain));
            if blocks.push(block).is_err() {
                break;
            }
            next = end;
        }
        blocks
    }

    /// The block of the bins from `next` to before `end`, from windows of them.
    fn block(&self, mut next: i32, end: i32, plain: bool) -> Block {
        let mut gathered = Gathered::new(next);
        while next < end {
            let count = (end - next).min(BLOCK);
            let mut places = [MaybeUninit::uninit(); BLOCK as usize + 2];
            let places = places.get_mut(..count as usize + 2).unwrap_or_default();
            let points = self.rest.spectrum.fill(next - 1, places);
            for (k, around) in (next..).zip(points.array_windows()) {
                if plain {
                    gathered.add(k, twice(around));
                } else if !self.is_hidden(k) {
                    gathered.add(k, self.difference(k, self.wide(around)).norm_sqr());
                }
            }
            next += count;
        }
        let unit = self.rest.unit;
        let scale = if plain { 0.25 * unit * unit } else { 1.0 };
        gathered.block(scale, rounding::<R>() * 1.5 * N as f32, plain)
    }

    /// Whether no bin from `first` to before `end` is hidden, or reached by a tone.
    fn is_plain(&self, first: i32, end: i32) -> bool {
        let (middle, half) = ((first + end) / 2, (end - first) / 2 + 1);
        let far = |bin: i32, from: i32| apart::<R, N>(middle, bin) > from + half;
        // An image of a real tone near an end of the spectrum.
        let inside = R::IQ || middle > LEAKS + half && middle < N as i32 / 2 - LEAKS - half;
        inside
            && self.rest.found.iter().all(|found| far(found.peak, LEAKS))
            && self.hidden.iter().all(|hidden| far(hidden.bin, hidden.width))
            && (!R::IQ || far(0, DRIFT))
    }
}

/// The power of the whole second difference, in stored units. Bins leave the room that three of them
/// need.
fn twice(&[[a, b], [c, d], [e, f]]: &[Point; 3]) -> f32 {
    let second = |before: i32, here: i32, after: i32| {
        (before >> 1).wrapping_add(after >> 1).wrapping_sub(here) as f32 * 2.0
    };
    let (re, im) = (second(a, c, e), second(b, d, f));
    re * re + im * im
}

/// The blocks that a block's floor is taken from.
fn around(blocks: &[Block], index: usize) -> &[Block] {
    let end = index.saturating_add(AROUND + 1).min(blocks.len());
    blocks.get(index.saturating_sub(AROUND)..end).unwrap_or_default()
}

/// The floor of a block: the mean of the quieter two thirds of its neighbours.
fn floor(around: &[Block]) -> f32 {
    let mut means: Vec<f32, { 2 * AROUND + 1 }> = first(around.iter().map(|block| block.mean));
    means.retain(|mean| mean.is_finite());
    let means = means.as_mut_slice();
    // By insertion: nine numbers.
    for end in 1..means.len() {
        for place in (1..=end).rev() {
            if let Some([before, here]) = means.get_mut(place - 1..=place)
                && here < before
            {
                core::mem::swap(before, here);
            }
        }
    }
    let kept = (2 * means.len() / 3).max(1);
    let sum: f32 = means.iter().take(kept).sum();
    if means.is_empty() { f32::INFINITY } else { sum / kept as f32 }
}
