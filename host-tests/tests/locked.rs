//! The locked way on noisy 12-bit records: its error over the bound, and whether it knows.

use picket_dsp::acquire::sample::{Iq, Real, Record};
use picket_dsp::spectrum::zoom::Oscillator;
use picket_dsp::tone::sigma::bound_bins;
use picket_dsp::tone::zoomed::{self, Place};
use picket_host::simulate::{Kind, Signal, generator};
use rand::RngExt;
use rayon::prelude::*;

const TRIALS: u64 = 400;

fn signal_sigma(amplitude: f64, snr_db: f64) -> f64 {
    Signal::tone(0.0, amplitude, snr_db).sigma()
}

/// RMSE over the bound, and the mean of (error / sigma)^2 with sigma from the true noise.
fn cell<R: Kind + Record, const N: usize>(
    centre: i32,
    offsets: (f64, f64),
    snr_db: f64,
    seed: u64,
) -> [f64; 2] {
    let amplitude = 2040.0 / (1.0 + 4.0 * Signal::tone(0.0, 1.0, snr_db).sigma());
    let middle = centre;
    let centre = zoomed::centre::<R>(centre as f32, N).unwrap();
    let oscillator = Oscillator::new::<R>(centre, N);
    let place = Place::new(centre, N);
    let sums: Vec<[f64; 2]> = (0..TRIALS)
        .into_par_iter()
        .map(|trial| {
            let mut rng = generator(seed, trial);
            let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            let offset = sign * rng.random_range(offsets.0..offsets.1);
            let mut signal = Signal::tone(f64::from(middle) + offset, amplitude, snr_db);
            // A constant offset must not show.
            signal.dc = [5.0, -3.0];
            let samples: [R::Sample; N] = signal.codes::<R>(N, &mut rng).try_into().unwrap();
            let zoom = oscillator.zoom::<R, N>(&samples);
            let found = place.fit::<R>(&zoom, (middle - centre) as f32).unwrap();
            let error = f64::from(found.offset) + f64::from(centre - middle) - offset;
            let parts = if R::IQ { 2.0 } else { 1.0 };
            let noise = parts * (signal.sigma().powi(2) + 1.0 / 12.0);
            let variance = N as f64 * noise / (2.0 * f64::from(found.information));
            [error * error, error * error / variance]
        })
        .collect();
    let [square, normal] =
        sums.iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]).map(|s| s / TRIALS as f64);
    // The converter's rounding is noise as well.
    let noise = signal_sigma(amplitude, snr_db).powi(2) + 1.0 / 12.0;
    let snr = amplitude * amplitude / (2.0 * noise);
    [square.sqrt() / f64::from(bound_bins::<R>(N, snr as f32)), normal]
}

#[test]
fn error_is_within_a_fifth_of_the_bound() {
    const SEED: u64 = 0x10CE_0001;
    println!("seed {SEED:#x}, {TRIALS} trials a cell");
    let mut worst = 0.0f64;
    let (mut squares, mut normals, mut count) = (0.0, 0.0, 0.0);
    let mut take = |name: String, [ratio, normal]: [f64; 2]| {
        println!("{name}: {ratio:.3}, (error/sigma)^2 {normal:.3}");
        worst = worst.max(ratio);
        squares += ratio * ratio;
        normals += normal;
        count += 1.0;
    };
    for snr_db in [-5.0, 10.0, 30.0, 60.0] {
        for offsets in [(0.0, 0.5), (0.5, 1.0), (1.5, 2.0)] {
            for centre in [8, 16, 24, 31, 32, 37, 64, 99, 300, 504] {
                let name = format!("real 1024, {snr_db} dB, bin {centre}, {offsets:?}");
                take(name, cell::<Real, 1024>(centre, offsets, snr_db, SEED));
            }
            let name = format!("I/Q 1024, {snr_db} dB, bin -200, {offsets:?}");
            take(name, cell::<Iq, 1024>(-200, offsets, snr_db, SEED));
            let name = format!("real 256, {snr_db} dB, bin 60, {offsets:?}");
            take(name, cell::<Real, 256>(60, offsets, snr_db, SEED));
            let name = format!("real 4096, {snr_db} dB, bin 999, {offsets:?}");
            take(name, cell::<Real, 4096>(999, offsets, snr_db, SEED));
        }
    }
    let (rms, normal) = ((squares / count).sqrt(), normals / count);
    println!("worst {worst:.3}, rms {rms:.3}, (error/sigma)^2 {normal:.3}");
    // 1.2 and three standard errors of 400 trials. Together: nominally 1.05.
    assert!(worst < 1.2 * (1.0 + 3.0 / (2.0 * TRIALS as f64).sqrt()), "{worst}");
    assert!(rms < 1.07, "{rms}");
    assert!((0.95..1.1).contains(&normal), "{normal}");
}
