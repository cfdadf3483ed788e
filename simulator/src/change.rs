//! What changes a source with time, drawn for a run.

use crate::draw::Draw;
use crate::random::{Speckle, Wander};
use crate::scene::Change;
use core::f64::consts::TAU;

/// Level and phase at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Changed {
    /// Factor of the amplitude.
    pub gain: f64,
    /// Cycles that are frequency.
    pub cycles: f64,
    /// Cycles that are none: jumps of the phase, speckle.
    pub turned: f64,
}

/// A change over time, in seconds.
type Course = Box<dyn Fn(f64) -> Changed + Send + Sync>;

/// All changes of a source.
#[derive(Default)]
pub(crate) struct Changes(Vec<Course>);

impl Changes {
    /// Draws them for a run whose samples lie between two times, at this rate.
    pub fn new(changes: &[Change], span_s: (f64, f64), rate_hz: f64, draw: &mut Draw) -> Self {
        Changes(changes.iter().map(|change| course(change, span_s, rate_hz, draw)).collect())
    }

    /// Adds a speckle's envelope.
    pub fn with_speckle(mut self, speckle: Speckle) -> Self {
        self.0.push(speckled(speckle));
        self
    }

    /// All of them at a time.
    pub fn at(&self, time_s: f64) -> Changed {
        let mut all = Changed { gain: 1.0, cycles: 0.0, turned: 0.0 };
        for change in &self.0 {
            let one = change(time_s);
            all.gain *= one.gain;
            all.cycles += one.cycles;
            all.turned += one.turned;
        }
        all
    }
}

fn gain(of: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Course {
    Box::new(move |t| Changed { gain: of(t), cycles: 0.0, turned: 0.0 })
}

fn cycles(of: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Course {
    Box::new(move |t| Changed { gain: 1.0, cycles: of(t), turned: 0.0 })
}

fn envelope(of: impl Fn(f64) -> [f64; 2] + Send + Sync + 'static) -> Course {
    Box::new(move |t| {
        let [re, im] = of(t);
        Changed { gain: libm::hypot(re, im), cycles: 0.0, turned: libm::atan2(im, re) / TAU }
    })
}

fn speckled(speckle: Speckle) -> Course {
    envelope(move |t| speckle.at(t))
}

/// Of the time between two blades, the standard deviation of that in which one hides the body.
const BLADE: f64 = 0.1;

/// So many deviations from its middle nothing is left of a burst: 1e-8 of its amplitude.
const BURST: f64 = 6.0;

fn course(change: &Change, span_s: (f64, f64), rate_hz: f64, draw: &mut Draw) -> Course {
    match change {
        Change::Am { depth, rate_hz } => {
            let [depth, rate, start] = [depth.draw(draw), rate_hz.draw(draw), draw.share()];
            gain(move |t| 1.0 + depth * libm::cos(TAU * (rate * t + start)))
        }
        Change::Fm { deviation_hz, rate_hz } => {
            let [far, rate, start] = [deviation_hz.draw(draw), rate_hz.draw(draw), draw.share()];
            cycles(move |t| far / (TAU * rate) * libm::sin(TAU * (rate * t + start)))
        }
        Change::Chirp { hz_per_s, at_s } => {
            let [slope, at] = [hz_per_s, at_s].map(|value| value.draw(draw));
            cycles(move |t| 0.5 * slope * (t - at) * (t - at))
        }
        Change::Jump { turns, hz, at_s } => {
            let [turns, hz, at] = [turns, hz, at_s].map(|value| value.draw(draw));
            Box::new(move |t| {
                let after = if t < at { 0.0 } else { 1.0 };
                Changed { gain: 1.0, cycles: after * hz * (t - at), turned: after * turns }
            })
        }
        Change::Walk { linewidth_hz } => {
            let deviation = libm::sqrt(linewidth_hz.draw(draw) / TAU);
            let walk = Wander::new(span_s, rate_hz, deviation, || draw.normal());
            cycles(move |t| walk.at(t))
        }
        Change::On { from_s, for_s } => {
            let [from, time] = [from_s, for_s].map(|value| value.draw(draw));
            gain(move |t| if t >= from && t < from + time { 1.0 } else { 0.0 })
        }
        Change::Level { db } => {
            let db = db.course(draw);
            gain(move |t| libm::exp10(db.at(t) / 20.0))
        }
        Change::Decay { time_s, from_s } => {
            let [time, from] = [time_s, from_s].map(|value| value.draw(draw));
            gain(move |t| libm::exp(-(t - from).max(0.0) / time))
        }
        Change::Burst { middle_s, deviation_s } => {
            let [middle, deviation] = [middle_s, deviation_s].map(|value| value.draw(draw));
            gain(move |t| bell((t - middle) / deviation))
        }
        Change::Keyed { bits_hz, by_turns } => {
            let (rate, start) = (bits_hz.draw(draw), draw.share());
            let number = move |t: f64| libm::floor(rate * (t - span_s.0) + start).max(0.0) as usize;
            let bits: Vec<bool> = (0..=number(span_s.1))
                .map(|bit| if *by_turns { bit % 2 == 0 } else { draw.either() })
                .collect();
            gain(move |t| f64::from(u8::from(bits.get(number(t)).copied().unwrap_or(false))))
        }
        Change::Hidden { depth, rate_hz } => {
            let [depth, rate, start] = [depth.draw(draw), rate_hz.draw(draw), draw.share()];
            gain(move |t| {
                let turned = rate * t + start;
                1.0 - depth * bell((turned - libm::round(turned)) / BLADE)
            })
        }
        Change::Speckle { bandwidth_hz } => {
            let bandwidth = bandwidth_hz.draw(draw);
            speckled(Speckle::new(span_s.0, span_s.1, bandwidth, || draw.normal()))
        }
        Change::Bursts { per_s, deviation_s, nepers } => {
            let [rate, deviation, nepers] =
                [per_s, deviation_s, nepers].map(|value| value.draw(draw));
            let reach = BURST * deviation;
            let (mut middle, mut all) = (span_s.0 - reach, Vec::new());
            loop {
                middle += draw.exponential() / rate;
                if middle > span_s.1 + reach {
                    break;
                }
                let (sin, cos) = libm::sincos(draw.phase());
                let level = libm::exp(-nepers * draw.share());
                all.push((middle, [level * cos, level * sin]));
            }
            envelope(move |t| {
                let mut sum = [0.0; 2];
                let from = all.partition_point(|(middle, _)| *middle < t - BURST * deviation);
                let near = all.iter().skip(from);
                for (middle, [re, im]) in near.take_while(|all| all.0 < t + BURST * deviation) {
                    let light = bell((t - middle) / deviation);
                    sum = [sum[0] + re * light, sum[1] + im * light];
                }
                sum
            })
        }
    }
}

/// A Gaussian of height 1 at a distance in standard deviations.
fn bell(x: f64) -> f64 {
    libm::exp(-0.5 * (x * x))
}
