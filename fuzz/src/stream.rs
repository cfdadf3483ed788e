//! Whatever a driver delivers, and however it cuts the stream, records keep their place and what is measured of them is a number.

use super::input::Input;
use super::measure::{config, number, samples};
use picket::accumulate::Accumulator;
use picket::acquire::assembler::Assembler;
use picket::acquire::burst::Trigger;
use picket::acquire::format::Format;
use picket::acquire::sample::{Iq, Real, Record};
use picket::burst::{BurstProcessor, Validation};
use picket::config::Config;
use picket::pipeline::{Alternating, Pipeline};
use picket::tone::Verdict;

/// Samples in a record.
const N: usize = 64;

/// A stream of random pieces to everything that takes one.
pub fn stream(bytes: &[u8]) {
    let mut input = Input(bytes);
    let config = config(&mut input);
    match input.byte() % 5 {
        0 => assembled::<Real>(&config, &mut input),
        1 => assembled::<Iq>(&config, &mut input),
        2 => bursts::<Real>(&config, &mut input),
        3 => bursts::<Iq>(&config, &mut input),
        _ => alternating(&config, &mut input),
    }
}

/// Chunks of any length at any place of the stream, whose records are measured and added up.
fn assembled<R: Record>(config: &Config, input: &mut Input) {
    let Ok(plan) = config.plan::<R, N>() else { return };
    let hop = u32::from(input.byte());
    let mut pipeline = Pipeline::<R, N>::new(plan);
    let mut accumulator = Accumulator::<R, N>::new(input.byte().into())
        .with_drift(input.number() as f32)
        .with_false_alarm(input.number());
    let mut assembler = Assembler::<R, N>::new(Format::signed::<16>()).with_hop(hop);
    let (mut clock, mut next) = (0u64, 0);
    while !input.0.is_empty() {
        let chunk = samples::<R, N>(input);
        let words = chunk.iter().flat_map(|&sample| {
            let parts = R::parts(sample);
            parts.into_iter().take(if R::IQ { 2 } else { 1 })
        });
        let words: Vec<i16> = words.take(1 + usize::from(input.byte())).collect();
        // Where the last chunk ended, a little before or after, or anywhere.
        clock = match input.byte() {
            // No clock counts 2^63 samples.
            0 => u64::from_le_bytes(input.take()) >> 1,
            place => clock.saturating_add_signed(i64::from(place as i8) / 64),
        };
        assembler.push_at(clock, &words, |stamp, record| {
            assert!(stamp.clock >= next && stamp.clock % u64::from(hop.max(1)) == 0, "{stamp:?}");
            next = stamp.clock + 1;
            let measurement = pipeline.block(*stamp, record);
            number(&measurement);
            let sum = accumulator.add(&measurement, &pipeline);
            if let Some(sum) = sum {
                assert!(sum.tone.is_consistent() && !sum.ln_chance.is_nan(), "{sum:?}");
            }
        });
        clock = clock.saturating_add(words.len() as u64 / if R::IQ { 2 } else { 1 });
    }
    let sum = accumulator.result(pipeline.plan());
    assert!(sum.tone.is_consistent() && !sum.ln_chance.is_nan(), "{sum:?}");
}

/// Pieces of a stream with losses between them, to the burst processor.
fn bursts<R: Record>(config: &Config, input: &mut Input) {
    let Ok(plan) = config.plan::<R, N>() else { return };
    let trigger = Trigger {
        ratio: (input.byte() & 1 != 0).then(|| input.number() as f32),
        hold_off: input.byte().into(),
        least: input.byte().into(),
    };
    let mut processor = BurstProcessor::<R, N>::with_trigger(plan, trigger);
    while !input.0.is_empty() {
        if input.byte() == 0 {
            processor.lost(u64::from_le_bytes(input.take()) >> 8);
        }
        let piece = samples::<R, N>(input);
        let piece = &piece[..usize::from(input.byte()) % (N + 1)];
        processor.push(piece, |burst| {
            assert!(burst.tone.is_consistent(), "{burst:?}");
            assert!(burst.arrival.is_finite() && burst.deviation >= 0.0, "{burst:?}");
            let valid = burst.validation == Validation::Valid;
            assert!(valid || burst.tone.verdict != Verdict::Good, "{burst:?}");
        });
    }
}

/// Pairs of one converter that takes them by turns.
fn alternating(config: &Config, input: &mut Input) {
    let Ok(plan) = config.plan::<Iq, N>() else { return };
    let mut pipeline = Alternating::<N, { 2 * N }>::new(plan);
    for sequence in 0..4 {
        let stamp = picket::Stamp { sequence, ..Default::default() };
        let mut pairs = samples::<Iq, N>(input);
        let before = pairs;
        number(&pipeline.block(stamp, &mut pairs));
        assert_eq!(pairs, before, "the codes are turned back");
    }
}
