//! The library at work on records whose kind and length are known only at run time.

use crate::answer::Answer;
use crate::moved::{Moved, SWINGS, Swing, Ways};
use crate::record::record;
use crate::settings::{Kind, Settings};
use picket_dsp::accumulate::{Accumulated, Accumulator, MOST_BLOCKS};
use picket_dsp::acquire::kind::{ForRecord, for_record};
use picket_dsp::acquire::sample::{Iq, Real, Record, Segment, Stamp};
use picket_dsp::config::{Config, ConfigError};
use picket_dsp::pipeline::{Measurement, Outcome, Pipeline};
use picket_dsp::plan::{Plan, Terms};
use picket_dsp::solve::track::{State, Track};
use picket_dsp::spectrum::peak::{self, Peak};
use picket_dsp::spectrum::view::View;
use picket_dsp::tone::Tone;
use picket_dsp::tone::lines::MOST;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::tracker::Tracker;
use std::f64::consts::PI;

/// The calls that are compiled for every kind and length of records. A record comes as [`Record::pairs`] gives it.
trait Bench {
    /// [`Tracker::block`].
    fn block(&mut self, stamp: &Stamp, record: &[[i16; 2]]) -> Option<Measurement>;
    /// [`Tracker::tracks`].
    fn tracks(&self, segment: Segment) -> &[Track];
    /// [`Accumulator::add`], of the last block.
    fn add(&mut self, block: &Measurement) -> Option<Accumulated>;
    /// [`Pipeline::outcome`](picket_dsp::Pipeline::outcome).
    fn outcome(&self, tone: &Tone) -> Outcome;
    /// [`Pipeline::look`] at a record, and its spectrum.
    fn view(&mut self, record: &[[i16; 2]]) -> (u32, View<'_>);
    /// [`Pipeline::lines`] of a record that nothing came before, the strongest first.
    fn lines(&mut self, stamp: &Stamp, record: &[[i16; 2]], most: usize) -> Vec<ToneWithPhase>;
}

struct Records<R: Record, const N: usize> {
    tracker: Tracker<R, N>,
    accumulator: Accumulator<R, N>,
    looked: Pipeline<R, N>,
}

impl<R: Record, const N: usize> Bench for Records<R, N> {
    fn block(&mut self, stamp: &Stamp, record: &[[i16; 2]]) -> Option<Measurement> {
        Some(self.tracker.block(stamp, R::samples(record).try_into().ok()?))
    }

    fn tracks(&self, segment: Segment) -> &[Track] {
        self.tracker.tracks(segment)
    }

    fn add(&mut self, block: &Measurement) -> Option<Accumulated> {
        self.accumulator.add(block, self.tracker.pipeline())
    }

    fn outcome(&self, tone: &Tone) -> Outcome {
        self.tracker.pipeline().outcome(tone)
    }

    fn view(&mut self, record: &[[i16; 2]]) -> (u32, View<'_>) {
        let clipped = R::samples(record).try_into().map_or(0, |samples| self.looked.look(samples));
        (clipped, self.looked.spectrum().view())
    }

    fn lines(&mut self, stamp: &Stamp, record: &[[i16; 2]], most: usize) -> Vec<ToneWithPhase> {
        let Ok(samples) = R::samples(record).try_into() else { return Vec::new() };
        let measurement = self.looked.block(stamp, samples);
        self.looked.lines(&measurement, most).to_vec()
    }
}

/// Makes a bench.
struct Make<'a> {
    terms: &'a Terms,
    sum: u32,
    false_alarm: f64,
}

impl ForRecord for Make<'_> {
    type Output = Result<Box<dyn Bench>, ConfigError>;

    fn run<R: Record, const N: usize>(self) -> Self::Output {
        let plan = Plan::from_terms(*self.terms)?;
        Ok(Box::new(Records::<R, N> {
            tracker: Tracker::new(plan),
            accumulator: Accumulator::new(self.sum).with_false_alarm(self.false_alarm),
            looked: Pipeline::new(plan),
        }))
    }
}

