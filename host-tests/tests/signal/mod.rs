//! Records of tones in noise as a converter delivers them, and how to measure errors on many of them.
#![allow(dead_code)]

use picket_claims::bound;
pub use picket_claims::bound::Line;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real, Record, Stamp};
use picket_dsp::config::Config;
use picket_dsp::pipeline::Pipeline;
use picket_dsp::spectrum::engine::{Engine, I32};
use picket_dsp::tone::Tone;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A generator of its own for every trial, so that the order of the threads does not matter.
pub fn rng(seed: u64, trial: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(trial);
    rng
}

pub fn db(x: f64) -> f64 {
    10f64.powf(x / 10.0)
}

/// The standard deviation of the noise in each part, for an SNR in dB.
pub fn sigma(amplitude: f64, snr_db: f64) -> f64 {
    amplitude * (0.5 / db(snr_db)).sqrt()
}

pub fn quantise(x: f64) -> i16 {
    x.round().clamp(-2048.0, 2047.0) as i16
}

pub fn analogue<const N: usize>(rng: &mut ChaCha8Rng, lines: &[Line], sigma: f64) -> [[f64; 2]; N] {
    std::array::from_fn(|n| {
        let mut x = [0.0; 2].map(|_: f64| sigma * rng.sample::<f64, _>(StandardNormal));
        for line in lines {
            let (sin, cos) = (TAU * line.bins * n as f64 / N as f64 + line.phase).sin_cos();
            x[0] += line.amplitude * cos;
            x[1] += line.amplitude * sin;
        }
        x
    })
}

pub const CODES: Codes = Codes::signed::<12>();

/// The largest amplitude at which four deviations of the noise do not clip.
pub fn amplitude(snr_db: f64) -> f64 {
    2040.0 / (1.0 + 4.0 * sigma(1.0, snr_db))
}

/// Runs `trial` so many times, in parallel and reproducibly, keeping what it returns.
pub fn trials<T: Send>(
    seed: u64,
    count: u64,
    trial: impl Fn(&mut ChaCha8Rng) -> T + Sync,
) -> Vec<T> {
    (0..count).into_par_iter().map(|index| trial(&mut rng(seed, index))).collect()
}

/// What the two kinds of record need from a test.
pub trait Kind: Record {
    /// The exact bound of a tone's frequency in bins.
    fn bound(n: usize, line: Line, sigma: f64) -> f64;
    /// Samples of `lines` in noise of `sigma` in each part.
    fn record<const N: usize>(
        rng: &mut ChaCha8Rng,
        lines: &[Line],
        sigma: f64,
    ) -> [Self::Sample; N] {
        analogue::<N>(rng, lines, sigma).map(|parts| Self::from_parts(parts.map(quantise)))
    }
}

impl Kind for Real {
    fn bound(n: usize, line: Line, sigma: f64) -> f64 {
        bound::real(n, &[line], sigma)[0]
    }
}

impl Kind for Iq {
    fn bound(n: usize, line: Line, sigma: f64) -> f64 {
        bound::iq(n, line.amplitude, sigma)
    }
}

/// The tone of a record by the whole pipeline, in its default configuration.
pub fn measure<R: Kind, const N: usize>(samples: &[R::Sample; N]) -> Tone {
    measure_by::<R, N, I32>(samples)
}

/// The same by any engine.
pub fn measure_by<R: Kind, const N: usize, E: Engine>(samples: &[R::Sample; N]) -> Tone {
    let plan = Config::new(1.0, Codes::signed::<12>()).plan::<R, N>().unwrap();
    Pipeline::<R, N, E>::new(plan).block(&Stamp::default(), samples).tone
}

/// The error of a tone in bins, round the circle for I/Q.
pub fn error<R: Kind, const N: usize>(tone: &Tone, bins: f64) -> f64 {
    let (error, n) = (tone.frequency.bins(N) - bins, N as f64);
    if R::IQ { (error + n / 2.0).rem_euclid(n) - n / 2.0 } else { error }
}

/// A line anywhere that is not `near-edge`: real ones with the peak at bins 2..=N/2-2, I/Q ones at 2..=N-2.
pub fn anywhere<R: Kind, const N: usize>(rng: &mut ChaCha8Rng, amplitude: f64) -> Line {
    let peaks = if R::IQ { 2..N as i32 - 1 } else { 2..N as i32 / 2 - 1 };
    let bins = f64::from(rng.random_range(peaks)) + rng.random_range(-0.5..0.5);
    Line { bins, amplitude, phase: rng.random_range(0.0..TAU) }
}

pub fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().sum::<f64>() / values.count() as f64
}
