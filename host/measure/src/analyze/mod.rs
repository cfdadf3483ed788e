//! Methods on a recording, block by block, in constant memory.

pub mod accumulated;
pub mod bursts;
pub mod carrier;
pub mod chirps;
pub mod clock;
pub mod command;
pub mod cut;
pub mod displacement;
pub mod frames;
pub mod fundamental;
pub mod input;
pub mod known;
pub mod moved;
pub mod radar;
pub mod ramp;
pub mod ranges;
pub mod repeats;
pub mod several;
pub mod told;
pub mod unfit;

use self::carrier::{Carrier, Speed};
use self::unfit::{Tally, Unfit};
use crate::arithmetic::{Arithmetic, Engine, Estimate, Explained, engine};
use crate::band;
use crate::cli::{self, print_line};
use crate::estimator::Estimator;
use crate::recording::{self, Blocks, Clock, Format, Recording, Records, Sample};
use crate::{length, with_kind};
use picket_dsp::Usable;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier as Width;
use picket_dsp::config::Config;
use picket_dsp::tone::effort::Effort;
use picket_dsp::tone::fit::Reach;
use picket_dsp::tone::{Verdict, Verdicts};
use picket_transform::num_complex::Complex;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// How answers are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Aligned columns for people.
    Text,
    /// A header line, then values.
    Csv,
    /// One JSON object a line, a summary at the end.
    Json,
}

/// What is done with a recording.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// How the file is read.
    pub read: recording::Options,
    /// Samples in a block; for JSON records, `None` takes each as it is.
    pub n: Option<usize>,
    /// From one block's start to the next; `None` for the block's length.
    pub hop: Option<usize>,
    /// Samples left out at the start (of each JSON record).
    pub skip: u64,
    /// The band searched in hertz.
    pub band_hz: Option<(f64, f64)>,
    /// The methods; `None` for the best of the record's kind.
    pub estimators: Option<Vec<Estimator>>,
    /// The reach of least squares.
    pub reach: Reach,
    /// The width of the codes.
    pub codes: Codes,
    /// The arithmetic.
    pub arithmetic: Arithmetic,
    /// The effort spent on a line that is not a steady tone.
    pub effort: Effort,
    /// The tone's own width.
    pub width: Width,
    /// The probability of a false alarm in a block of noise, above 0 and at most 0.5.
    pub false_alarm: f64,
    /// The carrier of a Doppler radar, for speeds.
    pub carrier: Option<Carrier>,
}

impl Analysis {
    /// Blocks of the usual length, end to end, by the best method of their kind: what the command does by default.
    pub fn new(codes: Codes, arithmetic: Arithmetic) -> Self {
        Self {
            read: recording::Options::default(),
            n: None,
            hop: None,
            skip: 0,
            band_hz: None,
            estimators: None,
            reach: Reach::default(),
            codes,
            arithmetic,
            effort: Effort::default(),
            width: Width::default(),
            false_alarm: Config::new(1.0, codes).false_alarm,
            carrier: None,
        }
    }
}

/// The block length of recordings where none is given.
pub const BLOCK: usize = 1024;

/// The answer of one method for one block. The keys are those of the JSON lines.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// The JSON record's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<serde_json::Value>,
    /// The block's number.
    pub block: u64,
    /// The time of the block's middle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// The method.
    pub method: &'static str,
    /// The frequency in cycles per block, 0..N for I/Q.
    pub bins: Option<f64>,
    /// The frequency; negative ones exist for I/Q. `None` without a rate.
    pub frequency_hz: Option<f64>,
    /// One standard deviation of it.
    pub sigma_hz: Option<f64>,
    /// The frequency in cycles per sample, where no rate is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycles_per_sample: Option<f64>,
    /// One standard deviation of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_cycles_per_sample: Option<f64>,
    /// One standard deviation of it with the sample rate's own, where that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty_hz: Option<f64>,
    /// One standard deviation in bins.
    pub sigma_bins: Option<f64>,
    /// Signal-to-noise ratio per sample.
    pub snr_db: Option<f64>,
    /// The speed in front of a radar of this carrier.
    #[serde(flatten)]
    pub speed: Option<Speed>,
    /// Whether it may be used.
    pub verdict: &'static str,
    /// What applies besides.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<&'static str>,
}

