//! Bursts of a stream.

use super::against::Against;
use crate::bound;
use crate::case::{Case, Truths};
use crate::seen::{Seen, Trial};
use picket_dsp::{Burst, BurstProcessor, Record, Validation};
use picket_simulator::scene::Source;
use picket_simulator::{Passed, Run, Truth};

/// The burst of the first source: of the valid ones near it the nearest, or the worst where other sources may be meant. Valid ones elsewhere
/// have no source.
pub(super) fn trial<R: Record, const N: usize>(
    case: &Case,
    run: &mut Run,
    mut processor: BurstProcessor<R, N>,
    records: usize,
) -> Trial {
    let codes = run.codes(0.0, records * N);
    let samples: Vec<R::Sample> = codes.into_iter().map(R::from_parts).collect();
    let mut valid = Vec::new();
    for chunk in samples.chunks(777) {
        processor.push(chunk, |burst| {
            if burst.validation == Validation::Valid {
                valid.push(*burst);
            }
        });
    }
    let cut = [records as u64, u64::from(processor.counters().bursts)];
    let rate_hz = case.scene.rate_hz;
    let Some(source) = case.scene.sources.first() else {
        return Trial { more: valid.len(), cut, ..Trial::default() };
    };
    let mut against = Against::stretch::<R>(case, run, 0.0, 1);
    (against.n, against.truths) = (N, Truths::Carrier);
    let mut near = None;
    if let Source::Particles(of) = source {
        let mut passed: Vec<&Passed> = run.particles(0).iter().collect();
        passed.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
        let deviation = |of_one: &Passed| 0.5 * of.radius_m / of_one.velocity_mps.abs() * rate_hz;
        let truth = |of_one: &&Passed| Truth {
            nominal_hz: of_one.velocity_mps / of.fringe_m + of.shift_hz,
            amplitude: of_one.amplitude,
            ..Truth::default()
        };
        let noise = against.noise;
        let bound =
            |of_one: &&Passed| bound::burst(N, R::IQ, of_one.amplitude, deviation(of_one), noise);
        against.bounds = passed.iter().map(bound).collect();
        against.lines = passed.iter().map(truth).collect();
        near = passed
            .first()
            .map(|first| (first.middle_s * rate_hz, 4.0 * deviation(first).max(N as f64 / 20.0)));
    }
    let is_near =
        |burst: &&Burst| near.is_none_or(|(middle, reach)| (burst.arrival - middle).abs() < reach);
    let found: Vec<&Burst> = valid.iter().filter(is_near).collect();
    let more = valid.len() - found.len();
    let from_middle =
        |burst: &Burst| near.map_or(0.0, |(middle, _)| (burst.arrival - middle).abs());
    let off = |burst: &Burst| against.tone(&burst.tone).worst();
    // Where another particle may be meant, none of them may be wrong.
    let chosen = match case.any_source {
        true => found.iter().max_by(|a, b| off(a).total_cmp(&off(b))),
        false => found.iter().min_by(|a, b| from_middle(a).total_cmp(&from_middle(b))),
    };
    let seen = vec![chosen.map_or(Seen::NOTHING, |burst| against.tone(&burst.tone))];
    Trial { seen, more, cut, ..Trial::default() }
}
