//! The library at work on records whose kind and length are known only when the page says them.

use crate::answer::Answer;
use crate::settings::{Kind, Settings};
use picket_dsp::accumulate::Accumulator;
use picket_dsp::acquire::sample::{Iq, Real, Record, Segment, Stamp};
use picket_dsp::config::{Config, ConfigError};
use picket_dsp::pipeline::{Measurement, Pipeline};
use picket_dsp::plan::{Plan, Terms};
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::peak::{self, Peak};
use picket_dsp::tracker::Tracker;
use std::f64::consts::PI;

/// Measures blocks, and remembers the last of which there is a picture.
pub trait Station {
    /// Takes a block; what its samples lack reads zero. Gives its measurement, or that of the sum which it completes.
    fn block(&mut self, stamp: Stamp, samples: &[[i16; 2]]) -> Option<Measurement>;
    /// The tracks of a segment: number, frequency in Hz, sigma in Hz, blocks since it was seen; held ones alone.
    fn tracks(&self, segment: Segment, into: &mut Vec<f64>);
    /// The spectrum of the last block, see [`Picture`].
    fn picture(&mut self) -> Picture;
    /// Appends the samples of that block, two codes each, and what the tones' module is told of them.
    fn shown(&self, samples: &mut Vec<u8>, terms: &mut Vec<f64>);
    /// What the blocks are measured by.
    fn terms(&self) -> &Terms;
}

/// A spectrum in dB of a sine from rail to rail, and what is said of it.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// The first bin's frequency and the distance of two bins, Hz.
    pub first_hz: f64,
    /// See there.
    pub step_hz: f64,
    /// The noise floor that the search saw: the mean of the bins away from the peak.
    pub floor_db: f64,
    /// What a peak must exceed.
    pub threshold_db: f64,
    /// The bins, from the lowest frequency on.
    pub bins_db: Vec<f64>,
    /// The tone of the same block.
    pub hertz: f64,
    /// Its sigma.
    pub sigma_hz: f64,
    /// Its amplitude.
    pub tone_db: f64,
}

struct Bench<R: Record, const N: usize> {
    plan: Plan<R, N>,
    tracker: Box<Tracker<R, N>>,
    spectrum: Box<Spectrum<R, N>>,
    shown: Box<[R::Sample; N]>,
    measured: Measurement,
    full_scale: f64,
    added: Option<Box<Added<R, N>>>,
}

/// Blocks that are added without their phases.
struct Added<R: Record, const N: usize> {
    pipeline: Pipeline<R, N>,
    accumulator: Accumulator<R, N>,
    /// The powers of the bins, from bin 0 on, of the sum in progress, and the mean of the last one that was complete.
    powers: Vec<f64>,
    mean: Vec<f64>,
    /// The last sum's answer.
    measured: Measurement,
}

/// A station for these settings.
///
/// # Errors
/// Why they cannot work: a value, or the length is none of 1024, 2048 and 4096, since shorter ones would make the page larger.
pub fn station(settings: &Settings) -> Result<Box<dyn Station>, String> {
    if settings.sum > 1 && settings.kind == Kind::Chirp {
        return Err("sums are of a tone or a Doppler shift, not of a chirp's ramps".into());
    }
    let (config, full_scale) = (settings.config(), settings.full_scale());
    let station = match settings.iq {
        true => from_kind::<Iq>(&config, settings.n, full_scale, settings.sum),
        false => from_kind::<Real>(&config, settings.n, full_scale, settings.sum),
    };
    station.map_err(|error| error.to_string())
}

/// A station for a configuration, each of whose blocks has its own answer.
///
/// # Errors
/// See [`station`].
pub fn from_config(
    config: &Config,
    iq: bool,
    n: usize,
    full_scale: f64,
) -> Result<Box<dyn Station>, ConfigError> {
    match iq {
        true => from_kind::<Iq>(config, n, full_scale, 1),
        false => from_kind::<Real>(config, n, full_scale, 1),
    }
}

fn from_kind<R: Record>(
    config: &Config,
    n: usize,
    full_scale: f64,
    sum: u32,
) -> Result<Box<dyn Station>, ConfigError> {
    match n {
        1024 => Bench::<R, 1024>::boxed(config, full_scale, sum),
        2048 => Bench::<R, 2048>::boxed(config, full_scale, sum),
        4096 => Bench::<R, 4096>::boxed(config, full_scale, sum),
        _ => Err(ConfigError::Length),
    }
}

impl<R: Record, const N: usize> Bench<R, N> {
    fn boxed(config: &Config, full_scale: f64, sum: u32) -> Result<Box<dyn Station>, ConfigError> {
        let plan = config.plan::<R, N>()?;
        let added = (sum > 1).then(|| Box::new(Added::new(plan, config.false_alarm, sum)));
        Ok(Box::new(Self {
            plan,
            tracker: Box::new(Tracker::new(plan)),
            spectrum: Box::new(Spectrum::new()),
            shown: Box::new([R::Sample::default(); N]),
            measured: Measurement::default(),
            full_scale,
            added,
        }))
    }
}

