//! What is claimed of an answer, on records with one thing wrong: by today's verdict and by the model of what else is there.

mod records;

use crate::signal::{CODES, Kind, quantise, trials};
use picket::config::Config;
use picket::model::Effort;
use picket::model::block::{Seen, measure_near};
use picket::pipeline::Pipeline;
use picket::plan::{Plan, Terms};
use picket::spectrum::neighbourhood::{Neighbourhood, Places};
use picket::spectrum::peak;
use picket::{Iq, Real, Stamp, Verdict};
use records::Scene;
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

/// A tone's verdict in the words of both.
const USABLE: [Verdict; 2] = [Verdict::Good, Verdict::Moving];

/// Today's answer and the model's.
fn both<R: Kind, const N: usize>(
    plan: &Plan<R, N>,
    scene: Scene,
    seed: u64,
    count: u64,
    snr_db: f64,
) -> [Vec<Said>; 2] {
    let pairs = trials(seed, count, |rng| {
        let taken = scene.record(rng, N, R::IQ, snr_db);
        let samples: [R::Sample; N] =
            std::array::from_fn(|i| R::of_parts(taken.samples[i].map(quantise)));
        let mut pipeline = Pipeline::<R, N>::new(*plan);
        let tone = pipeline.block(Stamp::default(), &samples).tone;
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
        let today = Said {
            error: apart(tone.frequency.bins(N)),
            sigma: f64::from(tone.sigma) * N as f64,
            usable: USABLE.contains(&tone.verdict),
            good: tone.verdict == Verdict::Good,
            weak: matches!(tone.verdict, Verdict::Weak | Verdict::NoSignal),
            bound: taken.bound,
        };
        let terms: &Terms = plan;
        let peak = peak::find(pipeline.spectrum(), terms.band).unwrap();
        let mut places = Places::new();
        let near = Neighbourhood::read(pipeline.spectrum(), peak.bin, &mut places);
        let seen = measure_near::<R, N>(&near, terms.options.threshold, Effort::Full);
        let model = seen.map_or(Said { weak: true, usable: false, good: false, ..today }, |seen| {
            let Seen { answer, detected, .. } = seen;
            Said {
                error: apart(f64::from(peak.bin) + f64::from(answer.offset)),
                sigma: f64::from(answer.variance).sqrt(),
                usable: detected && !answer.unresolved,
                good: detected && !answer.unresolved && !answer.moves,
                weak: !detected,
                bound: taken.bound,
            }
        });
        [today, model]
    });
    [0, 1].map(|which| pairs.iter().map(|pair| pair[which]).collect())
}

/// A row of the table: shares in percent.
#[derive(Clone, Copy, Debug)]
struct Row {
    off: f64,
    good_off: f64,
    refused: f64,
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
            refused: share(&|said| !said.usable && said.error.abs() < 5.0 * said.bound),
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
) -> Vec<(Scene, [Row; 2])> {
    let plan = Config::new(1.0, CODES).plan::<R, N>().unwrap();
    let kind = if R::IQ { "I/Q" } else { "real" };
    let scenes = Scene::all(R::IQ).into_iter().enumerate();
    let scenes =
        scenes.filter(|(_, scene)| only.is_none_or(|only| scene.group().starts_with(only)));
    scenes
        .map(|(number, scene)| {
            let seed = 39_000 + number as u64 + (snr_db * 1000.0) as u64 + N as u64 * 7 + u64::from(R::IQ);
            let rows = both::<R, N>(&plan, scene, seed, count, snr_db).map(|said| Row::of(&said));
            let [a, b] = &rows;
            println!(
                "{kind:4} {N:4} {snr_db:3} dB {:38} off {:5.1}/{:5.1}  good off {:5.1}/{:5.1}  refused {:5.1}/{:5.1}  weak {:5.1}/{:5.1}  rms {:7.2}/{:7.2}  z2 {:8.2}/{:8.2}  sigma {:7.2}/{:7.2}",
                format!("{scene:?}"), a.off, b.off, a.good_off, b.good_off, a.refused, b.refused, a.weak, b.weak, a.rms, b.rms, a.square, b.square, a.sigma, b.sigma
            );
            (scene, rows)
        })
        .collect()
}

/// The table today / model, by groups.
fn table(cells: &[(Scene, [Row; 2])]) {
    let mut groups = BTreeMap::<&str, Vec<[Row; 2]>>::new();
    for (scene, rows) in cells {
        groups.entry(scene.group()).or_default().push(*rows);
    }
    println!("\ntoday / model: means over cells (worst cell)");
    println!(
        "| group | usable and off by > 5 sigma % | good and off % | refused though right % | weak % | rms over bound | sigma over bound |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (group, rows) in groups {
        let pair = |of: &dyn Fn(&Row) -> f64| {
            let mean = |which: usize| {
                rows.iter().map(|rows| of(&rows[which])).sum::<f64>() / rows.len() as f64
            };
            let worst = |which: usize| rows.iter().map(|rows| of(&rows[which])).fold(0.0, f64::max);
            format!("{:.2}/{:.2} ({:.1}/{:.1})", mean(0), mean(1), worst(0), worst(1))
        };
        println!(
            "| {group} | {} | {} | {} | {} | {} | {} |",
            pair(&|row| row.off),
            pair(&|row| row.good_off),
            pair(&|row| row.refused),
            pair(&|row| row.weak),
            pair(&|row| row.rms),
            pair(&|row| row.sigma)
        );
    }
}

