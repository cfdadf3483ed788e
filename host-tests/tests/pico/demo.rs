//! `picket demo --board pico`, inside the same limits as on the emulated MPS2.

use host_tests::{data, sized};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Real, Stamp};
use picket_dsp::config::{Config, Scene};
use picket_dsp::pipeline::{Outcome, Pipeline};
use picket_dsp::tone::Verdict;
use picket_firmware::pico::N;
use picket_host::demo::options::{Board, Options};
use picket_host::demo::{pico, table};

/// The 28 targets of the lidar, slowed down to the board's rate, inside the paper's bars.
#[test]
fn every_lidar_row_is_inside_the_papers_bars() {
    for seed in 1..=sized(1, 20) {
        let options = Options { board: Board::Pico, seed, ..Options::default() };
        let summary = table::lidar(&options).unwrap();
        println!("seed {seed}\n{}\n{}", summary.rows_text(), summary.text());
        assert_eq!((summary.results.len(), summary.inside()), (28, 28), "{seed}");
        for row in &summary.results {
            let [range, velocity] = row.errors().unwrap();
            let answer = row.answer.unwrap();
            assert!(range.abs() < 5.0 * answer.sigma_range_m, "{seed} {row:?}");
            assert!(velocity.abs() < 5.0 * answer.sigma_velocity_mps, "{seed} {row:?}");
            assert_eq!(answer.verdict, Verdict::Good, "{seed} {row:?}");
        }
    }
}

/// A car's echo at 24 GHz, by others, from 9 s on: what the board makes of it with its twelve bits is what the pipeline makes of all
/// sixteen, as the MPS2 runs it.
#[test]
fn a_recorded_car_has_the_speed_that_it_has_elsewhere() {
    let bytes = std::fs::read(data("cw24_car_moto_towards_i16_48000.bin")).unwrap();
    let samples = bytes.as_chunks().0.iter().map(|&sample| i16::from_le_bytes(sample));
    let samples: Vec<i16> = samples.skip(40 * N).take(sized(120, 424) as usize * N).collect();
    let peak = samples.iter().fold(1.0f64, |peak, &sample| peak.max(f64::from(sample).abs()));
    let voltages: Vec<f64> =
        samples.iter().map(|&sample| f64::from(sample) * 1900.0 / peak).collect();
    let scene = Scene::Doppler {
        wavelength_m: 299_792_458.0 / 24e9,
        angle_rad: 0.0,
        mixing: picket_dsp::Mixing::RxConjTx,
    };
    let band_hz = Some((300.0, 2500.0));
    // The Pico has no joint fit.
    let effort = picket_dsp::Effort::LOOK;
    let config = Config { scene, band_hz, effort, ..Config::new(48e3, Codes::signed::<16>()) };
    let records = pico::records(config, &voltages).unwrap();
    let mut pipeline = Box::new(Pipeline::<Real, N>::new(config.plan().unwrap()));
    let (mut good, mut worst) = (0, 0.0f64);
    for (block, record) in samples.as_chunks::<N>().0.iter().zip(&records) {
        let elsewhere = pipeline.block(&Stamp::default(), block);
        let here = &record.measurement;
        let speed = |result: &Outcome| match result {
            Outcome::Velocity(velocity) => velocity.velocity.to_num::<f64>(),
            other => panic!("{other:?}"),
        };
        let sigmas = (here.tone.hertz() - elsewhere.tone.hertz()) / elsewhere.tone.sigma_hertz();
        if elsewhere.tone.verdict == Verdict::Good {
            good += 1;
            worst = worst.max(sigmas.abs());
            assert!(sigmas.abs() < 0.5, "{here:?} {elsewhere:?}");
            let difference = speed(&here.result) - speed(&elsewhere.result);
            // A sigma of a good block is some centimetres a second.
            assert!(difference.abs() < 0.05, "{here:?} {elsewhere:?}");
        }
    }
    println!("{good} good of {} blocks, at most {worst:.2} sigma from sixteen bits", records.len());
    // The car is there for the first seconds alone.
    assert!(good > 35, "{good}");
}