/// The engine for one kind and length of record, and the methods that suit it.
struct Station {
    engine: Box<dyn Engine>,
    estimators: Vec<Estimator>,
}

/// Runs an analysis.
pub struct Analyst<'a> {
    analysis: &'a Analysis,
    stations: BTreeMap<(bool, usize), Station>,
    rate_hz: Option<f64>,
    /// How the samples lie in time.
    clock: Option<Clock>,
    /// Blocks whose samples lie too unevenly in time for their sigma.
    uneven: u64,
    /// What was assumed of the file, until it is said.
    assumed: Option<String>,
    /// Blocks answered.
    blocks: u64,
    /// Records that were left out.
    skipped: u64,
    /// Blocks that integers do not take.
    tally: Tally,
    /// Answers before the first block that integers take: if they take none, nothing is given.
    held: Vec<Answer>,
    /// What is done with the answers.
    task: Task<'a>,
}

/// What is done with the blocks of a recording.
enum Task<'a> {
    /// Every one is measured, and this takes the answers.
    Measure(Box<dyn FnMut(Answer) + 'a>),
    /// One is explained.
    Explain { block: u64, explanation: Option<Box<Explanation>> },
}

/// One block's answer with every test behind its verdict.
#[derive(Debug)]
pub struct Explanation {
    /// The answer, as an analysis gives it.
    pub answer: Answer,
    /// The tests, the evidence and the fit.
    pub explained: Explained,
    /// The block's samples.
    pub samples: Vec<Complex<f64>>,
    /// Whether they are I/Q.
    pub iq: bool,
}

/// Explains the block of this number of `file`, counted from 0 as the analysis counts its answers.
pub fn explain(file: &Path, analysis: &Analysis, block: u64) -> Result<Explanation, String> {
    let mut analyst = Analyst::new(analysis, Task::Explain { block, explanation: None });
    analyst.run(file, |_| ())?;
    let blocks = analyst.blocks;
    match analyst.task {
        Task::Explain { explanation: Some(explanation), .. } => Ok(*explanation),
        _ => {
            let file = cli::name(file);
            let blocks = match blocks {
                0 => return Err(format!("{file} has no block: give a smaller --n")),
                1 => "1 block: give --block 0".to_owned(),
                _ => format!("{blocks} blocks: give --block 0 to {}", blocks - 1),
            };
            Err(format!("--block {block}: {file} has {blocks}"))
        }
    }
}

/// Whether a file holds records of JSON, each by itself.
pub(crate) fn is_json(file: &Path, format: Option<Format>) -> bool {
    format.or_else(|| Format::guess(file)) == Some(Format::Json) && Records::are_in(file)
}

/// What an analysis covered.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Summary {
    /// Always true: it distinguishes this line from the others.
    pub summary: bool,
    /// Blocks answered.
    pub blocks: u64,
    /// Records of a kind that no chosen method takes, or not every one.
    #[serde(skip_serializing_if = "none")]
    pub skipped: u64,
    /// Blocks that integers do not take: beyond the rails, or without one and a half codes.
    #[serde(skip_serializing_if = "none")]
    pub left_out: u64,
}

const fn none(count: &u64) -> bool {
    *count == 0
}

/// Analyses `file` and gives every answer to `sink`, in order. `progress` hears of every block's length.
pub fn run(
    file: &Path,
    analysis: &Analysis,
    sink: impl FnMut(Answer),
    progress: impl FnMut(u64),
) -> Result<Summary, String> {
    let mut analyst = Analyst::new(analysis, Task::Measure(Box::new(sink)));
    analyst.run(file, progress)?;
    let Analyst { blocks, skipped, tally, .. } = analyst;
    tally.tell(cli::name(file), analysis.codes);
    Ok(Summary { summary: true, blocks, skipped, left_out: tally.left_out() })
}

