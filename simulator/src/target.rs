//! What reflects the transmitter's wave.

use crate::random::Speckle;
use core::f64::consts::TAU;

/// A reflector on its way.
pub struct Target<'a> {
    /// Range at a time, m and s. Half the speed of light times the delay of the echo that arrives then.
    range_m: Box<dyn Fn(f64) -> f64 + Send + Sync + 'a>,
    /// Amplitude of its echo, codes.
    pub amplitude: f64,
    /// What the reflection adds to the phase of its echo, cycles.
    pub cycles: f64,
    /// Width of the random walk of its echo's phase (Lorentzian, full width at half maximum), Hz.
    pub linewidth_hz: f64,
    /// The envelope of its echo, over the time in seconds.
    speckle: Option<Speckle>,
}

impl<'a> Target<'a> {
    /// A target whose range, m, is a function of time, s.
    pub fn new(amplitude: f64, range_m: impl Fn(f64) -> f64 + Send + Sync + 'a) -> Self {
        let (cycles, linewidth_hz) = (0.0, 0.0);
        Target { range_m: Box::new(range_m), amplitude, cycles, linewidth_hz, speckle: None }
    }

    /// A target at `range_m` at time 0 that approaches at `velocity_mps`.
    pub fn moving(amplitude: f64, range_m: f64, velocity_mps: f64) -> Self {
        Self::new(amplitude, move |t| range_m - velocity_mps * t)
    }

    /// The same target, whose reflection adds this many cycles to the phase.
    #[must_use]
    pub fn turned(self, cycles: f64) -> Self {
        Target { cycles, ..self }
    }

    /// The same target with a rough surface, whose amplitude is then the root of the mean square over the speckle.
    #[must_use]
    pub fn rough(self, speckle: Speckle) -> Self {
        Target { speckle: Some(speckle), ..self }
    }

    /// Amplitude in codes, and cycles that the reflection adds to the phase, at a time in seconds.
    pub(crate) fn echo(&self, time_s: f64) -> (f64, f64) {
        match &self.speckle {
            None => (self.amplitude, self.cycles),
            Some(speckle) => {
                let [re, im] = speckle.at(time_s);
                let turned = libm::atan2(im, re) / TAU;
                (self.amplitude * libm::hypot(re, im), self.cycles + turned)
            }
        }
    }

    /// Its range at a time, m and s.
    pub fn range_m(&self, time_s: f64) -> f64 {
        (self.range_m)(time_s)
    }
}
