//! A plate that swings by micrometres in front of a radar: truth, measurement and bound side by side.

use super::answer::lines;
use super::measure::N;
use super::options::Options;
use super::{DemoError, said, shown};
use crate::output::Output;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::scenario::vibration::{self as plate, CYCLES, SWING_HZ, SWING_M};
use crate::simulate::generator;
use picket_dsp::solve::chirp::Mixing;
use picket_dsp::solve::displacement::{Between, Unwrapper};
use picket_dsp::tone::Verdict;
use picket_dsp::{Pipeline, Real, Segment, Stamp};
use serde::Serialize;
use std::f64::consts::TAU;
use std::path::Path;
use std::process::ExitCode;

/// The plate turns the phase by less than this share of a turn from ramp to ramp.
const MOST_TURNS: f32 = 0.1;

/// How far amplitude and noise may be from what they should be: a twentieth, and a tenth.
const AMPLITUDE_BAR: f64 = 0.05;
const NOISE_BAR: f64 = 1.1;

/// One ramp. The keys are those of the JSON lines.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// When, in the middle of the ramp.
    pub time_s: f64,
    /// Where the plate is, from its place in the first ramp.
    pub truth_um: f64,
    /// Where the phase puts it.
    pub measured_um: f64,
    /// One standard deviation.
    pub sigma_um: f64,
    /// Whether it may be used.
    pub verdict: &'static str,
}

/// The swing as a whole.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Always true: it tells this line from the others.
    pub summary: bool,
    /// Ramps.
    pub ramps: usize,
    /// Ramps with the verdict good.
    pub good: usize,
    /// The amplitude of the swing, by least squares, and its standard deviation.
    pub amplitude_um: f64,
    /// One standard deviation of it.
    pub sigma_amplitude_um: f64,
    /// The root mean square of what the swing leaves.
    pub noise_um: f64,
    /// The bound of one ramp.
    pub bound_um: f64,
}

impl Summary {
    /// Whether the swing is as it should be.
    pub fn inside(&self) -> bool {
        let swing = 1e6 * SWING_M;
        self.good == self.ramps
            && (self.amplitude_um / swing - 1.0).abs() < AMPLITUDE_BAR
            && self.noise_um < NOISE_BAR * self.bound_um
    }
}

/// Measures every ramp.
pub fn measured(options: &Options) -> Result<Vec<Row>, DemoError> {
    let mut pipeline = Box::new(Pipeline::<Real, N>::new(plate::config().plan().map_err(said)?));
    let unwrapper =
        Unwrapper::new(plate::wavelength_m(), Mixing::TxConjRx, Between::Turns(MOST_TURNS));
    let mut unwrapper = unwrapper.ok_or_else(|| said("no scale"))?;
    let radar = plate::radar(N, options.snr_db());
    let origin = plate::swing_m(plate::middle_s(&radar, 0));
    let rows = (0..CYCLES).map(|cycle| {
        let rng = &mut generator(options.seed, cycle as u64);
        let mut samples = [0; N];
        samples.copy_from_slice(&plate::samples(&radar, cycle, rng));
        let stamp = Stamp { sequence: cycle as u32, segment: Segment::Up, ..Stamp::default() };
        let measurement = pipeline.block(&stamp, &samples);
        let phasors = pipeline.lines(&measurement, 1);
        let moved =
            phasors.first().map(|phasor| unwrapper.push(&stamp, phasor)).unwrap_or_default();
        let time_s = plate::middle_s(&radar, cycle);
        Row {
            time_s,
            truth_um: 1e6 * (plate::swing_m(time_s) - origin),
            measured_um: 1e6 * moved.metres.to_num::<f64>(),
            sigma_um: 1e6 * f64::from(moved.sigma),
            verdict: moved.verdict.name(),
        }
    });
    Ok(rows.collect())
}

