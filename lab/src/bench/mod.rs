//! Instructions on emulated cores: every stage of a measurement, and other people's transforms beside it.
//!
//! What is counted are executed instructions, exactly (QEMU's instruction clock), not cycles: the
//! emulator knows no pipeline, no wait states and no cache. [`cycles`] models them from the program as it was executed.

pub mod cmsis;
pub mod command;
pub mod corpus;
pub mod cycles;
pub mod equality;
pub mod locked;
pub mod model;
pub mod plot;
pub mod precision;
pub mod quoted;
pub mod ranging;
pub mod row;
pub mod several;
pub mod size;
pub mod step;
pub mod table;
pub mod trace;
pub mod worst;

use crate::emulator::{Capture, Machine, RunError};
use crate::toolchain::{Firmware, Profile, Target, ToolError};
use model::Model;
use picket_dsp::Effort;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Real, Record};
use picket_dsp::config::Config;
use picket_dsp::spectrum::fft::twiddle;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::fit::Reach;
use picket_transform::Transform;
use picket_transform::num_complex::Complex;
use picket_wire::capture::Header;
pub use row::Row;
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A core and the emulated board that has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Core {
    /// What the table calls it.
    pub name: &'static str,
    /// The board.
    pub machine: Machine,
    /// What the image is built for.
    pub target: Target,
}

impl Core {
    /// Does it compute with floats?
    pub const fn has_fpu(&self) -> bool {
        matches!(self.target, Target::M4f | Target::M33 | Target::M55)
    }
}

/// The cores, the reference first. The M0's code runs on the M3's board: Armv6-M is a part of Armv7-M, so the
/// same instructions are executed, and the M0's own board has no memory for the longer records.
pub const CORES: [Core; 6] = [
    Core { name: "M4F", machine: Machine::An386, target: Target::M4f },
    Core { name: "M33", machine: Machine::An505, target: Target::M33 },
    Core { name: "M55", machine: Machine::An547, target: Target::M55 },
    Core { name: "M7", machine: Machine::An500, target: Target::M4f },
    Core { name: "M3", machine: Machine::An385, target: Target::M3 },
    Core { name: "M0", machine: Machine::An385, target: Target::M0 },
];

/// The record lengths.
pub const LENGTHS: [usize; 7] = [64, 128, 256, 512, 1024, 2048, 4096];

/// An engine of ours (see [`picket_dsp::spectrum::engine`]), and the image that counts it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Engine {
    /// What the table calls it.
    pub name: &'static str,
    /// The image.
    pub bin: &'static str,
}

impl Engine {
    /// Is the transform our own: are its loops to be compared with their definition, is its code ours to count?
    pub fn is_own(&self) -> bool {
        *self != FLOAT
    }

    /// Is it for this core? Floats are for those that compute with them.
    pub fn is_for(&self, core: &Core) -> bool {
        *self != FLOAT || core.has_fpu()
    }

    /// Bytes of the tables for a real record of `n` samples: factors of the passes and of the split.
    pub fn table_bytes(&self, n: usize) -> u64 {
        if *self == FLOAT {
            // The crate's one table: a quarter of a sine for 4096 points, without 0.
            return 4 * (4096 / 4 - 1);
        }
        let fine = twiddle::fine_passes(n / 2);
        let short = if fine.is_empty() { twiddle::passes(n / 2) } else { &[] };
        let splits = size_of_val(twiddle::splits(n)) + size_of_val(twiddle::sines(n));
        (size_of_val(short) + size_of_val(fine) + splits) as u64
    }
}

/// Our engines, the default first.
pub const ENGINES: [Engine; 2] = [Engine { name: "picket-i32", bin: "bench" }, FLOAT];

/// The one that is somebody else's transform.
pub const FLOAT: Engine = Engine { name: "picket-f32", bin: "bench_f32" };

/// Stages of a measurement by an engine of ours, as the image names them: the transform, the search for the peak and the noise floor,
/// both, what an estimate with sigma and verdict takes beyond them, the search for clipped samples, and all of it; and range
/// and velocity of a trapezoid's three tones, once a chirp.
pub const STAGES: [&str; 7] =
    ["fft", "peak", "fft_peak", "estimator", "clipped", "measurement", "chirp"];

