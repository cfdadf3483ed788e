//! Wind from echoes below the noise: sums of blocks along each beam of a cone, and the wind that they give.

use super::answer::lines;
use super::measure::N;
use super::nucleo::Nucleo;
use super::options::{Board, Options};
use super::{DemoError, said, shown};
use crate::device::Said;
use crate::output::Output;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::progress;
use crate::scenario::wind::{self, BEAMS, BLOCKS, FROM_DEG, WIND_MPS};
use crate::simulate::generator;
use picket_dsp::pipeline::Outcome;
use picket_dsp::plan::Solver;
use picket_dsp::solve::doppler;
use picket_dsp::{Accumulated, Accumulator, Iq, Pipeline, Stamp, Tone, Usable, Velocity};
use picket_wire::settings::Mode;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

/// One beam. The keys are those of the JSON lines.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Its direction, degrees from north over east.
    pub azimuth_deg: f64,
    /// How fast the air approaches.
    pub truth_mps: f64,
    /// What the sum shows.
    pub velocity_mps: f64,
    /// One standard deviation.
    pub sigma_mps: f64,
    /// The signal-to-noise ratio of a sample.
    pub snr_db: f64,
    /// Whether it may be used.
    pub verdict: &'static str,
    /// Whether it may be used within sigma.
    #[serde(skip)]
    pub usable: bool,
    /// Blocks that alone may be used.
    pub alone: u32,
    /// The power of each bin over that of the noise, in the first block whose strongest line is not the wind's, and in the sum.
    #[serde(skip)]
    pub powers: [Vec<f64>; 2],
}

/// A round.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Always true: it tells this line from the others.
    pub summary: bool,
    /// Beams.
    pub beams: usize,
    /// Beams that may be used, and are within 5 sigma.
    pub right: usize,
    /// Blocks that alone may be used.
    pub alone: u32,
    /// Root mean square of the error along a beam.
    pub rms_mps: f64,
    /// The bound for one.
    pub bound_mps: f64,
    /// Root mean square of error over sigma.
    pub sigmas: f64,
    /// The wind.
    pub truth_wind_mps: f64,
    /// The wind of the beams.
    pub wind_mps: f64,
    /// Where the wind comes from.
    pub truth_from_deg: f64,
    /// Where that of the beams comes from.
    pub from_deg: f64,
}

impl Row {
    fn error(&self) -> f64 {
        self.velocity_mps - self.truth_mps
    }

    fn is_right(&self) -> bool {
        self.usable && self.error().abs() < 5.0 * self.sigma_mps
    }
}

impl Summary {
    /// Of a round.
    pub fn of(rows: &[Row], snr_db: f64) -> Self {
        let mean = |of: fn(&Row) -> f64| rows.iter().map(of).sum::<f64>() / rows.len() as f64;
        let along: Vec<f64> = rows.iter().map(|row| row.velocity_mps).collect();
        let [wind_mps, from_deg] = wind::of_beams(&along);
        Summary {
            summary: true,
            beams: rows.len(),
            right: rows.iter().filter(|row| row.is_right()).count(),
            alone: rows.iter().map(|row| row.alone).sum(),
            rms_mps: mean(|row| row.error().powi(2)).sqrt(),
            bound_mps: wind::bound_mps(N, snr_db),
            sigmas: mean(|row| (row.error() / row.sigma_mps).powi(2)).sqrt(),
            truth_wind_mps: WIND_MPS,
            wind_mps,
            truth_from_deg: FROM_DEG,
            from_deg,
        }
    }

    /// Whether every beam is right.
    pub fn inside(&self) -> bool {
        self.right == self.beams
    }
}