/// The table of claims: `PICKET_LONG=1 cargo test -p host-tests claims:: -- --nocapture` prints it of 300 blocks a cell, with
/// `PICKET_CLAIMS=jump` a group of it, with `PICKET_BLOCKS=1000` of so many blocks. The short form has 40, of 256 and 1024 samples.
#[test]
fn the_campaign() {
    let long = std::env::var("PICKET_LONG").is_ok();
    let only = std::env::var("PICKET_CLAIMS").ok();
    let count = std::env::var("PICKET_BLOCKS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(if long { 300 } else { 40 });
    let only = only.as_deref();
    let mut all = Vec::new();
    for snr_db in [10.0, 30.0, 50.0] {
        all.extend(cells::<Real, 256>(snr_db, count, only));
        all.extend(cells::<Iq, 256>(snr_db, count, only));
        all.extend(cells::<Real, 1024>(snr_db, count, only));
        all.extend(cells::<Iq, 1024>(snr_db, count, only));
        if long {
            all.extend(cells::<Real, 4096>(snr_db, count, only));
            all.extend(cells::<Iq, 4096>(snr_db, count, only));
        }
    }
    table(&all);
    if only.is_none() {
        hold(&all);
    }
}

/// The share of blocks of noise alone in which a tone is detected where a hundredth is asked: today's tests, and the model's one.
fn alarms<R: Kind, const N: usize>(count: u64) -> [f64; 2] {
    let config = Config { false_alarm: 1e-2, ..Config::new(1.0, CODES) };
    let plan = config.plan::<R, N>().unwrap();
    let seen = trials(39_500 + N as u64, count, |rng| {
        let samples: [R::Sample; N] = R::record::<N>(rng, &[], 30.0);
        let mut pipeline = Pipeline::<R, N>::new(plan);
        let tone = pipeline.block(Stamp::default(), &samples).tone;
        let terms: &Terms = &plan;
        let peak = peak::find(pipeline.spectrum(), terms.band).unwrap();
        let mut places = Places::new();
        let near = Neighbourhood::read(pipeline.spectrum(), peak.bin, &mut places);
        let seen = measure_near::<R, N>(&near, terms.options.threshold, Effort::Full);
        [
            !matches!(tone.verdict, Verdict::Weak | Verdict::NoSignal),
            seen.is_some_and(|seen| seen.detected),
        ]
    });
    let share =
        |which: usize| seen.iter().filter(|detected| detected[which]).count() as f64 / count as f64;
    [share(0), share(1)]
}

#[test]
fn noise_passes_for_a_tone_no_more_often_than_asked() {
    let count = if std::env::var("PICKET_LONG").is_ok() { 40_000 } else { 3_000 };
    let (mut worst, mut least) = (0.0_f64, f64::INFINITY);
    for (kind, shares) in [
        ("real, 256", alarms::<Real, 256>(count)),
        ("I/Q, 256", alarms::<Iq, 256>(count)),
        ("real, 1024", alarms::<Real, 1024>(count)),
        ("I/Q, 1024", alarms::<Iq, 1024>(count)),
    ] {
        let [today, model] = shares.map(|share| 100.0 * share);
        println!("noise alone, {kind}: 1 % asked, today {today:.2} %, model {model:.2} %");
        worst = worst.max(model);
        least = least.min(model);
    }
    // The louder of the noise here and of the ring's louder side makes the one test stricter than asked: 0.40 to 0.76 % of 40,000 blocks.
    assert!(worst < 1.2 && least > 0.2, "{least} {worst}");
}

/// What each group of scenes may cost at most, means over its cells: usable and off, refused though right, percent. A single block
/// cannot show everything: whatever bends the phase along a straight line is frequency, and two lines a fraction of a bin apart are
/// one that changes.
const LIMITS: [(&str, [f64; 2]); 7] = [
    ("burst anywhere", [0.5, 11.0]),
    ("burst in the middle", [0.5, 6.0]),
    ("chirp", [0.5, 7.0]),
    ("fm", [0.5, 25.0]),
    ("jump", [4.0, 3.0]),
    ("two lines <", [8.0, 3.0]),
    ("walk", [6.0, 3.0]),
];

fn hold(cells: &[(Scene, [Row; 2])]) {
    let mut groups = BTreeMap::<&str, Vec<Row>>::new();
    for (scene, [_, model]) in cells {
        groups.entry(scene.group()).or_default().push(*model);
    }
    for (group, rows) in groups {
        let limit = LIMITS.iter().find(|(name, _)| group.starts_with(name));
        let [off, refused] = limit.map_or([1.0, 3.0], |(_, limits)| *limits);
        let mean = |of: &dyn Fn(&Row) -> f64| rows.iter().map(of).sum::<f64>() / rows.len() as f64;
        let said = [mean(&|row| row.off), mean(&|row| row.refused)];
        assert!(said[0] <= off && said[1] <= refused, "{group}: {said:?}");
        if group == "clean" {
            assert!(rows.iter().all(|row| row.off == 0.0 && row.weak == 0.0));
            let (rms, square) = (mean(&|row| row.rms), mean(&|row| row.square));
            assert!((0.95..1.05).contains(&rms) && (0.85..1.15).contains(&square));
        }
    }
}
