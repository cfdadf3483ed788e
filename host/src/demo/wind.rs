//! Wind from echoes below the noise: sums of blocks along each beam of a cone, and the wind that they give.

use super::feed::N;
use super::nucleo::Nucleo;
use super::options::{Board, Options};
use super::shown::{Shown, Speed, is_usable, keys, lines, rms, table};
use super::{DemoError, said};
use crate::device::Said;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::progress;
use crate::scenario::wind::{self, BEAMS, BLOCK_S, BLOCKS, FROM_DEG, WIND_MPS};
use picket_dsp::pipeline::Outcome;
use picket_dsp::plan::Solver;
use picket_dsp::solve::doppler;
use picket_dsp::{Accumulated, Accumulator, Iq, Pipeline, Stamp, Tone, Velocity};
use picket_wire::settings::Mode;
use serde::Serialize;

/// One beam. The keys are those of the JSON lines.
#[derive(Serialize)]
struct Row {
    /// Its direction, degrees from north over east.
    azimuth_deg: f64,
    /// How fast the air approaches, and what the sum shows.
    #[serde(flatten)]
    speed: Speed,
    /// Of a sample.
    snr_db: f64,
    /// Blocks that alone may be used.
    alone: u32,
    /// The power of each bin over that of the noise, in the first block whose strongest line is not the wind's, and in the sum.
    #[serde(skip)]
    powers: [Vec<f64>; 2],
}