/// Measures blocks, and remembers the last of which there is a picture.
pub struct Station {
    /// What the blocks are measured by.
    pub terms: Terms,
    bench: Box<dyn Bench>,
    full_scale: f64,
    /// The samples of that block, and its measurement or that of the last sum.
    shown: Vec<[i16; 2]>,
    measured: Measurement,
    /// The blocks of a sum.
    sum: u32,
    /// The powers of the bins, from bin 0 on, of the sum in progress, and the mean of the last one that was complete.
    powers: Vec<f64>,
    mean: Vec<f64>,
    way: Option<Way>,
}

/// The displacement so far.
struct Way {
    ways: Ways,
    all: Vec<Moved>,
    /// The last block's.
    last: Option<Moved>,
}

/// So many displacements are kept, or twice as many.
const KEPT: usize = 100_000;

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

impl Station {
    /// A station for these settings.
    ///
    /// # Errors
    /// Why they cannot work: a value, or the length.
    pub fn new(settings: &Settings) -> Result<Self, String> {
        if settings.sum > 1 && settings.kind == Kind::Chirp {
            return Err("sums are of a tone or a Doppler shift, not of a chirp's ramps".into());
        }
        let (config, full_scale) = (settings.config(), settings.full_scale());
        let (iq, n, rate_hz) = (settings.iq, settings.n, settings.rate_hz);
        let mut station = Self::adding(&config, iq, n, full_scale, settings.sum)
            .map_err(|error| error.to_string())?;
        if settings.displacement && settings.kind == Kind::Doppler && settings.sum <= 1 {
            let apart = (n as f64 / rate_hz, u64::MAX);
            let ways = Ways::new(&config.scene, rate_hz, (n, iq), apart)
                .map_err(|error| error.to_string())?;
            station.way = Some(Way { ways, all: Vec::new(), last: None });
        }
        Ok(station)
    }

    /// A station for a configuration, each of whose blocks has its own answer.
    ///
    /// # Errors
    /// See [`Station::new`].
    pub fn from_config(
        config: &Config,
        iq: bool,
        n: usize,
        full_scale: f64,
    ) -> Result<Self, ConfigError> {
        Self::adding(config, iq, n, full_scale, 1)
    }

    fn adding(
        config: &Config,
        iq: bool,
        n: usize,
        full_scale: f64,
        sum: u32,
    ) -> Result<Self, ConfigError> {
        let mut terms = if iq { config.terms::<Iq>(n) } else { config.terms::<Real>(n) }?;
        let sum = sum.clamp(1, MOST_BLOCKS);
        if sum > 1 {
            // Then every block is transformed whole.
            terms.tracking.most = 0;
        }
        let make = Make { terms: &terms, sum, false_alarm: config.false_alarm };
        Ok(Self {
            bench: for_record(iq, n, make).ok_or(ConfigError::Length)??,
            terms,
            full_scale,
            shown: vec![[0; 2]; n],
            measured: Measurement::default(),
            sum,
            powers: vec![0.0; n],
            mean: Vec::new(),
            way: None,
        })
    }

    /// Takes a block; what its samples lack reads zero. Gives its measurement, or that of the sum which it completes.
    pub fn block(&mut self, stamp: Stamp, samples: &[[i16; 2]]) -> Option<Measurement> {
        let mut samples = samples.to_vec();
        samples.resize(self.terms.n as usize, [0; 2]);
        let record = record(self.terms.iq, &samples);
        let mut measurement = self.bench.block(&stamp, &record)?;
        // Of a chirp the rising ramp is drawn: three spectra in turn are a flicker.
        let drawn = matches!(stamp.segment, Segment::Continuous | Segment::Up);
        if drawn {
            self.shown = samples;
        }
        if self.sum > 1 {
            let (_, view) = self.bench.view(&record);
            let unit = libm::ldexp(1.0, 2 * view.exponent);
            for (power, k) in self.powers.iter_mut().zip(0..) {
                *power += unit * view.power(k) as f64;
            }
            measurement.tone = self.bench.add(&measurement)?.tone;
            measurement.result = self.bench.outcome(&measurement.tone);
            let blocks = f64::from(self.sum);
            self.mean = self.powers.iter().map(|power| power / blocks).collect();
            self.powers.fill(0.0);
        }
        if drawn {
            self.measured = measurement;
        }
        Some(measurement)
    }