impl<'a> Analyst<'a> {
    fn new(analysis: &'a Analysis, task: Task<'a>) -> Self {
        let (stations, rate_hz) = (BTreeMap::new(), analysis.read.rate_hz);
        let (tally, held) = (Tally::default(), Vec::new());
        let (clock, assumed) = (None, None);
        Analyst {
            analysis,
            stations,
            rate_hz,
            clock,
            uneven: 0,
            assumed,
            blocks: 0,
            skipped: 0,
            tally,
            held,
            task,
        }
    }

    fn run(&mut self, file: &Path, progress: impl FnMut(u64)) -> Result<(), String> {
        if is_json(file, self.analysis.read.format) {
            self.records(file, progress)?;
        } else {
            self.stream(file, progress)?;
        }
        if self.blocks > 0 && self.uneven == self.blocks {
            let n = self.analysis.n.unwrap_or(BLOCK);
            let why = self.clock.map_or(String::new(), |clock| cut::uneven(&clock, n));
            return Err(format!("{}: {why}", cli::name(file)));
        }
        self.tally.check(self.analysis.codes)
    }

    /// Counts a block and gives its answers on.
    fn give(&mut self, place: &Place, (named, unfit): Measured) {
        let Task::Measure(sink) = &mut self.task else { return };
        self.tally.add(unfit);
        let mut uneven = false;
        for (method, estimate) in named {
            let answer = place.answer(method, estimate);
            uneven |= answer.verdict == Verdict::Gap.name() && place.is_uneven(&estimate);
            self.held.push(answer);
        }
        self.uneven += u64::from(uneven);
        if self.tally.left_out() + self.uneven < self.tally.blocks || self.held.len() > HELD {
            if let Some(assumed) = self.assumed.take() {
                eprintln!("{assumed}");
            }
            self.held.drain(..).for_each(sink);
        }
    }

    /// Whether the block that is to be explained is found.
    fn is_done(&self) -> bool {
        matches!(self.task, Task::Explain { explanation: Some(_), .. })
    }

    fn stream(&mut self, file: &Path, mut progress: impl FnMut(u64)) -> Result<(), String> {
        let recording = Recording::open(file, self.analysis.read).map_err(text)?;
        // Records of their own are measured one by one.
        let row = recording.row().and_then(|row| usize::try_from(row).ok());
        let whole = row.and_then(|row| length::LENGTHS.into_iter().rev().find(|&n| n <= row));
        let n = self.analysis.n.or(whole).unwrap_or(BLOCK);
        let hop = self.analysis.hop.or(row.filter(|&row| row >= n)).unwrap_or(n);
        let iq = recording.iq();
        self.clock = recording.clock();
        let told = |assumed: String| format!("{}: {assumed}", cli::name(file));
        self.assumed = recording.assumed().map(told);
        self.rate_hz = recording.knows_rate().then(|| recording.rate_hz());
        self.station(iq, n)?;
        let mut blocks = recording.blocks(n, hop, self.analysis.skip);
        if matches!(self.task, Task::Measure(_)) {
            self.batches(&mut blocks, n, hop, &mut progress)?;
            return missed(file, &blocks);
        }
        while let Some((start, samples)) = blocks.next_block().map_err(text)? {
            let samples = samples.to_vec();
            let gap = blocks.gap();
            self.block(None, (iq, gap), self.blocks, start, &samples)?;
            self.blocks += 1;
            progress(hop as u64);
            if self.is_done() {
                break;
            }
        }
        missed(file, &blocks)
    }