/// Fits the swing: sine, cosine and a constant, which are orthogonal over whole swings.
pub fn summed(rows: &[Row], snr_db: f64) -> Summary {
    let count = rows.len() as f64;
    let turn = |row: &Row| (TAU * SWING_HZ * row.time_s).sin_cos();
    let mean = rows.iter().map(|row| row.measured_um).sum::<f64>() / count;
    let sine = rows.iter().map(|row| 2.0 * turn(row).0 * row.measured_um).sum::<f64>() / count;
    let cosine = rows.iter().map(|row| 2.0 * turn(row).1 * row.measured_um).sum::<f64>() / count;
    let left = |row: &Row| {
        let (sin, cos) = turn(row);
        row.measured_um - mean - sine * sin - cosine * cos
    };
    let squares: f64 = rows.iter().map(|row| left(row).powi(2)).sum();
    let noise_um = (squares / (count - 3.0)).sqrt();
    Summary {
        summary: true,
        ramps: rows.len(),
        good: rows.iter().filter(|row| row.verdict == Verdict::Good.name()).count(),
        amplitude_um: sine.hypot(cosine),
        sigma_amplitude_um: noise_um * (2.0 / count).sqrt(),
        noise_um,
        bound_um: 1e6 * plate::bound_m(&plate::radar(N, snr_db)),
    }
}

/// Measures, prints and draws. Failure: amplitude or noise are not as they should be.
pub fn run(options: &Options) -> Result<ExitCode, DemoError> {
    let rows = measured(options)?;
    let summary = summed(&rows, options.snr_db());
    let draw = |file: &Path| draw(&rows, &summary, file, options.output);
    let print = || print(&rows, &summary, options);
    shown(options, draw, || lines(&rows, &summary), print, summary.inside())
}

fn print(rows: &[Row], summary: &Summary, options: &Options) {
    outln!(
        "A plate at {} m before a 122 GHz radar: 6 GHz in 1.024 ms, 12 bits at 1 MS/s, N = {N} per ramp, 200 ramps a second, {} dB, \
         seed {}\n",
        plate::RANGE_M,
        options.snr_db(),
        options.seed
    );
    outln!("{:>8} {:>10} {:>12} {:>8}  verdict", "time s", "true um", "measured um", "+-");
    // Whole or half swings between the rows would show no swing.
    for row in rows.iter().step_by(17) {
        outln!(
            "{:>8.3} {:>10.3} {:>12.3} {:>8.3}  {}",
            row.time_s,
            row.truth_um,
            row.measured_um,
            row.sigma_um,
            row.verdict
        );
    }
    outln!(
        "\n{} of {} ramps good\n  swing  {:.3} ± {:.3} um at {SWING_HZ} Hz (true: {} um)\n  noise  {:.3} um rms in a ramp (the bound: {:.3} um)",
        summary.good,
        summary.ramps,
        summary.amplitude_um,
        summary.sigma_amplitude_um,
        1e6 * SWING_M,
        summary.noise_um,
        summary.bound_um
    );
}

/// The first two swings, with a band of one sigma, and the bound.
fn draw(rows: &[Row], summary: &Summary, file: &Path, output: Output) -> Result<(), DemoError> {
    const SHOWN_S: f64 = 0.6;
    let shown: Vec<&Row> = rows.iter().filter(|row| row.time_s <= SHOWN_S).collect();
    let most = shown.iter().map(|row| row.measured_um.abs()).fold(1.4e6 * SWING_M, f64::max);
    let truth = |by: f64| shown.iter().map(move |row| (row.time_s, row.truth_um + by));
    let chart = Chart {
        name: "vibration",
        title: format!(
            "A plate at 30 cm, 122 GHz: {:.2} um at 5 Hz, noise {:.2} um, bound {:.2} um",
            summary.amplitude_um, summary.noise_um, summary.bound_um
        ),
        x: Axis::linear("time, s", 0.0, SHOWN_S),
        y: Axis::linear("displacement, um", -1.1 * most, 1.1 * most),
        series: vec![
            Series::new(
                "measured ± sigma",
                Style::Points,
                0,
                shown.iter().map(|row| (row.time_s, row.measured_um)),
            )
            .with_errors(shown.iter().map(|row| row.sigma_um)),
            Series::new("truth", Style::Line, 1, truth(0.0)),
            Series::new("truth + bound", Style::Dashed, 2, truth(summary.bound_um)),
            Series::new("truth - bound", Style::Dashed, 2, truth(-summary.bound_um)),
        ],
    };
    chart.save(file, output).map_err(said)
}
