//! A thousand records each of five things that go wrong: what may be used is as exact as its sigma says, and a dead channel
//! never has a sign. No feature of the library changes an answer (`features.rs`), so the figures are those of every build.

use crate::signal::mean;
use picket_dsp::{Codes, Config, Pipeline, Stamp, Tone, Usable, Verdict};
use picket_dsp::{Iq, Real};
use picket_host::simulate::{Kind, codes, generator};
use picket_lab::impair::{Impairment, Setup};
use rayon::prelude::*;

const N: usize = 1024;
const RECORDS: u64 = 1000;
const SEED: u64 = 380;

/// Tones of such records and the error of each in bins.
fn measured<R: Kind>(text: &str, snr_db: f64) -> Vec<(Tone, f64)> {
    let impairments = Impairment::parse(text).unwrap();
    let [impairment] = impairments.as_slice() else { panic!("{text}") };
    let setup = Setup::new(N, snr_db);
    let plan = Config::new(1.0, Codes::signed::<12>()).plan::<R, N>().unwrap();
    (0..RECORDS)
        .into_par_iter()
        .map(|trial| {
            let record = impairment.record::<R>(&setup, &mut generator(SEED, trial));
            let samples: [R::Sample; N] = codes::<R>(&record.samples).try_into().unwrap();
            let tone = Pipeline::<R, N>::new(plan).block(&Stamp::default(), &samples).tone;
            let off = tone.frequency.cycles() - record.bins / N as f64;
            (tone, (off - off.round()) * N as f64)
        })
        .collect()
}

/// The share that may be used within sigma, and the rms of its error over sigma.
fn of_usable<R: Kind>(text: &str, snr_db: f64) -> [f64; 2] {
    let seen = measured::<R>(text, snr_db);
    let usable = seen.iter().filter(|(tone, _)| tone.verdict.usable() <= Usable::WithinSigma);
    let share = usable.clone().count() as f64 / RECORDS as f64;
    let square = |(tone, error): &(Tone, f64)| (error / f64::from(tone.sigma) / N as f64).powi(2);
    let rms = mean(usable.map(square)).sqrt();
    println!("{}, {text}, {snr_db} dB: usable {share:.3}, error over sigma {rms:.2}", R::NAME);
    [share, rms]
}

/// Of all kinds but one nearly all records may be used, and error over sigma is at most 1.15: less where sigma has in it what may be wrong
/// besides. The noise hides too much of a second tone that is no stronger: there it is 2.0 of real records, all of which are
/// moving.
#[test]
fn what_is_usable_of_disturbed_records_is_within_its_sigma() {
    println!("seed {SEED}");
    for (text, snr_db, most) in [
        ("second-tone:offset=0.7,level-db=-20", 20.0, 2.2),
        ("second-tone:offset=0.7,level-db=-20", 40.0, 1.15),
        ("clip-converter:0.027", 20.0, 1.15),
        ("clip-converter:0.027", 40.0, 1.15),
        ("am:depth=0.2,cycles=0.3", 20.0, 1.15),
        ("am:depth=0.2,cycles=0.3", 40.0, 1.15),
        ("am:depth=0.2,cycles=1", 20.0, 1.15),
        ("am:depth=0.2,cycles=1", 40.0, 1.15),
        ("noise-flicker:1", 20.0, 1.15),
        ("noise-flicker:1", 40.0, 1.15),
    ] {
        for [share, rms] in [of_usable::<Real>(text, snr_db), of_usable::<Iq>(text, snr_db)] {
            assert!(share >= 0.99, "{text}, {snr_db} dB: {share} usable");
            assert!((0.3..=most).contains(&rms), "{text}, {snr_db} dB: {rms}");
        }
    }
}

#[test]
fn a_dead_channel_is_an_image_in_every_record() {
    println!("seed {SEED}");
    for snr_db in [0.0, 20.0, 40.0] {
        for part in [0, 1] {
            let seen = measured::<Iq>(&format!("iq-dead:{part}"), snr_db);
            let images = seen.iter().filter(|(tone, _)| tone.verdict == Verdict::Image).count();
            let signed =
                seen.iter().filter(|(tone, _)| tone.verdict.usable() < Usable::WithoutSign).count();
            println!(
                "part {part} dead, {snr_db} dB: image {images} of {RECORDS}, with a sign {signed}"
            );
            assert_eq!((images as u64, signed), (RECORDS, 0), "part {part}, {snr_db} dB");
        }
    }
}
