//! Instructions of a block that is measured where its tone is expected, beside those of the whole way on the same block.

use super::{Core, LIMIT, SEED, equality};
use crate::emulator::{Capture, RunError};
use crate::simulate::{Line, Signal, generator};
use crate::toolchain::{Firmware, Profile, ToolError};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Real, Segment};
use picket_dsp::config::{Config, ConfigError, Following};
use picket_dsp::pipeline::Measurement;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tracker::Tracker;
use picket_wire::capture::Header;
use picket_wire::follow::Follow;
use picket_wire::telemetry::{Health, Telemetry};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Samples in a block: what the image takes.
pub const N: usize = 1024;

/// What is counted, as the image names it: the bins about the expected tone, the fit to them, both with their checks, the search for
/// clipped samples; a block of the tracker by the short way and by the whole one; and the measurement without a tracker.
pub const STAGES: [&str; 7] = ["zoom", "fit", "lock", "clipped", "locked", "searched", "whole"];

/// Blocks at each signal-to-noise ratio in dB, and how far the tone moves from one to the next, in bins.
const RATIOS_DB: [f64; 4] = [60.0, 30.0, 10.0, -5.0];
const BLOCKS: usize = 32;
const DRIFT: f64 = 0.07;

/// One in this many blocks is searched.
const REFRESH: u8 = 16;

/// A stage on a core.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The core's name.
    pub core: &'static str,
    /// What was counted.
    pub stage: &'static str,
    /// Executed instructions, on the average of the blocks.
    pub mean: u64,
    /// The most.
    pub most: u64,
    /// In how many blocks it was done.
    pub blocks: usize,
}

/// What a core did.
#[derive(Clone, Debug)]
pub struct Count {
    /// The stages.
    pub rows: Vec<Row>,
    /// The records and tracks that it sent.
    pub telemetry: Vec<u8>,
    /// How many random blocks were mixed and transformed by kernel and definition, and how many of them differed.
    pub equality: (u64, u64),
}

impl Count {
    /// The stage of this name.
    pub fn stage(&self, name: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.stage == name)
    }
}

/// The image.
pub fn image(core: &Core) -> Result<PathBuf, ToolError> {
    let (target, profile) = (core.target, Profile::Release);
    Firmware { bin: "bench_locked", target, features: &["mps2"], profile }.build()
}

fn config() -> Config {
    let following = Following { most: 1, refresh: REFRESH, ..Following::default() };
    Config { arithmetic: Arithmetic::Float, following, ..Config::new(1.0, Codes::signed::<12>()) }
}

/// The blocks: a tone that drifts, over a constant offset, in noise of several strengths.
fn blocks() -> impl Iterator<Item = [i16; N]> {
    (0..RATIOS_DB.len() * BLOCKS).map(|number| {
        let snr_db = RATIOS_DB[number / BLOCKS];
        let amplitude = 2040.0 / (1.0 + 4.0 * Signal::tone(0.0, 1.0, snr_db).sigma());
        let bins = 100.3 + DRIFT * number as f64;
        let mut signal = Signal::tone(bins, amplitude, snr_db);
        signal.lines = vec![Line { bins, amplitude, phase: None }];
        signal.dc = [7.0, 0.0];
        let samples = signal.codes::<Real>(N, &mut generator(SEED, number as u64));
        std::array::from_fn(|index| samples.get(index).copied().unwrap_or(0))
    })
}

/// Counts on a core, and drives kernels and definition with `random` blocks of each length and kind.
pub fn count(core: &Core, image: &Path, random: u32) -> Result<Count, RunError> {
    let mut capture = Capture::create(&Header { period_us: random, ..header() })?;
    for block in blocks() {
        capture.push::<Real>(&block)?;
    }
    let mut telemetry = Vec::new();
    let outcome = capture.run(core.machine, image, LIMIT, |bytes| telemetry.extend(bytes))?;
    let figures = outcome.figures();
    let instructions = |ticks: f64| (ticks * core.machine.instructions_per_tick()).round() as u64;
    let rows = STAGES.iter().filter_map(|&stage| {
        let counts = figures.get(stage)?;
        Some(Row {
            core: core.name,
            stage,
            mean: instructions(counts.iter().sum::<u64>() as f64 / counts.len() as f64),
            most: instructions(*counts.iter().max()? as f64),
            blocks: counts.len(),
        })
    });
    let rows = rows.collect();
    Ok(Count { rows, telemetry, equality: equality(&figures) })
}

fn header() -> Header {
    Header::from_config::<Real>(config(), N as u32, (RATIOS_DB.len() * BLOCKS) as u32)
}

/// What this machine makes of the same blocks, and in how many of them it did not search.
pub fn here() -> Result<(Vec<u8>, usize), ConfigError> {
    let plan = config().plan::<Real, N>()?;
    let mut tracker = Box::new(Tracker::<Real, N>::new(plan));
    let (mut telemetry, mut locked) = (Vec::new(), 0);
    for (sequence, block) in blocks().enumerate() {
        let stamp = header().timing().stamp(sequence as u64, false);
        let measurement: Measurement = tracker.block(&stamp, &block);
        let (method, health) = (plan.options.method, Health::default());
        telemetry.extend(
            Telemetry { measurement, method, health, basis: None, uncertainty: None }.to_frame(),
        );
        telemetry.extend(Follow::from_tracker(&tracker, &stamp).to_frame());
        locked += usize::from(tracker.is_locked(Segment::Continuous));
    }
    Ok((telemetry, locked))
}
