//! A fan in front of a radar: its body's speed by the emulated firmware, and the sidebands of its blades in the records.

use super::feed::{N, play};
use super::options::Options;
use super::shown::{Shown, Speed, is_usable, keys, lines, rms, table};
use super::{DemoError, said};
use crate::device::Said;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::scenario::{fan, record};
use picket_dsp::pipeline::Outcome;
use picket_dsp::{Iq, Verdict};
use picket_transform::Transform;
use picket_transform::num_complex::Complex;
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Nearer than this many bins to the body's line its own window hides the sidebands.
const HIDDEN_BINS: f64 = 4.0;
/// The body's speed in the record that is drawn, m/s.
const DRAWN_MPS: f64 = 2.0;

/// One record. The keys are those of the JSON lines.
#[derive(Serialize)]
struct Row {
    /// The body's speed, positive when approaching, and what the firmware measured.
    #[serde(flatten)]
    speed: Speed,
    /// The power of the sidebands above the body's line, over that of the line; and below it.
    above_db: f64,
    below_db: f64,
    /// The level of each bin over the body's line, dB, from the most negative frequency on.
    #[serde(skip)]
    levels_db: Vec<f64>,
}

fn decibels(power: f64) -> f64 {
    10.0 * power.log10()
}

/// Metres per second in a bin.
fn mps_per_bin() -> f64 {
    let picket_dsp::Scene::Doppler { wavelength_m, .. } = fan::config().scene else {
        return f64::NAN;
    };
    fan::RATE_HZ / N as f64 * wavelength_m / 2.0
}

/// The level of each bin of a record over the body's line, through Hann's window, and the power of the sidebands above and below it.
fn sidebands(samples: &[[i16; 2]], velocity_mps: f64) -> (Vec<f64>, [f64; 2]) {
    let window = |n: usize| 1.0 - (TAU * n as f64 / N as f64).cos();
    let mut spectrum: Vec<Complex<f64>> = samples
        .iter()
        .enumerate()
        .map(|(n, [i, q])| Complex::new(f64::from(*i), f64::from(*q)) * window(n))
        .collect();
    f64::forward(N).process(&mut spectrum);
    let powers: Vec<f64> = (0..N).map(|k| spectrum[(k + N / 2) % N].norm_sqr()).collect();
    let body = velocity_mps / mps_per_bin() + (N / 2) as f64;
    let reach = fan::reach_hz() * N as f64 / fan::RATE_HZ;
    let sum = |from: f64, to: f64| -> f64 {
        let inside = powers.iter().enumerate().filter(|(k, _)| (from..=to).contains(&(*k as f64)));
        inside.map(|(_, power)| power).sum()
    };
    let line = sum(body - HIDDEN_BINS, body + HIDDEN_BINS);
    let sides = [sum(body + HIDDEN_BINS, body + reach), sum(body - reach, body - HIDDEN_BINS)];
    let levels = powers.iter().map(|power| decibels(power / line)).collect();
    (levels, sides.map(|side| decibels(side / line)))
}

/// Every record by the emulated firmware.
fn rows(options: &Options) -> Result<Vec<Row>, DemoError> {
    let mut config = fan::config();
    config.method = options.method.unwrap_or(config.method);
    config.plan::<Iq, N>().map_err(said)?;
    let (truths, mut blocks) = (fan::rows(), Vec::new());
    for (truth, trial) in truths.iter().zip(0..) {
        let scene = fan::scene(options.seed, N, truth, options.snr_db());
        blocks.push(record::<Iq>(&mut scene.run(trial).map_err(said)?, 0, N));
    }
    let mut rows = Vec::new();
    let played = blocks.iter().cloned().map(Ok).collect::<Vec<_>>().into_iter();
    play::<Iq>("frontend_qemu", (config, N), played, options, |_, said| {
        let Said::Telemetry(record) = said else { return };
        let sequence = record.measurement.stamp.sequence as usize;
        let (Some(truth), Some(samples)) = (truths.get(sequence), blocks.get(sequence)) else {
            return;
        };
        let Outcome::Velocity(velocity) = record.measurement.result else { return };
        let (levels_db, [above_db, below_db]) = sidebands(samples, truth.velocity_mps);
        rows.push(Row {
            speed: Speed {
                truth_mps: truth.velocity_mps,
                velocity_mps: velocity.velocity.to_num(),
                sigma_mps: velocity.sigma.into(),
                verdict: velocity.verdict,
            },
            above_db,
            below_db,
            levels_db,
        });
    })?;
    match rows.len() == blocks.len() {
        true => Ok(rows),
        false => Err(said(format!("{} of {} records were answered", rows.len(), blocks.len()))),
    }
}