impl<R: Record, const N: usize> Added<R, N> {
    fn new(plan: Plan<R, N>, false_alarm: f64, sum: u32) -> Self {
        Self {
            pipeline: Pipeline::new(plan),
            accumulator: Accumulator::new(sum).with_false_alarm(false_alarm),
            powers: vec![0.0; N],
            mean: Vec::new(),
            measured: Measurement::default(),
        }
    }

    fn block(&mut self, stamp: Stamp, record: &[R::Sample; N]) -> Option<Measurement> {
        let measurement = self.pipeline.block(&stamp, record);
        let spectrum = self.pipeline.spectrum();
        let unit = libm::ldexp(1.0, 2 * spectrum.exponent());
        for (power, k) in self.powers.iter_mut().zip(0..) {
            *power += unit * spectrum.power(k) as f64;
        }
        let sum = self.accumulator.add(&measurement, &self.pipeline)?;
        let blocks = f64::from(sum.blocks);
        self.mean = self.powers.iter().map(|power| power / blocks).collect();
        self.powers.fill(0.0);
        let result = self.pipeline.outcome(&sum.tone);
        self.measured = Measurement { tone: sum.tone, result, ..measurement };
        Some(self.measured)
    }
}

impl<R: Record, const N: usize> Station for Bench<R, N> {
    fn block(&mut self, stamp: Stamp, samples: &[[i16; 2]]) -> Option<Measurement> {
        let mut parts = samples.iter().copied();
        let record = std::array::from_fn(|_| R::from_parts(parts.next().unwrap_or_default()));
        if let Some(added) = &mut self.added {
            *self.shown = record;
            return added.block(stamp, &record);
        }
        let measurement = self.tracker.block(&stamp, &record);
        // Of a chirp the rising ramp is drawn: three spectra in turn are a flicker.
        if matches!(stamp.segment, Segment::Continuous | Segment::Up) {
            *self.shown = record;
            self.measured = measurement;
        }
        Some(measurement)
    }

    fn tracks(&self, segment: Segment, into: &mut Vec<f64>) {
        let rate_hz = self.terms().rate_hz;
        for track in self.tracker.tracks(segment) {
            if track.state == picket_dsp::solve::track::State::Held {
                into.extend([
                    f64::from(track.number),
                    track.tone.frequency.hertz(rate_hz),
                    f64::from(track.tone.sigma) * rate_hz,
                    f64::from(track.misses),
                ]);
            }
        }
    }

    fn picture(&mut self) -> Picture {
        let terms = *self.terms();
        self.spectrum.transform(&self.shown, terms.codes);
        let spectrum = &self.spectrum;
        let unit = libm::ldexp(1.0, 2 * spectrum.exponent());
        let lines = if R::IQ { N as f64 } else { N as f64 / 2.0 };
        let scale = 1.0 / lines / self.full_scale;
        let decibels = |power: f64| 10.0 * libm::log10(power * scale * scale + 1e-20);
        let found = peak::find(&spectrum.view(), terms.band);
        let floor = |peak: &Peak| peak.floor as f64 / f64::from(peak.floor_bins.max(1));
        let mut floor = found.as_ref().map_or(0.0, |peak| unit * floor(peak));
        let over = |peak: &Peak| f64::from(terms.options.threshold.over(peak.floor_bins));
        let mut over = found.as_ref().map_or(1.0, over);
        let first = if R::IQ { -(N as i32) / 2 } else { 0 };
        let last = if R::IQ { N as i32 / 2 - 1 } else { N as i32 / 2 };
        // From bin 0 on.
        let mean = self.added.as_ref().map_or(&[][..], |added| &added.mean);
        let power = |k: i32| match mean.get(k.rem_euclid(N as i32) as usize) {
            Some(power) => *power,
            None => unit * spectrum.power(k) as f64,
        };
        let mut tone = self.measured.tone;
        if let Some(added) = &self.added {
            tone = added.measured.tone;
            if !mean.is_empty() {
                floor = median((first..=last).map(power).collect());
                over = over_mean(over, added.accumulator.blocks());
            }
        }
        Picture {
            first_hz: f64::from(first) * terms.rate_hz / N as f64,
            step_hz: terms.rate_hz / N as f64,
            floor_db: decibels(floor),
            threshold_db: decibels(floor * over),
            bins_db: (first..=last).map(|k| decibels(power(k))).collect(),
            hertz: tone.hertz(),
            sigma_hz: tone.sigma_hertz(),
            tone_db: 20.0 * libm::log10(f64::from(tone.amplitude) / self.full_scale + 1e-10),
        }
    }