/// The crates that are measured in the same run; their only stage is the transform of a real record.
pub const RIVALS: [&str; 4] = ["microfft", "fixed-fft", "fixed-dsp-q15", "fixed-dsp-q31"];

/// The seed of the records that are counted.
pub const SEED: u64 = 2;
/// Records whose spectra are compared with exact ones, before those that are counted.
const EXACT: usize = 2;
const LIMIT: Duration = Duration::from_secs(300);

/// What an image counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Every length, and the other people's transforms in the default engine's image.
    All,
    /// Every length of ours.
    Ours,
    /// The default engine, real records of 1,024 samples alone: built in a tenth of the time.
    Short,
    /// Transform and search alone, of every length, and of both engines of ours: built in a tenth of the time, too.
    Kernels,
}

/// The image that counts an engine.
pub fn image(core: &Core, engine: &Engine, scope: Scope) -> Result<PathBuf, ToolError> {
    let features: &[&str] = match scope {
        Scope::All if *engine == ENGINES[0] => &["mps2", "rivals"],
        _ => &["mps2"],
    };
    let bin = match scope {
        Scope::Short => "bench_short",
        Scope::Kernels => "kernels",
        _ => engine.bin,
    };
    Firmware { bin, target: core.target, features, profile: Profile::Release }.build()
}

/// What the image counted.
#[derive(Clone, Debug)]
pub struct Count {
    core: Core,
    engine: Engine,
    n: usize,
    figures: Figures,
    /// Whether each record of the corpus has a sample at a rail.
    clipped: Vec<bool>,
    /// Ours and the rivals', full scale and 40 dB below.
    snr_db: HashMap<String, [f64; 2]>,
}

/// Counts the instructions for records of `n` samples, and drives kernels and definition with `random` blocks.
pub fn count(
    core: &Core,
    engine: &Engine,
    image: &Path,
    n: usize,
    how: How,
    random: u32,
) -> Result<Count, RunError> {
    let config = config(core, how);
    let corpus = corpus::corpus(n, SEED);
    let clipped = corpus.iter().map(|entry| entry.clipped).collect();
    let mut blocks = Vec::from(exact(n));
    blocks.extend(corpus.into_iter().map(|entry| entry.samples));
    let count = blocks.len() as u32;
    let header =
        Header { period_us: random, ..Header::from_config::<Real>(config, n as u32, count) };
    let (figures, results) = run::<Real>(core, image, &header, &blocks, |_| {})?;
    let snr_db = ratios(engine, n, &blocks, &figures, &results);
    Ok(Count { core: *core, engine: *engine, n, figures, clipped, snr_db })
}

/// How a measurement is made, beside what the core says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct How {
    /// The bins that least squares reads.
    pub reach: Reach,
    /// How closely a line that is no steady tone is looked at.
    pub effort: Effort,
    /// The converter's codes.
    pub codes: Codes,
}

impl Default for How {
    fn default() -> Self {
        Self { reach: Reach::default(), effort: Effort::default(), codes: Codes::signed::<12>() }
    }
}

fn config(core: &Core, How { reach, effort, codes }: How) -> Config {
    let arithmetic = if core.has_fpu() { Arithmetic::Float } else { Arithmetic::Fixed };
    Config { reach, arithmetic, effort, ..Config::new(1.0, codes) }
}

/// How many instructions a stage takes at most where only these bins of a record of `n` samples are searched. The tone is at a tenth of them all.
pub fn in_band<R: Record>(
    core: &Core,
    image: &Path,
    n: usize,
    bins: RangeInclusive<u32>,
    stage: &str,
) -> Result<u64, RunError> {
    // At this rate a bin is a hertz.
    let band_hz = Some(((*bins.start()).into(), (*bins.end()).into()));
    let config = Config { band_hz, ..Config::new(n as f64, Codes::signed::<12>()) };
    let pairs = |block: Vec<i16>| block.iter().map(|&code| R::from_parts([code; 2])).collect();
    let blocks = exact(n).map(pairs);
    let header =
        Header { period_us: 0, ..Header::from_config::<R>(config, n as u32, blocks.len() as u32) };
    let (figures, _) = run::<R>(core, image, &header, &blocks, |_| {})?;
    let most = figures.get(stage).and_then(|ticks| ticks.iter().max());
    Ok((*most.unwrap_or(&0) as f64 * core.machine.instructions_per_tick()).round() as u64)
}

