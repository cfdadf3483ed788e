//! The whole way on the host: the paper's rows in noise, and everything that is not a clean tone.

use host_tests::echoes;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Real, Segment, Stamp};
use picket_dsp::config::Config;
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::{Measurement, Outcome, Pipeline};
use picket_dsp::tone::Verdict;
use picket_host::scenario::{self, LIDAR_BARS, Row};
use picket_host::simulate::{Signal, generator};
use rayon::prelude::*;

const N: usize = 1024;

fn pipeline(config: Config) -> Pipeline<Real, N> {
    Pipeline::new(config.plan::<Real, N>().unwrap())
}

fn stamp(sequence: u32, segment: Segment) -> Stamp {
    Stamp { sequence, clock: u64::from(sequence) * N as u64, segment, gap: false }
}

fn block(signal: &Signal, seed: u64, trial: u64) -> [i16; N] {
    signal.codes::<Real>(N, &mut generator(seed, trial)).try_into().unwrap()
}

/// One chirp of the lidar in front of a target.
fn chirp(row: &Row, snr_db: f64, method: Method, seed: u64, trial: u64) -> Measurement {
    let config = Config { method, ..scenario::lidar() };
    let sensor = echoes::sensor::<Real>(&config, N, 0.0);
    let mut pipeline = pipeline(config);
    let mut last = Measurement::default();
    for (number, &segment) in config.scene.segments().iter().enumerate() {
        let rng = &mut generator(seed, 3 * trial + number as u64);
        let target = echoes::target(row, &sensor, 350.0, rng);
        let receiver = sensor.receiver.with_snr(target.amplitude, snr_db);
        let sensor = sensor.clone().received_by(receiver);
        let samples = echoes::codes::<Real>(&sensor, &[target], (0, number), rng);
        last = pipeline.block(&stamp(number as u32, segment), samples.as_array().unwrap());
    }
    last
}

/// Errors of range and velocity, if there is a target.
fn errors(row: &Row, measurement: &Measurement) -> Option<(f64, f64)> {
    let Outcome::Target(target) = measurement.result else { return None };
    let range = target.range.to_num::<f64>() - row.range_m;
    Some((range, target.velocity?.to_num::<f64>() - row.velocity_mps))
}

#[test]
fn every_row_is_inside_the_papers_bars_at_minus_five_decibels() {
    println!("seed 21");
    let rows = scenario::table3();
    for method in [Method::ZRife, Method::LeastSquaresReal] {
        let trials = 4000u64;
        let outside = (0..trials)
            .into_par_iter()
            .filter(|&trial| {
                let row = &rows[trial as usize % rows.len()];
                let measured = chirp(row, -5.0, method, 21, trial);
                !errors(row, &measured).is_some_and(|(range, velocity)| {
                    range.abs() <= LIDAR_BARS.range_m && velocity.abs() <= LIDAR_BARS.velocity_mps
                })
            })
            .count();
        println!("{method}: {outside} of {trials} outside");
        assert!(outside as f64 <= 0.001 * trials as f64, "{method}: {outside}");
    }
}

#[test]
fn a_target_never_mixes_two_chirps() {
    let row = Row { range_m: 50.0, velocity_mps: 10.0 };
    let samples = block(&Signal::tone(100.2, 1000.0, 20.0), 1, 0);
    use Segment::{Down, Flat, Up};
    for (blocks, complete) in [
        (&[(0, Up), (1, Flat), (2, Down)][..], true),
        (&[(0, Up), (2, Down)], false),
        (&[(1, Flat), (2, Down)], false),
        (&[(0, Up), (1, Flat), (5, Down)], false),
        (&[(0, Up), (4, Flat), (5, Down)], false),
        (&[(0, Up), (1, Flat), (3, Up), (4, Flat), (5, Down)], true),
        (&[(u32::MAX - 1, Up), (u32::MAX, Flat), (0, Down)], true),
    ] {
        let mut pipeline = pipeline(scenario::lidar());
        let last = blocks
            .iter()
            .map(|&(sequence, segment)| pipeline.block(&stamp(sequence, segment), &samples))
            .last()
            .unwrap();
        assert_eq!(errors(&row, &last).is_some(), complete, "{blocks:?}");
    }
}

#[test]
fn an_offset_changes_nothing() {
    let signal = Signal::tone(40.3, 500.0, 20.0);
    let plain = block(&signal, 2, 0);
    let raised = plain.map(|x| x + 900);
    let measure = |samples| pipeline(scenario::lidar()).block(&Stamp::default(), samples).tone;
    let (plain, raised) = (measure(&plain), measure(&raised));
    assert_eq!(plain.verdict, Verdict::Good);
    assert!((plain.frequency.bins(N) - raised.frequency.bins(N)).abs() < 1e-4);
    let unsigned = Config { codes: Codes::unsigned::<12>(), ..scenario::lidar() };
    let shifted = block(&signal, 2, 0).map(|x| x + 2048);
    let unsigned = pipeline(unsigned).block(&Stamp::default(), &shifted).tone;
    assert!((plain.frequency.bins(N) - unsigned.frequency.bins(N)).abs() < 1e-4);
    assert_eq!(unsigned.verdict, Verdict::Good);
}

#[test]
fn what_is_not_a_clean_tone_says_so() {
    let verdict = |samples: &[i16; N], gap| {
        let stamp = Stamp { gap, ..Stamp::default() };
        pipeline(scenario::lidar()).block(&stamp, samples).tone.verdict
    };
    let good = block(&Signal::tone(100.3, 1000.0, 10.0), 3, 0);
    assert_eq!(verdict(&good, false), Verdict::Good);
    assert_eq!(verdict(&good, true), Verdict::Gap);
    assert_eq!(verdict(&[0; N], false), Verdict::NoSignal);
    assert_eq!(verdict(&[-1234; N], false), Verdict::NoSignal);
    let clipped = block(&Signal::tone(100.3, 3000.0, 30.0), 3, 1);
    assert_eq!(verdict(&clipped, false), Verdict::Clipped);
    let edge = block(&Signal::tone(1.2, 1000.0, 30.0), 3, 2);
    assert_eq!(verdict(&edge, false), Verdict::NearEdge);
    let noise = block(&Signal::tone(100.3, 20.0, -30.0), 3, 3);
    assert_eq!(verdict(&noise, false), Verdict::Weak);
}