    fn shown(&self, samples: &mut Vec<u8>, terms: &mut Vec<f64>) {
        samples.extend(self.shown.iter().flat_map(|&s| R::parts(s)).flat_map(i16::to_le_bytes));
        let Terms { codes, band, rate_hz, .. } = *self.plan;
        let bits = f64::from(codes.bits());
        let bits = if codes.rails().0 < 0 { bits } else { -bits };
        let Measurement { stamp, clipped, tone, .. } = &self.measured;
        terms.extend([N as f64, R::IQ.into(), bits, rate_hz, band.low.into(), band.high.into()]);
        terms.extend([f64::from(*clipped), stamp.gap.into()]);
        terms.extend([tone.frequency.cycles(), tone.sigma.into(), tone.snr.into()]);
        terms.extend([tone.amplitude.into(), f64::from(tone.verdict as u8)]);
        terms.extend([tone.also.bits().into(), f64::from(stamp.segment as u8)]);
    }

    fn terms(&self) -> &Terms {
        &self.plan
    }
}

fn median(mut powers: Vec<f64>) -> f64 {
    powers.sort_by(f64::total_cmp);
    powers.get(powers.len() / 2).copied().unwrap_or(0.0)
}

/// The power over its mean that a mean of so many bins of noise exceeds as often as one bin exceeds `over`: by Wilson's and Hilferty's cube
/// root, whose variance is a ninth of the number's inverse.
fn over_mean(over: f64, blocks: u32) -> f64 {
    let deviations = 3.0 * (libm::cbrt(over) - 8.0 / 9.0);
    let part = 1.0 / (9.0 * f64::from(blocks.max(1)));
    let root = 1.0 - part + deviations * part.sqrt();
    root * root * root
}

impl Picture {
    /// The fitted tone as bins would show it, from `low_hz` to `high_hz` in so many steps: frequency and dB in turn.
    pub fn fitted(&self, n: usize, low_hz: f64, high_hz: f64, steps: usize, into: &mut Vec<f64>) {
        let n = n as f64;
        for step in 0..=steps {
            let hertz = low_hz + (high_hz - low_hz) * step as f64 / steps as f64;
            let off = PI * (hertz - self.hertz) / self.step_hz;
            let share =
                if off.abs() < 1e-9 { 1.0 } else { libm::sin(off) / (n * libm::sin(off / n)) };
            into.extend([hertz, self.tone_db + 20.0 * libm::log10(share.abs() + 1e-6)]);
        }
    }
}

/// The answer to a block.
pub fn answer(measurement: &Measurement, terms: &Terms) -> Answer {
    Answer::of(measurement, terms.n as usize, terms.iq, terms.rate_hz)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    /// A station that adds blocks answers as the library's accumulator, once a sum, and refuses chirps.
    #[test]
    fn a_sum_is_the_accumulators() {
        const N: usize = 1024;
        let mut settings = Settings { sum: 25, ..Settings::default() };
        let mut scene = Scene::new(7);
        assert!(scene.set("snr_db", -14.0) && scene.set("tone_hz", 1000.3));
        let mut station = station(&settings).unwrap();
        let plan = settings.config().plan::<Real, N>().unwrap();
        let mut pipeline = Box::new(Pipeline::<Real, N>::new(plan));
        let mut accumulator = Box::new(Accumulator::<Real, N>::new(25));
        let mut sums = 0;
        for _ in 0..60 {
            let (stamp, samples, truth) = scene.block(&settings);
            let record = std::array::from_fn(|index| samples[index][0]);
            let measurement = pipeline.block(&stamp, &record);
            let wanted = accumulator.add(&measurement, &pipeline).map(|sum| sum.tone);
            let told = station.block(stamp, &samples).map(|told| told.tone);
            assert_eq!(told, wanted);
            let Some(tone) = told else { continue };
            let off = (tone.hertz() - truth.hertz) / tone.sigma_hertz();
            assert!(off.abs() < 5.0, "{off}");
            // The line stands out of the mean of the bins, and nothing else exceeds the threshold.
            let picture = station.picture();
            let above = |&(_, &power): &(usize, &f64)| power > picture.threshold_db;
            let above: Vec<_> = picture.bins_db.iter().enumerate().filter(above).collect();
            let near = |k: usize| (k as f64 * picture.step_hz - truth.hertz).abs();
            assert!(above.iter().all(|&(k, _)| near(k) < 3.0 * picture.step_hz), "{above:?}");
            assert!(!above.is_empty() && picture.hertz == tone.hertz());
            sums += 1;
        }
        assert_eq!(sums, 2);
        settings.kind = Kind::Chirp;
        assert!(super::station(&settings).is_err());
    }

    #[test]
    fn one_block_has_its_own_threshold() {
        for over in [12.0, 20.7, 40.0] {
            assert!((over_mean(over, 1) / over - 1.0).abs() < 1e-9);
        }
        // A hundred numbers' mean has a deviation of a tenth: five to six of them.
        assert!((1.5..1.7).contains(&over_mean(20.7, 100)));
    }
}