/// Right: every speed is the body's, by its sigma.
pub(super) fn measured(options: &Options) -> Result<Shown, DemoError> {
    let all_rows = rows(options)?;
    let (rows, count) = (&all_rows, all_rows.len());
    let power = |of: fn(&Row) -> f64| {
        decibels(rows.iter().map(|row| 10f64.powf(of(row) / 10.0)).sum::<f64>() / count as f64)
    };
    let mut verdicts = BTreeMap::new();
    rows.iter().for_each(|row| *verdicts.entry(row.speed.verdict.name()).or_insert(0) += 1);
    let within = rows.iter().filter(|row| row.speed.is_within()).count();
    let lies =
        rows.iter().filter(|row| is_usable(row.speed.verdict) && !row.speed.is_within()).count();
    let in_record = N as f64 * 10f64.powf(options.snr_db() / 10.0);
    let bound_mps = (6.0 / (TAU * TAU * in_record)).sqrt() * mps_per_bin();
    let rms_mps = rms(rows.iter().map(|row| row.speed.error()));
    let sigmas = rms(rows.iter().map(|row| row.speed.sigmas()));
    let (above_db, below_db) = (power(|row| row.above_db), power(|row| row.below_db));
    let all = keys! {
        summary: true, rows: count, within, lies, verdicts: &verdicts, rms_mps, bound_mps, sigmas, above_db, below_db,
    };
    let good = Verdict::Good.name();
    let names = verdicts.keys().copied().filter(|name| *name != good);
    let names = std::iter::once(good).chain(names);
    let said: Vec<String> =
        names.map(|name| format!("{} {name}", verdicts.get(name).unwrap_or(&0))).collect();
    let text = format!(
        "{within} of {count} speeds are the body's within 5 sigma; {}\n  \
         velocity   rms {:.2} mm/s (the bound of a lone tone: {:.2} mm/s), error over sigma {sigmas:.2} (rms)\n  \
         sidebands  {above_db:.1} dB above the body's line, {below_db:.1} dB below it\n",
        said.join(", "),
        1e3 * rms_mps,
        1e3 * bound_mps
    );
    let table = table(
        rows,
        "true m/s: truth_mps +.3 | measured m/s: velocity_mps +.5 | +-: sigma_mps .5 | above dB: above_db .1 | below dB: below_db .1 | \
         verdict: verdict",
        |row| !row.speed.is_within(),
    );
    Ok(Shown {
        heading: format!(
            "A fan before a 24 GHz radar: three blades of 15 cm, 20 turns a second, I/Q, 12 bits at 20 kS/s, N = {N}, {} dB, seed {}",
            options.snr_db(),
            options.seed
        ),
        table,
        text,
        lines: lines(rows, &all)?,
        charts: rows.iter().filter(|row| row.speed.truth_mps == DRAWN_MPS).map(chart).collect(),
        right: within == count,
    })
}

/// The spectrum of a record.
fn chart(row: &Row) -> Chart {
    let hertz = |k: usize| (k as f64 / N as f64 - 0.5) * fan::RATE_HZ;
    let levels = row.levels_db.iter().enumerate().map(|(k, level)| (hertz(k), *level));
    let body_hz = row.speed.truth_mps / mps_per_bin() * fan::RATE_HZ / N as f64;
    let upright = |label, colour, at: f64| {
        Series::new(label, Style::Dashed, colour, [(at, -80.0), (at, 5.0)])
    };
    Chart {
        name: "fan",
        title: format!(
            "A fan at {DRAWN_MPS} m/s before a 24 GHz radar: {}",
            row.speed.verdict.name()
        ),
        x: Axis::linear("frequency, Hz", -5000.0, 5000.0),
        y: Axis::linear("level over the body's line, dB", -80.0, 5.0),
        series: vec![
            upright("the body", 1, body_hz),
            upright("tips that recede", 2, body_hz - fan::reach_hz()),
            upright("tips that approach", 2, body_hz + fan::reach_hz()),
            Series::new("record", Style::Line, 0, levels),
        ],
    }
}