    /// Measures all blocks, many at a time on all cores, and gives the answers in their order.
    fn batches(
        &mut self,
        blocks: &mut Blocks,
        n: usize,
        hop: usize,
        progress: &mut impl FnMut(u64),
    ) -> Result<(), String> {
        let (iq, rate_hz, analysis) = (blocks.recording().iq(), self.rate_hz, self.analysis);
        let station = |_| Station::new(analysis, rate_hz, iq, n);
        let stations: Result<Vec<_>, _> = (0..rayon::current_num_threads()).map(station).collect();
        let (mut stations, mut ready, mut next) = (stations?, Batch::default(), Batch::default());
        ready.read(blocks, n);
        loop {
            let each = ready.starts.len().div_ceil(stations.len()).max(1);
            let (starts, samples) =
                (ready.starts.par_chunks(each), ready.samples.par_chunks(each * n));
            // The next blocks are read meanwhile.
            let (measured, ()) = rayon::join(
                || {
                    let work = starts.zip(samples).zip(&mut stations);
                    let each = work.map(|((starts, samples), station)| {
                        let blocks = starts.iter().zip(samples.chunks_exact(n));
                        let measured = |((_, gap), samples): (&(u64, bool), &[Sample])| {
                            station.measured(samples, *gap, analysis)
                        };
                        blocks.map(measured).collect::<Vec<Measured>>()
                    });
                    each.collect::<Vec<_>>()
                },
                || {
                    if ready.end.is_none() {
                        next.read(blocks, n)
                    }
                },
            );
            for (&(start, _), found) in ready.starts.iter().zip(measured.into_iter().flatten()) {
                let (block, carrier, clock) = (self.blocks, analysis.carrier, self.clock);
                let place = Place { id: None, block, start, n, iq, rate_hz, clock, carrier };
                self.give(&place, found);
                self.blocks += 1;
                progress(hop as u64);
            }
            if let Some(end) = ready.end.take() {
                return end;
            }
            std::mem::swap(&mut ready, &mut next);
        }
    }

    fn records(&mut self, file: &Path, mut progress: impl FnMut(u64)) -> Result<(), String> {
        if let Some(rate) = self.rate_hz.filter(|&rate| !(rate > 0.0 && rate.is_finite())) {
            return Err(recording::RecordingError::Rate(rate).to_string());
        }
        // Why the first record is left out: the others are counted.
        let mut first = None;
        let mut left_out = |why: String, told: String, skipped: &mut u64| {
            *skipped += 1;
            first.get_or_insert((why, told));
        };
        let records = Records::open(file, self.analysis.read).map_err(text)?;
        for record in records {
            let record = match record {
                Ok(record) => record,
                Err(error @ recording::RecordingError::Line(..)) => {
                    let why = error.to_string();
                    left_out(why.clone(), format!("left out: {why}"), &mut self.skipped);
                    continue;
                }
                Err(error) => return Err(error.to_string()),
            };
            let id = cli::short(&record.id.to_string());
            let at = |error: String| format!("{}, record {id}: {error}", cli::name(file));
            if let Err(unfit) = self.suits(record.iq) {
                let told = format!("record {id}: left out: {unfit}");
                left_out(unfit, told, &mut self.skipped);
                continue;
            }
            let skip = self.analysis.skip as usize;
            let samples = record.samples.get(skip..).unwrap_or_default();
            let n = self.analysis.n.unwrap_or(samples.len());
            if n > samples.len() || samples.is_empty() {
                let why = at(format!("{} samples are fewer than {n}", samples.len()));
                left_out(why.clone(), format!("left out: {why}"), &mut self.skipped);
                continue;
            }
            let hop = self.analysis.hop.unwrap_or(n);
            // A length that is none, or a band without a bin at it.
            if let Err(why) = self.station(record.iq, n).map(|_| ()) {
                left_out(at(why.clone()), format!("left out: {}", at(why)), &mut self.skipped);
                continue;
            }
            for (block, window) in samples.windows(n).step_by(hop).enumerate() {
                let start = (skip + block * hop) as u64;
                let id = Some(record.id.clone());
                self.block(id, (record.iq, false), block as u64, start, window).map_err(at)?;
                self.blocks += 1;
            }
            progress(samples.len() as u64);
            if self.is_done() {
                break;
            }
        }
        match first {
            Some((why, _)) if self.blocks == 0 => return Err(why),
            Some((_, told)) if self.skipped == 1 => eprintln!("{told}"),
            Some((_, told)) => eprintln!("{told}; and {} more", self.skipped - 1),
            None => {}
        }
        if self.blocks == 0 {
            return Err(recording::RecordingError::Empty(file.into()).to_string());
        }
        Ok(())
    }

