//! The search for the bin that stands out of its own neighbourhood most.

use super::super::detection::Less;
use super::super::noise::rounding;
use super::super::several::first;
use super::leak::LEAKS;
use super::{DRIFT, Hunt, apart};
use crate::acquire::sample::Record;
use crate::spectrum::engine::Engine;
use core::mem::MaybeUninit;
use heapless::Vec;

/// The most blocks of bins, and the least bins of a block.
const BLOCKS: usize = 64;
const BLOCK: i32 = 8;

/// No block has a tone whose strongest difference exceeds its floor by less.
const LEAST: f32 = 5.0;

/// Blocks on each side that a block's floor is taken from.
const AROUND: usize = 4;

/// The second differences of neighbouring bins.
#[derive(Clone, Copy, Default)]
struct Block {
    /// The mean power of all but the strongest.
    mean: f32,
    /// The strongest one.
    most: f32,
    bin: i32,
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

    /// The block, its mean not below `least`. A block of which little is left is no floor.
    fn block(&self, least: f32) -> Block {
        let mean = ((self.sum - self.most) / (self.count - 1).max(1) as f32).max(least);
        let mean = if self.count < BLOCK / 2 { f32::INFINITY } else { mean };
        Block { mean, most: self.most, bin: self.bin }
    }
}

impl<R: Record, const N: usize, E: Engine> Hunt<'_, R, N, E> {
    /// The bin that exceeds its neighbourhood most, if noise does not.
    pub(super) fn search(&self) -> Option<i32> {
        let blocks = self.blocks();
        let (mut highest, mut best) = (LEAST, None);
        for (index, block) in blocks.iter().enumerate() {
            // The floor is not below the quietest of its blocks.
            let around = around(&blocks, index);
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

    /// The blocks of the band, from windows of its bins.
    fn blocks(&self) -> Vec<Block, BLOCKS> {
        let (low, high) = if R::IQ {
            (self.band.low, self.band.high)
        } else {
            (self.band.low.max(DRIFT), self.band.high.min(N as i32 / 2 - 2))
        };
        let width = ((high - low) / BLOCKS as i32 + 1).max(BLOCK);
        let least = rounding::<R>() * 1.5 * N as f32;
        let mut blocks = Vec::new();
        let mut next = low;
        while next <= high {
            let (mut gathered, end) =
                (Gathered::new(next), next.saturating_add(width).min(high + 1));
            while next < end {
                let count = (end - next).min(BLOCK);
                self.gather(next, count as usize, &mut gathered);
                next += count;
            }
            if blocks.push(gathered.block(least)).is_err() {
                break;
            }
        }
        blocks
    }

    /// Takes the differences around at most [`BLOCK`] bins from `first` on.
    fn gather(&self, first: i32, count: usize, gathered: &mut Gathered) {
        let mut places = [MaybeUninit::uninit(); BLOCK as usize + 2];
        let places = places.get_mut(..count + 2).unwrap_or_default();
        let points = self.rest.spectrum.fill(first - 1, places);
        let plain = self.is_plain(first, first + count as i32);
        for (k, around) in (first..).zip(points.array_windows()) {
            let around = self.wide(around);
            if plain {
                let [before, here, after] = around;
                gathered.add(k, ((before + after) * 0.5 - here).norm_sqr());
            } else if !self.is_hidden(k) {
                gathered.add(k, self.difference(k, around).norm_sqr());
            }
        }
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
