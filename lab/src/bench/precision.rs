//! Cycles and error side by side: what the frequency of a tone takes by each program, and how far off it is.
//!
//! The tones lie anywhere in the middle half of the spectrum, where a real tone's mirror image disturbs the others' interpolation least, at
//! full scale. Ours answers with sigma and verdict beside the frequency, which the others do not.

use super::cmsis::{self, capture};
use super::model::{self, LIMIT};
use super::{Core, ENGINES, How, SEED, Scope, bins, config, image, median};
use crate::arithmetic::{Arithmetic, Engine, engine};
use crate::emulator::RunError;
use crate::estimator::Estimator;
use crate::plot::chart::{Axis, Chart, Series, Style};
use crate::simulate::{Signal, Width, generator};
use crate::sweep::full_amplitude;
use crate::toolchain::{Firmware, Profile};
use picket_dsp::Effort;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Real;
use picket_dsp::tone::fit::Reach;
use picket_dsp::tone::sigma::bound_bins;
use picket_transform::num_complex::Complex;
use rand::RngExt;
use serde::Serialize;

/// The signal-to-noise ratios, dB.
pub const SNR_DB: [f64; 2] = [20.0, 40.0];
/// Before the effort, where the program is ours.
const OURS: &str = "picket ";
/// Tones at each of them.
pub const TONES: usize = 2000;
/// Tones at each of them whose cycles are modelled. Programs of others take hardly more for one record than for another.
const FOLLOWED: usize = 8;

/// What a program takes for records of a length, and how far off it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The core's name.
    pub core: &'static str,
    /// Whose program: ours with its effort, or another transform.
    pub program: String,
    /// Samples in a record.
    pub n: usize,
    /// Modelled cycles from the record to the frequency: the median of the tones that were followed.
    pub cycles: u64,
    /// The rms error over the Cramer-Rao bound at each of [`SNR_DB`].
    pub errors: [f64; 2],
}

/// Tones' frequencies in bins, and their records.
type Tones = (Vec<f64>, Vec<Vec<i16>>);

/// The tones of this length at a signal-to-noise ratio.
fn tones(n: usize, snr_db: f64) -> Tones {
    let width = Width::Codes(Codes::signed::<12>());
    let tone = |number| {
        let mut rng = generator(SEED ^ n as u64, number);
        let bins = n as f64 * rng.random_range(0.125..0.375);
        let signal = Signal::tone(bins, full_amplitude(width, snr_db), snr_db);
        (bins, signal.codes::<Real>(n, &mut rng))
    };
    (0..TONES as u64).map(tone).unzip()
}

/// The rms error over the bound.
fn error(n: usize, snr_db: f64, tones: &[f64], found: &[f64]) -> f64 {
    let squares: f64 = tones.iter().zip(found).map(|(bins, found)| (bins - found).powi(2)).sum();
    let bound = bound_bins(false, n, 10f64.powf(snr_db / 10.0) as f32);
    (squares / tones.len() as f64).sqrt() / f64::from(bound)
}

/// All programs on this core, for records of `n` samples; and why CMSIS-DSP is not among them.
///
/// # Errors
/// An image of ours cannot be built, or the emulator failed.
pub fn points(core: &Core, n: usize) -> Result<(Vec<Point>, Option<RunError>), String> {
    let [(low, first), (high, second)] = SNR_DB.map(|snr_db| tones(n, snr_db));
    let (tones, sets) = ([low, high], [first, second]);
    let point = |program: String, cycles: Vec<u64>, found: [Vec<f64>; 2]| {
        let errors = std::array::from_fn(|at| error(n, SNR_DB[at], &tones[at], &found[at]));
        let cycles = median(cycles.into_iter()).unwrap_or_default();
        Point { core: core.name, program, n, cycles, errors }
    };
    let mut points = Vec::new();
    for effort in [Effort::LOOK, Effort::TWO] {
        let (cycles, found) = ours(core, n, effort, &sets)?;
        points.push(point(format!("{OURS}{}", effort.name()), cycles, found));
    }
    let (cycles, found) = microfft(core, n, &sets).map_err(|error| error.to_string())?;
    points.push(point("microfft".into(), cycles, found));
    let missing = match cmsis::frequencies(core, n, &sets, FOLLOWED) {
        Ok(all) => {
            let each = all.into_iter();
            points.extend(each.map(|tones| point(tones.engine.into(), tones.cycles, tones.found)));
            None
        }
        Err(error) => Some(error),
    };
    Ok((points, missing))
}

