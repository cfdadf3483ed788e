//! The records whose instructions are counted: signals that a converter may deliver, easy or not.

use picket_dsp::acquire::codes::Codes;
use picket_simulator::scene::{Density, Form, Impulses, Source, Tone};
use picket_simulator::{Draw, Scene, Value};
use std::f64::consts::TAU;

/// Records of each kind, as often as a user may meet them.
const KINDS: [(Make, usize); 10] = [
    (tone, 48),
    (at_the_threshold, 10),
    (at_an_edge, 10),
    (several_lines, 10),
    (coloured_noise, 10),
    (noise, 6),
    (silence, 2),
    (impulses, 4),
    (overdriven, 16),
    (on_the_rails, 4),
];

/// Makes the scene of a record of this length: a hertz is a bin, a second a record. What depends on each other is drawn, the rest are intervals.
type Make = fn(&mut Draw, usize) -> Scene;

/// Full scale in codes of 12 bits.
const FULL: f64 = 2047.0;

/// A record of signed 12-bit codes.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The samples.
    pub samples: Vec<i16>,
    /// Whether a sample is at a rail.
    pub clipped: bool,
}

/// The records of this length: the same for the same seed.
pub fn corpus(n: usize, seed: u64) -> Vec<Entry> {
    let seed = seed ^ n as u64;
    let makes = KINDS.iter().flat_map(|&(make, count)| std::iter::repeat_n(make, count));
    let scene = |(number, make): (u64, Make)| {
        let scene = make(&mut Draw::new(seed, number), n);
        entry(&Scene { seed, rate_hz: n as f64, seconds: 1.0, ..scene }, number)
    };
    (0..).zip(makes).filter_map(scene).collect()
}

/// The record of a trial of a scene that can be.
fn entry(scene: &Scene, trial: u64) -> Option<Entry> {
    let samples: Vec<i16> = scene.codes(trial).ok()?.into_iter().map(|[code, _]| code).collect();
    let (low, high) = Codes::signed::<12>().rails();
    let clipped = samples.iter().any(|x| [low, high].contains(x));
    Some(Entry { samples, clipped })
}

fn line(frequency_hz: Value, amplitude: impl Into<Value>) -> Source {
    let amplitude = Some(amplitude.into());
    Source::Tone(Tone { frequency_hz, amplitude, ..Tone::default() })
}

fn anywhere(n: usize) -> Value {
    (3.0..n as f64 / 2.0 - 3.0).into()
}

/// Any power of ten between two.
fn decades(draw: &mut Draw, low: f64, high: f64) -> f64 {
    10f64.powf(draw.between(low, high))
}

/// A tone at this signal-to-noise ratio, of an amplitude that leaves its noise room; this share of both. With the most that it reaches, codes.
fn in_noise(draw: &mut Draw, bins: Value, snr_db: f64, share: f64) -> (Scene, f64) {
    let ratio = 10f64.powf(snr_db / 20.0) * 2f64.sqrt();
    let most = FULL / (1.0 + 4.5 / ratio);
    let amplitude = share * most * decades(draw, -1.0, -0.02);
    let mut scene = Scene { sources: vec![line(bins, amplitude)], ..Scene::default() };
    scene.receiver.noise.snr_db = Some(snr_db.into());
    (scene, amplitude * (1.0 + 4.5 / ratio))
}

/// -5 to 60 dB, at any frequency.
fn tone(draw: &mut Draw, n: usize) -> Scene {
    let snr_db = draw.between(-5.0, 60.0);
    in_noise(draw, anywhere(n), snr_db, 1.0).0
}

/// The line is 8 to 14 dB above the noise of a bin.
fn at_the_threshold(draw: &mut Draw, n: usize) -> Scene {
    let snr_db = draw.between(8.0, 14.0) - 10.0 * (n as f64 / 2.0).log10();
    in_noise(draw, anywhere(n), snr_db, 1.0).0
}

/// Within three bins of DC or of half the rate.
fn at_an_edge(draw: &mut Draw, n: usize) -> Scene {
    let half = n as f64 / 2.0;
    let bins = if draw.either() { 0.5..3.0 } else { half - 3.0..half - 0.5 };
    let snr_db = draw.between(0.0, 60.0);
    in_noise(draw, bins.into(), snr_db, 1.0).0
}

/// Two to six lines up to 40 dB below the first.
fn several_lines(draw: &mut Draw, n: usize) -> Scene {
    let snr_db = draw.between(-5.0, 60.0);
    let (mut scene, _) = in_noise(draw, anywhere(n), snr_db, 1.0 / 3.0);
    for _ in 0..=draw.below(5) {
        scene.sources.push(line(anywhere(n), 200.0 * decades(draw, -2.0, 0.0)));
    }
    scene
}

/// Noise of a low-pass or of a difference, with a tone or without.
fn coloured_noise(draw: &mut Draw, n: usize) -> Scene {
    const POINTS: usize = 32;
    let pole = draw.between(-0.95, 0.95);
    let point = |index: usize| {
        let share = index as f64 / (2 * POINTS) as f64;
        let power = 1.0 - 2.0 * pole * (TAU * share).cos() + pole * pole;
        [share * n as f64, -10.0 * power.log10()]
    };
    let mut scene = Scene { sources: vec![line(anywhere(n), 0.0..200.0)], ..Scene::default() };
    scene.receiver.noise.rms = Some((60.0 / (1.0 - pole * pole).sqrt()).into());
    scene.receiver.noise.shape =
        vec![Density::Points { points: (0..=POINTS).map(point).collect(), beside_tone: false }];
    scene
}

fn noise(draw: &mut Draw, _: usize) -> Scene {
    let mut scene = Scene::default();
    scene.receiver.noise.rms = Some(decades(draw, -0.5, 2.6).into());
    scene
}

fn silence(_: &mut Draw, _: usize) -> Scene {
    let mut scene = Scene::default();
    scene.receiver.offset[0] = (-500.0..500.0).into();
    scene
}

/// A tone with up to eight samples that stick out, as far as there is room.
fn impulses(draw: &mut Draw, n: usize) -> Scene {
    let snr_db = draw.between(-5.0, 60.0);
    let (mut scene, most) = in_noise(draw, anywhere(n), snr_db, 1.0);
    let (count, codes) = ((0.5..8.5).into(), (0.0..(0.99 * FULL - most).max(0.0)).into());
    scene.receiver.impulses = Some(Impulses { count, codes });
    scene
}

/// A tone up to six times as large as the range, off its middle or not.
fn overdriven(_: &mut Draw, n: usize) -> Scene {
    let amplitude = 1.005 * FULL..6.0 * FULL;
    let mut scene = Scene { sources: vec![line(anywhere(n), amplitude)], ..Scene::default() };
    scene.receiver.offset[0] = (-0.5 * FULL..0.5 * FULL).into();
    scene.receiver.noise.snr_db = Some((10.0..60.0).into());
    scene
}

/// Nothing but rails: a stuck input, or a square.
fn on_the_rails(draw: &mut Draw, n: usize) -> Scene {
    let mut scene = Scene::default();
    if draw.either() {
        scene.receiver.offset[0] = (FULL + 10.0).into();
    } else {
        let (frequency_hz, amplitude) = (anywhere(n), Some((FULL + 10.0).into()));
        let square = Tone { frequency_hz, amplitude, form: Form::Square, ..Tone::default() };
        scene.sources.push(Source::Tone(square));
    }
    scene
}
