//! Bursts in a stream.

use crate::native::{Native, samples_of};
use crate::tables::{self, TargetRow, joined};
use picket_dsp::acquire::kind::ForRecord;
use picket_dsp::plan::Solver;
use picket_dsp::solve::doppler;
use picket_dsp::{Burst, BurstProcessor, ConfigError, Outcome, Record, Trigger};

/// All bursts of a stream.
pub struct Bursts<'a> {
    pub native: &'a Native,
    pub words: &'a [i16],
    pub trigger: Trigger,
    /// The numbers of the samples that are missing, in order.
    pub missing: &'a [u64],
}

/// The arrival and the deviation in samples, the validation, the tone, the outcome.
pub type BurstRow = [f64; 3 + tables::TONE + tables::TARGET];

impl ForRecord for Bursts<'_> {
    type Output = Result<(Vec<BurstRow>, [u64; 5]), ConfigError>;

    fn run<R: Record, const N: usize>(self) -> Self::Output {
        let plan = self.native.config.plan::<R, N>()?;
        let solver = plan.solver;
        let mut rows = Vec::new();
        let mut each = |burst: &Burst| {
            let head = [burst.arrival, burst.deviation.into(), f64::from(burst.validation as u8)];
            let velocity: TargetRow = match solver {
                Solver::Doppler(scale) => {
                    tables::outcome(&Outcome::Velocity(doppler::velocity(&burst.tone, scale)))
                }
                _ => tables::outcome(&Outcome::None),
            };
            rows.push(joined([&head, &tables::tone(&burst.tone), &velocity]));
        };
        let mut processor = Box::new(BurstProcessor::<R, N>::with_trigger(plan, self.trigger));
        let samples: Vec<R::Sample> = samples_of::<R>(self.words).collect();
        let mut begin = 0;
        for &missing in self.missing {
            let missing = usize::try_from(missing).unwrap_or(usize::MAX);
            let Some(there) = samples.get(begin..missing) else { break };
            processor.push(there, &mut each);
            processor.lost(1);
            begin = missing + 1;
        }
        processor.push(samples.get(begin..).unwrap_or_default(), &mut each);
        let counted = processor.counters();
        let (bursts, lost, long) =
            (counted.bursts.into(), counted.lost.into(), counted.long.into());
        Ok((rows, [counted.samples, bursts, lost, long, counted.dead]))
    }
}
