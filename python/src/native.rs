//! A configuration, and the work that is done with it on arrays of words, without Python's lock.

use crate::blocks::{Blocks, Harmonics, Lines};
use crate::bursts::{BurstRow, Bursts};
use crate::explain::{Explain, Heard};
use crate::frames::{Found, Frames, Framing, Wanted};
use crate::phases::{Asked, Phases};
use crate::sums::Sums;
use crate::tables::{ToneRow, table};
use crate::terms::{self, SceneTerms};
use crate::tracks::Follow;
use crate::views::{self, Told};
use crate::wrong;
use numpy::{PyArray2, PyReadonlyArray1};
use picket_dsp::acquire::frontend::Timing;
use picket_dsp::acquire::kind::{ForRecord, for_record};
use picket_dsp::num_complex::Complex;
use picket_dsp::solve::phase_range::Calibration;
use picket_dsp::spectrum::engine::Engine;
use picket_dsp::{
    Arithmetic, Carrier, Chirp, Config, ConfigError, Effort, F32, Following, I32, Plan, Record,
    Scene, Segment, Stamp, Trigger,
};
use picket_wire::view;
use pyo3::prelude::*;

/// The engines by their names.
#[derive(Clone, Copy)]
enum Transform {
    I32,
    F32,
}

/// What a user set, checked.
#[pyclass(frozen, module = "picket_dsp._picket")]
pub struct Native {
    pub config: Config,
    pub n: usize,
    pub iq: bool,
    transform: Transform,
}

/// Work with a configuration whose kind of record, length and engine are known only at run time.
pub trait Work {
    type Output;
    fn run<R: Record, const N: usize, E: Engine>(
        self,
        native: &Native,
        plan: Plan<R, N>,
    ) -> Self::Output;
}

/// Work by the engine of its configuration.
struct Engined<'a, W>(&'a Native, W);

impl<W: Work> ForRecord for Engined<'_, W> {
    type Output = Result<W::Output, ConfigError>;

    fn run<R: Record, const N: usize>(self) -> Self::Output {
        let Self(native, work) = self;
        let plan = native.config.plan::<R, N>()?;
        Ok(match native.transform {
            Transform::I32 => work.run::<R, N, I32>(native, plan),
            Transform::F32 => work.run::<R, N, F32>(native, plan),
        })
    }
}

/// Nothing but the check that there is a plan.
struct Check;

impl Work for Check {
    type Output = ();
    fn run<R: Record, const N: usize, E: Engine>(self, _: &Native, _: Plan<R, N>) {}
}

