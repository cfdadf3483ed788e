//! Particles that cross the fringes of two laser beams, drawn for a run.

use crate::draw::Draw;
use crate::scene::Particles;
use crate::value::{Course, Value};
use core::f64::consts::TAU;

/// Radii of the crossing beyond which next to nothing of a particle is left: 4e-6 of its light.
const REACH: f64 = 2.5;

/// A particle on its way.
#[derive(Clone, Debug, PartialEq)]
pub struct Passed {
    /// When it is in the middle, s.
    pub middle_s: f64,
    /// Its velocity there, m/s.
    pub velocity_mps: f64,
    /// Amplitude of its tone there, codes.
    pub amplitude: f64,
    turns: f64,
    /// How much faster than the mean it is.
    beside_mps: f64,
}

/// All particles of a run.
pub(crate) struct Flow {
    of: Particles,
    mean: Course,
    /// In the order of their middles.
    pub passed: Vec<Passed>,
    /// The particles in each stretch of time, of so many seconds from `from_s` on.
    stretches: Vec<Vec<usize>>,
    from_s: f64,
    stretch_s: f64,
}

impl Flow {
    /// Draws the particles whose light is between two times.
    pub fn new(of: &Particles, amplitude: f64, span_s: (f64, f64), draw: &mut Draw) -> Self {
        let mean = of.velocity_mps.course(draw);
        let mut passed = Vec::new();
        for particle in &of.at {
            let middle_s = particle.middle_s.draw(draw);
            let flows = mean.at(middle_s);
            let velocity_mps =
                particle.velocity_mps.as_ref().map_or(flows, |value| value.draw(draw));
            let amplitude = amplitude * libm::exp10(particle.level_db.draw(draw) / 20.0);
            let turns = Value::or_any(particle.turns.as_ref(), draw);
            let beside_mps = velocity_mps - flows;
            passed.push(Passed { middle_s, velocity_mps, amplitude, turns, beside_mps });
        }
        // As many come as the flow carries past: the faster, the more. Six deviations beyond the mean is nobody.
        let most = mean.most() + 6.0 * of.turbulence_mps;
        let slow = REACH * of.radius_m / most;
        let (mut at, end) = (span_s.0 - 8.0 * slow, span_s.1 + 8.0 * slow);
        loop {
            // Without any it is infinite.
            at += draw.exponential() / (of.per_m * most);
            if at >= end {
                break;
            }
            let beside_mps = of.turbulence_mps * draw.normal();
            let velocity_mps = mean.at(at) + beside_mps;
            let taken = draw.share() * most < velocity_mps.abs();
            let (size, turns) = (libm::exp(of.sizes * draw.normal()), draw.share());
            if taken {
                let amplitude = amplitude * size;
                passed.push(Passed { middle_s: at, velocity_mps, amplitude, turns, beside_mps });
            }
        }
        passed.sort_by(|a, b| a.middle_s.total_cmp(&b.middle_s));
        let mut flow = Flow {
            of: of.clone(),
            mean,
            passed,
            stretches: Vec::new(),
            from_s: span_s.0,
            stretch_s: 0.0,
        };
        flow.sort(span_s);
        flow
    }

    /// Finds out when each of them is in the beam. A particle of a flow that reverses may come back.
    fn sort(&mut self, span_s: (f64, f64)) {
        let length = span_s.1 - span_s.0;
        let most =
            self.passed.iter().map(|p| p.beside_mps.abs()).fold(0.0, f64::max) + self.mean.most();
        // Nobody crosses half a radius in less.
        let step_s = (0.5 * self.of.radius_m / most.max(1e-12)).min(length);
        let count = ((length / step_s) as usize + 1).min(1 << 20);
        self.stretch_s = length / count as f64;
        self.stretches = vec![Vec::new(); count];
        let steady = self.mean.is_steady();
        for (number, particle) in self.passed.iter().enumerate() {
            let near = |place: usize| {
                let middle = self.from_s + (place as f64 + 0.5) * self.stretch_s;
                let moved = 0.5 * self.stretch_s * most;
                self.place_m(particle, middle).abs() <= REACH * self.of.radius_m + moved
            };
            let (from, to) = if steady {
                let half = (REACH * self.of.radius_m / particle.velocity_mps.abs().max(1e-12))
                    + self.stretch_s;
                let index =
                    |t: f64| ((t - self.from_s) / self.stretch_s).clamp(0.0, count as f64) as usize;
                (index(particle.middle_s - half), (index(particle.middle_s + half) + 1).min(count))
            } else {
                (0, count)
            };
            let places: Vec<usize> = (from..to).filter(|&place| near(place)).collect();
            for place in places {
                if let Some(stretch) = self.stretches.get_mut(place) {
                    stretch.push(number);
                }
            }
        }
    }

    /// Where a particle is, m from the middle.
    fn place_m(&self, particle: &Passed, time_s: f64) -> f64 {
        let flown = self.mean.integral(time_s) - self.mean.integral(particle.middle_s);
        flown + particle.beside_mps * (time_s - particle.middle_s)
    }

    /// Those that may be in the beam at a time: most of the time nobody.
    #[inline]
    pub fn near(&self, time_s: f64) -> &[usize] {
        let place = ((time_s - self.from_s) / self.stretch_s).max(0.0) as usize;
        let last = self.stretches.len().max(1) - 1;
        self.stretches.get(place.min(last)).map_or(&[], Vec::as_slice)
    }

    /// The light of these of them at a time, codes, and what a mixer in quadrature makes of its fringes.
    pub fn light(&self, near: &[usize], time_s: f64) -> [f64; 2] {
        let light = |&number: &usize| {
            let Some(particle) = self.passed.get(number) else { return [0.0; 2] };
            let x = self.place_m(particle, time_s);
            let ratio = x / self.of.radius_m;
            let turns = x / self.of.fringe_m + self.of.shift_hz * time_s + particle.turns;
            let (sin, cos) = libm::sincos(TAU * (turns - libm::floor(turns)));
            let level = particle.amplitude / self.of.visibility * libm::exp(-2.0 * (ratio * ratio));
            [
                level * (self.of.pedestal + self.of.visibility * cos),
                level * self.of.visibility * sin,
            ]
        };
        near.iter().map(light).fold([0.0; 2], |sum, [i, q]| [sum[0] + i, sum[1] + q])
    }

    /// The frequency of the mean flow at a time, Hz.
    pub fn mean_hz(&self, time_s: f64) -> f64 {
        self.mean.at(time_s) / self.of.fringe_m + self.of.shift_hz
    }

    /// The velocity of the mean flow at a time, m/s.
    pub fn mean_mps(&self, time_s: f64) -> f64 {
        self.mean.at(time_s)
    }
}
