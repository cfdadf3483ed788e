//! The Pico's own image on its emulator, with what `picket demo` has in front of the converter.
//!
//! The board measures tones. It makes no chirps, so a chirp's target is solved here, from the three records of its ramps.

use super::options::Options;
use super::table::Task;
use super::{DemoError, said};
use crate::pico::bench::{Pico, emulator};
use crate::pico::converter::Converter;
use crate::pico::{binary, image};
use crate::progress;
use crate::toolchain::{Need, Target, have};
use picket_dsp::config::{Config, Scene};
use picket_dsp::pipeline::Outcome;
use picket_dsp::plan::Solver;
use picket_dsp::solve::chirp;
use picket_dsp::tone::Tone;
use picket_firmware::pico::N;
use picket_firmware::pico::words::Words;
use picket_wire::command::Command;
use picket_wire::settings::{Calibration, Settings};
use picket_wire::telemetry::Telemetry;

/// The board's rate for scenes whose own it does not reach, Hz.
pub const RATE_HZ: f64 = 500e3;

/// The lidar's records, slowed down to the board's rate: a bin stays a bin. Each third has its chirp's target.
pub(super) fn lidar(task: &Task, options: &Options) -> Result<Vec<Telemetry>, DemoError> {
    let config = task.config;
    let plan = config.plan::<picket_dsp::Real, N>().map_err(said)?;
    let Solver::Chirp(equations) = plan.solver else { return Err(said("no chirp")) };
    let blocks = task.all_blocks::<picket_dsp::Real>(options)?;
    let voltages: Vec<f64> = blocks.into_iter().flatten().map(f64::from).collect();
    let slowed = Config { rate_hz: RATE_HZ, scene: Scene::Tone, ..config };
    let mut records = records(slowed, &voltages)?;
    for ramps in records.as_chunks_mut::<3>().0 {
        let tones: [Tone; 3] = ramps.each_ref().map(|record| record.measurement.tone);
        let target = chirp::trapezoid(&tones, false, &equations);
        ramps[2].measurement.result = Outcome::Target(target);
    }
    Ok(records)
}

/// The board's record of each block of a signal about 0, in codes; none is lost.
pub fn records(config: Config, voltages: &[f64]) -> Result<Vec<Telemetry>, DemoError> {
    let settings = settings(config)?;
    have(&[Need::Core(Target::M0), Need::Node]).map_err(said)?;
    // Its scripts come from a registry: before the image is built, which takes long.
    emulator().map_err(said)?;
    let elf = image().map_err(said)?;
    let mut board = Pico::plug(&binary(&elf).map_err(said)?).map_err(said)?;
    // It keeps the settings, and begins with the first sample when it is plugged in again.
    board.power().map_err(said)?;
    board.request(Command::SetSettings(settings, N)).map_err(said)?.map_err(refused)?;
    board.boot().map_err(said)?;
    board.request(Command::Save).map_err(said)?.map_err(refused)?;
    let converter = Converter::default();
    let codes: Vec<i16> = voltages.iter().map(|v| converter.code(2048.0 + v)).collect();
    board.samples(&codes).map_err(said)?;
    board.power().map_err(said)?;
    board.telemetry();
    let blocks = voltages.len() / N;
    let bar = progress::bar(blocks as u64, "blocks");
    let patience = (8e3 * N as f64 / config.rate_hz) as u64 + 1_000;
    let mut records: Vec<Telemetry> = Vec::new();
    while records.len() < blocks {
        board.frames(8.min(blocks - records.len()) as u64, patience).map_err(said)?;
        let more = board.telemetry();
        let lost = more.iter().zip(records.len() as u32..).any(|(record, number)| {
            record.measurement.stamp.sequence != number || record.health.lost > 0
        });
        if lost || more.is_empty() {
            return Err(said(format!("the board lost a block after {}", records.len())));
        }
        bar.inc(more.len() as u64);
        records.extend(more);
    }
    bar.finish_and_clear();
    records.truncate(blocks);
    Ok(records)
}

/// The settings for a scene of a continuous wave. The board's clock makes the rate nearest to it, and takes it for the rate itself.
fn settings(config: Config) -> Result<Settings, DemoError> {
    let codes = Settings::default().config.codes;
    let settings = Settings { config: Config { codes, ..config }, ..Settings::default() };
    let refused = |error: picket_wire::settings_error::SettingsError| said(error);
    let (_, words) = Words::plan(&settings).map_err(refused)?;
    let clock_ppm = ((config.rate_hz / words.rate_hz() - 1.0) * 1e6) as f32;
    let calibration = Calibration { clock_ppm, ..Calibration::default() };
    Ok(Settings { calibration, ..settings })
}

fn refused(refusal: picket_wire::command::Refusal) -> DemoError {
    said(format!("the board refuses: {refusal}"))
}
