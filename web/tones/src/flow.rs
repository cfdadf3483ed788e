//! Particles in the fringes of two laser beams, before a photodiode whose amplifier passes no steady light: a stream of samples, and
//! the bursts that the library finds in it.

use crate::random::Random;
use picket_dsp::{Burst, BurstProcessor, Plan, Real};
use picket_simulator::{Fringes, Particle};
use std::f64::consts::PI;

/// Samples per second.
pub const RATE_HZ: f64 = 200e3;
/// The recipe's: 650 nm at 10 degrees between the beams.
pub const FRINGES: Fringes = Fringes { spacing_m: 3.729e-6, radius_m: 90e-6, visibility: 0.7 };
/// Below this frequency the amplifier passes less, Hz.
const CORNER_HZ: f64 = 995.0;
/// The amplifier's full scale, codes of 12 bits.
const FULL: f64 = 2047.5;

/// Samples of a burst's record.
pub const N: usize = 1024;
/// Samples that are remembered.
const LATELY: usize = 1 << 16;

/// What the sliders say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sliders {
    /// The mean speed, m/s.
    pub mean_mps: f64,
    /// The standard deviation of a particle's speed, a share of the mean.
    pub turbulence: f64,
    /// Particles per second.
    pub particles_hz: f64,
    /// Signal-to-noise ratio per sample at the top of a usual burst, dB.
    pub snr_db: f64,
    /// The amplitude there, dB of full scale.
    pub level_db: f64,
}

/// A burst, and the particle that made it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The burst.
    pub burst: Burst,
    /// The speed of the particle next to its arrival, m/s; NaN where none is.
    pub truth_mps: f64,
}

/// A flow that goes on.
#[derive(Debug)]
pub struct Flow {
    processor: Box<BurstProcessor<Real, N>>,
    random: Random,
    /// Particles that are crossing, or did lately, in their order.
    particles: Vec<Particle>,
    /// When the next one comes, s.
    next_s: f64,
    samples: u64,
    /// The last input and output of the amplifier's high pass.
    passed: [f64; 2],
    /// The last codes, as many as [`LATELY`] at most.
    lately: Vec<i16>,
}

impl Flow {
    /// A flow from its start, for a processor with this plan: of signed codes of 12 bits at [`RATE_HZ`].
    pub fn new(plan: Plan<Real, N>, seed: u64) -> Self {
        Self {
            processor: Box::new(BurstProcessor::new(plan)),
            random: Random::new(seed),
            particles: Vec::new(),
            next_s: 0.005,
            samples: 0,
            passed: [0.0; 2],
            lately: Vec::new(),
        }
    }

    /// Goes on for so many samples: the bursts that are complete with them.
    pub fn advance(&mut self, sliders: &Sliders, count: usize) -> Vec<Found> {
        let amplitude = FULL * 10f64.powf(sliders.level_db / 20.0);
        let noise = amplitude / (2.0 * 10f64.powf(sliders.snr_db / 10.0)).sqrt();
        let end_s = (self.samples as f64 + count as f64) / RATE_HZ;
        // Whoever is in the middle a while after these samples is seen in them.
        while self.next_s < end_s + 0.1 {
            let speed = sliders.mean_mps * (1.0 + sliders.turbulence * self.random.normal());
            let size = (0.4 * self.random.normal()).exp();
            self.particles.push(Particle {
                middle_s: self.next_s,
                speed_mps: speed.max(0.2 * sliders.mean_mps),
                level: amplitude / FRINGES.visibility * size,
                turns: self.random.share(),
            });
            self.next_s -= (1.0 - self.random.share()).ln() / sliders.particles_hz.max(0.1);
        }
        let begin_s = end_s - 0.5;
        self.particles.retain(|particle| particle.middle_s > begin_s);
        let c = (PI * CORNER_HZ / RATE_HZ).tan();
        let (scale, back) = (1.0 / (1.0 + c), (1.0 - c) / (1.0 + c));
        let mut codes = Vec::with_capacity(count);
        for _ in 0..count {
            let time_s = self.samples as f64 / RATE_HZ;
            self.samples += 1;
            let seen = |particle: &&Particle| {
                (time_s - particle.middle_s).abs() < FRINGES.reach_s(particle)
            };
            let crossing = self.particles.iter().filter(seen);
            let light: f64 = crossing.map(|particle| FRINGES.light(particle, time_s)).sum();
            let [x, y] = self.passed;
            self.passed = [light, scale * (light - x) + back * y];
            let volts = self.passed[1] + noise * self.random.normal();
            codes.push(volts.round().clamp(-2048.0, 2047.0) as i16);
        }
        let (mut found, particles) = (Vec::new(), &self.particles);
        self.processor.push(&codes, |&burst| {
            let away = |particle: &&Particle| (particle.middle_s - burst.arrival / RATE_HZ).abs();
            let near = particles.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
            let near = near.filter(|near| away(near) < FRINGES.radius_m / near.speed_mps);
            let truth_mps = near.map_or(f64::NAN, |near| near.speed_mps);
            found.push(Found { burst, truth_mps });
        });
        self.lately.extend(codes);
        self.lately.drain(..self.lately.len().saturating_sub(LATELY));
        found
    }

    /// The samples around a burst that was just found, as shares of full scale.
    pub fn around(&self, burst: &Burst) -> Vec<f32> {
        let first = self.samples as usize - self.lately.len();
        let begin = (burst.arrival as usize).saturating_sub(N / 2).saturating_sub(first);
        // A record may be complete before so many samples came behind the middle.
        let begin = begin.min(self.lately.len().saturating_sub(N));
        let codes = self.lately.iter().skip(begin).take(N);
        codes.map(|&code| (f64::from(code) / FULL) as f32).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_dsp::Validation;

    /// Seed 1: half a minute of a flow. Speeds of valid bursts are right within their sigmas, and the mean of the truths is the flow's.
    #[test]
    fn bursts_have_the_speed_of_their_particles() {
        let sliders = Sliders {
            mean_mps: 0.05,
            turbulence: 0.05,
            particles_hz: 20.0,
            snr_db: 20.0,
            level_db: -14.0,
        };
        let mut flow = Flow::new(crate::plan(&crate::FLOW).unwrap(), 1);
        let (mut errors, mut all) = (Vec::new(), 0);
        for _ in 0..1800 {
            for Found { burst, truth_mps } in flow.advance(&sliders, 3333) {
                all += 1;
                let samples = flow.around(&burst);
                let most = samples.iter().fold(0.0f32, |most, x| most.max(x.abs()));
                assert!(samples.len() == N || all == 1, "{}", samples.len());
                assert!(
                    f64::from(most) * FULL > 0.7 * f64::from(burst.tone.amplitude),
                    "{burst:?}"
                );
                if burst.validation == Validation::Valid {
                    let speed = burst.tone.hertz() * FRINGES.spacing_m;
                    errors
                        .push((speed - truth_mps) / (burst.tone.sigma_hertz() * FRINGES.spacing_m));
                }
            }
        }
        let far = errors.iter().filter(|error| error.abs() > 5.0).count();
        errors.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        let median = errors[errors.len() / 2].abs();
        println!(
            "{all} bursts, {} valid, median error {median:.2} sigma, {far} beyond 5",
            errors.len()
        );
        assert!(all > 400 && errors.len() > all / 2, "{all} {}", errors.len());
        // The median of a normal number is .67.
        assert!((0.5..0.9).contains(&median), "{median}");
        assert!(far <= errors.len() / 50, "{far} of {}", errors.len());
    }
}
