//! A plate that swings by micrometres in front of a radar: truth, measurement and bound side by side.

use super::feed::{N, records};
use super::options::Options;
use super::shown::{Shown, keys, lines, named, table};
use super::{DemoError, said};
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::scenario::vibration::{self as plate, SWING_HZ, SWING_M};
use picket_dsp::solve::chirp::Mixing;
use picket_dsp::solve::displacement::{Between, Unwrapper};
use picket_dsp::{Pipeline, Real, Verdict};
use serde::Serialize;
use std::f64::consts::TAU;

/// The plate turns the phase by less than this share of a turn from ramp to ramp.
const MOST_TURNS: f32 = 0.1;

/// How far amplitude and noise may be from what they should be: a twentieth, and a tenth.
const AMPLITUDE_BAR: f64 = 0.05;
const NOISE_BAR: f64 = 1.1;

/// What the picture shows: three swings.
const SHOWN_S: f64 = 0.6;

/// One ramp. The keys are those of the JSON lines.
#[derive(Serialize)]
struct Row {
    /// When, in the middle of the ramp.
    time_s: f64,
    /// Where the plate is, from its place in the first ramp.
    truth_um: f64,
    /// Where the phase puts it.
    measured_um: f64,
    sigma_um: f64,
    #[serde(serialize_with = "named")]
    verdict: Verdict,
}

/// Each ramp.
fn rows(seed: u64, snr_db: f64) -> Result<Vec<Row>, DemoError> {
    let config = plate::config();
    let mut pipeline = Box::new(Pipeline::<Real, N>::new(config.plan().map_err(said)?));
    let unwrapper =
        Unwrapper::new(plate::wavelength_m(), Mixing::TxConjRx, Between::Turns(MOST_TURNS));
    let mut unwrapper = unwrapper.ok_or_else(|| said("no scale"))?;
    let scene = plate::scene(seed, N, snr_db);
    let run = scene.run(0).map_err(said)?;
    let range_m = |row: usize| run.truth_of_lap(0, row, N).range_m.unwrap_or(f64::NAN);
    let row = |(stamp, samples)| {
        let measurement = pipeline.block(&stamp, &samples);
        let phasors = pipeline.lines(&measurement, 1);
        let moved =
            phasors.first().map(|phasor| unwrapper.push(&stamp, phasor)).unwrap_or_default();
        let row = stamp.sequence as usize;
        Row {
            time_s: run.truth_of_lap(0, row, N).time_s,
            truth_um: 1e6 * (range_m(row) - range_m(0)),
            measured_um: 1e6 * moved.metres.to_num::<f64>(),
            sigma_um: 1e6 * f64::from(moved.sigma),
            verdict: moved.verdict,
        }
    };
    Ok(records::<Real>(&scene, &config)?.map(row).collect())
}

/// Right: all ramps are good, and amplitude and noise are as they should be.
pub(super) fn measured(options: &Options) -> Result<Shown, DemoError> {
    let rows = rows(options.seed, options.snr_db())?;
    // The swing: sine, cosine and a constant, which are orthogonal over whole swings.
    let count = rows.len() as f64;
    let turn = |row: &Row| (TAU * SWING_HZ * row.time_s).sin_cos();
    let mean = |of: &dyn Fn(&Row) -> f64| rows.iter().map(of).sum::<f64>() / count;
    let middle = mean(&|row| row.measured_um);
    let sine = mean(&|row| 2.0 * turn(row).0 * row.measured_um);
    let cosine = mean(&|row| 2.0 * turn(row).1 * row.measured_um);
    let square = mean(&|row| {
        let (sin, cos) = turn(row);
        (row.measured_um - middle - sine * sin - cosine * cos).powi(2)
    });
    let noise_um = (square * count / (count - 3.0)).sqrt();
    let (amplitude_um, sigma_amplitude_um) = (sine.hypot(cosine), noise_um * (2.0 / count).sqrt());
    let bound_um = 1e6 * plate::bound_m(N, options.snr_db());
    let (ramps, true_um) = (rows.len(), 1e6 * SWING_M);
    let good = rows.iter().filter(|row| row.verdict == Verdict::Good).count();
    let all =
        keys! { summary: true, ramps, good, amplitude_um, sigma_amplitude_um, noise_um, bound_um };
    let text = format!(
        "{good} of {ramps} ramps good\n  \
         swing  {amplitude_um:.3} ± {sigma_amplitude_um:.3} um at {SWING_HZ} Hz (true: {true_um} um)\n  \
         noise  {noise_um:.3} um rms in a ramp (the bound: {bound_um:.3} um)\n"
    );
    // Whole or half swings between the rows would show no swing.
    let table = table(
        rows.iter().step_by(17),
        "time s: time_s .3 | true um: truth_um .3 | measured um: measured_um .3 | +-: sigma_um .3 | verdict: verdict",
        |_| false,
    );
    // The first swings, with a band of one sigma, and the bound.
    let shown: Vec<&Row> = rows.iter().filter(|row| row.time_s <= SHOWN_S).collect();
    let most = shown.iter().map(|row| row.measured_um.abs()).fold(1.4 * true_um, f64::max);
    let truth = |by: f64| shown.iter().map(move |row| (row.time_s, row.truth_um + by));
    let measured = shown.iter().map(|row| (row.time_s, row.measured_um));
    let measured = Series::new("measured ± sigma", Style::Points, 0, measured);
    let chart = Chart {
        name: "vibration",
        title: format!(
            "A plate at 30 cm, 122 GHz: {amplitude_um:.2} um at 5 Hz, noise {noise_um:.2} um, bound {bound_um:.2} um"
        ),
        x: Axis::linear("time, s", 0.0, SHOWN_S),
        y: Axis::linear("displacement, um", -1.1 * most, 1.1 * most),
        series: vec![
            measured.with_errors(shown.iter().map(|row| row.sigma_um)),
            Series::new("truth", Style::Line, 1, truth(0.0)),
            Series::new("truth + bound", Style::Dashed, 2, truth(bound_um)),
            Series::new("truth - bound", Style::Dashed, 2, truth(-bound_um)),
        ],
    };
    Ok(Shown {
        heading: format!(
            "A plate at {} m before a 122 GHz radar: 6 GHz in 1.024 ms, 12 bits at 1 MS/s, N = {N} per ramp, 200 ramps a second, {} dB, \
             seed {}",
            plate::RANGE_M,
            options.snr_db(),
            options.seed
        ),
        table,
        text,
        lines: lines(&rows, &all)?,
        charts: vec![chart],
        right: good == ramps
            && (amplitude_um / true_um - 1.0).abs() < AMPLITUDE_BAR
            && noise_um < NOISE_BAR * bound_um,
    })
}
