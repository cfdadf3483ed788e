//! A turbulent flow whose particles cross the fringes of a laser: a laser-Doppler velocimeter.

use crate::simulate::{Width, generator};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::config::Config;
use picket_simulator::{Fringes, Particle};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::collections::VecDeque;

/// Fringes of 4 um, as of 532 nm at 7.6 degrees between the beams, where these are 200 um wide.
pub const FRINGES: Fringes = Fringes { spacing_m: 4e-6, radius_m: 100e-6, visibility: 0.7 };
/// A particle of the mean speed has 1 MHz, and an envelope whose standard deviation is an eighth of a record.
const RATE_HZ: f64 = 10e6;

/// The flow's mean velocity, m/s, and the standard deviation about it, a share of it.
pub const MEAN_MPS: f64 = 4.0;
/// The share.
pub const TURBULENCE: f64 = 0.1;
/// From this number of particles the mean is known to .07 % of itself, and the deviation to .5 %.
pub const PARTICLES: usize = 20_000;

/// From one particle to the next, on average, s: eight records. The nearer they come, the more are taken for two, and the more of them are
/// slow, because these take longer: at four records the mean of the others is .1 % too high.
const APART_S: f64 = 800e-6;
/// The tone's amplitude of a usual particle, codes: one of three times the size does not clip.
const AMPLITUDE: f64 = 250.0;
/// The standard deviation of the logarithm of a particle's light.
const SIZES: f64 = 0.4;

/// The photodiode's signal at 10 MS/s, in signed codes of 12 bits.
pub fn config() -> Config {
    Config::new(RATE_HZ, Codes::signed::<12>())
}

/// The flow, piece by piece.
#[derive(Debug)]
pub struct Flow {
    rng: ChaCha8Rng,
    /// The noise of a sample, codes.
    noise: f64,
    /// Particles that cross, or will.
    ahead: VecDeque<Particle>,
    /// Particles that have come so far.
    pub particles: Vec<Particle>,
    /// When the next one comes, s.
    next_s: f64,
    samples: usize,
}

impl Flow {
    /// A flow from its start, with a usual particle this many decibels above the noise of a sample at its top.
    pub fn new(seed: u64, snr_db: f64) -> Self {
        Flow {
            rng: generator(seed, 0),
            noise: AMPLITUDE / (2.0 * 10f64.powf(snr_db / 10.0)).sqrt(),
            ahead: VecDeque::new(),
            particles: Vec::new(),
            // The detector learns the noise in ten records.
            next_s: 1e-3,
            samples: 0,
        }
    }

    /// Whether all particles have passed.
    pub fn is_over(&self) -> bool {
        self.particles.len() == PARTICLES && self.ahead.is_empty()
    }

    /// The next particle. The number of arrivals is proportional to the speed: all particles of the volume that passes.
    fn particle(&mut self) -> Particle {
        let speed_mps = loop {
            let speed = 1.0 + TURBULENCE * self.rng.sample::<f64, _>(StandardNormal);
            // Of the mean speed every second one. Twice the mean is ten deviations from it.
            if self.rng.random_range(0.0..2.0) < speed {
                break MEAN_MPS * speed;
            }
        };
        let size = (SIZES * self.rng.sample::<f64, _>(StandardNormal)).exp();
        let middle_s = self.next_s;
        self.next_s -= APART_S * (1.0 - self.rng.random::<f64>()).ln();
        let level = AMPLITUDE / FRINGES.visibility * size;
        Particle { middle_s, speed_mps, level, turns: self.rng.random() }
    }

    /// The codes of the next samples.
    pub fn codes(&mut self, count: usize) -> Vec<i16> {
        let (first, end) = (self.samples, self.samples + count);
        self.samples = end;
        // A particle of a quarter of the mean speed is seen for 2,500 samples before its middle.
        while self.particles.len() < PARTICLES && self.next_s * RATE_HZ < end as f64 + 2500.0 {
            let particle = self.particle();
            self.particles.push(particle);
            self.ahead.push_back(particle);
        }
        let mut light: Vec<f64> =
            (0..count).map(|_| self.noise * self.rng.sample::<f64, _>(StandardNormal)).collect();
        for particle in &self.ahead {
            let reach = FRINGES.reach_s(particle);
            let place = |time_s: f64| (time_s * RATE_HZ).max(0.0) as usize;
            let from = place(particle.middle_s - reach).clamp(first, end);
            let to = place(particle.middle_s + reach).clamp(first, end);
            for (index, light) in light.iter_mut().enumerate().take(to - first).skip(from - first) {
                *light += FRINGES.light(particle, (first + index) as f64 / RATE_HZ);
            }
        }
        let gone_s = end as f64 / RATE_HZ;
        self.ahead.retain(|particle| particle.middle_s + FRINGES.reach_s(particle) > gone_s);
        let width = Width::Codes(Codes::signed::<12>());
        light.into_iter().map(|light| width.convert(light) as i16).collect()
    }
}