    /// Whether every chosen method takes records of a kind.
    fn suits(&self, iq: bool) -> Result<(), String> {
        let mut estimators = self.analysis.estimators.iter().flatten();
        with_kind!(iq, R => estimators.try_for_each(|estimator| estimator.check::<R>()))
    }

    /// The engine for records of a kind and length, made at first need.
    fn station(&mut self, iq: bool, n: usize) -> Result<&mut Station, String> {
        use std::collections::btree_map::Entry;
        match self.stations.entry((iq, n)) {
            Entry::Occupied(entry) => Ok(entry.into_mut()),
            Entry::Vacant(entry) => {
                Ok(entry.insert(Station::new(self.analysis, self.rate_hz, iq, n)?))
            }
        }
    }

    fn block(
        &mut self,
        id: Option<serde_json::Value>,
        (iq, gap): (bool, bool),
        block: u64,
        start: u64,
        samples: &[Sample],
    ) -> Result<(), String> {
        let wanted = match self.task {
            Task::Measure(_) => true,
            Task::Explain { block, .. } => block == self.blocks,
        };
        let n = samples.len();
        if !wanted {
            return self.station(iq, n).map(|_| ());
        }
        let (rate_hz, carrier, analysis) = (self.rate_hz, self.analysis.carrier, self.analysis);
        let clock = self.clock;
        let place = Place { id, block, start, n, iq, rate_hz, clock, carrier };
        let explains = matches!(self.task, Task::Explain { .. });
        let station = self.station(iq, n)?;
        if !explains {
            let measured = station.measured(samples, gap, analysis);
            self.give(&place, measured);
            return Ok(());
        }
        if let Some(unfit @ Unfit::Quiet) = Unfit::of(samples, analysis.codes) {
            return Err(unfit.cure(analysis.codes));
        }
        let values: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        let estimator = *station.estimators.first().ok_or("no method")?;
        let explained = station.engine.explain(&values, estimator);
        let answer = place.answer(estimator.name(), explained.estimate);
        if let Task::Explain { explanation, .. } = &mut self.task {
            *explanation = Some(Box::new(Explanation { answer, explained, samples: values, iq }));
        }
        Ok(())
    }
}

/// Where a block is, and what turns bins into hertz.
struct Place {
    id: Option<serde_json::Value>,
    block: u64,
    start: u64,
    n: usize,
    iq: bool,
    rate_hz: Option<f64>,
    clock: Option<Clock>,
    carrier: Option<Carrier>,
}

impl Place {
    /// Whether the samples lie so unevenly in time that sigma does not cover it.
    fn is_uneven(&self, estimate: &Estimate) -> bool {
        let Estimate { bins, sigma_bins, .. } = *estimate;
        let n = self.n as f64;
        let signed = if self.iq && bins >= n / 2.0 { bins - n } else { bins };
        let walks = self.clock.filter(|clock| clock.walk_s > 0.0);
        walks.is_some_and(|clock| signed.abs() * clock.share(self.n) > sigma_bins)
    }

