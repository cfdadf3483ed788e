//! Bursts of a stream.

use super::Pipeline;
use crate::acquire::burst::{BurstDetector, Counters, Trigger};
use crate::acquire::sample::{Record, Stamp};
use crate::burst::Burst;
use crate::plan::Plan;

/// Turns samples into bursts: a detector, and a pipeline that measures each record it cuts.
///
/// ```
/// use picket_dsp::{BurstProcessor, Codes, Plan, Real, Validation};
///
/// let mut processor = BurstProcessor::<Real, 1024>::new(Plan::tone(1e6, Codes::signed::<12>()));
/// let mut state = 1u32;
/// let mut noise = || {
///     state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
///     60.0 * (f64::from(state >> 8) / f64::from(1 << 24) - 0.5)
/// };
/// // One particle: 0.8 radians a sample under an envelope with a standard deviation of 100 samples.
/// let signal = |t: f64| 500.0 * (-t * t / 2e4).exp() * (0.8 * t).cos();
/// let stream: Vec<i16> = (-9000..9000).map(|t| (signal(t.into()) + noise()) as i16).collect();
/// let mut bursts = Vec::new();
/// processor.push(&stream, |burst| bursts.push(*burst));
/// assert!(bursts.len() == 1 && bursts[0].validation == Validation::Valid);
/// assert!((bursts[0].arrival - 9000.0).abs() < 5.0 && (bursts[0].deviation - 100.0).abs() < 5.0);
/// ```
#[derive(Clone, Debug)]
pub struct BurstProcessor<R: Record, const N: usize> {
    detector: BurstDetector<R, N>,
    pipeline: Pipeline<R, N>,
    /// The arrival of the last burst.
    last: Option<f64>,
}

impl<R: Record, const N: usize> BurstProcessor<R, N> {
    /// A placeholder of zeros that waits for [`BurstProcessor::set_plan`]: for static memory.
    pub const IDLE: Self =
        Self { detector: BurstDetector::IDLE, pipeline: Pipeline::new(Plan::IDLE), last: None };

    /// Follows another plan and another trigger from the next sample on.
    pub fn set_plan(&mut self, plan: Plan<R, N>, trigger: Trigger) {
        self.detector.set_plan(plan.codes, trigger);
        self.pipeline.set_plan(plan);
    }

    /// A processor with the plan's codes, band and rate.
    pub fn new(plan: Plan<R, N>) -> Self {
        Self::with_trigger(plan, Trigger::default())
    }

    /// A processor whose bursts begin and end by `trigger`.
    pub fn with_trigger(plan: Plan<R, N>, trigger: Trigger) -> Self {
        Self {
            detector: BurstDetector::new(plan.codes, trigger),
            pipeline: Pipeline::new(plan),
            last: None,
        }
    }

    /// Takes samples, as codes: a [`Format`](crate::Format) turns a driver's words into codes. Calls `each` with every burst that is
    /// complete.
    pub fn push(&mut self, samples: &[R::Sample], mut each: impl FnMut(&Burst)) {
        let Self { detector, pipeline, last } = self;
        detector.push(samples, |cut| {
            let burst = pipeline.burst(cut);
            // The flank of a burst that lies wholly in its record may trigger once more.
            let apart = 0.5 * f64::from(burst.deviation);
            if last.is_none_or(|last| burst.arrival - last > apart) {
                each(&burst);
                *last = Some(burst.arrival);
            }
        });
    }

    /// Takes the samples of a block. Its stamp shows how many samples are missing between this block and the one before.
    pub fn block(&mut self, stamp: &Stamp, samples: &[R::Sample; N], each: impl FnMut(&Burst)) {
        let missing = stamp.clock.saturating_sub(self.detector.clock());
        if missing > 0 {
            self.lost(missing);
        }
        self.push(samples, each);
    }

    /// The pipeline that measures the bursts. It may measure whole blocks between them.
    pub const fn pipeline(&mut self) -> &mut Pipeline<R, N> {
        &mut self.pipeline
    }

    /// Reports that `samples` samples are missing before the next. A burst in progress is dropped and counted as lost.
    pub fn lost(&mut self, samples: u64) {
        self.detector.lost(samples);
    }

    /// The counts so far.
    pub const fn counters(&self) -> &Counters {
        self.detector.counters()
    }
}
