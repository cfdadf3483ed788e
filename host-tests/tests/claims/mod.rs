//! What is claimed of an answer, on records with one thing wrong, at every effort.

mod records;

use crate::signal::{CODES, Kind, quantise, trials};
use host_tests::figures::hold;
use host_tests::sized;
use picket_dsp::config::Config;
use picket_dsp::pipeline::Pipeline;
use picket_dsp::plan::Plan;
use picket_dsp::{Effort, Iq, Real, Stamp, Verdict};
use records::{Colour, Scene};
use std::collections::BTreeMap;

/// An answer beside the truth.
#[derive(Clone, Copy, Debug)]
struct Said {
    /// Bins.
    error: f64,
    sigma: f64,
    /// Weak is neither.
    usable: bool,
    good: bool,
    weak: bool,
    bound: f64,
}

/// The verdicts whose answers are within their sigma.
const USABLE: [Verdict; 3] = [Verdict::Good, Verdict::Moving, Verdict::Clipped];

/// The efforts that are compared.
const EFFORTS: [Effort; 3] = [Effort::Look, Effort::One, Effort::Full];

/// The answers at each effort.
fn each<R: Kind, const N: usize>(
    plans: &[Plan<R, N>; 3],
    scene: Scene,
    seed: u64,
    count: u64,
    snr_db: f64,
) -> [Vec<Said>; 3] {
    let all = trials(seed, count, |rng| {
        let taken = scene.record(rng, N, R::IQ, snr_db);
        let samples: [R::Sample; N] =
            std::array::from_fn(|i| R::from_parts(taken.samples[i].map(quantise)));
        let from = |bins: f64, truth: f64| {
            let error = bins - truth;
            if R::IQ {
                (error + N as f64 / 2.0).rem_euclid(N as f64) - N as f64 / 2.0
            } else {
                error
            }
        };
        let apart = |bins: f64| {
            let across = 2.0 * taken.truth - taken.other;
            let errors = [taken.truth, taken.other, across].map(|truth| from(bins, truth));
            errors.into_iter().min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(f64::NAN)
        };
        plans.map(|plan| {
            let tone = Pipeline::<R, N>::new(plan).block(&Stamp::default(), &samples).tone;
            Said {
                error: apart(tone.frequency.bins(N)),
                sigma: f64::from(tone.sigma) * N as f64,
                usable: USABLE.contains(&tone.verdict),
                good: tone.verdict == Verdict::Good,
                weak: matches!(tone.verdict, Verdict::Weak | Verdict::NoSignal),
                bound: taken.bound,
            }
        })
    });
    [0, 1, 2].map(|which| all.iter().map(|said| said[which]).collect())
}

/// A row of the table: shares in percent.
#[derive(Clone, Copy, Debug)]
struct Row {
    off: f64,
    good_off: f64,
    /// Of all answers: those that may not be used, and those of them that are within five bounds of the tone.
    refused: f64,
    refused_right: f64,
    weak: f64,
    rms: f64,
    square: f64,
    sigma: f64,
}

impl Row {
    fn of(said: &[Said]) -> Self {
        let count = said.len() as f64;
        let share = |of: &dyn Fn(&Said) -> bool| {
            100.0 * said.iter().filter(|said| of(said)).count() as f64 / count
        };
        let lies = |said: &Said| said.error.abs() > 5.0 * said.sigma;
        let usable: Vec<&Said> = said.iter().filter(|said| said.usable).collect();
        let mean = |of: &dyn Fn(&Said) -> f64| {
            usable.iter().map(|said| of(said)).sum::<f64>() / usable.len().max(1) as f64
        };
        let mut sigmas: Vec<f64> = said.iter().map(|said| said.sigma / said.bound).collect();
        sigmas.sort_by(f64::total_cmp);
        Self {
            off: share(&|said| said.usable && lies(said)),
            good_off: share(&|said| said.good && lies(said)),
            refused: share(&|said| !said.usable),
            refused_right: share(&|said| !said.usable && said.error.abs() < 5.0 * said.bound),
            weak: share(&|said| said.weak),
            rms: mean(&|said| (said.error / said.bound).powi(2)).sqrt(),
            square: mean(&|said| (said.error / said.sigma).powi(2).min(1e6)),
            sigma: sigmas[sigmas.len() / 2],
        }
    }
}

