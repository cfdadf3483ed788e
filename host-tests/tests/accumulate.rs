//! Sums of many blocks: accuracy, sigma, detection and false alarms, from tones of a new phase in each block.

use crate::signal::*;
use host_tests::sized;
use picket_dsp::acquire::sample::Record;
use picket_dsp::config::Config;
use picket_dsp::{Accumulated, Accumulator, Iq, Pipeline, Real, Segment, Stamp, Verdict};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::{PI, TAU};
use std::sync::atomic::{AtomicU32, Ordering};

/// The standard deviation of the noise in codes.
const NOISE: f64 = 100.0;

/// The sum of `blocks` records of a tone of `bins`, which moves by `drift` bins from block to block, and is at `bins` in the middle.
fn summed<R: Record, const N: usize>(
    rng: &mut ChaCha8Rng,
    mut accumulator: Accumulator<R, N>,
    (bins, drift): (f64, f64),
    snr_db: f64,
) -> Accumulated {
    let blocks = accumulator.blocks();
    let amplitude = NOISE * (2.0 * db(snr_db)).sqrt();
    let plan = Config::new(1.0, CODES).plan::<R, N>().unwrap();
    let mut pipeline = Pipeline::<R, N>::new(plan);
    for block in 0..blocks {
        let place = bins + drift * (f64::from(block) - 0.5 * f64::from(blocks - 1));
        let phase = rng.random_range(0.0..TAU);
        let samples: [R::Sample; N] = std::array::from_fn(|n| {
            let (sin, cos) = (TAU * place * n as f64 / N as f64 + phase).sin_cos();
            let noise = |rng: &mut ChaCha8Rng| NOISE * rng.sample::<f64, _>(StandardNormal);
            let part = |x: f64, rng: &mut ChaCha8Rng| quantise(amplitude * x + noise(rng));
            R::from_parts([part(cos, rng), if R::IQ { part(sin, rng) } else { 0 }])
        });
        let stamp = Stamp { sequence: block, ..Stamp::default() };
        let measurement = pipeline.block(&stamp, &samples);
        if let Some(accumulated) = accumulator.add(&measurement, &pipeline) {
            return accumulated;
        }
    }
    panic!("no sum after {blocks} blocks")
}

/// The power of a line over the noise of its bin.
fn in_bin<R: Record, const N: usize>(snr_db: f64) -> f64 {
    db(snr_db) * N as f64 / if R::IQ { 1.0 } else { 2.0 }
}

/// The bound of a tone's frequency in one block over the root of the number of blocks, in bins.
fn bound<R: Record, const N: usize>(snr_db: f64, blocks: u32) -> f64 {
    (6.0 / (4.0 * PI * PI) / (in_bin::<R, N>(snr_db) * f64::from(blocks))).sqrt()
}

/// Root mean square error over the bound, and the mean of (error / sigma)^2, of lines that are detected.
fn precision<R: Record, const N: usize>(
    blocks: u32,
    snr_db: f64,
    drift: f64,
    seed: u64,
    count: u64,
) {
    let wide = AtomicU32::new(0);
    let errors: Vec<(f64, f64)> = trials(seed, count, |rng| {
        let last = if R::IQ { N as f64 } else { N as f64 / 2.0 };
        let bins = rng.random_range(8.0..last - 8.0);
        let accumulator = Accumulator::<R, N>::new(blocks).with_drift(drift as f32);
        let seen = summed(rng, accumulator, (bins, drift), snr_db);
        assert_eq!(seen.blocks, blocks);
        wide.fetch_add(u32::from(seen.tone.verdict == Verdict::Moving), Ordering::Relaxed);
        let mut error = seen.tone.frequency.bins(N) - bins;
        error -= N as f64 * (error / N as f64).round();
        (error, f64::from(seen.tone.sigma) * N as f64)
    });
    let ratio_of =
        ratio(&errors.iter().map(|e| (e.0, bound::<R, N>(snr_db, blocks))).collect::<Vec<_>>());
    let chi2 = ratio(&errors).rms.powi(2);
    println!(
        "{} N {N}, {blocks} blocks, {snr_db} dB, drift {drift}: rms/bound {:.3}, (error/sigma)^2 {chi2:.3}, outliers {}",
        if R::IQ { "I/Q " } else { "real" },
        ratio_of.rms,
        ratio_of.outliers
    );
    // What chance adds, three standard deviations of a mean of squares.
    let chance = 3.0 * (2.0 / count as f64).sqrt();
    let noncoherent = (1.0 + 1.0 / in_bin::<R, N>(snr_db)).sqrt();
    assert!(ratio_of.rms < 1.25f64.max(1.1 * noncoherent) * (1.0 + chance / 2.0));
    assert!((0.85 - chance..1.2 + chance).contains(&chi2), "seed {seed}");
    assert!(ratio_of.outliers < 0.01);
    // A steady line is not taken for a broad one, but in one sum of a hundred.
    let share = f64::from(wide.into_inner()) / count as f64;
    assert!(share <= 0.01 + 3.0 * (0.01 / count as f64).sqrt(), "{share} wide, seed {seed}");
}