/// What an image has counted, by name, block by block.
type Figures = HashMap<String, Vec<u64>>;

/// What an image counts of these blocks, and its results. `tell` gets what it sends meanwhile.
fn run<R: Record>(
    core: &Core,
    image: &Path,
    header: &Header,
    blocks: &[Vec<R::Sample>],
    tell: impl FnMut(&[u8]),
) -> Result<(Figures, Vec<u8>), RunError> {
    let mut capture = Capture::create(header)?;
    for block in blocks {
        capture.push::<R>(block)?;
    }
    // The random blocks of a long run take their time.
    let limit = LIMIT + header.period_us * Duration::from_millis(20);
    let outcome = capture.run(core.machine, image, limit, tell)?;
    Ok((outcome.figures(), outcome.results))
}

/// The median; `None` of nothing.
fn median(counts: impl Iterator<Item = u64>) -> Option<u64> {
    let mut counts: Vec<u64> = counts.collect();
    let middle = counts.len() / 2;
    (!counts.is_empty()).then(|| *counts.select_nth_unstable(middle).1)
}

fn equality(figures: &Figures) -> (u64, u64) {
    // One figure for each engine that the image has.
    let figure = |name| figures.get(name).map_or(u64::MAX, |each| each.iter().sum());
    (figure("compared"), figure("unequal"))
}

/// A full-scale tone, which just does not touch a rail, and one 40 dB below, without noise but for
/// their rounding.
fn exact(n: usize) -> [Vec<i16>; EXACT] {
    [2046.4, 20.464].map(|amplitude| {
        let turns = |index: usize| (0.0983 * n as f64 + 0.3) * index as f64 / n as f64;
        (0..n).map(|i| (amplitude * (TAU * turns(i) + 0.3).cos()).round() as i16).collect()
    })
}

/// Signal-to-error ratios of every transform that was run, over the bins between DC and Nyquist. Each engine scales
/// in its own way, so the gain that fits best is taken out.
fn ratios(
    ours: &Engine,
    n: usize,
    blocks: &[Vec<i16>],
    figures: &Figures,
    results: &[u8],
) -> HashMap<String, [f64; 2]> {
    let names = RIVALS.into_iter().filter(|name| figures.contains_key(*name));
    let names: Vec<&str> = std::iter::once(ours.name).chain(names).collect();
    let values = bins(results);
    let mut ratios = HashMap::new();
    for (index, spectrum) in values.chunks_exact(n / 2).enumerate() {
        let (block, engine) = (index / names.len(), index % names.len());
        let Some(samples) = blocks.get(block) else { break };
        if block < 2 {
            let pair: &mut [f64; 2] = ratios.entry(names[engine].to_owned()).or_default();
            pair[block] = ratio(samples, spectrum);
        }
    }
    ratios
}

/// The bins that an image has written.
fn bins(results: &[u8]) -> Vec<Complex<f64>> {
    let float = |bytes: &[u8; 4]| f64::from(f32::from_le_bytes(*bytes));
    let parts = results.as_chunks::<4>().0.as_chunks::<2>().0;
    parts.iter().map(|[re, im]| Complex::new(float(re), float(im))).collect()
}

fn ratio(samples: &[i16], got: &[Complex<f64>]) -> f64 {
    let mut exact: Vec<Complex<f64>> = samples.iter().map(|&x| f64::from(x).into()).collect();
    f64::forward(exact.len()).process(&mut exact);
    let bins = || exact.iter().zip(got).skip(1);
    let signal: f64 = bins().map(|(x, _)| x.norm_sqr()).sum();
    let gain = bins().map(|(x, y)| (y * x.conj()).re).sum::<f64>() / signal;
    let error: f64 = bins().map(|(x, y)| (y - x * gain).norm_sqr()).sum();
    10.0 * (gain * gain * signal / error).log10()
}

