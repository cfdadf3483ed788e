//! Displacement from phases: never a wrong turn in an answer that is called good.

use picket_claims::scenes::amplitude;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::solve::chirp::Mixing;
use picket_dsp::solve::displacement::{Between, Displacement, Unwrapper};
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::{Codes, Config, Iq, Pipeline, Stamp, Tone, Usable, Verdict};
use picket_simulator::scene::{self, Noise, Receiver, Source, Target, Vibration, Waveform};
use picket_simulator::{Draw, Scene};
use rayon::prelude::*;
use std::f64::consts::TAU;

const N: usize = 256;
const BLOCKS: u64 = 40;

/// Blocks whose displacement is good, and those of them that are more than a quarter of a turn off. `truth` is in turns.
fn judged(moved: &[Displacement], truth: &[f64]) -> [usize; 2] {
    let mut origin: Option<(u32, f64)> = None;
    let (mut good, mut wrong) = (0, 0);
    for (moved, &truth) in moved.iter().zip(truth) {
        if origin.is_none_or(|(start, _)| start != moved.start) {
            origin = Some((moved.start, truth));
        }
        let since = truth - origin.unwrap().1;
        if moved.verdict.usable() <= Usable::WithinSigma {
            good += 1;
            wrong += usize::from((moved.metres.to_num::<f64>() - since).abs() > 0.25);
        }
    }
    [good, wrong]
}

/// A target before a continuous-wave radar: its frequency in bins follows a function of the time in blocks.
fn by_frequency(snr_db: f64, swing_bins: f64, period: f64, seed: u64) -> [f64; 2] {
    let amplitude = amplitude(snr_db).min(1500.0);
    let plan = Config::new(1.0, Codes::signed::<12>()).plan::<Iq, N>().unwrap();
    let n = N as f64;
    // A wave of 2 m turns once a metre.
    let waveform = Waveform { carrier_hz: SPEED_OF_LIGHT / 2.0, ..Waveform::default() };
    let target = Target {
        range_m: 3000.0.into(),
        velocity_mps: (-40.0 / n..40.0 / n).into(),
        amplitude: Some(amplitude.into()),
        vibration: vec![Vibration {
            amplitude_m: (swing_bins * period / TAU).into(),
            frequency_hz: (1.0 / (period * n)).into(),
            phase_turns: (0.0..1.0).into(),
        }],
        ..Target::default()
    };
    let noise = Noise { snr_db: Some(snr_db.into()), ..Noise::default() };
    let scene = |mixing| Scene {
        seed,
        rate_hz: 1.0,
        seconds: n * BLOCKS as f64,
        waveform: Some(waveform.clone()),
        sources: vec![Source::Target(target.clone())],
        receiver: Receiver { iq: true, mixing, noise: noise.clone(), ..Receiver::default() },
        ..Scene::default()
    };
    let of_run = |trial: u64| {
        let (sent, mixing) = [
            (scene::Mixing::TxConjRx, Mixing::TxConjRx),
            (scene::Mixing::RxConjTx, Mixing::RxConjTx),
        ][trial as usize % 2];
        let mut run = scene(sent).run(trial).unwrap();
        let mut pipeline = Pipeline::<Iq, N>::new(plan);
        let mut unwrapper = Unwrapper::new(2.0, mixing, Between::Frequency).unwrap();
        let (mut moved, mut truth) = (Vec::new(), Vec::new());
        // Blocks that an offset cannot disturb.
        let mut measurable = 0;
        for block in 0..BLOCKS {
            let clock = block * N as u64;
            let frequency = run.truth(0, clock as f64, N).frequency_hz * n;
            measurable += usize::from(frequency.abs() > 2.0);
            let record = run.record(block as usize, N);
            let stamp = Stamp { sequence: block as u32, clock, ..Stamp::default() };
            let measurement = pipeline.block(&stamp, record.as_array().unwrap());
            for phasor in &pipeline.lines(&measurement, 1) {
                let now = unwrapper.push(&stamp, phasor);
                // A displacement counts from a block whose tone can be used.
                if phasor.tone.verdict.usable() <= Usable::WithinSigma {
                    moved.push(now);
                    truth.push(run.truth(0, clock as f64 + 0.5 * n, 1).range_m.unwrap());
                }
            }
        }
        let [good, wrong] = judged(&moved, &truth);
        [good, wrong, measurable]
    };
    let seen: Vec<[usize; 3]> = (0..50).into_par_iter().map(of_run).collect();
    let sum = |i: usize| seen.iter().map(|seen| seen[i]).sum::<usize>() as f64;
    let [good, wrong] = [sum(0) / sum(2), sum(1) / sum(0).max(1.0)];
    println!(
        "{snr_db} dB, {swing_bins} bins over {period} blocks, seed {seed}: good {good:.3}, wrong {wrong:.4}"
    );
    [good, wrong]
}

