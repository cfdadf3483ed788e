//! Sums of the spectra of many blocks.

use crate::native::{Native, Work};
use crate::tables::{self, joined};
use picket_dsp::spectrum::engine::Engine;
use picket_dsp::{Accumulator, Pipeline, Plan, Record, Segment};

/// Every complete sum of this many blocks.
pub struct Sums<'a> {
    pub words: &'a [i16],
    pub hop: usize,
    pub blocks: u32,
    pub segment: Segment,
    pub drift_bins: f32,
    pub false_alarm: Option<f64>,
}

impl Work for Sums<'_> {
    type Output = Vec<[f64; 3 + tables::TONE]>;

    fn run<R: Record, const N: usize, E: Engine>(
        self,
        native: &Native,
        plan: Plan<R, N>,
    ) -> Self::Output {
        let mut rows = Vec::new();
        let mut sum = Accumulator::<R, N>::new(self.blocks).with_drift(self.drift_bins);
        if let Some(probability) = self.false_alarm {
            sum = sum.with_false_alarm(probability);
        }
        if self.segment != Segment::Continuous {
            sum = sum.for_segment(self.segment);
        }
        let mut sum = Box::new(sum);
        let mut pipeline = Box::new(Pipeline::<R, N, E>::new(plan));
        let count = native.count(self.words, self.hop);
        let mut first = 0;
        native.records::<R, N>(self.words, self.hop, 0..count, |stamp, samples| {
            if sum.added() == 0 {
                first = stamp.clock;
            }
            let seen = pipeline.block(&stamp, samples);
            if let Some(seen) = sum.add(&seen, &pipeline) {
                let head = [first as f64, seen.blocks.into(), seen.ln_chance.into()];
                rows.push(joined([&head, &tables::tone(&seen.tone)]));
            }
        });
        rows
    }
}