    /// What a method found there.
    fn answer(&self, method: &'static str, estimate: Estimate) -> Answer {
        let Place { ref id, block, start, n, iq, rate_hz, clock, carrier } = *self;
        let uneven = self.is_uneven(&estimate);
        let Estimate { bins, sigma_bins, snr_db, verdict, also } = estimate;
        let verdict = if uneven && verdict.usable() < Usable::No { Verdict::Gap } else { verdict };
        let number = |x: f64| x.is_finite().then_some(x);
        let hertz = |bins: f64| rate_hz.and_then(|rate| number(bins * rate / n as f64));
        let signed = if iq && bins >= n as f64 / 2.0 { bins - n as f64 } else { bins };
        let unknown = |bins: f64| number(bins / n as f64).filter(|_| rate_hz.is_none());
        let with_rate = |clock: Clock| {
            let share = clock.share(n);
            hertz(sigma_bins.hypot(signed * share)).filter(|_| share > 0.0)
        };
        let speed = |carrier: Carrier| Some(carrier.speed(hertz(signed)?, hertz(sigma_bins), iq));
        Answer {
            id: id.clone(),
            block,
            time_s: rate_hz.map(|rate| (start as f64 + n as f64 / 2.0) / rate),
            method,
            bins: number(bins),
            frequency_hz: hertz(signed),
            sigma_hz: hertz(sigma_bins),
            cycles_per_sample: unknown(signed),
            sigma_cycles_per_sample: unknown(sigma_bins),
            uncertainty_hz: clock.and_then(with_rate),
            sigma_bins: number(sigma_bins),
            snr_db: number(snr_db),
            speed: carrier.and_then(speed),
            verdict: verdict.name(),
            also: names(also),
        }
    }
}

/// Answers that are held back at most.
const HELD: usize = 1 << 16;

/// Samples that are measured at a time: they stay in a processor's caches.
const BATCH: usize = 1 << 18;

/// Blocks that are measured at a time.
#[derive(Default)]
struct Batch {
    /// Of each, the number of its first sample and whether it is behind a gap.
    starts: Vec<(u64, bool)>,
    /// Their samples, one block after the other.
    samples: Vec<Sample>,
    /// How the recording ended, where it did.
    end: Option<Result<(), String>>,
}

impl Batch {
    /// Reads other blocks of this many samples.
    fn read(&mut self, blocks: &mut Blocks, n: usize) {
        self.starts.clear();
        self.samples.clear();
        self.end = None;
        while self.starts.len() < (BATCH / n).clamp(1, 1024) && self.end.is_none() {
            match blocks.append_block(&mut self.samples) {
                Ok(Some(start)) => self.starts.push((start, blocks.gap())),
                Ok(None) => self.end = Some(Ok(())),
                Err(error) => self.end = Some(Err(text(error))),
            }
        }
        self.samples.truncate(self.starts.len() * n);
    }
}