/// The power of each bin over the mean of those that are no line's, from the most negative frequency on.
fn over_noise(powers: &[f64], peak: usize) -> Vec<f64> {
    // A line's neighbours hold some of it: four bins away it is down by 20 dB and more.
    let apart = |k: usize| {
        let away = k.abs_diff(peak);
        away.min(N - away) > 4
    };
    let noise: Vec<f64> =
        powers.iter().enumerate().filter(|(k, _)| apart(*k)).map(|(_, power)| *power).collect();
    let mean = noise.iter().sum::<f64>() / noise.len() as f64;
    (0..N).filter_map(|k| powers.get((k + N / 2) % N)).map(|power| power / mean).collect()
}

fn is_usable(tone: &Tone) -> bool {
    tone.verdict.usable() <= Usable::WithinSigma
}

/// The one measurement that the board has told.
fn measured_by_board(said: &mut Vec<Said>) -> Result<(Tone, Velocity), DemoError> {
    let mut tones = said.drain(..).filter_map(|said| match said {
        Said::Telemetry(record) => Some(record.measurement),
        _ => None,
    });
    let (first, more) = (tones.next(), tones.next());
    match (first.map(|first| (first.tone, first.result)), more) {
        (Some((tone, Outcome::Velocity(velocity))), None) => Ok((tone, velocity)),
        _ => Err(super::said("the board has not told one velocity a beam")),
    }
}

