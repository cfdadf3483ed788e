//! Instructions of the further tones of a block, beside those of its first.

use super::{Core, LIMIT, SEED};
use crate::emulator::{Capture, RunError};
use crate::simulate::{Line, Signal, generator};
use crate::toolchain::{Firmware, Profile, ToolError};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::{Config, ConfigError};
use picket_dsp::pipeline::{Measurement, Outcome, Pipeline};
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::lines::MOST;
use picket_wire::capture::Header;
use picket_wire::telemetry::{Health, Telemetry};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Samples in a block: what the image takes.
pub const N: usize = 1024;

/// Blocks of each number of tones.
const BLOCKS: usize = 16;

/// The strongest tone above the noise, and how much weaker each of the others is, dB.
const SNR_DB: f64 = 40.0;
const WEAKER_DB: f64 = 8.0;

/// What blocks of this many tones cost, on the average.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Row {
    /// The core's name.
    pub core: &'static str,
    /// Tones in the block.
    pub tones: usize,
    /// The measurement of the first tone alone.
    pub whole: u64,
    /// Its phase beside.
    pub phase: u64,
    /// All of them beside.
    pub lines: u64,
}

/// The image.
pub fn image(core: &Core) -> Result<PathBuf, ToolError> {
    let (target, profile) = (core.target, Profile::Release);
    Firmware { bin: "bench_several", target, features: &["mps2"], profile }.build()
}

fn config() -> Config {
    Config { arithmetic: Arithmetic::Float, ..Config::new(1.0, Codes::signed::<12>()) }
}

fn header() -> Header {
    Header::from_config::<Real>(config(), N as u32, (MOST * BLOCKS) as u32)
}

/// One to four tones at any distance from 12 bins on.
fn blocks() -> impl Iterator<Item = [i16; N]> {
    (0..MOST * BLOCKS).map(|number| {
        let lines = (0..1 + number / BLOCKS).map(|tone| Line {
            bins: 40.3
                + 3.37 * number as f64
                + (12.0 + 5.1 * (number % BLOCKS) as f64) * tone as f64,
            amplitude: 450.0 * 10f64.powf(-WEAKER_DB / 20.0 * tone as f64),
            phase: None,
        });
        let signal = Signal { lines: lines.collect(), ..Signal::tone(0.0, 0.0, SNR_DB) };
        let samples = signal.codes::<Real>(N, &mut generator(SEED, number as u64));
        std::array::from_fn(|index| samples.get(index).copied().unwrap_or(0))
    })
}

/// Counts on a core. Beside the rows: the tones that it sent.
pub fn count(core: &Core, image: &Path) -> Result<(Vec<Row>, Vec<u8>), RunError> {
    let mut capture = Capture::create(&header())?;
    for block in blocks() {
        capture.push::<Real>(&block)?;
    }
    let mut telemetry = Vec::new();
    let outcome = capture.run(core.machine, image, LIMIT, |bytes| telemetry.extend(bytes))?;
    let figures = outcome.figures();
    let mean = |stage: &str, tones: usize| {
        let counts = figures.get(stage).map(Vec::as_slice).unwrap_or_default();
        let counts = counts.get(BLOCKS * (tones - 1)..BLOCKS * tones).unwrap_or_default();
        let ticks = counts.iter().sum::<u64>() as f64 / BLOCKS as f64;
        (ticks * core.machine.instructions_per_tick()).round() as u64
    };
    let row = |tones| Row {
        core: core.name,
        tones,
        whole: mean("whole", tones),
        phase: mean("phase", tones),
        lines: mean("lines", tones),
    };
    Ok(((1..=MOST).map(row).collect(), telemetry))
}

/// What this machine makes of the same blocks, and how many tones it finds in each.
pub fn here() -> Result<(Vec<u8>, Vec<usize>), ConfigError> {
    let plan = config().plan::<Real, N>()?;
    let mut pipeline = Box::new(Pipeline::<Real, N>::new(plan));
    let (mut telemetry, mut found) = (Vec::new(), Vec::new());
    for (sequence, block) in blocks().enumerate() {
        let stamp = header().timing().stamp(sequence as u64, false);
        let measurement = pipeline.block(&stamp, &block);
        let lines = pipeline.lines(&measurement, MOST);
        for phasor in &lines {
            let measurement =
                Measurement { tone: phasor.tone, result: Outcome::None, ..measurement };
            let (method, health) = (plan.options.method, Health::default());
            telemetry.extend(
                Telemetry { measurement, method, health, basis: None, uncertainty: None }
                    .to_frame(),
            );
        }
        found.push(lines.len());
    }
    Ok((telemetry, found))
}
