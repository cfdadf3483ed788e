//! The calibration of a radar by a target at rest at a known range.

use super::Style;
use super::cut::{self, Cut};
use super::radar::Radar;
use super::told::Told;
use super::unfit::{Tally, Unfit};
use crate::cli::{self, print_line};
use crate::follow::record;
use crate::output::Output;
use crate::recording::Recording;
use crate::scatter::Scatter;
use crate::simulate::Kind;
use crate::{views, with_record};
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::config::{Config, SPEED_OF_LIGHT};
use picket_dsp::pipeline::Pipeline;
use picket_dsp::solve::phase_range::{Calibration, PhaseRanging};
use picket_dsp::tone::lines::MOST;
use picket_dsp::{Chirp, ToneWithPhase};
use picket_transform::num_complex::Complex;
use picket_wire::view;
use serde_json::{Map, Value, json};
use std::f64::consts::TAU;
use std::path::Path;
use std::time::SystemTime;

/// A range with one standard deviation, as a user types it: 1.000 or 1.000:0.0001.
///
/// # Errors
/// It is no positive range, or its standard deviation is negative.
pub fn parse(text: &str) -> Result<(f64, f64), String> {
    let wrong = || "give metres, with one standard deviation behind a colon: 1.000:0.0001".into();
    let (range, sigma) = text.split_once(':').unwrap_or((text, "0"));
    let number = |text: &str| text.parse::<f64>().ok().filter(|x| x.is_finite() && *x >= 0.0);
    number(range).filter(|range| *range > 0.0).zip(number(sigma)).ok_or_else(wrong)
}

/// What comes out.
#[derive(Clone, Debug)]
pub struct Known {
    /// The phase at 0 m and the range's offset; with two distances the slope.
    pub calibration: Calibration,
    /// Records that were used, and those that were not.
    pub records: usize,
    /// Tones that may not be used, or were another target's.
    pub left_out: usize,
    /// The distance, m, with one standard deviation.
    known: (f64, f64),
    /// How many times as wide as their sigmas the phases scatter, where that cannot be chance.
    scatter: Option<f64>,
    /// Another calibration, at another distance, is in it.
    two: bool,
}

/// A calibration at one distance, as a file has it.
#[derive(Clone, Copy, Debug)]
pub struct First {
    calibration: Calibration,
    known: (f64, f64),
}

impl First {
    /// What `--known-m` or `picket calibrate --range` wrote.
    ///
    /// # Errors
    /// The file cannot be read, is no calibration at a known distance, or one at two already.
    pub fn read(path: &Path) -> Result<Self, String> {
        let wrong = |error: &str| format!("{}: {error}", cli::name(path));
        let (calibration, all) = read(path)?;
        let number = |name: &str| all.get(name).and_then(Value::as_f64);
        let known = number("known_m").zip(number("sigma_known_m"));
        let known = known.ok_or_else(|| wrong("it does not say at which distance it was made"))?;
        match calibration.slope_ppm == 0.0 && calibration.sigma_slope_ppm == 0.0 {
            true => Ok(Self { calibration, known }),
            false => Err(wrong("it has two distances already: name one with a single distance")),
        }
    }
}

/// The calibration in a file, and all that stands in it.
///
/// # Errors
/// The file cannot be read, or is no calibration.
pub fn read(path: &Path) -> Result<(Calibration, Map<String, Value>), String> {
    let wrong = |error: String| format!("{}: {error}", cli::name(path));
    let text = std::fs::read_to_string(path).map_err(|error| wrong(error.to_string()))?;
    let all: Map<String, Value> =
        serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    let known = views::names::<view::Calibration>();
    // What else stands in the file is how it was made.
    let numbers = all.iter().filter(|(name, _)| known.contains(name));
    let numbers = numbers.filter_map(|(name, value)| Some((name.as_str(), value.as_f64()?)));
    let told: view::Calibration = views::told(numbers).map_err(wrong)?;
    match all.contains_key("phase_rad") {
        true => Ok((Calibration::from(&told), all)),
        false => Err(wrong("no calibration: --known-m --save writes one".into())),
    }
}