/// Every scene at this length and SNR; prints a row a cell.
fn cells<R: Kind, const N: usize>(
    snr_db: f64,
    count: u64,
    only: Option<&str>,
) -> Vec<(Scene, [Row; 3])> {
    let plans =
        EFFORTS.map(|effort| Config { effort, ..Config::new(1.0, CODES) }.plan::<R, N>().unwrap());
    let kind = if R::IQ { "I/Q" } else { "real" };
    let scenes = Scene::all(R::IQ).into_iter().enumerate();
    let scenes =
        scenes.filter(|(_, scene)| only.is_none_or(|only| scene.group().starts_with(only)));
    scenes
        .map(|(number, scene)| {
            let seed = 39_000 + number as u64 + (snr_db * 1000.0) as u64 + N as u64 * 7 + u64::from(R::IQ);
            let rows = each::<R, N>(&plans, scene, seed, count, snr_db).map(|said| Row::of(&said));
            for (effort, Row { off, good_off, refused, refused_right, weak, rms, square, sigma }) in EFFORTS.iter().zip(&rows) {
                println!(
                    "{kind:4} {N:4} {snr_db:3} dB {:38} {:4}  off {off:5.1}  good off {good_off:5.1}  refused {refused:5.1}, right {refused_right:5.1}  weak {weak:5.1}  rms {rms:7.2}  z2 {square:8.2}  sigma {sigma:7.2}",
                    format!("{scene:?}"), effort.name()
                );
            }
            (scene, rows)
        })
        .collect()
}

/// A group's figures as `docs/effort.md` has them, at each effort: the means over its cells of the shares that are refused, that are refused
/// though right, and that are usable and off, and the median of sigma.
fn figures(rows: &[[Row; 3]]) -> Vec<f64> {
    let each = |of: fn(&Row) -> f64| {
        [0, 1, 2].map(|which| rows.iter().map(|rows| of(&rows[which])).collect::<Vec<f64>>())
    };
    let means = |of| each(of).map(|values| values.iter().sum::<f64>() / values.len() as f64);
    let sigma = each(|row| row.sigma).map(|mut values| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    });
    let refused = [means(|row| row.refused), means(|row| row.refused_right)].concat();
    [refused, means(|row| row.off).to_vec(), sigma.to_vec()].concat()
}

/// Blocks a cell of the short form.
const SHORT: u64 = 12;

/// What each group may cost, on 256 and 1,024 samples. `PICKET_LONG=1` takes 100 blocks a cell, and holds the table of `docs/effort.md` to them;
/// `PICKET_BLOCKS=1000` takes so many; with `PICKET_CLAIMS=jump` only that group is printed.
#[test]
fn the_campaign() {
    let only = std::env::var("PICKET_CLAIMS").ok();
    let blocks = std::env::var("PICKET_BLOCKS").ok().map(|text| text.parse().unwrap());
    let count = blocks.unwrap_or(sized(SHORT, 100));
    let only = only.as_deref();
    let mut all = Vec::new();
    for snr_db in [10.0, 30.0, 50.0] {
        all.extend(cells::<Real, 256>(snr_db, count, only));
        all.extend(cells::<Iq, 256>(snr_db, count, only));
        all.extend(cells::<Real, 1024>(snr_db, count, only));
        all.extend(cells::<Iq, 1024>(snr_db, count, only));
    }
    if only.is_some() {
        return;
    }
    let mut groups = BTreeMap::<&str, Vec<[Row; 3]>>::new();
    for (scene, rows) in &all {
        groups.entry(scene.group()).or_default().push(*rows);
    }
    for (group, rows) in groups {
        keep(group, &rows, count);
        if count == 100 {
            hold(&format!("effort, {group}"), 0.01, &figures(&rows));
        }
    }
}

