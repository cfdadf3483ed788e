//! Sums of blocks, and bursts in the stream.

use crate::either::Idle;
use crate::meter::{Gathered, Meter};
use core::mem;
use heapless::Vec;
use picket_dsp::accumulate::Accumulator;
use picket_dsp::acquire::sample::{Record, Stamp};
use picket_dsp::config::Config;
use picket_dsp::pipeline::BurstProcessor;
use picket_dsp::pipeline::Measurement;
use picket_dsp::plan::Plan;
use picket_wire::burst::Burst;
use picket_wire::settings::{Mode, Settings};
use picket_wire::sum::Sum;

/// Measures blocks, sums of them, or bursts.
pub struct Gatherer<R: Record, const N: usize> {
    mode: Mode,
    /// The processor; its pipeline measures blocks, too.
    processor: BurstProcessor<R, N>,
    sum: Accumulator<R, N>,
    gathered: Gathered,
    /// The number of the next burst.
    number: u32,
}

impl<R: Record, const N: usize> Gatherer<R, N> {
    /// Keeps the bursts that a block completes.
    #[inline(never)] // their room on the stack is not beside a block's
    fn bursts(&mut self, stamp: &Stamp, samples: &[R::Sample; N]) {
        let Self { gathered, number, processor, .. } = self;
        *gathered = Gathered::Bursts(Vec::new());
        let Gathered::Bursts(bursts) = gathered else { return };
        processor.block(stamp, samples, |&burst| {
            // A burst without room leaves a hole in the numbers.
            let _ = bursts.push(Burst { number: *number, burst, ..Burst::default() });
            *number = number.wrapping_add(1);
        });
        let counters = *processor.counters();
        let pipeline = processor.pipeline();
        for burst in bursts.iter_mut() {
            burst.result = pipeline.outcome(&burst.burst.tone);
            burst.counters = counters;
        }
        if bursts.is_empty() {
            *gathered = Gathered::Nothing;
        }
    }
}

impl<R: Record, const N: usize> Idle for Gatherer<R, N> {
    const IDLE: Self = Self {
        mode: Mode::Blocks,
        processor: BurstProcessor::IDLE,
        sum: Accumulator::IDLE,
        gathered: Gathered::Block,
        number: 0,
    };
}

impl<R: Record, const N: usize> Meter<R, N> for Gatherer<R, N> {
    const SIGNALS: bool = true;

    fn set_plan(&mut self, plan: Plan<R, N>) {
        self.processor.pipeline().set_plan(plan);
    }

    fn choose(&mut self, settings: &Settings) {
        let &Settings { mode, config: Config { false_alarm, .. }, .. } = settings;
        self.mode = mode;
        match mode {
            Mode::Blocks | Mode::Frames { .. } => {}
            Mode::Accumulate { blocks, drift_bins } => {
                self.sum.set_plan(blocks, drift_bins, false_alarm);
            }
            Mode::Bursts(trigger) => {
                let plan = *self.processor.pipeline().plan();
                self.processor.set_plan(plan, trigger);
            }
        }
    }

    #[inline(never)] // once in an image, not in each place that measures
    fn block(&mut self, stamp: &Stamp, samples: &mut [R::Sample; N]) -> Measurement {
        if let Mode::Bursts(_) = self.mode {
            self.bursts(stamp, samples);
            return Measurement { stamp: *stamp, ..Measurement::default() };
        }
        let pipeline = self.processor.pipeline();
        let (clipped, tone) = pipeline.tone(stamp, samples);
        let result = pipeline.outcome(&tone);
        let mut measurement = Measurement { stamp: *stamp, clipped, tone, result };
        if let Mode::Accumulate { .. } = self.mode {
            self.gathered = match self.sum.add(&measurement, pipeline) {
                None => Gathered::Nothing,
                Some(sum) => {
                    measurement.tone = sum.tone;
                    measurement.result = pipeline.outcome(&sum.tone);
                    let (sequence, ln_chance) = (stamp.sequence, sum.ln_chance);
                    Gathered::Sum(Sum { sequence, blocks: sum.blocks, ln_chance })
                }
            };
        }
        measurement
    }

    fn gathered(&mut self) -> Gathered {
        mem::replace(&mut self.gathered, Gathered::Block)
    }
}
