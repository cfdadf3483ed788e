//! What an unknown recording holds, and the command that measures it.

mod spectrum;
mod values;

use crate::arithmetic::{Arithmetic, Estimate, engine};
use crate::estimator::Estimator;
use crate::recording::{Options, Recording, RecordingError};
use crate::report::chart::{Axis, Chart, Series, Style};
use crate::with_kind;
use picket::acquire::codes::Codes;
use picket::config::Config;
use picket::estimate::least_squares::Reach;
use picket_transform::num_complex::Complex;
use spectrum::{floored, powers};
use std::path::Path;
use values::{Values, values};

/// What is looked at of a recording, in samples.
const MOST: usize = 1 << 20;
/// The longest and the shortest record that it is cut into.
const LONGEST: usize = 1 << 15;
const SHORTEST: usize = 64;
/// The longest record that is proposed unless lines are near each other.
const USUAL: usize = 4096;
/// Lines that are told, and how far above the floor they stand, in dB.
const LINES: usize = 6;
const ABOVE_DB: f64 = 13.0;
/// Lines so far below the strongest one are not told, in dB: a converter's own.
const BELOW_DB: f64 = 70.0;
/// Points of the drawn spectrum: each is the strongest of its bins.
const POINTS: usize = 800;
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
    values: Values,
    /// Codes per unit of the file.
    scale: f64,
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
}

/// A line of the spectrum.
#[derive(Clone, Copy, Debug)]
pub struct Spectral {
    /// Its frequency.
    pub frequency_hz: f64,
    sigma_hz: f64,
    /// Above the floor.
    above_db: f64,
    verdict: &'static str,
}

impl Survey {
    /// Looks at the first million samples.
    pub fn of(file: &Path, read: Options) -> Result<Self, String> {
        let recording = Recording::open(file, read).map_err(|error| error.to_string())?;
        let (rate_hz, iq) = (recording.rate_hz(), recording.iq());
        let mut samples = Vec::new();
        for sample in recording.samples().take(MOST) {
            samples.push(sample.map_err(|error| error.to_string())?.value);
        }
        if samples.len() < SHORTEST {
            let short = RecordingError::Short(file.into(), samples.len() as u64, SHORTEST);
            return Err(short.to_string());
        }
        let n = LONGEST.min(1 << samples.len().ilog2());
        let powers = powers(&samples, n);
        let mut survey = Survey {
            rate_hz,
            iq,
            samples: samples.len(),
            values: values(&samples),
            scale: read.scale,
            n,
            power: floored(&powers, rate_hz, iq),
            lines: Vec::new(),
            hum_hz: None,
            tone: None,
        };
        survey.lines = survey.peaks(&samples);
        survey.hum_hz = survey.hum();
        let hum = |line: &Spectral| survey.hum_hz.is_some_and(|hum| survey.of_hum(line, hum));
        survey.tone = survey.lines.iter().position(|line| !hum(line));
        if survey.tone.is_none() && !survey.lines.is_empty() {
            // Nothing but the mains: they are what was recorded.
            survey.tone = Some(0);
        }
        Ok(survey)
    }

    fn bin_hz(&self) -> f64 {
        self.rate_hz / self.n as f64
    }

    /// The strongest lines, each measured in its own band in the middle of the recording.
    fn peaks(&self, samples: &[Complex<f64>]) -> Vec<Spectral> {
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
        let strongest = found.first().map_or(0.0, |line| line.1);
        found.retain(|line| line.1 > strongest - BELOW_DB);
        found.truncate(LINES);
        let measured = |&(hertz, power, above_db): &(f64, f64, f64)| {
            // Wide enough for the noise around it to be seen, and no stronger line within.
            let stronger = found.iter().filter(|line| line.1 > power);
            let free =
                stronger.map(|line| (line.0 - hertz).abs() / 2.0).fold(f64::INFINITY, f64::min);
            let width = free.min(64.0 * self.bin_hz()).max(3.0 * self.bin_hz());
            let estimate = self.measured(samples, (hertz - width, hertz + width));
            match estimate.filter(|estimate| estimate.bins.is_finite()) {
                Some(Estimate { bins, sigma_bins, verdict, .. }) => {
                    let signed = if self.iq && bins > self.n as f64 / 2.0 {
                        bins - self.n as f64
                    } else {
                        bins
                    };
                    Spectral {
                        frequency_hz: signed * self.bin_hz(),
                        sigma_hz: sigma_bins * self.bin_hz(),
                        above_db,
                        verdict: verdict.name(),
                    }
                }
                None => Spectral {
                    frequency_hz: hertz,
                    sigma_hz: f64::NAN,
                    above_db,
                    verdict: "no-signal",
                },
            }
        };
        found.iter().map(measured).collect()
    }