impl Row {
    fn is_right(&self) -> bool {
        is_usable(self.speed.verdict) && self.speed.is_within()
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

/// The only measurement that the board has sent.
fn measured_by_board(said: &mut Vec<Said>) -> Result<(Tone, Velocity), DemoError> {
    let mut tones = said.drain(..).filter_map(|said| match said {
        Said::Telemetry(record) => Some(record.measurement),
        _ => None,
    });
    let (first, more) = (tones.next(), tones.next());
    match (first.map(|first| (first.tone, first.result)), more) {
        (Some((tone, Outcome::Velocity(velocity))), None) => Ok((tone, velocity)),
        _ => Err(super::said("the board has not returned one velocity for each beam")),
    }
}

/// The beams of a round, by the core here or by the emulated board.
fn rows(options: &Options) -> Result<Vec<Row>, DemoError> {
    let mode = Mode::Accumulate { blocks: BLOCKS, drift_bins: 0.0 };
    let mut board = match options.board {
        Board::Nucleo => Some(Nucleo::start(wind::config(), true, mode)?),
        _ => None,
    };
    let mut said_by_board = Vec::new();
    let plan = wind::config().plan::<Iq, N>().map_err(said)?;
    let Solver::Doppler(scale) = plan.solver else { return Err(said("no velocity")) };
    let mut pipeline = Box::new(Pipeline::<Iq, N>::new(plan));
    let mut accumulator = Box::new(Accumulator::<Iq, N>::new(BLOCKS));
    let bar = progress::bar((BEAMS as u64) * u64::from(BLOCKS), "blocks");
    let mut rows = Vec::new();
    for beam in 0..BEAMS {
        let scene = wind::scene(options.seed, N, beam, options.snr_db());
        let mut run = scene.run(beam as u64).map_err(said)?;
        let (mut powers, mut alone) = ([vec![0.0; N], vec![0.0; N]], 0);
        for sequence in 0..BLOCKS {
            let samples = run.codes(f64::from(sequence) * BLOCK_S, N);
            let Some(samples) = samples.as_array() else { return Err(said("no whole block")) };
            let stamp = Stamp { sequence, ..Stamp::default() };
            let measurement = pipeline.block(&stamp, samples);
            alone += u32::from(is_usable(measurement.tone.verdict));
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
                speed: Speed {
                    truth_mps: wind::along_mps(beam),
                    velocity_mps: velocity.velocity.to_num(),
                    sigma_mps: velocity.sigma.into(),
                    verdict: sum.tone.verdict,
                },
                snr_db: sum.tone.snr_db().into(),
                alone,
                powers: powers.each_ref().map(|powers| over_noise(powers, peak)),
            });
        }
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// Right: every beam may be used, and is within 5 sigma.
pub(super) fn measured(options: &Options) -> Result<Shown, DemoError> {
    let rows = rows(options)?;
    let along: Vec<f64> = rows.iter().map(|row| row.speed.velocity_mps).collect();
    let [wind_mps, from_deg] = wind::of_beams(&along);
    let (beams, right) = (rows.len(), rows.iter().filter(|row| row.is_right()).count());
    let alone: u32 = rows.iter().map(|row| row.alone).sum();
    let rms_mps = rms(rows.iter().map(|row| row.speed.error()));
    let sigmas = rms(rows.iter().map(|row| row.speed.sigmas()));
    let bound_mps = wind::bound_mps(N, options.snr_db());
    let (truth_wind_mps, truth_from_deg) = (WIND_MPS, FROM_DEG);
    let all = keys! {
        summary: true, beams, right, alone, rms_mps, bound_mps, sigmas, truth_wind_mps, wind_mps, truth_from_deg, from_deg,
    };
    let text = format!(
        "{right} of {beams} beams can be used and are within 5 sigma; of {} blocks alone {alone} can be used\n  \
         along a beam  rms {:.2} mm/s (the bound: {:.2} mm/s), error over sigma {sigmas:.2} (rms)\n  \
         wind          {wind_mps:.4} m/s from {from_deg:.3} degrees (true: {WIND_MPS} m/s from {FROM_DEG})\n",
        beams * BLOCKS as usize,
        1e3 * rms_mps,
        1e3 * bound_mps
    );
    let table = table(
        rows.iter().step_by(3),
        "azimuth: azimuth_deg | true m/s: truth_mps +.4 | measured m/s: velocity_mps +.4 | +-: sigma_mps .4 | SNR dB: snr_db .1 | verdict: verdict",
        |row| !row.is_right(),
    );
    Ok(Shown {
        heading: format!(
            "Wind around a lidar's cone: 1550 nm, I/Q, 12 bits at 50 MS/s, N = {N}, sums of {BLOCKS} blocks, {} dB a sample, seed {}",
            options.snr_db(),
            options.seed
        ),
        table,
        text,
        lines: lines(&rows, &all)?,
        charts: rows.first().map(|row| chart(row, options.snr_db())).into_iter().collect(),
        right: right == beams,
    })
}

/// The first beam: the spectrum of one block, of the sum, and where the wind is.
fn chart(row: &Row, snr_db: f64) -> Chart {
    // What the wind may be along a beam, and a little more.
    const SHOWN_MPS: f64 = 6.0;
    let velocity = |k: usize| (k as f64 - (N / 2) as f64) * wind::mps_per_bin(N);
    let line = |label: String, colour, powers: &[f64]| {
        let levels = powers.iter().map(|power| 10.0 * power.log10());
        let levels = levels.enumerate().map(|(k, level)| (velocity(k), level));
        Series::new(label, Style::Line, colour, levels)
    };
    let [block, sum] = &row.powers;
    Chart {
        name: "wind",
        title: format!(
            "Wind {} dB below the noise of a sample: one block, and {BLOCKS} without their phases",
            -snr_db
        ),
        x: Axis::linear("velocity towards the lidar, m/s", -SHOWN_MPS, SHOWN_MPS),
        y: Axis::linear("power of a bin over the noise, dB", -25.0, 20.0),
        series: vec![
            Series::new(
                "the air",
                Style::Dashed,
                1,
                [-25.0, 20.0].map(|at| (row.speed.truth_mps, at)),
            ),
            line("a block that misses it".into(), 6, block),
            line(format!("mean of {BLOCKS}"), 0, sum),
        ],
    }
}
