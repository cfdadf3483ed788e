//! The records whose instructions are counted: what a converter may deliver, not what suits us.

use picket_dsp::acquire::codes::Codes;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
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

/// Makes a record of this length, in codes that are not yet rounded.
type Make = fn(&mut ChaCha8Rng, usize) -> Vec<f64>;

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
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ n as u64);
    let makes = KINDS.iter().flat_map(|&(make, count)| std::iter::repeat_n(make, count));
    makes.map(|make| entry(&make(&mut rng, n))).collect()
}

fn entry(values: &[f64]) -> Entry {
    let (low, high) = Codes::signed::<12>().rails();
    let samples: Vec<i16> =
        values.iter().map(|x| x.round().clamp(low.into(), high.into()) as i16).collect();
    let clipped = samples.iter().any(|x| [low, high].contains(x));
    Entry { samples, clipped }
}

fn line(rng: &mut ChaCha8Rng, n: usize, bins: f64, amplitude: f64) -> Vec<f64> {
    let phase = rng.random_range(0.0..TAU);
    (0..n).map(|t| amplitude * (TAU * bins * t as f64 / n as f64 + phase).cos()).collect()
}

fn with_noise(rng: &mut ChaCha8Rng, values: Vec<f64>, sigma: f64) -> Vec<f64> {
    values.into_iter().map(|x| x + sigma * rng.sample::<f64, _>(StandardNormal)).collect()
}

fn anywhere(rng: &mut ChaCha8Rng, n: usize) -> f64 {
    rng.random_range(3.0..n as f64 / 2.0 - 3.0)
}

/// The noise of a tone at this signal-to-noise ratio, and an amplitude that leaves it room.
fn level(rng: &mut ChaCha8Rng, snr_db: f64) -> (f64, f64) {
    let ratio = 10f64.powf(snr_db / 20.0) * 2f64.sqrt();
    let most = FULL / (1.0 + 4.5 / ratio);
    let amplitude = most * 10f64.powf(rng.random_range(-1.0..-0.02));
    (amplitude, amplitude / ratio)
}

fn in_noise(rng: &mut ChaCha8Rng, n: usize, bins: f64, snr_db: f64) -> Vec<f64> {
    let (amplitude, sigma) = level(rng, snr_db);
    let values = line(rng, n, bins, amplitude);
    with_noise(rng, values, sigma)
}

/// -5 to 60 dB, at any frequency.
fn tone(rng: &mut ChaCha8Rng, n: usize) -> Vec<f64> {
    let (bins, snr_db) = (anywhere(rng, n), rng.random_range(-5.0..60.0));
    in_noise(rng, n, bins, snr_db)
}

/// The line is 8 to 14 dB above the noise of a bin.
fn at_the_threshold(rng: &mut ChaCha8Rng, n: usize) -> Vec<f64> {
    let bins = anywhere(rng, n);
    let snr_db = rng.random_range(8.0..14.0) - 10.0 * (n as f64 / 2.0).log10();
    in_noise(rng, n, bins, snr_db)
}

/// Within three bins of DC or of half the rate.
fn at_an_edge(rng: &mut ChaCha8Rng, n: usize) -> Vec<f64> {
    let near = rng.random_range(0.5..3.0);
    let bins = if rng.random() { near } else { n as f64 / 2.0 - near };
    let snr_db = rng.random_range(0.0..60.0);
    in_noise(rng, n, bins, snr_db)
}

/// Two to six lines up to 40 dB below the first.
fn several_lines(rng: &mut ChaCha8Rng, n: usize) -> Vec<f64> {
    let mut values = tone(rng, n).iter().map(|x| x / 3.0).collect::<Vec<_>>();
    for _ in 0..rng.random_range(1..6) {
        let (bins, amplitude) = (anywhere(rng, n), 200.0 * 10f64.powf(rng.random_range(-2.0..0.0)));
        let other = line(rng, n, bins, amplitude);
        values.iter_mut().zip(other).for_each(|(x, y)| *x += y);
    }
    values
}

/// Noise of a low-pass or of a difference, with a tone or without.
fn coloured_noise(rng: &mut ChaCha8Rng, n: usize) -> Vec<f64> {
    let (pole, mut state) = (rng.random_range(-0.95..0.95), 0.0);
    let white = with_noise(rng, vec![0.0; n], 60.0);
    let (bins, amplitude) = (anywhere(rng, n), rng.random_range(0.0..200.0));
    let tone = line(rng, n, bins, amplitude);
    let filtered = white.into_iter().map(|x| {
        state = pole * state + x;
        state
    });
    filtered.zip(tone).map(|(x, y)| x + y).collect()
}

fn noise(rng: &mut ChaCha8Rng, n: usize) -> Vec<f64> {
    let sigma = 10f64.powf(rng.random_range(-0.5..2.6));
    with_noise(rng, vec![0.0; n], sigma)
}

fn silence(rng: &mut ChaCha8Rng, n: usize) -> Vec<f64> {
    vec![rng.random_range(-500.0..500.0); n]
}

/// A tone with up to eight samples anywhere in the range.
fn impulses(rng: &mut ChaCha8Rng, n: usize) -> Vec<f64> {
    let mut values = tone(rng, n);
    for _ in 0..rng.random_range(1..9) {
        let at = rng.random_range(0..n);
        values[at] = rng.random_range(-0.99 * FULL..0.99 * FULL);
    }
    values
}

/// A tone up to six times as large as the range, off its middle or not.
fn overdriven(rng: &mut ChaCha8Rng, n: usize) -> Vec<f64> {
    let (bins, snr_db) = (anywhere(rng, n), rng.random_range(10.0..60.0));
    let amplitude = FULL * rng.random_range(1.005..6.0);
    let offset = FULL * rng.random_range(-0.5..0.5);
    let values = line(rng, n, bins, amplitude).into_iter().map(|x| x + offset).collect();
    with_noise(rng, values, amplitude / 2f64.sqrt() * 10f64.powf(-snr_db / 20.0))
}

/// Nothing but rails: a stuck input, or a square.
fn on_the_rails(rng: &mut ChaCha8Rng, n: usize) -> Vec<f64> {
    if rng.random() {
        return vec![FULL + 10.0; n];
    }
    let bins = anywhere(rng, n);
    line(rng, n, bins, 1.0).into_iter().map(|x| x.signum() * (FULL + 10.0)).collect()
}