    fn measured(&self, samples: &[Complex<f64>], band: (f64, f64)) -> Option<Estimate> {
        let start = (samples.len() - self.n) / 2;
        let record = &samples[start..start + self.n];
        let half = self.rate_hz / 2.0;
        let low = if self.iq { -half } else { 0.0 };
        let band_hz = Some((band.0.max(low), band.1.min(half)));
        let config = Config { band_hz, ..Config::new(self.rate_hz, Codes::signed::<16>()) };
        with_kind!(self.iq, R => {
            let plan = config.terms::<R>(self.n).ok()?;
            let mut engine = engine::<R>(Arithmetic::F64, self.n, plan).ok()?;
            engine.measure(record, &[Estimator::best(self.iq, Reach::Four)], false).pop()
        })
    }

    /// 50 or 60 Hz, where a line is there that a record can tell from its neighbours: of both, that which a line is nearer to.
    fn hum(&self) -> Option<f64> {
        let off = |hum: f64| {
            let each = self.lines.iter().map(|line| (line.frequency_hz.abs() - hum).abs());
            each.fold(f64::INFINITY, f64::min)
        };
        let near =
            |&hum: &f64| self.bin_hz() * 4.0 < hum && off(hum) < 1.5 * self.bin_hz().max(0.2);
        [50.0, 60.0].into_iter().filter(near).min_by(|&a, &b| off(a).total_cmp(&off(b)))
    }

    /// Whether a line is the mains' or one of its harmonics.
    fn of_hum(&self, line: &Spectral, hum: f64) -> bool {
        let order = (line.frequency_hz.abs() / hum).round();
        let off = (line.frequency_hz.abs() - order * hum).abs();
        (1.0..=12.0).contains(&order)
            && off < (1.5 * self.bin_hz()).max(0.002 * order * hum).min(hum / 8.0)
    }

