//! A trial: the records of a run of the scene, measured. Each way with a file of its own says what its answers are held against.

mod against;
mod bursts;
mod chirps;
mod frames;
mod phases;
mod tracks;

use crate::case::{Case, Engine, Path};
use crate::seen::{Seen, Trial};
use against::Against;
use picket_dsp::spectrum::engine;
use picket_dsp::spectrum::layout::Layout;
use picket_dsp::spectrum::zoom::Oscillator;
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::zoomed::{self, Place};
use picket_dsp::{
    Accumulator, Alternating, BurstProcessor, F32, I32, Iq, Pipeline, Record, Stamp, Tone, Tracker,
    Verdict,
};
use picket_measure::{length, with_record};
use picket_simulator::Run;

/// A trial of a case.
pub fn trial(case: &Case, number: u64) -> Trial {
    let mut run = match case.scene.run(number) {
        Ok(run) => run,
        Err(error) => panic!("{}: {error}", case.label),
    };
    let mut trial = match case.path {
        Path::ByTurns => pairs(case, &mut run),
        _ => sized(case, &mut run, number),
    };
    if case.whatever {
        let answers = trial.seen.iter_mut().filter(|seen| !seen.off[0].is_nan());
        answers.for_each(|seen| seen.verdict = Verdict::Good);
    }
    trial
}

fn pairs(case: &Case, run: &mut Run) -> Trial {
    match case.n {
        64 => by_turns::<64, 128>(case, run),
        128 => by_turns::<128, 256>(case, run),
        256 => by_turns::<256, 512>(case, run),
        512 => by_turns::<512, 1024>(case, run),
        1024 => by_turns::<1024, 2048>(case, run),
        n => panic!("{}: no records of {n} pairs", case.label),
    }
}

fn sized(case: &Case, run: &mut Run, number: u64) -> Trial {
    if let Err(error) = length::check(case.n) {
        panic!("{}: {error}", case.label);
    }
    with_record!(case.scene.receiver.iq, case.n, R, N => match case.engine {
        Engine::I32 => measured::<R, N, I32>(case, run, number),
        Engine::F32 => measured::<R, N, F32>(case, run, number),
    })
}

fn measured<R: Record, const N: usize, E: engine::Engine>(
    case: &Case,
    run: &mut Run,
    number: u64,
) -> Trial {
    let plan = match case.config.plan::<R, N>() {
        Ok(plan) => plan,
        Err(error) => panic!("{}: {error}", case.label),
    };
    let mut pipeline = Box::new(Pipeline::<R, N, E>::new(plan));
    match case.path {
        Path::Block => {
            let samples = samples::<R, N>(run, 0);
            let measurement = pipeline.block(&Stamp::default(), &samples);
            let against = Against::new::<R>(case, run, 0);
            Trial { seen: vec![against.tone(&measurement.tone)], ..Trial::default() }
        }
        Path::Lines(most) => {
            let samples = samples::<R, N>(run, 0);
            let measurement = pipeline.block(&Stamp::default(), &samples);
            let lines = pipeline.lines(&measurement, most);
            Against::new::<R>(case, run, 0).lines(&lines)
        }
        Path::Sum(blocks, drift) => {
            let mut sum = Box::new(
                Accumulator::<R, N>::new(blocks)
                    .with_drift(drift)
                    .with_false_alarm(case.config.false_alarm),
            );
            for block in 0..blocks {
                let samples = samples::<R, N>(run, block as usize);
                let stamp = Stamp { sequence: block, ..Stamp::default() };
                let measurement = pipeline.block(&stamp, &samples);
                if let Some(accumulated) = sum.add(&measurement, &pipeline) {
                    // The middle of the sum.
                    let against = Against::summed::<R>(case, run, blocks);
                    let seen = vec![against.tone(&accumulated.tone)];
                    return Trial { seen, ..Trial::default() };
                }
            }
            Trial { seen: vec![Seen::NOTHING], ..Trial::default() }
        }
        Path::Blocks(count) => {
            let block = |index: usize| {
                let samples = samples::<R, N>(run, index);
                let stamp = Stamp { sequence: index as u32, ..Stamp::default() };
                let tone = pipeline.block(&stamp, &samples).tone;
                Against::new::<R>(case, run, index).tone(&tone)
            };
            Trial { seen: (0..count).map(block).collect(), ..Trial::default() }
        }
        Path::Harmonic(orders) => {
            let samples = samples::<R, N>(run, 0);
            let measurement = pipeline.block(&Stamp::default(), &samples);
            let against = Against::new::<R>(case, run, 0);
            let found = pipeline.harmonic(&measurement, orders);
            let seen = vec![found.map_or(Seen::NOTHING, |found| against.tone(&found.tone))];
            Trial { seen, ..Trial::default() }
        }
        Path::Locked(bins) => {
            let seen = vec![locked::<R, N>(case, run, bins)];
            Trial { seen, ..Trial::default() }
        }
        Path::Tracks(settled, more) => {
            let mut tracker = Box::new(Tracker::<R, N>::new(plan));
            tracks::trial(case, run, &mut tracker, settled, more)
        }
        Path::Bursts(records) => {
            bursts::trial(case, run, BurstProcessor::<R, N>::new(plan), records)
        }
        // Measured before.
        Path::ByTurns => Trial::default(),
        Path::Chirps(laps) => chirps::trial::<R, N, E>(case, run, &mut pipeline, laps),
        Path::Frame(chirps) => frames::trial::<R, N, E>(case, run, chirps),
        Path::FrameBeside(chirps) => frames::beside::<R, N, E>(case, run, number, chirps),
        Path::TwoFrames(chirps) => frames::pair::<R, N, E>(case, run, number, chirps),
        Path::FramePhase(chirps) => frames::phase::<R, N, E>(case, run, chirps),
        Path::Phase => phases::trial::<R, N, E>(case, run, &mut pipeline),
        Path::Sequence(laps) => chirps::sequence::<R, N, E>(case, run, &mut pipeline, laps),
    }
}