#[pymethods]
impl Native {
    #[new]
    #[pyo3(signature = (n, rate_hz, low, high, iq, engine, arithmetic, effort, band_hz, false_alarm, scene, following, carrier, method))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        n: usize,
        rate_hz: f64,
        low: i16,
        high: i16,
        iq: bool,
        engine: &str,
        arithmetic: &str,
        effort: u8,
        band_hz: Option<(f64, f64)>,
        false_alarm: Option<f64>,
        scene: Option<SceneTerms>,
        following: Option<(f32, u8, u8)>,
        carrier: (f32, f32),
        method: &str,
    ) -> PyResult<Self> {
        let codes = terms::codes(low, high).map_err(wrong)?;
        let mut config = Config { band_hz, ..Config::new(rate_hz, codes) };
        config.arithmetic = match arithmetic {
            "float" => Arithmetic::Float,
            "fixed" => Arithmetic::Fixed,
            _ => return Err(wrong(format!("arithmetic is float or fixed, not {arithmetic}"))),
        };
        config.effort = Effort::from_rounds(effort).ok_or_else(|| {
            wrong(format!("effort is a number of rounds from 0 to 3, not {effort}"))
        })?;
        let transform = match engine {
            "i32" => Transform::I32,
            "f32" => Transform::F32,
            _ => return Err(wrong(format!("engine is i32 or f32, not {engine}"))),
        };
        if let Some(probability) = false_alarm {
            config.false_alarm = probability;
        }
        if let Some(terms) = scene {
            config.scene = terms::scene(&terms).map_err(wrong)?;
            [config.range_m, config.velocity_mps] = terms.9;
        }
        if let Some((rate_bins, most, refresh)) = following {
            config.following = Following { rate_bins, most, refresh };
        }
        let (linewidth_hz, envelope_hz) = carrier;
        config.carrier = Carrier { linewidth_hz, envelope_hz };
        config.method = method.parse().map_err(wrong)?;
        let native = Self { config, n, iq, transform };
        native.work(Check)?;
        Ok(native)
    }

    /// The strongest tone of every block and its outcome, on this many threads. `missing` has the numbers of missing samples,
    /// in order.
    fn blocks<'py>(
        &self,
        py: Python<'py>,
        words: PyReadonlyArray1<'py, i16>,
        hop: usize,
        phase: bool,
        threads: usize,
        missing: Vec<u64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let words = words.as_slice().map_err(wrong)?;
        let work = Blocks { words, hop, phase, threads, missing: &missing };
        table(py, py.detach(|| self.work(work))?)
    }

    /// The fundamental of every block's harmonics up to an order: the block's first sample, the orders seen, and the tone.
    fn harmonics<'py>(
        &self,
        py: Python<'py>,
        words: PyReadonlyArray1<'py, i16>,
        hop: usize,
        order: u32,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let work = Harmonics { words: words.as_slice().map_err(wrong)?, hop, order };
        table(py, py.detach(|| self.work(work))?)
    }

    /// All tones of one block.
    fn lines<'py>(
        &self,
        py: Python<'py>,
        words: PyReadonlyArray1<'py, i16>,
        most: usize,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let work = Lines { words: words.as_slice().map_err(wrong)?, most };
        table(py, py.detach(|| self.work(work))?)
    }

    /// One block's tone, and every test behind its verdict: fit, name, value, limit, whether the value exceeds it.
    fn explain<'py>(
        &self,
        py: Python<'py>,
        words: PyReadonlyArray1<'py, i16>,
    ) -> PyResult<(ToneRow, Vec<Heard>)> {
        let work = Explain { words: words.as_slice().map_err(wrong)? };
        py.detach(|| self.work(work))
    }

    /// Tones followed from block to block: the rows of the blocks, of the tracks, and of the targets.
    #[allow(clippy::type_complexity)]
    fn track<'py>(
        &self,
        py: Python<'py>,
        words: PyReadonlyArray1<'py, i16>,
        hop: usize,
    ) -> PyResult<[Bound<'py, PyArray2<f64>>; 3]> {
        let work = Follow { native: self, words: words.as_slice().map_err(wrong)?, hop };
        let followed = py.detach(|| self.usual(work))?;
        Ok([table(py, followed.blocks)?, table(py, followed.tracks)?, table(py, followed.targets)?])
    }

    /// Sums of this many blocks: the first block's first sample, the blocks, the logarithm of the chance, and the tone.
    #[pyo3(signature = (words, hop, blocks, segment, drift_bins, false_alarm))]
    #[allow(clippy::too_many_arguments)]
    fn sums<'py>(
        &self,
        py: Python<'py>,
        words: PyReadonlyArray1<'py, i16>,
        hop: usize,
        blocks: u32,
        segment: u8,
        drift_bins: f32,
        false_alarm: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let words = words.as_slice().map_err(wrong)?;
        let segment = Segment::from_u8(segment).ok_or_else(|| wrong("there is no such segment"))?;
        let work = Sums { words, hop, blocks, segment, drift_bins, false_alarm };
        table(py, py.detach(|| self.work(work))?)
    }

    /// The bursts of a stream, and what was counted: samples, bursts, lost and long ones, dead samples.
    #[pyo3(signature = (words, ratio, hold_off, least, missing))]
    #[allow(clippy::type_complexity)]
    fn bursts<'py>(
        &self,
        py: Python<'py>,
        words: PyReadonlyArray1<'py, i16>,
        ratio: Option<f32>,
        hold_off: u32,
        least: u32,
        missing: Vec<u64>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, [u64; 5])> {
        let words = words.as_slice().map_err(wrong)?;
        let trigger = Trigger { ratio, hold_off, least };
        let work = Bursts { native: self, words, trigger, missing: &missing };
        let (rows, counts): (Vec<BurstRow>, _) = py.detach(|| self.usual(work))?;
        Ok((table(py, rows)?, counts))
    }

    /// Targets of frames of chirps that follow one another: names of the columns, and rows.
    #[pyo3(signature = (words, framing, background))]
    fn frames<'py>(
        &self,
        py: Python<'py>,
        words: PyReadonlyArray1<'py, i16>,
        framing: FramingTerms,
        background: Vec<[f32; 2]>,
    ) -> PyResult<(Vec<String>, Bound<'py, PyArray2<f64>>)> {
        let words = words.as_slice().map_err(wrong)?;
        let framing = self::framing(&framing)?;
        let background: Vec<_> =
            background.into_iter().map(|[re, im]| Complex::new(re, im)).collect();
        let wanted = Wanted::Targets(&background);
        let work = Frames { native: self, words, framing: &framing, wanted };
        let found = py.detach(|| self.usual(work))?;
        let columns =
            Framing::columns(framing.uncertainty.is_some(), framing.calibration.is_some());
        let rows = views::table(py, found.rows, columns.len())?;
        Ok((columns, rows))
    }

    /// What stands still in the first frame, a number for each kept bin, and its share of the power.
    fn background(
        &self,
        words: PyReadonlyArray1<'_, i16>,
        framing: FramingTerms,
    ) -> PyResult<(Vec<[f32; 2]>, f32)> {
        let words = words.as_slice().map_err(wrong)?;
        let framing = self::framing(&framing)?;
        let work = Frames { native: self, words, framing: &framing, wanted: Wanted::Background };
        let found = self.usual(work)?;
        Ok((found.background.into_iter().map(|it| [it.re, it.im]).collect(), found.share))
    }

    /// Checks the terms of frames. Returns the distance between aliases of a velocity, m/s, and how many bins are kept.
    fn framing(&self, framing: FramingTerms) -> PyResult<(f32, usize)> {
        let framing = self::framing(&framing)?;
        let work = Frames { native: self, words: &[], framing: &framing, wanted: Wanted::Plan };
        let Found { alias_mps, bins, .. } = self.usual(work)?;
        Ok((alias_mps, bins))
    }

    /// What the phases of blocks tell: names of the columns, and rows.
    #[pyo3(signature = (words, hop, asked, missing))]
    fn phases<'py>(
        &self,
        py: Python<'py>,
        words: PyReadonlyArray1<'py, i16>,
        hop: usize,
        asked: AskedTerms,
        missing: Vec<u64>,
    ) -> PyResult<(Vec<String>, Bound<'py, PyArray2<f64>>)> {
        let words = words.as_slice().map_err(wrong)?;
        let (name, known, [first, second]) = asked;
        let asked = match name.as_str() {
            "ranges" => Asked::Ranges(calibration(&known)?),
            "calibration" => Asked::Calibration { known_m: first, sigma_m: second as f32 },
            "way" => Asked::Way { most_turns: first as f32 },
            "sequence" => Asked::Sequence { period: first as u32 },
            _ => return Err(wrong(format!("nothing is called {name}"))),
        };
        let work = Phases { native: self, words, hop, asked, missing: &missing };
        let rows = py.detach(|| self.usual(work))?;
        let columns = asked.columns();
        let rows = views::table(py, rows, columns.len())?;
        Ok((columns, rows))
    }
}