/// A tone 60 dB below the noise is none. In white noise each effort finds as many as the next; in noise of another shape the joint fit
/// may find twice as many, see docs/effort.md.
#[test]
fn noise_alone_is_no_tone_at_full_effort() {
    fn found<R: Kind, const N: usize>(scene: Scene, count: u64) -> [usize; 2] {
        let plans = [Effort::One, Effort::Full].map(|effort| {
            let config = Config { effort, false_alarm: 1e-3, ..Config::new(1.0, CODES) };
            config.plan::<R, N>().unwrap()
        });
        let all = trials(39_500 + N as u64, count, |rng| {
            let taken = scene.record(rng, N, R::IQ, -60.0);
            // 350 codes of noise.
            let part = |parts: [f64; 2]| R::from_parts(parts.map(|x| quantise(x * 5e-4)));
            let samples: [R::Sample; N] = std::array::from_fn(|i| part(taken.samples[i]));
            plans.map(|plan| {
                let tone = Pipeline::<R, N>::new(plan).block(&Stamp::default(), &samples).tone;
                USABLE.contains(&tone.verdict)
            })
        });
        let found = [0, 1].map(|which| all.iter().filter(|usable| usable[which]).count());
        println!("{scene:?}, N {N}, {count} records: {found:?} at one and full effort");
        found
    }
    let few = 8.0;
    for scene in [Scene::Low, Scene::Colour(Colour::Filtered(0.5))] {
        for [one, full] in [found::<Real, 256>(scene, 4000), found::<Iq, 1024>(scene, 2000)] {
            assert!(full <= one + 1, "{scene:?}: {one} and {full}");
        }
    }
    for scene in [-10.0, 20.0].map(|db| Scene::Colour(Colour::Slope(db))) {
        for [one, full] in [found::<Real, 256>(scene, 4000), found::<Iq, 1024>(scene, 2000)] {
            assert!(full as f64 <= 2.0 * one as f64 + few, "{scene:?}: {one} and {full}");
        }
    }
}

/// What each group of scenes may cost at most at full effort, means over its cells: usable and off, refused though right, percent. A
/// single block cannot show everything: whatever bends the phase along a straight line is frequency, two lines a fraction of a bin
/// apart are one that changes, and a symmetric pair of sidebands is more lines than join the fit.
const LIMITS: [(&str, [f64; 2]); 4] = [
    ("fm", [0.5, 8.0]),
    ("jump", [4.5, 1.0]),
    ("two lines < 1 bin", [7.0, 1.0]),
    ("walk", [6.5, 1.0]),
];

/// What chance adds to a share in percent of so many records: three standard deviations, and a record.
fn chance(percent: f64, records: f64) -> f64 {
    3.0 * (percent * (100.0 - percent) / records).sqrt() + 100.0 / records
}

fn keep(group: &str, rows: &[[Row; 3]], blocks: u64) {
    let limit = LIMITS.iter().find(|(name, _)| group == *name);
    let [off, refused] = limit.map_or([0.5, 3.0], |(_, limits)| *limits);
    let records = rows.len() as f64 * blocks as f64;
    // The limits are those of 100 blocks a cell and more.
    let most = |percent| percent + if blocks < 100 { chance(percent, records) } else { 0.0 };
    let slack = if blocks < 100 { 100.0 / records } else { 0.0 };
    let mean = |effort: usize, of: fn(&Row) -> f64| {
        rows.iter().map(|rows| of(&rows[effort])).sum::<f64>() / rows.len() as f64
    };
    let [look, one, full] = [0, 1, 2]
        .map(|effort| (mean(effort, |row| row.off), mean(effort, |row| row.refused_right)));
    println!(
        "{group}: {records} records, usable and off, refused and right, %: {look:?} {one:?} {full:?}"
    );
    assert!(full.0 <= most(off) && full.1 <= most(refused), "{group}: {full:?}");
    // More effort makes no answer unusable that was usable, and hardly ever a wrong one usable.
    assert!(full.1 <= one.1 && full.0 <= one.0 + 0.1 + slack, "{group}: {one:?}, {full:?}");
    // Two steps end where all do, but for a fraction of a percent of bursts.
    assert!(
        look.0 <= one.0 + 0.5 + slack && one.1 <= look.1 + 1.0 + slack,
        "{group}: {look:?}, {one:?}"
    );
    if group == "clean" {
        assert!(rows.iter().all(|[.., full]| full.off == 0.0 && full.weak == 0.0));
        let (rms, square) = (mean(2, |row| row.rms), mean(2, |row| row.square));
        // Of so many squares of a normal number the mean is known to the root of two over the root of their number.
        let spread = if blocks < 100 { 3.0 * (2.0 / records).sqrt() } else { 0.0 };
        assert!((0.95 - spread / 2.0..1.05 + spread / 2.0).contains(&rms), "{rms}");
        assert!((0.85 - spread..1.15 + spread).contains(&square), "{square}");
    }
}
