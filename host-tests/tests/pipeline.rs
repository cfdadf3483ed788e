//! The whole way on the host: the paper's rows in noise, and everything that is not a clean tone.

use picket_claims::samples;
use picket_claims::scenes::{Kind, line, tones};
use picket_dsp::acquire::sample::{Real, Segment, Stamp};
use picket_dsp::config::Config;
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::{Measurement, Outcome, Pipeline};
use picket_dsp::tone::Verdict;
use picket_dsp::{Arithmetic, Codes};
use picket_host::scenario::{self, LIDAR_BARS, Row};
use picket_simulator::Scene;
use rayon::prelude::*;

const N: usize = 1024;

fn pipeline(config: Config) -> Pipeline<Real, N> {
    Pipeline::new(config.plan::<Real, N>().unwrap())
}

fn stamp(sequence: u32, segment: Segment) -> Stamp {
    Stamp { sequence, clock: u64::from(sequence) * N as u64, segment, gap: false }
}

/// A record of a tone in noise of so many codes.
fn block(bins: f64, amplitude: f64, noise: f64) -> [i16; N] {
    let scene = tones(Kind::Real, N, [line(bins, amplitude)], noise);
    samples::<Real, N>(&mut scene.run(0).unwrap(), 0)
}

/// One chirp of the lidar in front of a target.
fn chirp(row: &Row, snr_db: f64, method: Method, seed: u64, trial: u64) -> Measurement {
    let config = Config { method, ..scenario::lidar() };
    let sensor = Scene { seed, ..scenario::sensor::<Real>(&config, N, 0.0, 1) };
    let mut run = row.scene(&sensor, N, (350.0, snr_db), None).run(trial).unwrap();
    let mut pipeline = pipeline(config);
    let mut last = Measurement::default();
    for (number, &segment) in config.scene.segments().iter().enumerate() {
        let samples = samples::<Real, N>(&mut run, number);
        last = pipeline.block(&stamp(number as u32, segment), &samples);
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
    let samples = block(100.2, 1000.0, 70.0);
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
fn each_verdict_where_it_belongs() {
    for arithmetic in [Arithmetic::Float, Arithmetic::Fixed] {
        let config = Config { arithmetic, ..Config::new(1.0, Codes::signed::<12>()) };
        for (bins, amplitude, gap, wanted) in [
            (100.3, 1000.0, false, Verdict::Good),
            (1.2, 1000.0, false, Verdict::NearEdge),
            (510.8, 1000.0, false, Verdict::NearEdge),
            (100.3, 2300.0, false, Verdict::Clipped),
            (100.3, 1000.0, true, Verdict::Gap),
            (100.3, 0.05, false, Verdict::Weak),
        ] {
            let stamp = Stamp { gap, ..Stamp::default() };
            let tone = pipeline(config).block(&stamp, &block(bins, amplitude, 2.0)).tone;
            assert_eq!(tone.verdict, wanted, "{arithmetic:?}: {amplitude} codes at {bins}");
        }
        for code in [0, 5, -1234] {
            let tone = pipeline(config).block(&Stamp::default(), &[code; N]).tone;
            assert_eq!(tone.verdict, Verdict::NoSignal, "{arithmetic:?}: {code}");
        }
    }
}