/// From -3 to 24 dB in the bin of one block, and at 0 dB a sample; seeds 4100 on.
#[test]
fn a_sum_is_as_precise_as_its_blocks_allow() {
    let count = sized(200, 2000);
    for (at, (blocks, snr_db)) in
        [(4, -15.0), (4, 0.0), (16, -18.0), (16, 0.0), (100, -22.0), (100, -6.0)]
            .into_iter()
            .enumerate()
    {
        let seed = 4100 + 10 * at as u64;
        precision::<Real, 1024>(blocks, snr_db, 0.0, seed, count);
        precision::<Iq, 1024>(blocks, snr_db - 3.0, 0.0, seed + 1, count);
    }
    precision::<Real, 1024>(1000, -26.0, 0.0, 4170, sized(100, 1000));
    precision::<Real, 64>(30, -3.0, 0.0, 4180, count);
    precision::<Real, 256>(30, -9.0, 0.0, 4181, count);
    precision::<Iq, 64>(30, -6.0, 0.0, 4182, count);
    precision::<Real, 4096>(16, -24.0, 0.0, 4183, count / 2);
}

/// A known drift of up to a quarter of a bin a block costs little; seeds 4190 on.
#[test]
fn a_known_drift_is_compensated() {
    for (at, drift) in [0.013, 0.25, -0.11].into_iter().enumerate() {
        let seed = 4190 + 2 * at as u64;
        precision::<Real, 1024>(40, -18.0, drift, seed, sized(100, 1000));
        precision::<Iq, 256>(40, -15.0, drift, seed + 1, sized(100, 1000));
    }
}

/// The natural logarithm of the gamma function of a whole number or one half more, above 0.
fn ln_gamma(x: f64) -> f64 {
    // Stirling's series from 20 on, exact to 1e-12.
    let (mut low, mut x) = (0.0, x);
    while x < 20.0 {
        low += x.ln();
        x += 1.0;
    }
    let z = 1.0 / (x * x);
    (x - 0.5) * x.ln() - x + 0.5 * TAU.ln() + (1.0 / 12.0 - z * (1.0 / 360.0 - z / 1260.0)) / x
        - low
}

/// The power over the noise of one bin, in each of `m` blocks, that is detected with probability `detected` where noise alone passes
/// with probability `false_alarm` in a search over all frequencies of `bins` bins, the noise known: Rice's formula for the
/// threshold, the noncentral chi-squared distribution for the line.
fn theory(m: u32, bins: f64, false_alarm: f64, detected: f64) -> f64 {
    let m = f64::from(m);
    let solve = |mut low: f64, mut high: f64, above: &dyn Fn(f64) -> bool| {
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if above(middle) { high = middle } else { low = middle }
        }
        high
    };
    let alarms = |x: f64| {
        let ln = 0.5 * (PI / 3.0).ln() + (m - 0.5) * x.ln() - x - ln_gamma(m);
        bins.ln() + ln < false_alarm.ln()
    };
    let threshold = solve(m, 3.0 * m + 100.0, &alarms);
    let seen = |snr: f64| {
        // A Poisson mixture of sums of m + k exponential numbers.
        let mean = m * snr;
        // exp(-x) sum over j < m of x^j / j!, from the largest term down.
        let mut tail = 0.0;
        let mut term = ((m - 1.0) * threshold.ln() - threshold - ln_gamma(m)).exp();
        let mut next = term * threshold / m;
        for j in (0..m as u32).rev() {
            tail += term;
            term *= f64::from(j) / threshold;
        }
        let (mut weight, mut total) = (-mean, 0.0);
        for k in 0..(mean + 20.0 * mean.sqrt() + 50.0) as u32 {
            total += weight.exp() * tail.min(1.0);
            tail += next;
            next *= threshold / (m + f64::from(k) + 1.0);
            weight += mean.ln() - f64::from(k + 1).ln();
        }
        total > detected
    };
    solve(1e-4, 100.0, &seen)
}

