//! What a frame's targets are beside those of the usual way, on the same records: the strongest cell of the windowed map, and a parabola
//! through it and its neighbours.

use super::Table;
use super::figures::{head, row};
use crate::report::SEED;
use picket_dsp::frame::{Cells, Frame, FramePlan};
use picket_dsp::tone::Usable;
use picket_dsp::{Iq, Pipeline, Plan};
use picket_host::scenario::cars::{CHIRPS, N, codes, config, scene};
use picket_host::scenario::{place, record};
use picket_simulator::Scene;
use picket_simulator::scene::{Noise, Source, Target};
use picket_transform::Transform;
use picket_transform::num_complex::Complex;
use rayon::prelude::*;
use std::f64::consts::TAU;

pub(super) const TABLES: &[Table] = &[Table::new("docs/signals.md", "peers", lines)];

/// Frames of each level.
const FRAMES: usize = 100;

/// Ratios of signal to noise per sample.
const LEVELS_DB: [f64; 5] = [-26.0, -20.0, -10.0, 0.0, 20.0];

/// A target is found where it is within so many cells in both directions.
const NEAR: f64 = 2.0;

/// One target anywhere in noise, before the radar of the scene `cars`.
fn one(snr_db: f64) -> Scene {
    let spread = (0.5 / 10f64.powf(0.1 * snr_db)).sqrt();
    // With four deviations of the noise beside it, it is within the codes.
    let amplitude = 2040.0 / (1.0 + 4.0 * spread);
    let mut scene = scene(SEED, snr_db);
    scene.sources = vec![Source::Target(Target {
        range_m: (10.0..100.0).into(),
        velocity_mps: (-16.0..16.0).into(),
        amplitude: Some(amplitude.into()),
        ..Target::default()
    })];
    scene.receiver.noise = Noise { rms: Some((amplitude * spread).into()), ..Noise::default() };
    scene
}

/// Range and velocity by the map's strongest cell, if noise alone is as strong in fewer than one frame of a million.
fn by_map(chirps: &[Vec<[i16; 2]>], plan: &FramePlan) -> Option<[f64; 2]> {
    let hann = |place: usize, length: usize| {
        0.5 - 0.5 * (TAU * (place as f64 + 0.5) / length as f64).cos()
    };
    let (along, across) = (f64::forward(N), f64::forward(CHIRPS));
    let mut map = vec![Complex::default(); N * CHIRPS];
    for (chirp, samples) in chirps.iter().enumerate() {
        let mut points: Vec<Complex<f64>> = samples
            .iter()
            .enumerate()
            .map(|(n, &[re, im])| Complex::new(re.into(), im.into()) * hann(n, N))
            .collect();
        along.process(&mut points);
        for (bin, point) in points.into_iter().enumerate() {
            map[bin * CHIRPS + chirp] = point * hann(chirp, CHIRPS);
        }
    }
    map.chunks_exact_mut(CHIRPS).for_each(|rows| across.process(rows));
    let power = |bin: usize, row: usize| map[bin * CHIRPS + row % CHIRPS].norm_sqr();
    let bins = 1..N / 2 - 1;
    let cells = || bins.clone().flat_map(|bin| (0..CHIRPS).map(move |row| (bin, row)));
    let (bin, row) = cells().max_by(|a, b| power(a.0, a.1).total_cmp(&power(b.0, b.1)))?;
    // The target has a few cells of thousands, so their median is the noise's: ln 2 of its mean.
    let mut powers: Vec<f64> = cells().map(|(bin, row)| power(bin, row)).collect();
    let count = powers.len();
    let (_, median, _) = powers.select_nth_unstable_by(count / 2, f64::total_cmp);
    if power(bin, row) < *median / 2f64.ln() * (count as f64 / 1e-6).ln() {
        return None;
    }
    let top = |before: f64, at: f64, after: f64| {
        let [before, at, after] = [before, at, after].map(f64::ln);
        0.5 * (before - after) / (before - 2.0 * at + after)
    };
    let beside = top(power(bin - 1, row), power(bin, row), power(bin + 1, row));
    let above = top(power(bin, row + CHIRPS - 1), power(bin, row), power(bin, row + 1));
    let turned = if row < CHIRPS / 2 { row as f64 } else { row as f64 - CHIRPS as f64 };
    Some(plan.cell((bin as f64 + beside) as f32, (turned + above) as f32).map(f64::from))
}

