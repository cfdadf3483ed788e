//! A fan in front of a radar: its body's speed by the emulated firmware, and the sidebands of its blades in the records.

use super::answer::lines;
use super::measure::{N, play};
use super::options::Options;
use super::{DemoError, said, shown};
use crate::emulator::Capture;
use crate::output::Output;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::progress;
use crate::scenario::{self, fan};
use crate::simulate::generator;
use picket_dsp::pipeline::Outcome;
use picket_dsp::{Iq, Usable, Verdict};
use picket_transform::Transform;
use picket_transform::num_complex::Complex;
use picket_wire::capture::Header;
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;
use std::process::ExitCode;

/// Nearer than this many bins to the body's line its own window hides the sidebands.
const HIDDEN_BINS: f64 = 4.0;

/// One record. The keys are those of the JSON lines.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The body's speed, positive when approaching.
    pub truth_mps: f64,
    /// What the firmware measured.
    pub velocity_mps: f64,
    /// One standard deviation.
    pub sigma_mps: f64,
    /// Whether it may be used.
    pub verdict: &'static str,
    /// What that allows.
    #[serde(skip)]
    pub usable: bool,
    /// The power of the sidebands above the body's line, over that of the line.
    pub above_db: f64,
    /// Below it.
    pub below_db: f64,
    /// The level of each bin over the body's line, dB, from the most negative frequency on.
    #[serde(skip)]
    pub levels_db: Vec<f64>,
}

/// All records.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Always true: it tells this line from the others.
    pub summary: bool,
    /// Records.
    pub rows: usize,
    /// Records whose speed is within 5 sigma of the body's.
    pub within: usize,
    /// Records that may be used within sigma, and whose speed is not within 5 sigma.
    pub lies: usize,
    /// How often each verdict was given.
    pub verdicts: BTreeMap<&'static str, usize>,
    /// Root mean square of the error.
    pub rms_mps: f64,
    /// The bound of a lone tone.
    pub bound_mps: f64,
    /// Root mean square of error over sigma.
    pub sigmas: f64,
    /// The power of the sidebands over the line, above it and below it.
    pub above_db: f64,
    /// See above.
    pub below_db: f64,
}

fn decibels(power: f64) -> f64 {
    10.0 * power.log10()
}

impl Row {
    fn error(&self) -> f64 {
        self.velocity_mps - self.truth_mps
    }

    fn is_within(&self) -> bool {
        self.error().abs() <= 5.0 * self.sigma_mps
    }
}

impl Summary {
    /// Of all records.
    pub fn of(rows: &[Row], snr_db: f64) -> Self {
        let mean = |of: fn(&Row) -> f64| rows.iter().map(of).sum::<f64>() / rows.len() as f64;
        let mut verdicts = BTreeMap::new();
        rows.iter().for_each(|row| *verdicts.entry(row.verdict).or_default() += 1);
        let n = N as f64;
        let bound_bins = (6.0 / (TAU * TAU * n * 10f64.powf(snr_db / 10.0))).sqrt();
        Summary {
            summary: true,
            rows: rows.len(),
            within: rows.iter().filter(|row| row.is_within()).count(),
            lies: rows.iter().filter(|row| row.usable && !row.is_within()).count(),
            verdicts,
            rms_mps: mean(|row| row.error().powi(2)).sqrt(),
            bound_mps: bound_bins * mps_per_bin(),
            sigmas: mean(|row| (row.error() / row.sigma_mps).powi(2)).sqrt(),
            above_db: decibels(mean(|row| 10f64.powf(row.above_db / 10.0))),
            below_db: decibels(mean(|row| 10f64.powf(row.below_db / 10.0))),
        }
    }