/// What each method answered to a block, and why integers do not take it.
type Measured = (Vec<(&'static str, Estimate)>, Option<Unfit>);

/// Says how many samples have no number.
fn missed(file: &Path, blocks: &Blocks) -> Result<(), String> {
    if let missed @ 1.. = blocks.recording().missed() {
        let samples = if missed == 1 { "sample has" } else { "samples have" };
        eprintln!(
            "{}: {missed} {samples} no number: each block with one is a gap",
            cli::name(file)
        );
    }
    Ok(())
}

impl Station {
    /// What each method answers to a block.
    fn measured(&mut self, samples: &[Sample], gap: bool, analysis: &Analysis) -> Measured {
        let unfit = Unfit::of(samples, analysis.codes);
        let answers = match unfit {
            Some(Unfit::Quiet) => vec![Estimate::NOTHING; self.estimators.len()],
            // Codes beyond the rails have a verdict of their own.
            _ => self.engine.measure_samples(samples, &self.estimators, gap),
        };
        let names = self.estimators.iter().map(|estimator| estimator.name());
        (names.zip(answers).collect(), unfit)
    }

    fn new(analysis: &Analysis, rate_hz: Option<f64>, iq: bool, n: usize) -> Result<Self, String> {
        length::check(n)?;
        let best = || vec![Estimator::best(iq, analysis.reach)];
        let estimators = analysis.estimators.clone().unwrap_or_else(best);
        with_kind!(iq, R => {
            for estimator in &estimators {
                estimator.check::<R>()?;
                analysis.arithmetic.check(*estimator)?;
            }
            // Without a rate all frequencies are in cycles per sample.
            let rate = rate_hz.unwrap_or(1.0);
            let config = Config {
                rate_hz: rate,
                codes: analysis.codes,
                band_hz: analysis.band_hz,
                false_alarm: analysis.false_alarm,
                effort: analysis.effort,
                carrier: analysis.width,
                ..Config::new(1.0, Codes::signed::<12>())
            };
            band::holds_a_bin(analysis.band_hz, rate, n, iq)?;
            let plan = config.terms::<R>(n).map_err(text)?;
            Ok(Station { engine: engine::<R>(analysis.arithmetic, n, plan)?, estimators })
        })
    }
}

/// The names of verdicts, the most severe first.
pub fn names(verdicts: Verdicts) -> Vec<&'static str> {
    verdicts.iter().map(Verdict::name).collect()
}

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// Prints an answer.
pub fn print(answer: &Answer, style: Style) {
    match style {
        Style::Json => print_line(&serde_json::to_string(answer).unwrap_or_default()),
        Style::Csv => {
            let number = |x: Option<f64>| x.map_or(String::new(), |x| x.to_string());
            let speed = Speed::csv(answer.speed);
            let uncertainty = answer.uncertainty_hz.map_or(String::new(), |x| format!(",{x}"));
            print_line(&format!(
                "{},{},{},{},{},{},{},{},{}{speed}{uncertainty}",
                answer.id.as_ref().map_or(String::new(), plain),
                answer.block,
                number(answer.time_s),
                answer.method,
                number(answer.bins),
                number(answer.frequency_hz),
                number(answer.sigma_hz),
                number(answer.snr_db),
                answer.verdict
            ));
        }
        Style::Text => {
            let number = |x: Option<f64>, digits: usize| {
                x.map_or("-".to_owned(), |x| format!("{x:.digits$}"))
            };
            let place = answer.id.as_ref().map_or(answer.block.to_string(), plain);
            let speed = Speed::text(answer.speed);
            let uncertainty =
                answer.uncertainty_hz.map_or(String::new(), |x| format!(" {x:>12.6}"));
            print_line(&format!(
                "{place:>8} {:>11} {:>14} {:>16} {:>12}{uncertainty} {:>7}{speed}  {:<10} {}",
                number(answer.time_s, 4),
                number(answer.bins, 6),
                number(answer.frequency_hz.or(answer.cycles_per_sample.map(|x| 1e3 * x)), 6),
                number(answer.sigma_hz.or(answer.sigma_cycles_per_sample.map(|x| 1e3 * x)), 6),
                number(answer.snr_db, 1),
                answer.verdict,
                answer.method,
            ));
        }
    }
}

/// Prints the headings of the answers.
pub fn print_heading(style: Style, speeds: bool, first: &Answer) {
    let knows_rate = first.cycles_per_sample.is_none();
    let uncertain = first.uncertainty_hz.is_some();
    match style {
        Style::Json => {}
        Style::Csv => {
            let speed = if speeds { carrier::CSV } else { "" };
            let uncertainty = if uncertain { ",uncertainty_hz" } else { "" };
            print_line(&format!(
                "id,block,time_s,method,bins,frequency_hz,sigma_hz,snr_db,verdict{speed}{uncertainty}"
            ));
        }
        Style::Text => print_line(&format!(
            "{:>8} {:>11} {:>14} {:>16} {:>12}{} {:>7}{}  {:<10} {}",
            "block",
            "time s",
            "bins",
            if knows_rate { "frequency Hz" } else { "c/1000 samples" },
            if knows_rate { "sigma Hz" } else { "sigma" },
            if uncertain { "  uncertainty" } else { "" },
            "SNR dB",
            if speeds { carrier::TEXT } else { "" },
            "verdict",
            "method"
        )),
    }
}

/// A JSON value without its quotes; commas would split a csv line.
fn plain(value: &serde_json::Value) -> String {
    let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    text.replace([',', '\n'], " ")
}
