//! Feeds the firmware with targets and reads its answers.

use super::options::{Board, Options};
use super::table::{Answer, Result as Row, Summary};
use super::{DemoError, pico, said};
use crate::device::{Listener, Said};
use crate::emulator::{self, Capture, Machine, RunError};
use crate::progress;
use crate::scenario::{self, Bars};
use crate::simulate::{Kind, Signal, generator};
use crate::toolchain::{Firmware, Profile};
use picket::acquire::sample::{Iq, Real};
use picket::config::Config;
use picket::estimate::method::Method;
use picket::pipeline::{Measurement, Outcome};
use picket::plan::Solver;
use picket_wire::capture::Header;
use picket_wire::telemetry::Telemetry;
use std::time::Duration;

/// Samples in a block.
pub const N: usize = 1024;

/// The amplitude that uses a 12-bit converter well: tone plus four sigmas of the noise reach the rail.
fn amplitude(snr_db: f64) -> f64 {
    2047.0 / (1.0 + 4.0 * Signal::tone(0.0, 1.0, snr_db).sigma())
}

/// The lidar's rows, once for each seed.
pub fn lidar(options: &Options) -> Result<Summary, DemoError> {
    let lidar = Lidar::new(options.method)?;
    let records = match options.board {
        Board::Mps2 => measured::<Real>(lidar.config, &lidar.beats, options)?,
        Board::Pico => pico::lidar(lidar.config, &lidar.beats, options)?,
    };
    Ok(lidar.summary(records.iter().map(|record| &record.measurement), options.seeds))
}

/// The lidar's task: what is set and what is in front of it.
pub(super) struct Lidar {
    pub config: Config,
    method: Method,
    rows: Vec<scenario::Row>,
    /// Three for each row, in signed cycles per sample.
    pub beats: Vec<f64>,
}

impl Lidar {
    pub fn new(method: Option<Method>) -> Result<Self, DemoError> {
        let config = configured(scenario::lidar(), method);
        let plan = config.plan::<Real, N>().map_err(said)?;
        let Solver::Chirp(equations) = plan.solver else { return Err(said("no chirp")) };
        let rows = scenario::table3();
        let beats = rows.iter().flat_map(|row| scenario::lidar_beats(row, &equations));
        let beats = beats.map(|(_, cycles)| cycles).collect();
        Ok(Lidar { config, method: plan.options.method, rows, beats })
    }

    /// Truth beside measurement, for so many seeds one after the other.
    pub fn summary<'a>(
        self,
        measurements: impl Iterator<Item = &'a Measurement>,
        seeds: u64,
    ) -> Summary {
        let answers = measurements.filter_map(|measurement| match measurement.result {
            Outcome::Target(target) => Some((
                measurement.stamp.sequence as usize / 3,
                Answer {
                    range_m: target.range.to_num(),
                    velocity_mps: target.velocity.to_num(),
                    sigma_range_m: target.sigma_range.into(),
                    sigma_velocity_mps: target.sigma_velocity.into(),
                    verdict: target.verdict,
                },
            )),
            _ => None,
        });
        let rows = (0..seeds).flat_map(|_| self.rows.iter().copied()).collect();
        summary(rows, answers, scenario::LIDAR_BARS, self.method)
    }
}

/// The turntable's speeds.
pub fn turntable(options: &Options) -> Result<Summary, DemoError> {
    let config = configured(scenario::turntable(), options.method);
    let plan = config.plan::<Iq, N>().map_err(said)?;
    let Solver::Doppler(scale) = plan.solver else { return Err(said("no velocity")) };
    let rows = scenario::turntable_rows();
    let per_cycle: f64 = scale.fixed.to_num();
    let tones: Vec<f64> = rows.iter().map(|row| row.velocity_mps / per_cycle).collect();
    let records = measured::<Iq>(config, &tones, options)?;
    let answers = records.iter().filter_map(|record| match record.measurement.result {
        Outcome::Velocity(velocity) => Some((
            record.measurement.stamp.sequence as usize,
            Answer {
                range_m: 0.0,
                velocity_mps: velocity.velocity.to_num(),
                sigma_range_m: 0.0,
                sigma_velocity_mps: velocity.sigma.into(),
                verdict: velocity.verdict,
            },
        )),
        _ => None,
    });
    Ok(summary(rows, answers, scenario::TURNTABLE_BARS, plan.options.method))
}