    /// Whether every speed is the body's, by its sigma.
    pub fn inside(&self) -> bool {
        self.within == self.rows
    }
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

/// The records of a seed, each with its body's speed.
fn records(seed: u64, snr_db: f64) -> Vec<(f64, Vec<[i16; 2]>)> {
    let radar = fan::radar(N, snr_db);
    let record = |(row, trial): (scenario::Row, u64)| {
        (row.velocity_mps, fan::samples(&radar, &row, &mut generator(seed, trial)))
    };
    fan::rows().into_iter().zip(0..).map(record).collect()
}

/// Measures every record by the emulated firmware.
pub fn measured(options: &Options) -> Result<Vec<Row>, DemoError> {
    let mut config = fan::config();
    config.method = options.method.unwrap_or(config.method);
    config.plan::<Iq, N>().map_err(said)?;
    let records = records(options.seed, options.snr_db());
    let header = Header::from_config::<Iq>(config, N as u32, records.len() as u32);
    let mut capture = Capture::create(&header).map_err(said)?;
    for (_, samples) in &records {
        capture.push::<Iq>(samples).map_err(said)?;
    }
    let bar = progress::bar(records.len() as u64, "blocks");
    let mut rows = Vec::new();
    play(capture, options, |record| {
        bar.inc(1);
        let measurement = record.measurement;
        let Some((truth_mps, samples)) = records.get(measurement.stamp.sequence as usize) else {
            return;
        };
        let Outcome::Velocity(velocity) = measurement.result else { return };
        let (levels_db, [above_db, below_db]) = sidebands(samples, *truth_mps);
        rows.push(Row {
            truth_mps: *truth_mps,
            velocity_mps: velocity.velocity.to_num(),
            sigma_mps: velocity.sigma.into(),
            verdict: velocity.verdict.name(),
            usable: velocity.verdict.usable() <= Usable::WithinSigma,
            above_db,
            below_db,
            levels_db,
        });
    })
    .map_err(said)?;
    bar.finish_and_clear();
    match rows.len() == records.len() {
        true => Ok(rows),
        false => Err(said(format!("{} of {} records were answered", rows.len(), records.len()))),
    }
}

/// Measures, prints and draws. Failure: a speed is not the body's by its sigma.
pub fn run(options: &Options) -> Result<ExitCode, DemoError> {
    let rows = measured(options)?;
    let summary = Summary::of(&rows, options.snr_db());
    let draw = |file: &Path| draw(&rows, file, options.output);
    let print = || print(&rows, &summary, options);
    shown(options, draw, || lines(&rows, &summary), print, summary.inside())
}

fn print(rows: &[Row], summary: &Summary, options: &Options) {
    outln!(
        "A fan before a 24 GHz radar: three blades of 15 cm, 20 turns a second, I/Q, 12 bits at 20 kS/s, N = {N}, {} dB, seed {}\n",
        options.snr_db(),
        options.seed
    );
    outln!(
        "{:>9} {:>13} {:>8} {:>9} {:>9}  verdict",
        "true m/s",
        "measured m/s",
        "+-",
        "above dB",
        "below dB"
    );
    for row in rows {
        outln!(
            "{:>+9.3} {:>+13.5} {:>8.5} {:>9.1} {:>9.1}  {}",
            row.truth_mps,
            row.velocity_mps,
            row.sigma_mps,
            row.above_db,
            row.below_db,
            row.verdict
        );
    }
    let said: Vec<String> = [Verdict::Good.name()]
        .into_iter()
        .chain(summary.verdicts.keys().copied().filter(|name| *name != Verdict::Good.name()))
        .map(|name| format!("{} {name}", summary.verdicts.get(name).unwrap_or(&0)))
        .collect();
    outln!(
        "\n{} of {} speeds are the body's within 5 sigma; {}\n  \
         velocity   rms {:.2} mm/s (the bound of a lone tone: {:.2} mm/s), error over sigma {:.2} (rms)\n  \
         sidebands  {:.1} dB above the body's line, {:.1} dB below it",
        summary.within,
        summary.rows,
        said.join(", "),
        1e3 * summary.rms_mps,
        1e3 * summary.bound_mps,
        summary.sigmas,
        summary.above_db,
        summary.below_db
    );
}

/// The spectrum of the record with the body at 2 m/s.
fn draw(rows: &[Row], file: &Path, output: Output) -> Result<(), DemoError> {
    let shown = rows.iter().find(|row| row.truth_mps == 2.0);
    let Some(row) = shown else { return Err(said("no record of 2 m/s")) };
    let hertz = |k: usize| (k as f64 / N as f64 - 0.5) * fan::RATE_HZ;
    let levels = row.levels_db.iter().enumerate().map(|(k, level)| (hertz(k), *level));
    let body_hz = row.truth_mps / mps_per_bin() * fan::RATE_HZ / N as f64;
    let tips = [-1.0, 1.0].map(|side| body_hz + side * fan::reach_hz());
    let upright = |at: f64| [(at, -80.0), (at, 5.0)];
    let chart = Chart {
        name: "fan",
        title: format!("A fan at 2 m/s before a 24 GHz radar: {}", row.verdict),
        x: Axis::linear("frequency, Hz", -5000.0, 5000.0),
        y: Axis::linear("level over the body's line, dB", -80.0, 5.0),
        series: vec![
            Series::new("the body", Style::Dashed, 1, upright(body_hz)),
            Series::new("tips that recede", Style::Dashed, 2, upright(tips[0])),
            Series::new("tips that approach", Style::Dashed, 2, upright(tips[1])),
            Series::new("record", Style::Line, 0, levels),
        ],
    };
    chart.save(file, output).map_err(said)
}