    /// Follows the displacement to a block, before this is measured; `None` for one that is left out.
    pub fn follow(&mut self, stamp: &Stamp, samples: Option<&[[i16; 2]]>) {
        let Some(way) = &mut self.way else { return };
        let whole = Stamp { gap: false, ..*stamp };
        let record = samples.map(|samples| record(self.terms.iq, samples));
        let lines = record.map(|record| self.bench.lines(&whole, &record, MOST));
        way.last = way.ways.push(stamp.clock, stamp.gap, lines.iter().flatten().next());
        way.all.extend(way.last);
        if way.all.len() > 2 * KEPT {
            way.all.drain(..KEPT);
        }
    }

    /// Whether the displacement is followed.
    pub const fn follows(&self) -> bool {
        self.way.is_some()
    }

    /// What swings in the displacement so far.
    pub fn swings(&self) -> Vec<Swing> {
        let found = self.way.as_ref().and_then(|way| {
            let whole = way.ways.record(&way.all)?;
            let n = whole.codes.len();
            let mut station = Self::from_config(&whole.config(), false, n, 1.0).ok()?;
            let samples: Vec<[i16; 2]> = whole.codes.iter().map(|&code| [code, 0]).collect();
            let lines = station.bench.lines(&Stamp::default(), &record(false, &samples), SWINGS);
            Some(whole.swings(&lines))
        });
        found.unwrap_or_default()
    }

    /// The answer to a measurement.
    pub fn answer(&self, measurement: &Measurement) -> Answer {
        let row = Answer::of(measurement, self.terms.n as usize, self.terms.iq, self.terms.rate_hz);
        let Some(Moved { moved, .. }) = self.way.as_ref().and_then(|way| way.last) else {
            return row;
        };
        Answer {
            displacement_m: moved.metres.to_num(),
            sigma_displacement_m: moved.sigma.into(),
            displacement_start: moved.start.into(),
            displacement_verdict: f64::from(moved.verdict as u8),
            ..row
        }
    }

    /// The samples of a record that touch a rail, and its spectrum; what its samples lack reads zero.
    pub fn view(&mut self, samples: &[[i16; 2]]) -> (u32, View<'_>) {
        let mut samples = samples.to_vec();
        samples.resize(self.terms.n as usize, [0; 2]);
        self.bench.view(&record(self.terms.iq, &samples))
    }

    /// The tracks of a segment: number, frequency in Hz, sigma in Hz, blocks since it was seen; held ones alone.
    pub fn tracks(&self, segment: Segment, into: &mut Vec<f64>) {
        let rate_hz = self.terms.rate_hz;
        for track in self.bench.tracks(segment) {
            if track.state == State::Held {
                into.extend([
                    f64::from(track.number),
                    track.tone.frequency.hertz(rate_hz),
                    f64::from(track.tone.sigma) * rate_hz,
                    f64::from(track.misses),
                ]);
            }
        }
    }

    /// The spectrum of the last block.
    pub fn picture(&mut self) -> Picture {
        let terms = &self.terms;
        let (n, count) = (terms.n as i32, f64::from(terms.n));
        let (_, view) = self.bench.view(&record(terms.iq, &self.shown));
        let unit = libm::ldexp(1.0, 2 * view.exponent);
        let lines = if terms.iq { count } else { count / 2.0 };
        let scale = 1.0 / lines / self.full_scale;
        let decibels = |power: f64| 10.0 * libm::log10(power * scale * scale + 1e-20);
        let found = peak::find(&view, terms.band);
        let floor = |peak: &Peak| peak.floor as f64 / f64::from(peak.floor_bins.max(1));
        let mut floor = found.as_ref().map_or(0.0, |peak| unit * floor(peak));
        let over = |peak: &Peak| f64::from(terms.options.threshold.over(peak.floor_bins));
        let mut over = found.as_ref().map_or(1.0, over);
        let (first, last) = if terms.iq { (-n / 2, n / 2 - 1) } else { (0, n / 2) };
        // From bin 0 on.
        let power = |k: i32| match self.mean.get(k.rem_euclid(n) as usize) {
            Some(power) => *power,
            None => unit * view.power(k) as f64,
        };
        if !self.mean.is_empty() {
            floor = median((first..=last).map(power).collect());
            over = over_mean(over, self.sum);
        }
        let tone = &self.measured.tone;
        Picture {
            first_hz: f64::from(first) * terms.rate_hz / count,
            step_hz: terms.rate_hz / count,
            floor_db: decibels(floor),
            threshold_db: decibels(floor * over),
            bins_db: (first..=last).map(|k| decibels(power(k))).collect(),
            hertz: tone.hertz(),
            sigma_hz: tone.sigma_hertz(),
            tone_db: 20.0 * libm::log10(f64::from(tone.amplitude) / self.full_scale + 1e-10),
        }
    }