fn by_turns<const N: usize, const TWICE: usize>(case: &Case, run: &mut Run) -> Trial {
    let plan = match case.config.plan::<Iq, N>() {
        Ok(plan) => plan,
        Err(error) => panic!("{}: {error}", case.label),
    };
    let mut pairs = samples::<Iq, N>(run, 0);
    let before = pairs;
    let mut turns = Box::new(Alternating::<N, TWICE>::new(plan));
    let tone = turns.block(&Stamp::default(), &mut pairs).tone;
    assert_eq!(pairs, before, "{}: the codes are not what they were", case.label);
    let seen = vec![Against::new::<Iq>(case, run, 0).tone(&tone)];
    Trial { seen, ..Trial::default() }
}

/// The locked way: where its tone is expected, with sigma from the true noise.
fn locked<R: Record, const N: usize>(case: &Case, run: &mut Run, bins: i32) -> Seen {
    let samples = samples::<R, N>(run, 0);
    let against = Against::new::<R>(case, run, 0);
    let layout = Layout::of::<R, N>();
    let Some(centre) = zoomed::centre(bins as f32, layout) else { return Seen::NOTHING };
    let zoom = Oscillator::new(centre, layout).zoom::<R, N>(&samples);
    let Some(found) = Place::new(centre, layout).fit(&zoom, (bins - centre) as f32) else {
        return Seen::NOTHING;
    };
    let parts = if R::IQ { 2.0 } else { 1.0 };
    let noise = parts * against.noise * against.noise;
    let variance = N as f64 * noise / (2.0 * f64::from(found.information));
    let Some(frequency) = Frequency::from_bins(centre, f64::from(found.offset), N) else {
        return Seen::NOTHING;
    };
    let sigma = (variance.sqrt() / N as f64) as f32;
    against.tone(&Tone { frequency, sigma, verdict: Verdict::Good, ..Tone::default() })
}

/// The samples of a run's record.
pub fn samples<R: Record, const N: usize>(run: &mut Run, index: usize) -> [R::Sample; N] {
    let codes = run.record(index, N);
    std::array::from_fn(|n| R::from_parts(codes.get(n).copied().unwrap_or_default()))
}