/// The records whose cycles are modelled.
fn followed(sets: &[Vec<Vec<i16>>; 2]) -> Vec<&[i16]> {
    sets.iter().flat_map(|set| set.iter().take(FOLLOWED)).map(Vec::as_slice).collect()
}

/// Ours: cycles on the core, and frequencies by this machine, which has the same bits.
fn ours(
    core: &Core,
    n: usize,
    effort: Effort,
    sets: &[Vec<Vec<i16>>; 2],
) -> Result<(Vec<u64>, [Vec<f64>; 2]), String> {
    let how = How { effort, ..How::default() };
    let told = |error: RunError| error.to_string();
    let image = image(core, &ENGINES[0], Scope::Ours).map_err(|error| error.to_string())?;
    let stages = model::stages::<Real>(core, &image, n, how, &followed(sets)).map_err(told)?;
    let sections = stages.unwrap_or_default().remove("measurement").unwrap_or_default();
    let cycles = sections.iter().map(|section| section.cycles).collect();
    let plan = config(core, how).terms::<Real>(n).map_err(|error| error.message().to_owned())?;
    let mut engine = engine::<Real>(Arithmetic::Target, n, plan)?;
    Ok((cycles, sets.each_ref().map(|set| measured(engine.as_mut(), set))))
}

fn measured(engine: &mut dyn Engine, records: &[Vec<i16>]) -> Vec<f64> {
    let method = [Estimator::best(false, Reach::default())];
    let each = records.iter().map(|record| {
        let record: Vec<Complex<f64>> = record.iter().map(|&x| f64::from(x).into()).collect();
        engine.measure(&record, &method, false).first().map_or(f64::NAN, |answer| answer.bins)
    });
    each.collect()
}

fn microfft(
    core: &Core,
    n: usize,
    sets: &[Vec<Vec<i16>>; 2],
) -> Result<(Vec<u64>, [Vec<f64>; 2]), RunError> {
    let (bin, features, profile) = ("bench_microfft", &["mps2", "rivals"], Profile::Release);
    let image = Firmware { bin, target: core.target, features, profile }.build()?;
    let how = How::default();
    let stages = model::stages::<Real>(core, &image, n, how, &followed(sets))?;
    let sections = stages.unwrap_or_default().remove("frequency").unwrap_or_default();
    let cycles = sections.iter().map(|section| section.cycles).collect();
    let found = |set: &[Vec<i16>]| -> Result<Vec<f64>, RunError> {
        let results = capture(n, set)?.run(core.machine, &image, LIMIT, |_| {})?.results;
        Ok(bins(&results).iter().map(|place| place.re + place.im).collect())
    };
    let [one, other] = sets;
    Ok((cycles, [found(one)?, found(other)?]))
}

/// Cycles in thousands, and the errors.
type Places = Vec<(f64, [f64; 2])>;

/// The error over the cycles, of each program from the shortest record to the longest. Efforts that take the same are drawn once.
pub fn chart(points: &[Point]) -> Chart {
    let mut programs: Vec<(String, Places)> = Vec::new();
    let mut names: Vec<&str> = Vec::new();
    for point in points {
        let name = point.program.as_str();
        if names.contains(&name) {
            continue;
        }
        names.push(name);
        let own = points.iter().filter(|point| point.program == name);
        let own: Places = own.map(|point| (point.cycles as f64 / 1e3, point.errors)).collect();
        match (programs.iter_mut().find(|(_, places)| *places == own), name.strip_prefix(OURS)) {
            (Some((label, _)), Some(effort)) => *label += &format!("/{effort}"),
            _ => programs.push((name.to_owned(), own)),
        }
    }
    let series = programs.iter().enumerate().flat_map(|(colour, (label, places))| {
        [(1, Style::Marked), (0, Style::Dashed)].map(|(at, style)| {
            let places = places.iter().map(|&(cycles, errors)| (cycles, errors[at]));
            Series::new(format!("{label}, {} dB", SNR_DB[at]), style, colour, places)
        })
    });
    let cycles = points.iter().map(|point| point.cycles as f64 / 1e3);
    let (few, most) =
        cycles.fold((f64::INFINITY, 1.0), |(few, most), x| (f64::min(few, x), f64::max(most, x)));
    let worst = points.iter().flat_map(|point| point.errors).fold(1.0, f64::max);
    Chart {
        name: "cycles-error",
        title: "The frequency of a tone: error over cycles of a Cortex-M4F, N = 64 to 4096 from the left".into(),
        x: Axis::log("modelled cycles, thousands", 0.9 * few, 1.1 * most),
        y: Axis::linear("rms error / Cramer-Rao bound", 0.8, worst + 0.1),
        series: series.collect(),
    }
}
