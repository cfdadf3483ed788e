//! CMSIS-DSP, counted in the same run: its program is `lab/cmsis/bench.c`.

use super::cycles::{self, Clock};
use super::trace::Trace;
use super::{Core, Figures, LIMIT, Row, bins, exact, ratio};
use crate::emulator::{Capture, Footprint, Outcome, RunError};
use crate::toolchain;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::Config;
use picket_transform::num_complex::Complex;
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

/// What the program counts of each record: the transform; with the largest bin; with the offset from that.
const STAGES: usize = 3;

/// The rows of CMSIS-DSP on this core for records of `n` samples; none for a core that it is not counted on.
///
/// # Errors
/// Its compiler or its sources cannot be had, or the emulator failed.
pub fn rows(core: &Core, n: usize) -> Result<Vec<Row>, RunError> {
    let mut rows = Vec::new();
    for numbers in &KINDS {
        let header = Header::BYTES;
        let Some(image) = toolchain::cmsis(core.target, numbers.name, n, header)? else { break };
        let outcome = capture(n, &exact(n))?.run(core.machine, &image, LIMIT, |_| {})?;
        let figures = figures(&outcome);
        let cycles = match Clock::of(core) {
            Some(clock) => modelled(core, &image, capture(n, &exact(n))?, clock)?,
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

/// What the frequency of tones takes by one kind of numbers.
pub(super) struct Tones {
    /// What the table calls it.
    pub engine: &'static str,
    /// The cycles of the first so many of both sets.
    pub cycles: Vec<u64>,
    /// The frequencies of all, in bins.
    pub found: [Vec<f64>; 2],
}

/// What the frequency takes of two sets of tones, the first `followed` of each in cycles, too. None for a core that the library is not
/// counted on, or whose timing is not published.
pub(super) fn frequencies(
    core: &Core,
    n: usize,
    sets: &[Vec<Vec<i16>>; 2],
    followed: usize,
) -> Result<Vec<Tones>, RunError> {
    let mut all = Vec::new();
    let Some(clock) = Clock::of(core) else { return Ok(all) };
    for numbers in &KINDS {
        let header = Header::BYTES;
        let Some(image) = toolchain::cmsis(core.target, numbers.name, n, header)? else { break };
        let first: Vec<_> =
            sets.iter().flat_map(|set| set.iter().take(followed).cloned()).collect();
        let cycles = modelled(core, &image, capture(n, &first)?, clock.clone())?;
        let cycles = cycles.into_iter().skip(2).step_by(STAGES).collect();
        let found = |set: &[Vec<i16>]| -> Result<Vec<f64>, RunError> {
            let outcome = capture(n, set)?.run(core.machine, &image, LIMIT, |_| {})?;
            let bins = bins(&outcome.results);
            Ok(records(&bins, n).map(|(_, place)| place.re + place.im).collect())
        };
        let [one, other] = sets;
        all.push(Tones { engine: numbers.engine, cycles, found: [found(one)?, found(other)?] });
    }
    Ok(all)
}

/// A capture of these records.
pub(super) fn capture(n: usize, blocks: &[Vec<i16>]) -> Result<Capture, RunError> {
    let config = Config::new(1.0, Codes::signed::<12>());
    let header = Header::from_config::<Real>(config, n as u32, blocks.len() as u32);
    let mut capture = Capture::create(&header)?;
    for block in blocks {
        capture.push::<Real>(block)?;
    }
    Ok(capture)
}

/// The program says its figures by semihosting.
fn figures(outcome: &Outcome) -> Figures {
    let messages = String::from_utf8_lossy(&outcome.log).into_owned();
    Outcome { messages, ..outcome.clone() }.figures()
}

/// Cycles of the stages, record by record.
fn modelled(
    core: &Core,
    image: &Path,
    capture: Capture,
    clock: Clock,
) -> Result<Vec<u64>, RunError> {
    let mut trace = Trace::new(clock);
    capture.trace(core.machine, image, LIMIT, |line| trace.line(line))?;
    // Before each stage, the program reads its clock around nothing.
    let stages = trace.sections.as_chunks().0.iter();
    Ok(stages.map(|[nothing, stage]| stage.cycles.saturating_sub(nothing.cycles)).collect())
}

fn snr_db(n: usize, results: &[u8]) -> Vec<f64> {
    let bins = bins(results);
    exact(n).iter().zip(records(&bins, n)).map(|(block, (bins, _))| ratio(block, bins)).collect()
}

/// Of each record the bins of its spectrum, and the largest bin with the offset from it.
fn records(
    bins: &[Complex<f64>],
    n: usize,
) -> impl Iterator<Item = (&[Complex<f64>], Complex<f64>)> {
    bins.chunks_exact(n / 2 + 1).filter_map(|record| {
        let (place, spectrum) = record.split_last()?;
        Some((spectrum, *place))
    })
}
