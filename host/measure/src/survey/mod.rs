//! What an unknown recording holds, and the command that measures it.

mod nature;
mod picture;
mod series;
mod spectrum;
mod trial;
mod ways;
mod words;

use crate::analyze::cut::uneven;
use crate::arithmetic::{Arithmetic, Estimate, engine};
use crate::estimator::Estimator;
use crate::recording::{Clock, Levels, Options, Recording, RecordingError, Sample, Scaling};
use crate::with_kind;
use nature::{Finding, Known, Nature};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::config::Config;
use picket_dsp::tone::Verdict;
use picket_dsp::tone::effort::Effort;
use picket_dsp::tone::fit::Reach;
use picket_transform::num_complex::Complex;
use series::Series;
use spectrum::{floored, powers};
use std::path::Path;
use trial::{Ground, Of, Way};

/// What is looked at of a recording, in samples.
const MOST: usize = 1 << 20;
/// The longest and the shortest record that it is cut into.
const LONGEST: usize = 1 << 15;
const SHORTEST: usize = 64;
/// The longest record in which a line is measured.
const USUAL: usize = 4096;
/// The most lines that are listed, and how far above the floor a listed line stands, in dB.
const LINES: usize = 6;
const ABOVE_DB: f64 = 13.0;
/// Lines that are weaker than the strongest one by more than this, in dB, are not listed: they are the converter's own.
const BELOW_DB: f64 = 70.0;
/// Bins of the window's main lobe, on each side.
const LOBE: i64 = 3;

/// The look at a recording.
#[derive(Clone, Debug)]
pub struct Survey {
    /// Samples per second.
    pub rate_hz: f64,
    /// I/Q.
    pub iq: bool,
    /// Samples looked at.
    pub samples: usize,
    /// Levels in codes.
    levels: Levels,
    scaling: Scaling,
    /// Samples without a number.
    missed: u64,
    /// Whether the rate is known.
    knows_rate: bool,
    /// How the samples lie in time, from a column of times, if there is one.
    clock: Option<Clock>,
    /// Samples of a record, where the recording has records of their own.
    row: Option<usize>,
    /// Chirps of a frame, where the sides of an array count so many.
    frame: Option<u64>,
    /// What was assumed of the file.
    assumed: Option<String>,
    /// The record's length.
    n: usize,
    /// Power over the bins in dB of a full-scale sine, and the floor.
    power: Vec<(f64, f64, f64)>,
    /// The strongest lines, by strength.
    pub lines: Vec<Spectral>,
    /// The mains' frequency, where its line is there.
    pub hum_hz: Option<f64>,
    /// The line that the command is for.
    pub tone: Option<usize>,
    /// The fundamental that the lines are multiples of.
    series: Option<Series>,
    /// What ways of measuring did on the recording.
    finding: Finding,
}

/// How the codes of a recording differ from those of 16 bits.
#[derive(Clone, Copy, Debug)]
enum Width {
    /// 12 bits from 0 on.
    Unsigned12,
    /// Clipped below the rails: this factor brings them there.
    Scale(f64),
}

/// A line of the spectrum.
#[derive(Clone, Copy, Debug)]
pub struct Spectral {
    /// Its frequency.
    pub frequency_hz: f64,
    /// By the noise, and with the rate's own.
    noise_hz: f64,
    sigma_hz: f64,
    /// Above the floor.
    above_db: f64,
    verdict: &'static str,
}

impl Survey {
    /// Looks at the first million samples.
    pub fn of(file: &Path, read: Options) -> Result<Self, String> {
        let recording = Recording::open(file, read).map_err(|error| error.to_string())?;
        let mut recording = recording;
        let (rate_hz, iq, scaling) = (recording.rate_hz(), recording.iq(), recording.scaling());
        let mut all = Vec::new();
        recording.fill(&mut all, MOST).map_err(|error| error.to_string())?;
        let levels = Levels::from_samples(&all, iq).filter(|_| all.len() >= SHORTEST);
        let samples: Vec<Complex<f64>> = all.iter().map(|sample: &Sample| sample.value).collect();
        let Some(levels) = levels else {
            let short = RecordingError::Short(file.into(), samples.len() as u64, SHORTEST);
            return Err(short.to_string());
        };
        let row = recording.row().and_then(|row| usize::try_from(row).ok());
        let row = row.filter(|row| (SHORTEST..samples.len()).contains(row));
        let n = LONGEST.min(1 << row.unwrap_or(samples.len()).ilog2());
        let powers = powers(&samples, n, row.unwrap_or(1));
        let mut survey = Survey {
            rate_hz,
            iq,
            samples: samples.len(),
            levels,
            scaling,
            missed: recording.missed(),
            knows_rate: recording.knows_rate(),
            clock: recording.clock(),
            row,
            frame: recording.frame().filter(|chirps| *chirps >= 8),
            assumed: recording.assumed(),
            n,
            power: floored(&powers, rate_hz, iq),
            lines: Vec::new(),
            hum_hz: None,
            tone: None,
            series: None,
            finding: Finding::bare(Nature::Noise),
        };
        survey.lines = survey.peaks(&samples);
        let mains = survey.mains();
        // A line alone is what was recorded.
        survey.hum_hz = mains.filter(|_| survey.lines.len() > 1);
        let alone_hz = mains.filter(|_| survey.lines.len() == 1);
        survey.series = survey.stacked();
        let hum = |line: &Spectral| survey.hum_hz.is_some_and(|hum| survey.of_hum(line, hum));
        survey.tone = survey.lines.iter().position(|line| !hum(line));
        if survey.tone.is_none() && !survey.lines.is_empty() {
            // Nothing but the mains: they are what was recorded.
            survey.tone = Some(0);
        }
        survey.finding = match survey.levels.high <= survey.levels.low {
            true => Finding::bare(Nature::Silence),
            false => survey.tried(&samples, alone_hz),
        };
        Ok(survey)
    }