/// Measures the beams of a round, by the core here or by the emulated board.
pub fn measured(seed: u64, snr_db: f64, board: Board) -> Result<Vec<Row>, DemoError> {
    let mode = Mode::Accumulate { blocks: BLOCKS, drift_bins: 0.0 };
    let mut board = match board {
        Board::Nucleo => Some(Nucleo::start(wind::config(), true, mode)?),
        _ => None,
    };
    let mut said_by_board = Vec::new();
    let plan = wind::config().plan::<Iq, N>().map_err(said)?;
    let Solver::Doppler(scale) = plan.solver else { return Err(said("no velocity")) };
    let mut pipeline = Box::new(Pipeline::<Iq, N>::new(plan));
    let mut accumulator = Box::new(Accumulator::<Iq, N>::new(BLOCKS));
    let lidar = wind::lidar(N, snr_db);
    let bar = progress::bar((BEAMS as u64) * u64::from(BLOCKS), "blocks");
    let mut rows = Vec::new();
    for beam in 0..BEAMS {
        let rng = &mut generator(seed, beam as u64);
        let (mut powers, mut alone) = ([vec![0.0; N], vec![0.0; N]], 0);
        for sequence in 0..BLOCKS {
            let mut samples = [[0; 2]; N];
            samples.copy_from_slice(&wind::samples(&lidar, beam, snr_db, rng));
            let stamp = Stamp { sequence, ..Stamp::default() };
            let measurement = pipeline.block(&stamp, &samples);
            alone += u32::from(is_usable(&measurement.tone));
            let off =
                measurement.tone.frequency.bins(N) - wind::along_mps(beam) / wind::mps_per_bin(N);
            let hidden = off.abs() > 1.0 && powers[0].iter().all(|power| *power == 0.0);
            let spectrum = pipeline.spectrum();
            let unit = f64::from(spectrum.exponent()).exp2().powi(2);
            let [block, sums] = &mut powers;
            for (k, (one, sum)) in block.iter_mut().zip(sums).enumerate() {
                let power = unit * spectrum.power(k as i32) as f64;
                *sum += power;
                if hidden {
                    *one = power;
                }
            }
            bar.inc(1);
            let added = accumulator.add(&measurement, &pipeline);
            if let Some(board) = &mut board {
                said_by_board.extend(board.block(samples.as_flattened())?);
            }
            let Some(sum) = added else { continue };
            let (tone, velocity) = match &mut board {
                None => (sum.tone, doppler::velocity(&sum.tone, scale)),
                Some(board) => {
                    said_by_board.extend(board.rest()?);
                    measured_by_board(&mut said_by_board)?
                }
            };
            let sum = Accumulated { tone, ..sum };
            let peak = sum.tone.frequency.bins(N).rem_euclid(N as f64).round() as usize % N;
            rows.push(Row {
                azimuth_deg: wind::azimuth_deg(beam),
                truth_mps: wind::along_mps(beam),
                velocity_mps: velocity.velocity.to_num(),
                sigma_mps: velocity.sigma.into(),
                snr_db: sum.tone.snr_db().into(),
                verdict: sum.tone.verdict.name(),
                usable: is_usable(&sum.tone),
                alone,
                powers: powers.each_ref().map(|powers| over_noise(powers, peak)),
            });
        }
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// Measures, prints and draws. Failure: a beam is not right.
pub fn run(options: &Options) -> Result<ExitCode, DemoError> {
    let rows = measured(options.seed, options.snr_db(), options.board)?;
    let summary = Summary::of(&rows, options.snr_db());
    let draw = |file: &Path| draw(&rows, options, file, options.output);
    let print = || print(&rows, &summary, options);
    shown(options, draw, || lines(&rows, &summary), print, summary.inside())
}

fn print(rows: &[Row], summary: &Summary, options: &Options) {
    outln!(
        "Wind around a lidar's cone: 1550 nm, I/Q, 12 bits at 50 MS/s, N = {N}, sums of {BLOCKS} blocks, {} dB a sample, seed {}\n",
        options.snr_db(),
        options.seed
    );
    outln!(
        "{:>7} {:>9} {:>13} {:>7} {:>7}  verdict",
        "azimuth",
        "true m/s",
        "measured m/s",
        "+-",
        "SNR dB"
    );
    for row in rows.iter().step_by(3) {
        outln!(
            "{:>7} {:>+9.4} {:>+13.4} {:>7.4} {:>7.1}  {}",
            row.azimuth_deg,
            row.truth_mps,
            row.velocity_mps,
            row.sigma_mps,
            row.snr_db,
            row.verdict
        );
    }
    outln!(
        "\n{} of {} beams can be used and are within 5 sigma; of {} blocks alone {} can be used\n  \
         along a beam  rms {:.2} mm/s (the bound: {:.2} mm/s), error over sigma {:.2} (rms)\n  \
         wind          {:.4} m/s from {:.3} degrees (true: {} m/s from {FROM_DEG})",
        summary.right,
        summary.beams,
        summary.beams * BLOCKS as usize,
        summary.alone,
        1e3 * summary.rms_mps,
        1e3 * summary.bound_mps,
        summary.sigmas,
        summary.wind_mps,
        summary.from_deg,
        summary.truth_wind_mps
    );
}

/// The first beam: the spectrum of one block, of the sum, and where the wind is.
fn draw(rows: &[Row], options: &Options, file: &Path, output: Output) -> Result<(), DemoError> {
    let Some(row) = rows.first() else { return Err(said("no beam")) };
    // What the wind may be along a beam, and a little more.
    const SHOWN_MPS: f64 = 6.0;
    let velocity = |k: usize| (k as f64 - (N / 2) as f64) * wind::mps_per_bin(N);
    let line = |index: usize| {
        let levels = row.powers[index].iter().map(|power| 10.0 * power.log10());
        levels.enumerate().map(move |(k, level)| (velocity(k), level))
    };
    let chart = Chart {
        name: "wind",
        title: format!(
            "Wind {} dB below the noise of a sample: one block, and {BLOCKS} without their phases",
            -options.snr_db()
        ),
        x: Axis::linear("velocity towards the lidar, m/s", -SHOWN_MPS, SHOWN_MPS),
        y: Axis::linear("power of a bin over the noise, dB", -25.0, 20.0),
        series: vec![
            Series::new("the air", Style::Dashed, 1, [-25.0, 20.0].map(|at| (row.truth_mps, at))),
            Series::new("a block that misses it", Style::Line, 6, line(0)),
            Series::new(format!("mean of {BLOCKS}"), Style::Line, 0, line(1)),
        ],
    };
    chart.save(file, output).map_err(said)
}