/// Range and velocity of the strongest target that may be used.
fn by_frame(chirps: &[Vec<[i16; 2]>], plan: FramePlan) -> Option<[f64; 2]> {
    let mut memory = vec![[0i16; 2]; plan.cells()];
    let mut frame = Frame::new(plan, Cells::Narrow(&mut memory))?;
    let mut pipeline = Box::new(Pipeline::<Iq, N>::new(Plan::tone(config().rate_hz, codes())));
    for samples in chirps {
        let clipped = pipeline.look(samples.as_array()?);
        frame.push(&pipeline.spectrum().view(), clipped);
    }
    let targets = frame.targets();
    let target = &targets.iter().find(|found| found.target.verdict.usable() == Usable::Yes)?.target;
    Some([target.range.to_num(), target.velocity?.to_num()])
}

/// Found of so many frames, and the rms errors of range and velocity.
fn seen(answers: &[(Option<[f64; 2]>, [f64; 2])], cell: [f64; 2]) -> [String; 3] {
    let errors: Vec<[f64; 2]> = answers
        .iter()
        .filter_map(|&(answer, truth)| answer.map(|it| [0, 1].map(|of| it[of] - truth[of])))
        .filter(|error| [0, 1].iter().all(|&of| error[of].abs() < NEAR * cell[of]))
        .collect();
    let rms = |of: usize| {
        (errors.iter().map(|error| error[of] * error[of]).sum::<f64>() / errors.len() as f64).sqrt()
    };
    let figure = |value: f64| if errors.is_empty() { "-".into() } else { format!("{value:.2}") };
    [
        format!("{:.0} %", 100.0 * errors.len() as f64 / answers.len() as f64),
        figure(1e3 * rms(0)),
        figure(1e3 * rms(1)),
    ]
}

fn lines(_: &Table) -> Result<Vec<String>, String> {
    let plan = config().plan().map_err(|error| error.to_string())?;
    let (origin, next) = (plan.cell(40.0, 0.0), plan.cell(41.0, 1.0));
    let cell = [0, 1].map(|of| f64::from(next[of] - origin[of]).abs());
    let mut rows = head(
        "| SNR per sample | map: found | range mm | velocity mm/s | Picket: found | range mm | velocity mm/s |",
    );
    for snr_db in LEVELS_DB {
        let scene = one(snr_db);
        let ends = [0, CHIRPS - 1].map(|chirp| scene.start_s(chirp, N));
        let middle_s = f64::midpoint(ends[0], ends[1]) + 0.5 * (N - 1) as f64 / config().rate_hz;
        let answers = (0..FRAMES).into_par_iter().map(|frame| {
            let mut run = scene.run(frame as u64).map_err(|error| error.to_string())?;
            let chirps: Vec<_> =
                (0..CHIRPS).map(|chirp| record::<Iq>(&mut run, chirp, N)).collect();
            let truth = place(&run.truth(0, middle_s, 1));
            Ok([(by_map(&chirps, &plan), truth), (by_frame(&chirps, plan), truth)])
        });
        let answers: Vec<[_; 2]> = answers.collect::<Result<_, String>>()?;
        let of = |method: usize| {
            seen(&answers.iter().map(|both| both[method]).collect::<Vec<_>>(), cell)
        };
        rows.push(row([format!("{snr_db:.0} dB")].into_iter().chain(of(0)).chain(of(1))));
    }
    Ok(rows)
}