    fn bin_hz(&self) -> f64 {
        self.rate_hz / self.n as f64
    }

    /// Frequency, power and height over the floor of each peak, by strength.
    fn raised(&self) -> Vec<(f64, f64, f64)> {
        let at = |index: i64| self.power.get(usize::try_from(index).ok()?);
        let dc = self.power.iter().position(|&(hertz, ..)| hertz == 0.0).unwrap_or(0) as i64;
        let mut found: Vec<(f64, f64, f64)> = Vec::new();
        for (index, &(hertz, power, floor)) in (0i64..).zip(&self.power) {
            let around = (index - LOBE..=index + LOBE).filter(|&other| other != index);
            let highest = around.filter_map(at).all(|&(_, other, _)| other <= power);
            let away = (index - dc).abs() > LOBE;
            if highest && away && power - floor > ABOVE_DB {
                found.push((hertz, power, power - floor));
            }
        }
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found
    }

    /// The series of harmonics that most of the power is in, and not in its fundamental alone; the mains' beside a tone is none.
    fn stacked(&self) -> Option<Series> {
        let peaks: Vec<(f64, f64)> = self.raised().iter().map(|peak| (peak.0, peak.1)).collect();
        let series =
            series::series(&peaks, self.bin_hz()).filter(|_| !self.iq && self.row.is_none())?;
        let mains = self.hum_hz.is_some_and(|hum| {
            let order = (series.hz / hum).round().max(1.0);
            (series.hz - order * hum).abs() < 0.01 * series.hz
        });
        (series.share > 0.8 && series.first < 0.7 && !mains).then_some(series)
    }

    /// The strongest lines, each measured in its own band in the middle of the recording.
    fn peaks(&self, samples: &[Complex<f64>]) -> Vec<Spectral> {
        let mut found = self.raised();
        let strongest = found.first().map_or(0.0, |line| line.1);
        found.retain(|line| line.1 > strongest - BELOW_DB);
        found.truncate(LINES);
        let measured = |&(hertz, power, above_db): &(f64, f64, f64)| {
            // Wide enough for the noise around it to be seen, and no stronger line within.
            let stronger = || found.iter().filter(|line| line.1 > power);
            let free =
                stronger().map(|line| (line.0 - hertz).abs() / 2.0).fold(f64::INFINITY, f64::min);
            let bin_hz = self.rate_hz / self.record() as f64;
            let width = free.min(64.0 * bin_hz).max(3.0 * bin_hz);
            let estimate = self.measured(samples, (hertz - width, hertz + width));
            let near = estimate.and_then(|Estimate { bins, sigma_bins, verdict, .. }| {
                let n = self.record() as f64;
                let signed = if self.iq && bins > n / 2.0 { bins - n } else { bins };
                let (frequency_hz, sigma_hz) = (signed * bin_hz, sigma_bins * bin_hz);
                let (noise_hz, verdict) = (sigma_hz, verdict.name());
                let sigma_hz = self.with_rate(frequency_hz, noise_hz, self.record());
                let measured = Spectral { frequency_hz, noise_hz, sigma_hz, above_db, verdict };
                let off = |hertz: f64| (frequency_hz - hertz).abs();
                let other = stronger().map(|line| off(line.0)).fold(f64::INFINITY, f64::min);
                (off(hertz) < bin_hz.min(other)).then_some(measured)
            });
            // Else a line within a bin of a stronger one, which no record of the library tells from it: it is anywhere in its bin here.
            near.unwrap_or(Spectral {
                frequency_hz: hertz,
                noise_hz: self.bin_hz() / 12f64.sqrt(),
                sigma_hz: self.bin_hz() / 12f64.sqrt(),
                above_db,
                verdict: Verdict::Unresolved.name(),
            })
        };
        let mut lines: Vec<Spectral> = Vec::new();
        for line in found.iter().map(measured) {
            // Two peaks may be one line.
            let same = |other: &Spectral| {
                (other.frequency_hz - line.frequency_hz).abs() < 0.5 * self.bin_hz()
            };
            if !lines.iter().any(same) {
                lines.push(line);
            }
        }
        lines
    }