impl Count {
    /// The instructions of a stage: the median over the records that are not clipped.
    pub fn median(&self, stage: &str) -> Option<u64> {
        median(self.each(stage, false))
    }

    /// What 95 of 100 records that are not clipped take at the most in a stage.
    pub fn most_of_95(&self, stage: &str) -> Option<u64> {
        let mut each: Vec<u64> = self.each(stage, false).collect();
        each.sort_unstable();
        each.get((each.len() * 95).div_ceil(100).saturating_sub(1)).copied()
    }

    /// The most instructions that a stage took, of the records that are clipped or of the others.
    pub fn worst(&self, stage: &str, clipped: bool) -> Option<u64> {
        self.each(stage, clipped).max()
    }

    /// The instructions of a stage, record by record of the corpus. A rival is counted in the
    /// first records alone, because no transform depends on its data.
    pub fn each(&self, stage: &str, clipped: bool) -> impl Iterator<Item = u64> {
        let rate = self.core.machine.instructions_per_tick();
        let counts = self.figures.get(stage).map_or(&[][..], Vec::as_slice);
        let skipped = if counts.len() > EXACT { EXACT } else { 0 };
        let kinds = self.clipped.iter().copied().chain(std::iter::repeat(false));
        let chosen = counts[skipped..].iter().zip(kinds).filter(move |&(_, kind)| kind == clipped);
        chosen.map(move |(&ticks, _)| (ticks as f64 * rate).round() as u64)
    }

    /// The ratio of a full-scale tone to the error of our transform, and of one 40 dB below, in dB.
    pub fn snr_db(&self) -> Option<[f64; 2]> {
        self.snr_db.get(self.engine.name).copied()
    }

    /// How many blocks were transformed by kernel and definition, and how many of them differed.
    pub fn equality(&self) -> (u64, u64) {
        equality(&self.figures)
    }

    /// Bytes of a pipeline's memory with two records for the converter to fill in turn, and its result.
    pub fn pipeline_bytes(&self) -> Option<u64> {
        let own = *self.figures.get("pipeline_bytes")?.last()?;
        Some(own + 2 * 2 * self.n as u64 + size_of::<picket_dsp::pipeline::Measurement>() as u64)
    }

    /// Every stage of ours, then the rivals'.
    pub fn rows(&self, model: Option<&Model>) -> Vec<Row> {
        let snr = |engine: &str, which: usize| self.snr_db.get(engine).map(|pair| pair[which]);
        let spectrum = self.figures.get("spectrum_bytes").and_then(|f| f.last().copied());
        let row = |engine: &str, stage: &str, name: &str| {
            let ours = engine == self.engine.name;
            let instructions = self.median(name)?;
            let transform = stage.starts_with("fft");
            let median_cycles = model.and_then(|model| model.median(name));
            Some(Row {
                most_of_95: self.most_of_95(name).filter(|_| ours),
                worst: self.worst(name, false).filter(|_| ours),
                worst_clipped: self.worst(name, true).filter(|_| ours),
                ram_bytes: match (ours, stage) {
                    (true, "measurement") => self.pipeline_bytes(),
                    (true, _) => spectrum.map(|bytes| bytes + 2 * self.n as u64),
                    (false, _) => quoted::ram(engine, self.n),
                },
                table_bytes: ours.then(|| self.engine.table_bytes(self.n)),
                snr_0_db: snr(engine, 0).filter(|_| transform),
                snr_m40_db: snr(engine, 1).filter(|_| transform),
                median_cycles,
                model_cycles: median_cycles
                    .map(cycles::range)
                    .or_else(|| cycles::rough(&self.core, instructions)),
                ..Row::new(self.core.name, engine, self.n, stage, instructions)
            })
        };
        let ours = STAGES.iter().filter_map(|stage| row(self.engine.name, stage, stage));
        ours.chain(RIVALS.iter().filter_map(|rival| row(rival, "fft", rival))).collect()
    }
}