/// When a calibration was made, and how warm it was, where its file says so.
pub fn made(path: &Path, all: &Map<String, Value>) -> Option<String> {
    let number = |name: &str| all.get(name).and_then(Value::as_f64);
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).ok()?.as_secs_f64();
    let age = number("unix_s").map(|made| format!("{:.1} days ago", (now - made) / 86_400.0));
    let warm = number("celsius").map(|celsius| format!("at {celsius} °C"));
    let how: Vec<String> = age.into_iter().chain(warm).collect();
    (!how.is_empty()).then(|| format!("{}: calibrated {}", cli::name(path), how.join(", ")))
}

/// A radar's chirp and its records: rate, samples, and whether they are I/Q.
#[derive(Clone, Copy, Debug)]
pub struct Records<'a> {
    /// The chirp.
    pub chirp: &'a Chirp,
    /// The sample rate, Hz.
    pub rate_hz: f64,
    /// Samples of a record.
    pub n: usize,
    /// I/Q records.
    pub iq: bool,
}

/// The share of the records that must show the same target as the strongest.
const AGREE: f64 = 0.75;
/// The scatter of the phases beyond which their mean is none, radians.
const RESTS_RAD: f64 = 0.3;

impl Known {
    /// By the strongest tones of rising ramps before a target at rest at a known distance, and by a calibration at another one, which gives the
    /// slope of the sweep.
    ///
    /// # Errors
    /// In one line: no tone may be used, the target is not the strongest in all records, it moves, or both distances are the same.
    pub fn of(
        radar: &Records,
        lines: &[ToneWithPhase],
        known: (f64, f64),
        first: Option<&First>,
    ) -> Result<Self, String> {
        let &Records { chirp, rate_hz, n, iq } = radar;
        let ranging = |slope: Calibration| {
            PhaseRanging::new(chirp, rate_hz, n, iq, slope).map_err(super::text)
        };
        let (known_m, sigma_m) = (known.0, known.1 as f32);
        let plain = ranging(Calibration::default())?;
        let one = |line: &ToneWithPhase| plain.calibrate(line, known_m, 0.0);
        let mut usable: Vec<(ToneWithPhase, Calibration)> =
            lines.iter().filter_map(|line| Some((*line, one(line)?))).collect();
        if usable.is_empty() {
            return Err(
                "no ramp has a tone that may be used: is the target the strongest one, and at rest?"
                    .into(),
            );
        }
        usable.sort_by(|(_, a), (_, b)| a.offset_m.total_cmp(&b.offset_m));
        let (_, middle) = usable[usable.len() / 2];
        let cell_m = (SPEED_OF_LIGHT / (2.0 * chirp.bandwidth_hz) * chirp.duration_s * rate_hz
            / n as f64) as f32;
        let (used, others): (Vec<_>, Vec<_>) = usable
            .into_iter()
            .partition(|(_, one)| (one.offset_m - middle.offset_m).abs() < cell_m);
        if (used.len() as f64) < AGREE * (used.len() + others.len()) as f64 {
            let at = |one: &Calibration| known_m + f64::from(one.offset_m);
            let other = others.first().map_or(f64::NAN, |(_, other)| at(other));
            return Err(format!(
                "the strongest target is at {:.3} m in some records and at {other:.3} m in others: cover the other one, or bring the known one nearer",
                at(&middle)
            ));
        }
        let (scatter, rms) = scatter(&used);
        if rms > RESTS_RAD {
            return Err(format!(
                "the phase scatters by {rms:.2} rad ({:.3} mm) from record to record: the target must rest, and be above the noise",
                1e3 * rms * chirp.wavelength_m / (2.0 * TAU)
            ));
        }
        let all = |ranging: &PhaseRanging| {
            ranging.calibrate_all(used.iter().map(|(line, _)| line), known_m, sigma_m)
        };
        let none = "the known distance is out of reach";
        let mut calibration = all(&plain).ok_or(none)?;
        if let Some(first) = first {
            let slope = first.slope(&calibration, known)?;
            let here = all(&ranging(slope)?).ok_or(none)?;
            // At 0 m, where both distances lead.
            let [near, far] = [first.known.0, known_m];
            let [one, other] =
                [first.calibration, calibration].map(|at| f64::from(at.sigma_offset_m));
            let sigma_offset_m = ((one * far).hypot(other * near) / (far - near).abs()) as f32;
            calibration = Calibration { sigma_offset_m, ..here };
        }
        if scatter.is_some() {
            calibration.sigma_phase_rad = calibration.sigma_phase_rad.hypot(rms as f32);
        }
        let (records, two) = (used.len(), first.is_some());
        Ok(Self { calibration, records, left_out: lines.len() - records, known, scatter, two })
    }