#[test]
fn a_frequency_tells_the_turns() {
    for (snr_db, swing, period, least) in [
        (-3.0, 0.0, 10.0, 0.9),
        (10.0, 0.0, 10.0, 0.98),
        (40.0, 0.0, 10.0, 0.98),
        (20.0, 3.0, 200.0, 0.9),
        (20.0, 10.0, 30.0, 0.0),
        (20.0, 10.0, 6.0, 0.0),
        (20.0, 5.0, 2.3, 0.0),
        (40.0, 1.0, 2.0, 0.0),
        (40.0, 30.0, 50.0, 0.0),
    ] {
        let [good, wrong] = by_frequency(snr_db, swing, period, 31);
        assert!(good >= least);
        assert_eq!(wrong, 0.0);
    }
}

/// A step of up to three quarters of a turn is refused where a quarter is the most, and never taken for a small one.
#[test]
fn a_step_that_is_too_large_is_refused() {
    for sigma in [0.001, 0.03, 0.1] {
        let seen: Vec<[usize; 2]> = (0..2000)
            .into_par_iter()
            .map(|trial| {
                let mut draw = Draw::new(32, trial);
                let mut unwrapper =
                    Unwrapper::new(2.0, Mixing::TxConjRx, Between::Turns(0.25)).unwrap();
                let (mut turns, mut truth, mut moved) = (0.0, Vec::new(), Vec::new());
                for sequence in 0..20 {
                    let phase = TAU * turns + sigma * draw.normal();
                    let phase = (phase - TAU * (phase / TAU).round()) as f32;
                    let tone = Tone { verdict: Verdict::Good, ..Tone::default() };
                    let phasor = ToneWithPhase { tone, phase, sigma_phase: sigma as f32 };
                    moved.push(unwrapper.push(&Stamp { sequence, ..Stamp::default() }, &phasor));
                    truth.push(turns);
                    let most = if sequence % 5 == 4 { 0.75 } else { 0.1 };
                    turns += draw.between(-most, most);
                }
                judged(&moved, &truth)
            })
            .collect();
        let [good, wrong] = [0, 1].map(|i| seen.iter().map(|seen| seen[i]).sum::<usize>());
        println!("sigma {sigma} rad, seed 32: {good} of 40000 good, {wrong} wrong");
        assert!(good > 20_000 && wrong == 0);
    }
}

/// After a gap, and after a block that is not good, displacement starts anew.
#[test]
fn a_gap_starts_anew() {
    let mut unwrapper = Unwrapper::new(1.0, Mixing::TxConjRx, Between::Turns(0.25)).unwrap();
    let mut push = |phase: f32, verdict, gap| {
        let phasor =
            ToneWithPhase { tone: Tone { verdict, ..Tone::default() }, phase, sigma_phase: 0.01 };
        let moved = unwrapper.push(&Stamp { gap, ..Stamp::default() }, &phasor);
        (moved.metres.to_num::<f32>(), moved.start, moved.verdict)
    };
    assert_eq!(push(3.0, Verdict::Good, false), (0.0, 0, Verdict::Good));
    // Past half a turn the phase goes on at minus half a turn.
    let (metres, start, verdict) = push(-3.0, Verdict::Good, false);
    let turns = 1.0 - 6.0 / std::f32::consts::TAU;
    assert!((metres - 0.5 * turns).abs() < 1e-5, "{metres}");
    assert_eq!((start, verdict), (0, Verdict::Good));
    assert_eq!(push(-3.0, Verdict::Good, true), (0.0, 1, Verdict::Unresolved));
    assert_eq!(push(-3.0, Verdict::Good, false), (0.0, 1, Verdict::Good));
    assert_eq!(push(0.0, Verdict::Weak, false), (0.0, 2, Verdict::Weak));
    assert_eq!(push(0.0, Verdict::Good, false), (0.0, 2, Verdict::Good));
}