    /// Appends the samples of that block, two codes each, and what the tones' module is told of them.
    pub fn shown(&self, samples: &mut Vec<u8>, terms: &mut Vec<f64>) {
        samples.extend(self.shown.as_flattened().iter().copied().flat_map(i16::to_le_bytes));
        let Terms { n, iq, codes, band, rate_hz, .. } = self.terms;
        let bits = f64::from(codes.bits());
        let bits = if codes.rails().0 < 0 { bits } else { -bits };
        let Measurement { stamp, clipped, tone, .. } = &self.measured;
        terms.extend([n.into(), iq.into(), bits, rate_hz, band.low.into(), band.high.into()]);
        terms.extend([f64::from(*clipped), stamp.gap.into()]);
        terms.extend([tone.frequency.cycles(), tone.sigma.into(), tone.snr.into()]);
        terms.extend([tone.amplitude.into(), f64::from(tone.verdict as u8)]);
        terms.extend([tone.also.bits().into(), f64::from(stamp.segment as u8)]);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use picket_dsp::Pipeline;

    /// A station that adds blocks answers as the library's accumulator, once a sum, and refuses chirps.
    #[test]
    fn a_sum_is_the_accumulators() {
        const N: usize = 1024;
        let mut settings = Settings { sum: 25, ..Settings::default() };
        let mut scene = Scene::new(7);
        assert!(scene.set("snr_db", -14.0) && scene.set("tone_hz", 1000.3));
        let mut station = Station::new(&settings).unwrap();
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
        assert!(Station::new(&settings).is_err());
    }

    /// The displacement is that of the target within its sigma, and starts anew behind a block that is left out.
    #[test]
    fn a_displacement_is_followed() {
        let settings =
            Settings { kind: Kind::Doppler, iq: true, displacement: true, ..Settings::default() };
        let mut scene = Scene::new(5);
        assert!(scene.set("velocity_mps", 2.5) && scene.set("snr_db", 10.0));
        let mut station = Station::new(&settings).unwrap();
        let block_s = 1024.0 / 48e3;
        let mut first = None;
        for block in 0..200 {
            let (stamp, samples, _) = scene.block(&settings);
            station.follow(&stamp, (block != 150).then_some(&samples));
            let measurement = station.block(stamp, &samples).unwrap();
            let row = station.answer(&measurement);
            match block {
                150 => assert!(row.displacement_m.is_nan(), "{row:?}"),
                151 => {
                    let unsure = f64::from(picket_dsp::Verdict::Unresolved as u8);
                    assert_eq!((row.displacement_m, row.displacement_verdict), (0.0, unsure));
                    first = None;
                }
                _ => {
                    assert_eq!(row.displacement_start, f64::from(u8::from(block > 150)));
                    let way = row.displacement_m + 2.5 * f64::from(block) * block_s;
                    let off = (way - *first.get_or_insert(way)) / row.sigma_displacement_m;
                    assert!(off.abs() < 6.0, "{block}: {off}");
                }
            }
        }
        // What is even has no swing.
        assert!(station.swings().iter().all(|swing| swing.amplitude_m[0] < 1e-4));
        assert!(!Station::new(&Settings { sum: 10, ..settings }).unwrap().follows());
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
