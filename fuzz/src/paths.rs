//! Every way that samples take to an answer: whatever is set and whatever the samples are, what is usable is a number with a sigma.

use super::input::Input;
use super::measure::{config, samples};
use picket_dsp::acquire::sample::{Iq, Real, Record, Stamp};
use picket_dsp::pipeline::{Alternating, Measurement, Pipeline};
use picket_dsp::spectrum::engine::Engine;
use picket_dsp::{Accumulator, BurstProcessor, Config, F32, Format, Framer, I32, Tone, Usable};

/// A configuration, a length and a path, then samples.
pub fn paths(bytes: &[u8]) {
    let mut input = Input(bytes);
    let config = config(&mut input);
    let [length, path] = input.take();
    let input = &mut input;
    match (path % 10, length % 5) {
        (0, 0) => alternating::<64, 128>(&config, input),
        (0, 1) => alternating::<128, 256>(&config, input),
        (0, 2) => alternating::<256, 512>(&config, input),
        (0, 3) => alternating::<1024, 2048>(&config, input),
        (0, _) => alternating::<2048, 4096>(&config, input),
        (_, 0) => path_of::<64>(path, &config, input),
        (_, 1) => path_of::<128>(path, &config, input),
        (_, 2) => path_of::<256>(path, &config, input),
        (_, 3) => path_of::<1024>(path, &config, input),
        (_, _) => path_of::<4096>(path, &config, input),
    }
}

fn path_of<const N: usize>(path: u8, config: &Config, input: &mut Input) {
    match path % 10 {
        1 => block::<Real, N, I32>(config, input),
        2 => block::<Iq, N, I32>(config, input),
        3 => accumulated::<Real, N>(config, input),
        4 => accumulated::<Iq, N>(config, input),
        5 => bursts::<Real, N>(config, input),
        6 => bursts::<Iq, N>(config, input),
        7 => block::<Real, N, F32>(config, input),
        8 => block::<Iq, N, F32>(config, input),
        _ => assembled::<N>(config, input),
    }
}

/// Numbers, and a sigma where it is used.
#[track_caller]
fn sound(tone: &Tone) {
    for value in [tone.sigma, tone.snr, tone.amplitude] {
        assert!(value >= 0.0, "{tone:?}");
    }
    assert!(tone.is_consistent(), "{tone:?}");
    if tone.verdict.usable() <= Usable::WithinSigma {
        assert!(tone.sigma < 1.0 && tone.snr > 0.0, "{tone:?}");
    }
}

/// The strongest tone, all tones, and the fundamental.
fn block<R: Record, const N: usize, E: Engine>(config: &Config, input: &mut Input) {
    let Ok(plan) = config.plan::<R, N>() else { return };
    let mut pipeline = Pipeline::<R, N, E>::new(plan);
    let measurement = pipeline.block(&Stamp::default(), &samples::<R, N>(input));
    sound(&measurement.tone);
    for phasor in pipeline.lines(&measurement, 4) {
        sound(&phasor.tone);
        let usable = phasor.tone.verdict.usable() <= Usable::WithinSigma;
        assert!(!phasor.phase.is_nan() && phasor.sigma_phase >= 0.0, "{phasor:?}");
        assert!(!usable || phasor.sigma_phase.is_finite(), "{phasor:?}");
    }
    if let Some(harmonic) = pipeline.harmonic(&measurement, 8) {
        sound(&harmonic.tone);
    }
}

/// Pairs that one converter takes by turns.
fn alternating<const N: usize, const TWICE: usize>(config: &Config, input: &mut Input) {
    let Ok(plan) = config.plan::<Iq, N>() else { return };
    let mut pipeline = Alternating::<N, TWICE>::new(plan);
    let pairs = samples::<Iq, N>(input);
    let mut turned = pairs;
    sound(&pipeline.block(&Stamp::default(), &mut turned).tone);
}

/// A sum of three blocks, whose line may move.
fn accumulated<R: Record, const N: usize>(config: &Config, input: &mut Input) {
    let Ok(plan) = config.plan::<R, N>() else { return };
    let mut pipeline = Pipeline::<R, N>::new(plan);
    let drift = input.number() as f32;
    let mut sum = Accumulator::<R, N>::new(3).with_drift(drift);
    for sequence in [0, 1, u32::from(input.byte())] {
        let stamp = Stamp { sequence, ..Stamp::default() };
        let measurement = pipeline.block(&stamp, &samples::<R, N>(input));
        if let Some(result) = sum.add(&measurement, &pipeline) {
            sound(&result.tone);
        }
    }
}

/// A stream with a hole in it.
fn bursts<R: Record, const N: usize>(config: &Config, input: &mut Input) {
    let Ok(plan) = config.plan::<R, N>() else { return };
    let mut processor = BurstProcessor::<R, N>::new(plan);
    for _ in 0..4 {
        let samples = samples::<R, N>(input);
        processor.push(&samples, |burst| {
            sound(&burst.tone);
            assert!(burst.arrival >= 0.0 && burst.deviation >= 0.0, "{burst:?}");
        });
        if input.byte() & 3 == 0 {
            processor.lost(input.byte().into());
        }
    }
}

/// Chunks of words that come twice, or leave samples out.
fn assembled<const N: usize>(config: &Config, input: &mut Input) {
    let Ok(plan) = config.plan::<Real, N>() else { return };
    let mut pipeline = Pipeline::<Real, N>::new(plan);
    let hop = u32::from(input.byte());
    let mut framer = Framer::<Real, N>::new(Format::unsigned::<12>()).with_hop(hop);
    let mut last: Option<Measurement> = None;
    for _ in 0..4 {
        let clock = match input.byte() {
            // No clock counts 2^63 samples.
            255 => u64::from_le_bytes(input.take()) >> 1,
            clock => u64::from(clock) * N as u64 / 16,
        };
        let words: [u16; N] = samples::<Real, N>(input).map(|sample| sample as u16);
        framer.push_at(clock, &words, |stamp, samples| {
            let measurement = pipeline.block(stamp, samples);
            sound(&measurement.tone);
            if let Some(last) = last {
                assert!(stamp.clock > last.stamp.clock, "{stamp:?} after {:?}", last.stamp);
            }
            last = Some(measurement);
        });
    }
}