/// Chirps, period in s, bins, probability of a false alarm, and by their names the standard deviations of what is not known and a
/// calibration.
type FramingTerms = (usize, f64, Option<(i32, i32)>, Option<f64>, Option<Told>, Option<Told>);

/// What is asked of phases: its name, a calibration, and two numbers.
type AskedTerms = (String, Told, [f64; 2]);

fn framing(terms: &FramingTerms) -> PyResult<Framing> {
    let (chirps, period_s, bins, false_alarm, known, calibrated) = terms;
    Ok(Framing {
        chirps: *chirps,
        period_s: *period_s,
        bins: *bins,
        false_alarm: *false_alarm,
        uncertainty: known.as_ref().map(views::uncertainty).transpose()?,
        calibration: calibrated.as_ref().map(calibration).transpose()?,
    })
}

fn calibration(told: &Told) -> PyResult<Calibration> {
    Ok(Calibration::from(&views::told::<view::Calibration>(told)?))
}

impl Native {
    /// Does the work by the configuration's engine.
    fn work<W: Work>(&self, work: W) -> PyResult<W::Output> {
        self.usual(Engined(self, work))
    }

    /// Does work that knows its engine.
    fn usual<T, W>(&self, work: W) -> PyResult<T>
    where
        W: ForRecord<Output = Result<T, ConfigError>>,
    {
        let done = for_record(self.iq, self.n, work);
        done.ok_or_else(|| wrong(terms::length(self.n)))?.map_err(|error| self.refused(error))
    }

