//! Tones that are on for a part of a record only, or whose level changes strongly: what is usable is within five sigma.

use crate::signal::*;
use host_tests::sized;
use picket_dsp::config::Config;
use picket_dsp::{Arithmetic, Codes, Iq, Pipeline, Real, Record, Stamp, Usable};
use rand::RngExt;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

const N: usize = 1024;

/// A level over the record's time, which goes from 0 to 1, and where it is.
type Envelope = fn(f64, f64) -> f64;

/// Name, envelope, and the range from which the place is drawn.
const ENVELOPES: [(&str, Envelope, (f64, f64)); 9] = [
    ("Gaussian burst, sd .1", |t, c| (-((t - c) / 0.1).powi(2) / 2.0).exp(), (0.2, 0.8)),
    ("Gaussian burst, sd .2", |t, c| (-((t - c) / 0.2).powi(2) / 2.0).exp(), (0.2, 0.8)),
    ("Gaussian burst, sd .35", |t, c| (-((t - c) / 0.35).powi(2) / 2.0).exp(), (0.0, 1.0)),
    ("on for .25", |t, c| f64::from((c..c + 0.25).contains(&t)), (0.0, 0.75)),
    ("on for .5", |t, c| f64::from((c..c + 0.5).contains(&t)), (0.0, 0.5)),
    ("on for .75", |t, c| f64::from((c..c + 0.75).contains(&t)), (0.0, 0.25)),
    ("AM of .9, one cycle", |t, c| (1.0 + 0.9 * (TAU * (t + c)).sin()) / 1.9, (0.0, 1.0)),
    ("AM of .9, two cycles", |t, c| (1.0 + 0.9 * (TAU * (2.0 * t + c)).sin()) / 1.9, (0.0, 1.0)),
    ("decay to 1/e in .2", |t, _| (-t / 0.2).exp(), (0.0, 1.0)),
];

/// The shares of records that are usable within sigma, and of those that are usable and off by more than five sigma.
fn shares<R: Record>(
    (envelope, places): (Envelope, (f64, f64)),
    arithmetic: Arithmetic,
    snr_db: f64,
    seed: u64,
) -> [f64; 2] {
    let config = Config { arithmetic, ..Config::new(1.0, Codes::signed::<12>()) };
    let plan = config.plan::<R, N>().unwrap();
    let amplitude = amplitude(snr_db);
    let noise = sigma(amplitude, snr_db);
    let seen = trials(seed, sized(50, 1000), |rng| {
        let (bins, phase) = (rng.random_range(20.0..480.0), rng.random_range(0.0..TAU));
        let place = rng.random_range(places.0..places.1);
        let samples: Vec<R::Sample> = (0..N)
            .map(|n| {
                let level = amplitude * envelope(n as f64 / N as f64, place);
                let (sin, cos) = (TAU * bins * n as f64 / N as f64 + phase).sin_cos();
                R::from_parts([cos, sin].map(|part| {
                    quantise(level * part + noise * rng.sample::<f64, _>(StandardNormal))
                }))
            })
            .collect();
        let samples: &[R::Sample; N] = samples.as_slice().try_into().unwrap();
        let tone = Pipeline::<R, N>::new(plan).block(&Stamp::default(), samples).tone;
        let usable = matches!(tone.verdict.usable(), Usable::Yes | Usable::WithinSigma);
        let off = (tone.frequency.bins(N) - bins).abs() > 5.0 * f64::from(tone.sigma) * N as f64;
        (usable, usable && off)
    });
    let share = |of: fn(&(bool, bool)) -> bool| {
        seen.iter().filter(|seen| of(seen)).count() as f64 / seen.len() as f64
    };
    [share(|seen| seen.0), share(|seen| seen.1)]
}

/// 10, 30 and 50 dB at the peak, real and I/Q, either arithmetic, a seed for each cell from 381 on.
#[test]
fn a_tone_for_a_part_of_a_record_is_within_five_sigma_or_not_usable() {
    let mut seeds = 381..;
    for (name, envelope, places) in ENVELOPES {
        let mut cells = Vec::new();
        for arithmetic in [Arithmetic::Float, Arithmetic::Fixed] {
            for snr_db in [10.0, 30.0, 50.0] {
                let shape = (envelope, places);
                cells.push(shares::<Real>(shape, arithmetic, snr_db, seeds.next().unwrap()));
                cells.push(shares::<Iq>(shape, arithmetic, snr_db, seeds.next().unwrap()));
            }
        }
        let [usable, off] = [0, 1].map(|i| mean(cells.iter().map(|cell| cell[i])));
        let worst = cells.iter().map(|cell| cell[1]).fold(0.0, f64::max);
        println!(
            "{name}: usable {usable:.3}, off by more than five sigma {off:.4}, worst cell {worst:.3}"
        );
        // What chance adds to 3 % of so many records, three standard deviations.
        let records = cells.len() as f64 * sized(50, 1000) as f64;
        assert!(off <= 0.03 + 3.0 * (0.03 / records).sqrt(), "{name}");
    }
}
