//! CMSIS-DSP, counted in the same run: its program is `host/cmsis/bench.c`.

use super::cycles::{self, Clock};
use super::trace::Trace;
use super::{Core, Figures, LIMIT, Row, bins, exact, ratio};
use crate::emulator::{Capture, Footprint, Outcome, RunError};
use crate::toolchain;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::Config;
use picket_wire::capture::Header;
use std::path::Path;

/// A kind of numbers of the library's.
struct Numbers {
    /// What the table calls it.
    engine: &'static str,
    /// What the program calls it.
    name: &'static str,
    /// Bytes of memory for each sample: the record and its transform.
    bytes: u64,
}

const KINDS: [Numbers; 3] = [
    Numbers { engine: "cmsis-q15", name: "Q15", bytes: 2 + 4 },
    Numbers { engine: "cmsis-q31", name: "Q31", bytes: 4 + 8 },
    Numbers { engine: "cmsis-f32", name: "F32", bytes: 4 + 4 },
];

/// The rows of CMSIS-DSP on this core for records of `n` samples; none for a core that it is not counted on.
///
/// # Errors
/// Its compiler or its sources cannot be had, or the emulator failed.
pub fn rows(core: &Core, n: usize) -> Result<Vec<Row>, RunError> {
    let mut rows = Vec::new();
    for numbers in &KINDS {
        let header = Header::BYTES;
        let Some(image) = toolchain::cmsis(core.target, numbers.name, n, header)? else { break };
        let outcome = capture(n)?.run(core.machine, &image, LIMIT, |_| {})?;
        let figures = figures(&outcome);
        let cycles = match Clock::of(core) {
            Some(clock) => modelled(core, &image, n, clock)?,
            None => Vec::new(),
        };
        let snr = snr_db(n, &outcome.results);
        let tables = Footprint::constants(&image)?;
        for (index, stage) in ["fft", "fft_peak"].into_iter().enumerate() {
            let ticks = figures.get(stage).and_then(|counts| counts.first()).copied().unwrap_or(0);
            let rate = core.machine.instructions_per_core_tick();
            let instructions = (ticks as f64 * rate).round() as u64;
            let median_cycles = cycles.get(index).copied();
            rows.push(Row {
                ram_bytes: Some(numbers.bytes * n as u64),
                table_bytes: Some(tables),
                snr_0_db: snr.first().copied(),
                snr_m40_db: snr.get(1).copied(),
                median_cycles,
                model_cycles: median_cycles
                    .map(cycles::range)
                    .or_else(|| cycles::rough(core, instructions)),
                ..Row::new(core.name, numbers.engine, n, stage, instructions)
            });
        }
    }
    Ok(rows)
}

/// The two exact records.
fn capture(n: usize) -> Result<Capture, RunError> {
    let config = Config::new(1.0, Codes::signed::<12>());
    let blocks = exact(n);
    let header = Header::of::<Real>(config, n as u32, blocks.len() as u32);
    let mut capture = Capture::create(&header)?;
    for block in &blocks {
        capture.push::<Real>(block)?;
    }
    Ok(capture)
}

/// The program says its figures by semihosting.
fn figures(outcome: &Outcome) -> Figures {
    let messages = String::from_utf8_lossy(&outcome.log).into_owned();
    Outcome { messages, ..outcome.clone() }.figures()
}

/// Cycles of the stages for the first record.
fn modelled(core: &Core, image: &Path, n: usize, clock: Clock) -> Result<Vec<u64>, RunError> {
    let mut trace = Trace::new(clock);
    capture(n)?.trace(core.machine, image, LIMIT, |line| trace.line(line))?;
    // Before each stage, the program reads its clock around nothing.
    let stages = trace.sections.as_chunks().0.iter();
    Ok(stages.map(|[nothing, stage]| stage.cycles.saturating_sub(nothing.cycles)).collect())
}

fn snr_db(n: usize, results: &[u8]) -> Vec<f64> {
    let bins = bins(results);
    exact(n).iter().zip(bins.chunks_exact(n / 2)).map(|(block, bins)| ratio(block, bins)).collect()
}