    /// What to type, after the file and how it is read.
    pub fn proposal(&self) -> Option<String> {
        let tone = self.lines.get(self.tone?)?;
        let others = || self.lines.iter().filter(|line| !std::ptr::eq(*line, tone));
        let apart = others().map(|line| (line.frequency_hz - tone.frequency_hz).abs());
        let apart = apart.fold(tone.frequency_hz.abs(), f64::min);
        let mut n = self.n.min(USUAL);
        while n < self.n && apart * (n as f64) < 16.0 * self.rate_hz {
            n *= 2;
        }
        let mut words = format!("--n {n}");
        let stronger = self.tone != Some(0);
        if stronger || self.hum_hz.is_some() {
            // Rounded to a tenth of a bin, inwards: the rate's half may have digits of its own.
            let digits = (10.0 * n as f64 / self.rate_hz).log10().ceil().clamp(0.0, 12.0);
            let unit = 10f64.powf(-digits);
            let (low, high) = self.band(tone, n);
            let (low, high) = ((low / unit).ceil() * unit, (high / unit).floor() * unit);
            words += &format!(" --band {low:.0$}:{high:.0$}", digits as usize);
        }
        if stronger {
            // The sides of a stronger line reach far without a window.
            words += " --method grandke";
        }
        let Values { low, high, step, clipped, .. } = self.values;
        if step.is_some() && low >= 0.0 && high <= 4095.0 {
            words += " --bits 12 --unsigned";
        } else if self.scale == 1.0 && clipped > 0.0 && high.max(-low) < 32000.0 {
            words += &format!(" --scale {:.4}", 32767.0 / high.min(-low).max(1e-12));
        }
        Some(words)
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

    /// The lines for a person; `command` is what was typed of the file and how it is read.
    pub fn text(&self, command: &str) -> String {
        let Values { low, high, mean, rms, step, clipped } = self.values;
        let kind = if self.iq { "I/Q" } else { "real" };
        let seconds = self.samples as f64 / self.rate_hz;
        let mut text = format!(
            "rate      {} Hz, {kind}, {} samples looked at ({seconds:.4} s)\n",
            self.rate_hz, self.samples
        );
        text += &format!(
            "values    {} to {}, mean {}, rms without it {}",
            digits(low),
            digits(high),
            digits(mean),
            digits(rms)
        );
        text += &match step {
            Some(step) => {
                let bits = ((high - low) / step + 1.0).log2().ceil().max(1.0);
                format!("; in steps of {step}: {bits} bits are used\n")
            }
            None => "\n".into(),
        };
        text += &match clipped > 0.0 {
            true => format!(
                "clipped   {:.2} % of the samples lie at either end: lower the gain\n",
                100.0 * clipped
            ),
            false => "clipped   no\n".into(),
        };
        text += &match self.hum_hz {
            Some(hum) => format!("hum       {hum} Hz is among the lines\n"),
            None => "hum       none seen\n".into(),
        };
        if self.lines.is_empty() {
            return text
                + "lines     none stands out of the noise; --plot FILE.svg draws the spectrum\n";
        }
        text += "lines         frequency Hz      sigma Hz  dB over the floor  verdict\n";
        for line in &self.lines {
            let Spectral { frequency_hz, sigma_hz, above_db, verdict } = line;
            text += &format!(
                "          {frequency_hz:16.4} {sigma_hz:13.6} {above_db:18.1}  {verdict}\n"
            );
        }
        match self.proposal() {
            Some(proposal) => text + &format!("try       picket analyze {command} {proposal}\n"),
            None => text,
        }
    }

    /// The spectrum with its floor.
    pub fn draw(&self, file: &Path, picture: &Path) -> Result<(), String> {
        let bottom = self.power.iter().map(|p| p.2).fold(f64::INFINITY, f64::min);
        let top = self.power.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
        let (bottom, top) = ((bottom / 10.0).floor() * 10.0 - 10.0, (top / 10.0).ceil() * 10.0);
        let together = self.power.len().div_ceil(POINTS);
        let points = |value: fn(&(f64, f64, f64)) -> f64| {
            self.power.chunks(together).map(move |bins| {
                let highest = bins.iter().map(value).fold(bottom, f64::max);
                (bins[0].0, highest)
            })
        };
        let half = self.rate_hz / 2.0;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let marks = self.lines.iter().map(|line| {
            let nearest = self.power.iter().min_by(|a, b| {
                (a.0 - line.frequency_hz).abs().total_cmp(&(b.0 - line.frequency_hz).abs())
            });
            (line.frequency_hz, nearest.map_or(bottom, |point| point.1))
        });
        let chart = Chart {
            name: "spectrum",
            title: format!("Spectrum of {name}, N = {}", self.n),
            x: Axis::linear("frequency, Hz", if self.iq { -half } else { 0.0 }, half),
            y: Axis::linear("dB of a full-scale sine", bottom, top),
            series: vec![
                Series::new("spectrum", Style::Line, 0, points(|p| p.1)),
                Series::new("floor", Style::Dashed, 1, points(|p| p.2)),
                Series::new("lines", Style::Points, 2, marks),
            ],
        };
        chart.save(picture)
    }
}

/// Four digits and more.
fn digits(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let before = value.abs().max(1e-9).log10().floor();
    format!("{value:.*}", (3.0 - before).clamp(0.0, 12.0) as usize)
}
