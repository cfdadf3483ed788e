//! Two crossed beams of one laser, and particles that cross their fringes: a laser-Doppler velocimeter.

use core::f64::consts::TAU;

/// Where the beams cross.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fringes {
    /// From one fringe to the next, m: the wavelength over twice the sine of half the angle between the beams.
    pub spacing_m: f64,
    /// The radius at which the light is down by exp(-2), m.
    pub radius_m: f64,
    /// How deep the fringes cut the light, 0 to 1.
    pub visibility: f64,
}

/// A particle on its way across.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// When it is in the middle, s.
    pub middle_s: f64,
    /// Its speed, m/s.
    pub speed_mps: f64,
    /// The light that it scatters in the middle, without fringes, in the unit of the answer.
    pub level: f64,
    /// The place of the middle among the fringes, turns.
    pub turns: f64,
}

impl Fringes {
    /// The light that a particle scatters at a time, s.
    pub fn light(&self, particle: &Particle, time_s: f64) -> f64 {
        let x = particle.speed_mps * (time_s - particle.middle_s);
        let ratio = x / self.radius_m;
        let envelope = libm::exp(-2.0 * (ratio * ratio));
        let fringes =
            1.0 + self.visibility * libm::cos(TAU * (x / self.spacing_m + particle.turns));
        particle.level * envelope * fringes
    }
}
