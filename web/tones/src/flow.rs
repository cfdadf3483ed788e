//! Particles in the fringes of two laser beams, before a photodiode whose amplifier passes no steady light: a stream of samples, and
//! the bursts that the library finds in it.

use picket_dsp::{Burst, BurstProcessor, Plan, Real};
use picket_simulator::scene::{Noise, Particles, Receiver, Source};
use picket_simulator::{Run, Scene};

/// Samples per second.
pub const RATE_HZ: f64 = 200e3;
/// From one fringe to the next, m: the recipe's 650 nm at 10 degrees between the beams.
pub const FRINGE_M: f64 = 3.729e-6;
/// Radius of the crossing, m.
const RADIUS_M: f64 = 90e-6;
/// Below this frequency the amplifier passes less, Hz.
const CORNER_HZ: f64 = 995.0;
/// The amplifier's full scale, codes of 12 bits.
const FULL: f64 = 2047.5;
/// A scene lasts so long, s; then the next one begins.
const SCENE_S: f64 = 20.0;

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
    seed: u64,
    /// The run of a scene that is shown, by these sliders, and the sample of the flow with which it began.
    run: Option<(Run, Sliders, u64)>,
    /// Runs so far.
    runs: u64,
    samples: u64,
    /// The last codes, as many as [`LATELY`] at most.
    lately: Vec<i16>,
}

impl Sliders {
    /// The scene that they say.
    fn scene(&self, seed: u64) -> Scene {
        let amplitude = FULL * 10f64.powf(self.level_db / 20.0);
        let particles = Particles {
            fringe_m: FRINGE_M,
            radius_m: RADIUS_M,
            visibility: 0.7,
            velocity_mps: self.mean_mps.into(),
            turbulence_mps: self.turbulence * self.mean_mps,
            per_m: self.particles_hz.max(0.1) / self.mean_mps,
            amplitude: Some(amplitude.into()),
            sizes: 0.4,
            ..Particles::default()
        };
        Scene {
            seed,
            rate_hz: RATE_HZ,
            seconds: SCENE_S,
            sources: vec![Source::Particles(particles)],
            receiver: Receiver {
                noise: Noise { snr_db: Some(self.snr_db.into()), ..Noise::default() },
                high_pass_hz: vec![CORNER_HZ],
                ..Receiver::default()
            },
            ..Scene::default()
        }
    }
}

impl Flow {
    /// A flow from its start, for a processor with this plan: of signed codes of 12 bits at [`RATE_HZ`].
    pub fn new(plan: Plan<Real, N>, seed: u64) -> Self {
        Self {
            processor: Box::new(BurstProcessor::new(plan)),
            seed,
            run: None,
            runs: 0,
            samples: 0,
            lately: Vec::new(),
        }
    }

    /// Goes on for this many samples, and returns the bursts that they complete. Other sliders are another scene.
    pub fn advance(&mut self, sliders: &Sliders, count: usize) -> Vec<Found> {
        let goes_on = self.run.as_ref().is_some_and(|(_, of, begun)| {
            of == sliders && (self.samples - begun) as f64 + count as f64 <= SCENE_S * RATE_HZ
        });
        if !goes_on {
            self.runs += 1;
            let run = sliders.scene(self.seed).run(self.runs);
            self.run = run.ok().map(|run| (run, *sliders, self.samples));
        }
        let Some((run, _, begun)) = &mut self.run else { return Vec::new() };
        let from_s = (self.samples - *begun) as f64 / RATE_HZ;
        let codes: Vec<i16> = run.codes(from_s, count).into_iter().map(|[code, _]| code).collect();
        self.samples += count as u64;
        let (mut found, particles) = (Vec::new(), run.particles(0));
        let begun_s = *begun as f64 / RATE_HZ;
        self.processor.push(&codes, |&burst| {
            let arrival_s = burst.arrival / RATE_HZ - begun_s;
            // They are in the order of their middles.
            let next = particles.partition_point(|particle| particle.middle_s < arrival_s);
            let both = particles.iter().take(next + 1).skip(next.saturating_sub(1));
            let away = |middle_s: f64| (middle_s - arrival_s).abs();
            let near = both.min_by(|a, b| away(a.middle_s).total_cmp(&away(b.middle_s)));
            let near = near.filter(|near| away(near.middle_s) < RADIUS_M / near.velocity_mps);
            let truth_mps = near.map_or(f64::NAN, |near| near.velocity_mps);
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
        let mut flow = Flow::new(crate::flow_plan().unwrap(), 1);
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
                    let speed = burst.tone.hertz() * FRINGE_M;
                    errors.push((speed - truth_mps) / (burst.tone.sigma_hertz() * FRINGE_M));
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