    /// An error with the arguments that it is about.
    fn refused(&self, error: ConfigError) -> PyErr {
        let Config { rate_hz, band_hz, false_alarm, carrier, following, scene, .. } = &self.config;
        let given = match (error, band_hz, scene) {
            (ConfigError::Rate | ConfigError::Scale, ..) => format!("rate_hz={rate_hz}"),
            (ConfigError::Band, Some((low, high)), _) => format!("band_hz=({low}, {high})"),
            (ConfigError::FalseAlarm, ..) => format!("false_alarm={false_alarm}"),
            (ConfigError::Following, ..) => format!("rate_bins={}", following.rate_bins),
            (ConfigError::Carrier, ..) => {
                let Carrier { linewidth_hz, envelope_hz } = carrier;
                format!("linewidth_hz={linewidth_hz}, envelope_hz={envelope_hz}")
            }
            (ConfigError::Ramp, _, Scene::Chirp(Chirp { duration_s, guard_s, .. })) => {
                let record = self.n as f64 / rate_hz;
                format!("duration_s={duration_s}, guard_s={guard_s}, a record of {record} s")
            }
            _ => return wrong(error),
        };
        wrong(format!("{given}: {error}"))
    }

    /// The stamps of blocks that begin this many samples apart.
    pub fn timing(&self, hop: usize) -> Timing {
        let period = u32::try_from(hop).unwrap_or(u32::MAX);
        Timing { period, segments: self.config.scene.segments() }
    }

    /// The blocks of these words, each as samples with a stamp.
    pub fn records<R: Record, const N: usize>(
        &self,
        words: &[i16],
        hop: usize,
        blocks: std::ops::Range<usize>,
        mut each: impl FnMut(Stamp, &[R::Sample; N]),
    ) {
        let timing = self.timing(hop);
        let mut samples = Box::new([R::Sample::default(); N]);
        for block in blocks {
            let words = words.get(block * hop * parts::<R>()..).unwrap_or_default();
            for (place, sample) in samples.iter_mut().zip(samples_of::<R>(words)) {
                *place = sample;
            }
            each(timing.stamp(block as u64, false), &samples);
        }
    }

    /// So many blocks are in these words.
    pub fn count(&self, words: &[i16], hop: usize) -> usize {
        let samples = words.len() / if self.iq { 2 } else { 1 };
        samples.checked_sub(self.n).map_or(0, |rest| rest / hop.max(1) + 1)
    }
}

/// Words in a sample.
const fn parts<R: Record>() -> usize {
    if R::IQ { 2 } else { 1 }
}

/// The samples in these words.
pub fn samples_of<R: Record>(words: &[i16]) -> impl Iterator<Item = R::Sample> {
    let samples = words.chunks_exact(parts::<R>());
    samples.map(|words| R::from_parts([words[0], words.get(1).copied().unwrap_or(0)]))
}
