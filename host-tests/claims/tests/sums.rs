//! Sums of many blocks: accuracy, sigma, detection and false alarms.

use picket_claims::scenes::{Kind, line, tones};
use picket_claims::{Asked, Case, Event, Path, hold};
use picket_dsp::Verdict;
use picket_simulator::scene::Change;
use picket_simulator::{Scene, Value};
use statrs::function::gamma::{gamma_ur, ln_gamma};
use std::f64::consts::PI;

use Kind::{Iq, Real};

/// The standard deviation of the noise in codes.
const NOISE: f64 = 100.0;

fn db(x: f64) -> f64 {
    10f64.powf(x / 10.0)
}

/// A sum of so many blocks of a tone, which drifts by so many bins from block to block.
fn summed(kind: Kind, n: usize, blocks: u32, snr_db: f64, drift: f64) -> Scene {
    let last = if kind == Iq { n } else { n / 2 } as f64;
    let middle_s = 0.5 * f64::from(blocks - 1) + 0.5;
    let room = 8.0 + 0.5 * f64::from(blocks) * drift.abs();
    let mut tone = line(room..last - room, NOISE * (2.0 * db(snr_db)).sqrt());
    if drift != 0.0 {
        tone.changes = vec![Change::Chirp { hz_per_s: drift.into(), at_s: middle_s.into() }];
    }
    let mut scene = tones(kind, n, [tone], NOISE);
    scene.seconds = f64::from(blocks);
    scene
}

fn label(claim: &str, kind: Kind, n: usize, blocks: u32, snr_db: f64, drift: f64) -> String {
    format!("{claim}: {} {n}, {blocks} blocks, {snr_db:.2} dB, drift {drift}", kind.name())
}

/// From -3 to 24 dB in the bin of one block, and at 0 dB a sample.
fn precise(kind: Kind, n: usize, blocks: u32, snr_db: f64, drift: f64, trials: u64) -> Case {
    let scene = summed(kind, n, blocks, snr_db, drift);
    let label = label("a sum is precise", kind, n, blocks, snr_db, drift);
    let case = Case::new(label, scene, n).by(Path::Sum(blocks, drift as f32)).trials(trials);
    // Blocks without a common phase lose a little where their own line is weak.
    let in_bin = db(snr_db) * n as f64 / if kind == Iq { 1.0 } else { 2.0 };
    let most = 1.25f64.max(1.1 * (1.0 + 1.0 / in_bin).sqrt());
    let case = case.asks(Asked::OverBound { quantity: 0, most }).square(0.85, 1.2);
    let case = case.at_most(0.01, Event::Elsewhere);
    // A steady line is not taken for a broad one, but in one sum of a hundred.
    case.at_most(0.01, Event::Is(&[Verdict::Moving]))
}

#[test]
fn a_sum_is_as_precise_as_its_blocks_allow() {
    let mut rows = Vec::new();
    for (blocks, snr_db) in
        [(4, -15.0), (4, 0.0), (16, -18.0), (16, 0.0), (100, -22.0), (100, -6.0)]
    {
        rows.push(precise(Real, 1024, blocks, snr_db, 0.0, 200));
        rows.push(precise(Iq, 1024, blocks, snr_db - 3.0, 0.0, 200));
    }
    rows.push(precise(Real, 1024, 1000, -26.0, 0.0, 100));
    rows.push(precise(Real, 64, 30, -3.0, 0.0, 200));
    rows.push(precise(Real, 256, 30, -9.0, 0.0, 200));
    rows.push(precise(Iq, 64, 30, -6.0, 0.0, 200));
    rows.push(precise(Real, 4096, 16, -24.0, 0.0, 100));
    // A known drift of up to a quarter of a bin a block costs little.
    for drift in [0.013, 0.25, -0.11] {
        rows.push(precise(Real, 1024, 40, -18.0, drift, 100));
        rows.push(precise(Iq, 256, 40, -15.0, drift, 100));
    }
    hold(rows);
}

/// The power over the noise of one bin, in each of `m` blocks, that is detected with probability `detected` where noise alone passes with
/// probability `false_alarm` in a search over all frequencies of `bins` bins, the noise known: Rice's formula for the threshold, the noncentral
/// chi-squared distribution for the line.
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
    // A Poisson mixture of sums of m + k exponential numbers.
    let seen = |snr: f64| {
        let mean = m * snr;
        let last = (mean + 20.0 * mean.sqrt() + 50.0) as u32;
        let term = |k: u32| {
            let k = f64::from(k);
            (k * mean.ln() - mean - ln_gamma(k + 1.0)).exp() * gamma_ur(m + k, threshold)
        };
        (0..last).map(term).sum::<f64>() > detected
    };
    solve(1e-4, 100.0, &seen)
}

/// Lines anywhere between bins, at the theory's power + .3 dB, are found in nine sums of ten; noise passes as often as asked.
#[test]
fn a_line_is_found_where_theory_says_and_noise_passes_as_often_as_asked() {
    let mut rows = Vec::new();
    for (blocks, trials) in [(4, 600), (30, 300), (100, 200), (1000, 40)] {
        let snr_db = 10.0 * (theory(blocks, 511.0, 1e-6, 0.9) * 2.0 / 1024.0).log10() + 0.3;
        let label = label("a sum finds", Real, 1024, blocks, snr_db, 0.0);
        let case = Case::new(label, summed(Real, 1024, blocks, snr_db, 0.0), 1024);
        rows.push(case.by(Path::Sum(blocks, 0.0)).trials(trials).at_least(0.9, Event::Good));
    }
    for (kind, n, blocks, trials) in [
        (Real, 1024, 4, 1000),
        (Real, 1024, 30, 1000),
        (Real, 1024, 100, 333),
        (Real, 256, 10, 1000),
        (Real, 64, 10, 1000),
        (Iq, 256, 10, 1000),
    ] {
        let mut scene = tones(kind, n, [], NOISE);
        scene.seconds = f64::from(blocks);
        let label = label("noise alone, summed", kind, n, blocks, -300.0, 0.0);
        let case = Case::new(label, scene, n).by(Path::Sum(blocks, 0.0)).trials(trials);
        let case = case.told(|config| config.false_alarm = 0.05);
        rows.push(case.asks(Asked::Share { of: Event::Found, least: 0.025, most: 0.1 }));
    }
    // A line of another frequency in each block, as of turbulent wind, is moving.
    let mut tone = line(200.3, 0.3 * NOISE);
    tone.changes = vec![Change::Fm { deviation_hz: 2.8.into(), rate_hz: Value::from(0.29..0.31) }];
    let mut scene = tones(Real, 1024, [tone], NOISE);
    scene.seconds = 60.0;
    let case = Case::new("a broad line is moving, summed", scene, 1024).by(Path::Sum(60, 0.0));
    rows.push(case.trials(50).at_least(0.95, Event::Is(&[Verdict::Moving])));
    hold(rows);
}