/// Lines anywhere between bins, at the theory's power + .3 dB, are found in nine sums of ten; 1e-6; seeds 4200 on.
#[test]
fn a_line_is_found_where_theory_says() {
    for (at, (blocks, count)) in [
        (4, sized(600, 6000)),
        (30, sized(300, 3000)),
        (100, sized(200, 2000)),
        (1000, sized(40, 400)),
    ]
    .into_iter()
    .enumerate()
    {
        let power = theory(blocks, 511.0, 1e-6, 0.9);
        let snr_db = 10.0 * (power * 2.0 / 1024.0).log10() + 0.3;
        let seed = 4200 + at as u64;
        let found = trials(seed, count, |rng| {
            let bins = rng.random_range(20.0..490.0);
            let seen = summed(rng, Accumulator::<Real, 1024>::new(blocks), (bins, 0.0), snr_db);
            let near = (seen.tone.frequency.bins(1024) - bins).abs() < 1.5;
            near && seen.tone.verdict == Verdict::Good
        });
        let share = found.iter().filter(|&&found| found).count() as f64 / count as f64;
        println!("{blocks} blocks, {snr_db:.2} dB a sample: found {share:.3}");
        assert!(share > 0.9 - 3.0 * (0.09 / count as f64).sqrt(), "{blocks} blocks, seed {seed}");
    }
}

/// Noise alone passes as often as asked, within a factor of two; seeds 4300 on.
#[test]
fn noise_passes_as_often_as_asked() {
    fn alarms<R: Record, const N: usize>(blocks: u32, asked: f64, seed: u64, count: u64) {
        let passed = trials(seed, count, |rng| {
            let accumulator = Accumulator::<R, N>::new(blocks).with_false_alarm(asked);
            summed(rng, accumulator, (10.0, 0.0), -300.0).tone.verdict != Verdict::Weak
        });
        let share = passed.iter().filter(|&&passed| passed).count() as f64 / count as f64;
        println!("N {N}, {blocks} blocks: asked {asked}, seen {share:.4}");
        let chance = 3.0 * (asked / count as f64).sqrt();
        assert!((asked / 2.0 - chance..asked * 2.0 + chance).contains(&share), "seed {seed}");
    }
    let count = sized(1000, 20_000);
    alarms::<Real, 1024>(4, 0.05, 4300, count);
    alarms::<Real, 1024>(30, 0.05, 4301, count);
    alarms::<Real, 1024>(100, 0.05, 4302, count / 3);
    alarms::<Real, 256>(10, 0.05, 4303, count);
    alarms::<Real, 64>(10, 0.05, 4304, count);
    alarms::<Iq, 256>(10, 0.05, 4305, count);
}

/// A line of another frequency in each block, as of turbulent wind, is moving. Seed 4310.
#[test]
fn a_broad_line_is_moving() {
    let seen = trials(4310, sized(50, 500), |rng| {
        let plan = Config::new(1.0, CODES).plan::<Real, 1024>().unwrap();
        let mut pipeline = Pipeline::<Real, 1024>::new(plan);
        let mut sum = Accumulator::<Real, 1024>::new(60);
        let mut last = None;
        for sequence in 0..60 {
            let bins = 200.3 + 2.0 * rng.sample::<f64, _>(StandardNormal);
            let samples = std::array::from_fn(|n| {
                let noise = NOISE * rng.sample::<f64, _>(StandardNormal);
                quantise(0.3 * NOISE * (TAU * bins * n as f64 / 1024.0).cos() + noise)
            });
            let measurement = pipeline.block(&Stamp { sequence, ..Stamp::default() }, &samples);
            last = sum.add(&measurement, &pipeline).or(last);
        }
        last.unwrap().tone.verdict == Verdict::Moving
    });
    let share = seen.iter().filter(|&&moving| moving).count() as f64 / seen.len() as f64;
    println!("{share} moving");
    assert!(share >= 0.95);
}

/// Each segment of a chirp has its sum, a gap does no harm, and silence is nothing.
#[test]
fn segments_silence_and_clearing() {
    let plan = Config::new(1.0, CODES).plan::<Real, 64>().unwrap();
    let mut pipeline = Pipeline::<Real, 64>::new(plan);
    let mut sum = Accumulator::<Real, 64>::new(3).for_segment(Segment::Down);
    let mut results = 0;
    for sequence in 0..12 {
        let segment = [Segment::Up, Segment::Down][sequence as usize % 2];
        let stamp = Stamp { sequence, segment, gap: sequence == 5, ..Stamp::default() };
        let measurement = pipeline.block(&stamp, &[7; 64]);
        results += i32::from(sum.add(&measurement, &pipeline).is_some_and(|seen| {
            assert_eq!((seen.tone.verdict, seen.blocks), (Verdict::NoSignal, 3));
            true
        }));
    }
    assert_eq!((results, sum.added()), (2, 0));
}