    /// For programs, and for `--calibration`.
    pub fn json(&self) -> Map<String, Value> {
        let mut all = views::object(&view::Calibration::from(&self.calibration));
        all.insert("known_m".into(), json!(self.known.0));
        all.insert("sigma_known_m".into(), json!(self.known.1));
        all.insert("ramps".into(), json!(self.records));
        all
    }

    /// For people.
    pub fn lines(&self) -> Vec<String> {
        let Calibration { phase_rad, sigma_phase_rad, offset_m, sigma_offset_m, .. } =
            self.calibration;
        let left = match self.left_out {
            0 => String::new(),
            left => format!(" ({left} left out)"),
        };
        let at_zero = format!(
            "by {} ramps{left}: a target at 0 m has the phase {phase_rad:.4} +- {sigma_phase_rad:.4} rad, and its frequency shows {:.3} +- {:.3} mm",
            self.records,
            1e3 * offset_m,
            1e3 * sigma_offset_m
        );
        let Calibration { slope_ppm, sigma_slope_ppm, .. } = self.calibration;
        let slope = self.two.then(|| {
            format!(
                "the sweep is steeper than stated by {slope_ppm:.1} +- {sigma_slope_ppm:.1} ppm"
            )
        });
        let scatter = self.scatter.map(|times| {
            format!(
                "the phases scatter {times:.1} times as wide as their sigmas, and the sigma above has that: target or sensor moves a little"
            )
        });
        [Some(at_zero), slope, scatter].into_iter().flatten().collect()
    }
}

impl First {
    /// The slope of the sweep, by this distance and another one.
    fn slope(
        &self,
        other: &Calibration,
        (known_m, sigma_m): (f64, f64),
    ) -> Result<Calibration, String> {
        let (near_m, sigma_near) = self.known;
        let way = known_m - near_m;
        // The distances' own deviations are in those of the offsets.
        let seen = way + f64::from(other.offset_m - self.calibration.offset_m);
        let sigma = other.sigma_offset_m.hypot(self.calibration.sigma_offset_m);
        let apart =
            way.abs() > 5.0 * sigma_m.hypot(sigma_near) && way.abs() > 5.0 * f64::from(sigma);
        let seen = [(seen * way.signum()) as f32, sigma];
        let slope = Calibration::default().with_slope(seen, [way.abs() as f32, 0.0]);
        slope.filter(|_| apart).ok_or_else(|| {
            format!("{near_m} m and {known_m} m are too close to tell the slope of the sweep: move the target farther")
        })
    }
}

/// How many times as wide as their sigmas the phases scatter, where that cannot be chance, and by how many radians.
fn scatter(used: &[(ToneWithPhase, Calibration)]) -> (Option<f64>, f64) {
    let mut sum = Complex::new(0.0, 0.0);
    for (_, one) in used {
        sum += Complex::from_polar(1.0, f64::from(one.phase_rad));
    }
    let off = |one: &Calibration| {
        let off = (f64::from(one.phase_rad) - sum.arg()) / TAU;
        TAU * (off - off.round())
    };
    let squares = |of: &dyn Fn(&Calibration) -> f64| -> f64 {
        used.iter().map(|(_, one)| of(one) * of(one)).sum()
    };
    let sigmas = Scatter::of(squares(&|one| off(one) / f64::from(one.sigma_phase_rad)), used.len());
    let radians = Scatter::of(squares(&off), used.len());
    let wide = sigmas.filter(|scatter| !scatter.agrees() && scatter.times > 1.0);
    (wide.map(|scatter| scatter.times), radians.map_or(0.0, |radians| radians.times))
}