    /// The samples of the longest record in which a line is measured.
    fn record(&self) -> usize {
        self.n.min(USUAL)
    }

    /// What the record in the middle shows in a band.
    fn measured(&self, samples: &[Complex<f64>], band: (f64, f64)) -> Option<Estimate> {
        let n = self.record();
        let middle = (samples.len() - n) / 2;
        let start = middle / self.row.unwrap_or(1) * self.row.unwrap_or(1);
        let (codes, scale) = self.codes();
        let record: Vec<Complex<f64>> =
            samples.iter().skip(start).take(n).map(|x| x * scale).collect();
        let half = self.rate_hz / 2.0;
        let low = if self.iq { -half } else { 0.0 };
        let band_hz = Some((band.0.max(low), band.1.min(half)));
        // What a line is not is told by tests, not by what a joint fit makes of it.
        let config = Config { band_hz, effort: Effort::LOOK, ..Config::new(self.rate_hz, codes) };
        with_kind!(self.iq, R => {
            let plan = config.terms::<R>(n).ok()?;
            let mut engine = engine::<R>(Arithmetic::Target, n, plan).ok()?;
            engine.measure(&record, &[Estimator::best(self.iq, Reach::Four)], false).pop()
        })
    }

    /// 50 or 60 Hz, where a line is there that a record can tell from its neighbours: of both, that which a line is nearer to. Mains are
    /// within half a hertz of what they should be.
    fn mains(&self) -> Option<f64> {
        let off = |hum: f64| {
            let each = self.lines.iter().map(|line| {
                ((line.frequency_hz.abs() - hum).abs() - 3.0 * line.noise_hz.min(self.bin_hz()))
                    .max(0.0)
            });
            each.fold(f64::INFINITY, f64::min)
        };
        let near = |&hum: &f64| {
            self.bin_hz() * 4.0 < hum && off(hum) < (1.5 * self.bin_hz()).clamp(0.2, 0.5)
        };
        [50.0, 60.0].into_iter().filter(near).min_by(|&a, &b| off(a).total_cmp(&off(b)))
    }

    /// Whether a line is the mains' or one of its harmonics.
    fn of_hum(&self, line: &Spectral, hum: f64) -> bool {
        let order = (line.frequency_hz.abs() / hum).round();
        let off = (line.frequency_hz.abs() - order * hum).abs();
        (1.0..=12.0).contains(&order)
            && off < (1.5 * self.bin_hz()).max(0.002 * order * hum).min(hum / 8.0)
    }

    /// Tries ways of measuring on the samples.
    fn tried(&self, samples: &[Complex<f64>], alone_hz: Option<f64>) -> Finding {
        let tone = self.tone.and_then(|tone| self.lines.get(tone));
        let band = |tone: &Spectral| self.band(tone, self.n.min(USUAL));
        let hum = |line: &&Spectral| self.hum_hz.is_some_and(|hum| self.of_hum(line, hum));
        let known = Known {
            hum_hz: self.hum_hz,
            alone_hz,
            bands: tone.map(band).into_iter().collect(),
            lines: self.lines.iter().filter(|line| !hum(line)).count(),
            comb_hz: self.comb_hz(),
            row: self.row,
            line: tone
                .filter(|line| line.verdict == Verdict::Good.name())
                .map(|it| (it.frequency_hz, it.noise_hz)),
            series: self.series,
        };
        let (codes, scale) = self.codes();
        let (iq, rate_hz, records) = (self.iq, self.rate_hz, self.row.is_some());
        let ground = Ground { samples, iq, rate_hz, codes, scale, records };
        let mut finding = nature::finding(ground, &known);
        if let Some((way, ..)) = &finding.held
            && self.uneven(way.n).is_some()
        {
            finding = Finding::bare(Nature::Unknown);
        }
        finding
    }

    /// Why blocks of this length are not measured, where the samples lie too unevenly in time.
    fn uneven(&self, n: usize) -> Option<String> {
        let clock = self.clock.filter(|clock| clock.walk_s > 0.0)?;
        let line = self.tone.and_then(|tone| self.lines.get(tone))?;
        let off_hz = line.frequency_hz.abs() * clock.share(n);
        (off_hz > 0.5 * line.noise_hz).then(|| uneven(&clock, n))
    }

