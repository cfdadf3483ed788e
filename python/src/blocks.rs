//! Blocks, each by itself.

use crate::native::{Native, Work};
use crate::tables::{self, BlockRow, joined};
use picket_dsp::spectrum::engine::Engine;
use picket_dsp::{Pipeline, Plan, Record, Stamp, ToneWithPhase};
use rayon::prelude::*;
use std::ops::Range;

/// The strongest tone of every block.
pub struct Blocks<'a> {
    pub words: &'a [i16],
    pub hop: usize,
    pub phase: bool,
    pub threads: usize,
    /// The numbers of the samples that are missing, in order.
    pub missing: &'a [u64],
}

impl Work for Blocks<'_> {
    type Output = Vec<BlockRow>;

    fn run<R: Record, const N: usize, E: Engine>(
        self,
        native: &Native,
        plan: Plan<R, N>,
    ) -> Vec<BlockRow> {
        let count = native.count(self.words, self.hop);
        let some = |blocks: Range<usize>| {
            let mut rows = Vec::with_capacity(blocks.len());
            let mut pipeline = Box::new(Pipeline::<R, N, E>::new(plan));
            native.records::<R, N>(self.words, self.hop, blocks, |stamp, samples| {
                let next = self.missing.partition_point(|&number| number < stamp.clock);
                let next = self.missing.get(next).copied().unwrap_or(u64::MAX);
                let gap = next < stamp.clock.saturating_add(N as u64);
                let seen = pipeline.block(&Stamp { gap, ..stamp }, samples);
                let lines = if self.phase { pipeline.lines(&seen, 1) } else { Default::default() };
                rows.push(tables::block(&seen, lines.first()));
            });
            rows
        };
        // Whole chirps, so that every part begins with a first segment; some hundred blocks, so that a part is worth a thread.
        let chirp = native.timing(self.hop).segments.len().max(1);
        let part = count.div_ceil(4 * self.threads.max(1)).max(64).next_multiple_of(chirp);
        // A chirp's hypotheses lead to those of the next: such chirps have one thread.
        if self.threads <= 1 || count <= part || chirp > 1 {
            return some(0..count);
        }
        let parts: Vec<_> = (0..count).step_by(part).collect();
        let parts = parts.into_par_iter().map(|from| some(from..(from + part).min(count)));
        parts.flatten_iter().collect()
    }
}

/// The fundamental of every block's harmonics up to an order.
pub struct Harmonics<'a> {
    pub words: &'a [i16],
    pub hop: usize,
    pub order: u32,
}

impl Work for Harmonics<'_> {
    type Output = Vec<[f64; 2 + tables::TONE]>;

    fn run<R: Record, const N: usize, E: Engine>(
        self,
        native: &Native,
        plan: Plan<R, N>,
    ) -> Self::Output {
        let mut rows = Vec::new();
        let mut pipeline = Box::new(Pipeline::<R, N, E>::new(plan));
        let blocks = 0..native.count(self.words, self.hop);
        native.records::<R, N>(self.words, self.hop, blocks, |stamp, samples| {
            let seen = pipeline.block(&stamp, samples);
            let found = pipeline.harmonic(&seen, self.order);
            let (tone, orders) =
                found.map_or_else(Default::default, |found| (found.tone, found.orders));
            rows.push(joined([&[stamp.clock as f64, orders.into()], &tables::tone(&tone)]));
        });
        rows
    }
}

/// All tones of one block.
pub struct Lines<'a> {
    pub words: &'a [i16],
    pub most: usize,
}

impl Work for Lines<'_> {
    type Output = Vec<[f64; tables::TONE + 2]>;

    fn run<R: Record, const N: usize, E: Engine>(
        self,
        native: &Native,
        plan: Plan<R, N>,
    ) -> Self::Output {
        let mut rows = Vec::new();
        let mut pipeline = Box::new(Pipeline::<R, N, E>::new(plan));
        native.records::<R, N>(self.words, N, 0..1, |stamp, samples| {
            let seen = pipeline.block(&stamp, samples);
            let row = |line: ToneWithPhase| {
                joined([&tables::tone(&line.tone), &tables::phase(Some(&line))])
            };
            rows.extend(pipeline.lines(&seen, self.most).into_iter().map(row));
        });
        rows
    }
}