/// Measures the strongest tone of each rising ramp of `file`.
///
/// # Errors
/// The recording cannot be read, or none of its tones may be used.
pub fn run(
    file: &Path,
    cut: &Cut,
    n: Option<usize>,
    (radar, told): (&Radar, &Told),
    known: (f64, f64),
) -> Result<(Known, Tally), String> {
    let first = told.first.as_deref().map(First::read).transpose()?;
    let recording = Recording::open(file, cut.read).map_err(super::text)?;
    if !recording.knows_rate() {
        return Err("ranges need the sample rate: add --rate HZ".into());
    }
    let ramps = radar.ramps(&recording, n, told.period_s, cut.read.axes.is_some())?;
    cut::assumed(file, &recording);
    let (rate_hz, n, iq) = (recording.rate_hz(), ramps.n, recording.iq());
    let chirp = &radar.chirp(rate_hz, &ramps, told.guard_s, told.curvature);
    let place = (ramps.hop, cut.skip + ramps.skip as u64);
    let (lines, tally) =
        with_record!(iq, n, R, N => strongest::<R, N>(recording, (cut, place), chirp))?;
    let known = Known::of(&Records { chirp, rate_hz, n, iq }, &lines, known, first.as_ref())?;
    Ok((known, tally))
}

/// The strongest tone of each rising ramp.
fn strongest<R: Kind, const N: usize>(
    recording: Recording,
    (cut, (hop, skip)): (&Cut, (usize, u64)),
    chirp: &Chirp,
) -> Result<(Vec<ToneWithPhase>, Tally), String> {
    let rate_hz = recording.rate_hz();
    let config =
        Config { band_hz: cut.band_hz, reach: cut.reach, ..Config::new(rate_hz, cut.codes) };
    let mut pipeline = Box::new(Pipeline::<R, N>::new(config.plan::<R, N>().map_err(super::text)?));
    let mut blocks = recording.blocks(N, hop, skip);
    let segments = chirp.shape.segments();
    let (mut lines, mut tally) = (Vec::<ToneWithPhase>::new(), Tally::default());
    for place in 0.. {
        let Some((_, samples)) = blocks.next_block().map_err(super::text)? else { break };
        if segments.get(place % segments.len().max(1)) != Some(&Segment::Up) {
            continue;
        }
        let unfit = Unfit::of(samples, cut.codes);
        let values: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        tally.add(unfit);
        if unfit.is_none() && !blocks.gap() {
            let stamp = Stamp { segment: Segment::Up, ..Stamp::default() };
            let measurement = pipeline.block(&stamp, &record::<R, N>(&values));
            lines.extend(pipeline.lines(&measurement, MOST).first());
        }
    }
    tally.check(cut.codes)?;
    Ok((lines, tally))
}

/// Prints a calibration, and keeps it where that is asked for.
///
/// # Errors
/// The file cannot be written.
pub fn tell(
    known: &Known,
    style: Style,
    (save, output): (Option<&Path>, Output),
) -> Result<(), String> {
    let all = Value::Object(known.json()).to_string();
    if let Some(path) = save {
        output.write(path, format!("{all}\n").as_bytes())?;
    }
    match style {
        Style::Text => {
            known.lines().iter().for_each(|line| print_line(line));
            print_line(&kept(save));
        }
        Style::Json | Style::Csv => print_line(&all),
    }
    Ok(())
}

/// How a calibration is used that is in this file, or in none.
fn kept(file: Option<&Path>) -> String {
    match file {
        Some(path) => {
            format!("saved: --calibration {}", cli::quoted(&path.display().to_string()))
        }
        None => "--save FILE keeps it for --calibration".into(),
    }
}
