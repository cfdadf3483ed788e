//! A record's answers.

use super::case::{Case, Path};
use super::digest::Digest;
use crate::simulate::Kind;
use picket_dsp::spectrum::engine::Engine;
use picket_dsp::{
    Accumulator, Alternating, BurstProcessor, F32, FrequencyOnly, I32, Iq, Pipeline, Plan, Segment,
    Stamp, Tracker,
};
use picket_measure::explain::rows::Notes;

/// Orders by which a fundamental is sought.
const ORDERS: u32 = 8;
/// Lines that are sought.
const LINES: usize = 4;

/// Adds all answers to a record to `digest`.
///
/// # Errors
/// There is no such record.
pub fn measure(case: &mut Case, digest: &mut Digest) -> Result<(), String> {
    if case.path == Path::ByTurns {
        return match case.n {
            64 => by_turns::<64, 128>(case, digest),
            128 => by_turns::<128, 256>(case, digest),
            256 => by_turns::<256, 512>(case, digest),
            512 => by_turns::<512, 1024>(case, digest),
            1024 => by_turns::<1024, 2048>(case, digest),
            _ => by_turns::<2048, 4096>(case, digest),
        };
    }
    with_record!(case.iq, case.n, R, N => records::<R, N>(case, digest))
}

fn records<R: Kind, const N: usize>(case: &mut Case, digest: &mut Digest) -> Result<(), String> {
    let (samples, stamps) = case.samples::<R>()?;
    let plan = case.config.plan::<R, N>().map_err(|error| error.to_string())?;
    let blocks = stamps.iter().zip(samples.as_chunks::<N>().0);
    match case.path {
        Path::Tracks => {
            let mut tracker = Box::new(Tracker::<R, N>::new(plan));
            for (stamp, samples) in blocks {
                digest.of("block");
                digest.measurement(&tracker.block(stamp, samples));
                digest.whole("locked", u8::from(tracker.is_locked(Segment::Continuous)));
                for track in tracker.tracks(Segment::Continuous) {
                    digest.of("track");
                    digest.track(track);
                }
            }
        }
        Path::Bursts => {
            let mut processor = Box::new(BurstProcessor::<R, N>::new(plan));
            // Chunks of a driver are no records.
            for chunk in samples.chunks(777) {
                processor.push(chunk, |burst| {
                    digest.of("burst");
                    digest.burst(burst);
                });
            }
            digest.of("counters");
            digest.whole("bursts", processor.counters().bursts);
            digest.whole("lost", processor.counters().lost);
            digest.whole("long", processor.counters().long);
        }
        _ if case.floats => pipeline::<R, N, F32>(case.path, plan, blocks, digest),
        _ => pipeline::<R, N, I32>(case.path, plan, blocks, digest),
    }
    Ok(())
}

/// What a pipeline says of blocks, and a sum of them.
fn pipeline<'a, R: Kind, const N: usize, E: Engine>(
    path: Path,
    plan: Plan<R, N>,
    blocks: impl Iterator<Item = (&'a Stamp, &'a [R::Sample; N])>,
    digest: &mut Digest,
) {
    let mut pipeline = Box::new(Pipeline::<R, N, E>::new(plan));
    let mut sum = Box::new(Accumulator::<R, N>::new(path.blocks() as u32).with_drift(0.1));
    for (stamp, samples) in blocks {
        let measurement = pipeline.block(stamp, samples);
        digest.of("block");
        digest.measurement(&measurement);
        if path == Path::Sum
            && let Some(accumulated) = sum.add(&measurement, &pipeline)
        {
            digest.of("sum");
            digest.accumulated(&accumulated);
        }
        if path != Path::Block {
            continue;
        }
        if let Some(rise) = pipeline.rise(&measurement) {
            digest.of("rise");
            digest.rise(&rise);
        }
        for line in pipeline.lines(&measurement, LINES) {
            digest.of("line");
            digest.phasor(&line);
        }
        if let Some(harmonic) = pipeline.harmonic(&measurement, ORDERS) {
            digest.of("harmonic");
            digest.harmonic(&harmonic);
        }
        let notes = Notes::default();
        let (clipped, tone, evidence) = pipeline.explain(stamp, samples, &notes);
        digest.of("explain");
        digest.whole("clipped", clipped);
        digest.tone(&tone);
        digest.evidence(&evidence);
        let (notes, fitted) = notes.taken();
        digest.notes(&notes);
        fitted.iter().for_each(|fitted| digest.fitted(fitted));
        let only = FrequencyOnly::<R, N, E>::new().block(samples, plan.codes);
        only.iter().for_each(|line| {
            digest.of("frequency only");
            digest.unjudged(line);
        });
    }
}

fn by_turns<const N: usize, const TWICE: usize>(
    case: &mut Case,
    digest: &mut Digest,
) -> Result<(), String> {
    let (mut samples, stamps) = case.samples::<Iq>()?;
    let plan = case.config.plan::<Iq, N>().map_err(|error| error.to_string())?;
    let mut turns = Box::new(Alternating::<N, TWICE>::new(plan));
    for (stamp, pairs) in stamps.iter().zip(samples.as_chunks_mut::<N>().0) {
        digest.of("block");
        digest.measurement(&turns.block(stamp, pairs));
    }
    Ok(())
}