fn configured(config: Config, method: Option<Method>) -> Config {
    Config { method: method.unwrap_or(config.method), ..config }
}

/// The samples of a tone of so many cycles per sample; `trial` numbers the noise of a seed.
pub(super) fn block<R: Kind>(cycles: f64, snr_db: f64, seed: u64, trial: u64) -> Vec<R::Sample> {
    // A real tone is the same at minus its frequency.
    let bins = if R::IQ { cycles } else { cycles.abs() } * N as f64;
    Signal::tone(bins, amplitude(snr_db), snr_db).codes::<R>(N, &mut generator(seed, trial))
}

/// One block of noisy samples for each tone (cycles per sample) and seed, through the firmware.
fn measured<R: Kind>(
    config: Config,
    tones: &[f64],
    options: &Options,
) -> Result<Vec<Telemetry>, DemoError> {
    let blocks = tones.len() as u64 * options.seeds;
    let header = Header::of::<R>(config, N as u32, blocks as u32);
    let mut capture = Capture::create(&header).map_err(said)?;
    for seed in options.seed..options.seed.wrapping_add(options.seeds) {
        for (trial, &cycles) in (0..).zip(tones) {
            let samples = block::<R>(cycles, options.snr_db(), seed, trial);
            capture.push::<R>(&samples).map_err(said)?;
        }
    }
    let bar = progress::bar(blocks, "blocks");
    let mut records = Vec::new();
    play(capture, options, |record| {
        bar.inc(1);
        records.push(record);
    })
    .map_err(said)?;
    bar.finish_and_clear();
    Ok(records)
}

/// Plays a capture to the firmware; `take` gets each record as it comes. Gives what was lost on the way.
pub fn play(
    capture: Capture,
    options: &Options,
    mut take: impl FnMut(Telemetry),
) -> Result<Listener, RunError> {
    play_on("frontend_qemu", capture, options, |said| {
        if let Said::Telemetry(record) = said {
            take(record);
        }
    })
}

/// The same on another image, and with all that it says.
pub fn play_on(
    bin: &'static str,
    capture: Capture,
    options: &Options,
    mut take: impl FnMut(Said),
) -> Result<Listener, RunError> {
    let features: &[&str] = if options.log { &["mps2", "log"] } else { &["mps2"] };
    let profile = Profile::Release;
    let image = Firmware { bin, target: BOARD.target(), features, profile };
    let image = image.build()?;
    let mut listener = Listener::default();
    let outcome = capture.run(BOARD, &image, LIMIT, |piece| {
        listener.read(piece).into_iter().for_each(&mut take);
    })?;
    if options.log {
        for line in emulator::log_lines(&image, &outcome.log)? {
            eprintln!("firmware: {line}");
        }
    }
    Ok(listener)
}

/// The board that has DMA.
const BOARD: Machine = Machine::An505;

/// No run takes longer.
const LIMIT: Duration = Duration::from_secs(3600);

fn summary(
    truths: Vec<scenario::Row>,
    answers: impl Iterator<Item = (usize, Answer)>,
    bars: Bars,
    method: Method,
) -> Summary {
    let mut results: Vec<Row> =
        truths.into_iter().map(|truth| Row { truth, answer: None }).collect();
    for (row, answer) in answers {
        if let Some(result) = results.get_mut(row) {
            result.answer = Some(answer);
        }
    }
    Summary { results, bars, method: method.name().into() }
}
