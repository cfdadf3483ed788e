//! The library at work on records whose kind and length are known only when the page says them.

use crate::answer::Answer;
use crate::settings::Settings;
use picket::acquire::sample::{Iq, Real, Record, Segment, Stamp};
use picket::config::{Config, ConfigError};
use picket::pipeline::Measurement;
use picket::plan::{Plan, Terms};
use picket::spectrum::{Spectrum, peak};
use picket::tracker::Tracker;
use std::f64::consts::PI;

/// Measures blocks, and remembers the last of which there is a picture.
pub trait Station {
    /// Measures a block; what its samples lack reads zero.
    fn block(&mut self, stamp: Stamp, samples: &[[i16; 2]]) -> Measurement;
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
}

/// A station for these settings.
///
/// # Errors
/// A value cannot work, or the length is none of 1024, 2048 and 4096: shorter ones would make the page larger.
pub fn station(settings: &Settings) -> Result<Box<dyn Station>, ConfigError> {
    of_config(&settings.config(), settings.iq, settings.n, settings.full_scale())
}

/// A station for a configuration.
///
/// # Errors
/// See [`station`].
pub fn of_config(
    config: &Config,
    iq: bool,
    n: usize,
    full_scale: f64,
) -> Result<Box<dyn Station>, ConfigError> {
    if iq { of_kind::<Iq>(config, n, full_scale) } else { of_kind::<Real>(config, n, full_scale) }
}

fn of_kind<R: Record>(
    config: &Config,
    n: usize,
    full_scale: f64,
) -> Result<Box<dyn Station>, ConfigError> {
    match n {
        1024 => Bench::<R, 1024>::boxed(config, full_scale),
        2048 => Bench::<R, 2048>::boxed(config, full_scale),
        4096 => Bench::<R, 4096>::boxed(config, full_scale),
        _ => Err(ConfigError::Length),
    }
}

impl<R: Record, const N: usize> Bench<R, N> {
    fn boxed(config: &Config, full_scale: f64) -> Result<Box<dyn Station>, ConfigError> {
        let plan = config.plan::<R, N>()?;
        Ok(Box::new(Self {
            plan,
            tracker: Box::new(Tracker::new(plan)),
            spectrum: Box::new(Spectrum::new()),
            shown: Box::new([R::Sample::default(); N]),
            measured: Measurement::default(),
            full_scale,
        }))
    }
}

impl<R: Record, const N: usize> Station for Bench<R, N> {
    fn block(&mut self, stamp: Stamp, samples: &[[i16; 2]]) -> Measurement {
        let mut parts = samples.iter().copied();
        let record = std::array::from_fn(|_| R::of_parts(parts.next().unwrap_or_default()));
        let measurement = self.tracker.block(stamp, &record);
        // Of a chirp the rising ramp is drawn: three spectra in turn are a flicker.
        if matches!(stamp.segment, Segment::Continuous | Segment::Up) {
            *self.shown = record;
            self.measured = measurement;
        }
        measurement
    }

    fn tracks(&self, segment: Segment, into: &mut Vec<f64>) {
        let rate_hz = self.terms().rate_hz;
        for track in self.tracker.tracks(segment) {
            if track.state == picket::solve::track::State::Held {
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
        let unit = libm::ldexp(1.0, spectrum.exponent());
        let lines = if R::IQ { N as f64 } else { N as f64 / 2.0 };
        let scale = unit / lines / self.full_scale;
        let decibels = |power: f64| 10.0 * libm::log10(power * scale * scale + 1e-20);
        let found = peak::find(spectrum, terms.band);
        let floor = found.map_or(0.0, |peak| peak.floor as f64 / f64::from(peak.floor_bins.max(1)));
        let over = found.map_or(1.0, |peak| terms.options.threshold.over(peak.floor_bins).into());
        let first = if R::IQ { -(N as i32) / 2 } else { 0 };
        let last = if R::IQ { N as i32 / 2 - 1 } else { N as i32 / 2 };
        let tone = self.measured.tone;
        Picture {
            first_hz: f64::from(first) * terms.rate_hz / N as f64,
            step_hz: terms.rate_hz / N as f64,
            floor_db: decibels(floor),
            threshold_db: decibels(floor * over),
            bins_db: (first..=last).map(|k| decibels(spectrum.power(k) as f64)).collect(),
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