    /// A sigma by the noise together with the rate's own, in blocks of this length.
    fn with_rate(&self, hertz: f64, sigma_hz: f64, n: usize) -> f64 {
        sigma_hz.hypot(hertz * self.clock.map_or(0.0, |clock| clock.share(n)))
    }

    /// The distance of the strongest lines, where all are as far apart, or multiples of that.
    fn comb_hz(&self) -> Option<f64> {
        let mut hz: Vec<f64> = self.lines.iter().map(|line| line.frequency_hz).collect();
        hz.sort_by(f64::total_cmp);
        let least = hz.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let (first, last) = (*hz.first()?, *hz.last()?);
        let steps = ((last - first) / least).round();
        let step = (last - first) / steps;
        let off = |hz: &f64| ((hz - first) / step - ((hz - first) / step).round()).abs();
        let even = hz.len() >= 3 && steps < 64.0 && hz.iter().all(|hz| off(hz) < 0.08);
        (even && step > 3.0 * self.bin_hz()).then_some(step)
    }

    /// The codes, and the factor to them.
    fn codes(&self) -> (Codes, f64) {
        match self.width() {
            Some(Width::Unsigned12) if self.scaling == Scaling::CODES => {
                (Codes::unsigned::<12>(), 1.0)
            }
            Some(Width::Unsigned12) => (Codes::signed::<16>(), 1.0),
            Some(Width::Scale(scale)) => (Codes::signed::<16>(), scale),
            None => (Codes::signed::<16>(), 1.0),
        }
    }

    /// What a person has to say of the codes.
    fn width(&self) -> Option<Width> {
        let Levels { low, high, step, clipped, .. } = self.levels;
        let [bottom, top] = [low, high].map(|code| self.scaling.number(code));
        let whole = self.scaling.factor == 1.0 && step.is_some();
        if whole && bottom >= 0.0 && top <= 4095.0 {
            Some(Width::Unsigned12)
        } else if self.scaling == Scaling::CODES && clipped > 0.0 && high.max(-low) < 32000.0 {
            Some(Width::Scale(32767.0 / high.min(-low).max(1e-12)))
        } else {
            None
        }
    }

    /// What to type, after the file and how it is read: the way that held.
    pub fn proposal(&self) -> Option<String> {
        let width = match self.width() {
            Some(Width::Unsigned12) => " --bits 12 --unsigned".into(),
            Some(Width::Scale(scale)) => format!(" --scale {scale:.4}"),
            None => String::new(),
        };
        let (way, ..) = self.finding.held.as_ref()?;
        Some(self.words(way) + &width)
    }

    /// The words of a way.
    fn words(&self, way: &Way) -> String {
        let Way { n, hop, skip, band_hz, of } = *way;
        let mut words = format!("--n {n}");
        if of == Of::Bursts {
            return words + " --burst";
        }
        if hop != n {
            words += &format!(" --hop {hop}");
        }
        if skip > 0 {
            words += &format!(" --skip {skip}");
        }
        if let Some(band_hz) = band_hz {
            words += &self.band_words(band_hz, n);
        }
        match of {
            Of::Track => words + " --track",
            Of::Harmonics(order) => words + &format!(" --harmonics {order}"),
            Of::Blocks | Of::Bursts => words,
        }
    }

    /// A band, rounded to a tenth of a bin, inwards: the rate's half may have digits of its own.
    fn band_words(&self, (low, high): (f64, f64), n: usize) -> String {
        let digits = (10.0 * n as f64 / self.rate_hz).log10().ceil().clamp(0.0, 12.0);
        let unit = 10f64.powf(-digits);
        let (low, high) = ((low / unit).ceil() * unit, (high / unit).floor() * unit);
        format!(" --band {low:.0$}:{high:.0$}", digits as usize)
    }

    /// From half-way to the next line below to half-way to the next one above.
    fn band(&self, tone: &Spectral, n: usize) -> (f64, f64) {
        let (f, half, bin) = (tone.frequency_hz, self.rate_hz / 2.0, self.rate_hz / n as f64);
        let ends = if self.iq { (-half, half) } else { (0.0, half) };
        let near = |side: f64| {
            let others = self.lines.iter().map(|line| (line.frequency_hz - f) * side);
            others.filter(|&off| off > 0.5 * bin).fold(f64::INFINITY, f64::min) / 2.0
        };
        // A tone that moves stays in it for a while.
        let width = (f.abs() / 4.0).max(8.0 * bin);
        ((f - near(-1.0).min(width)).max(ends.0), (f + near(1.0).min(width)).min(ends.1))
    }
}
