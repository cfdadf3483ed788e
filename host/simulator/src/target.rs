//! What reflects the transmitter's wave.

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
}

impl<'a> Target<'a> {
    /// A target whose range, m, is a function of time, s.
    pub fn new(amplitude: f64, range_m: impl Fn(f64) -> f64 + Send + Sync + 'a) -> Self {
        Target { range_m: Box::new(range_m), amplitude, cycles: 0.0, linewidth_hz: 0.0 }
    }

    /// A target at `range_m` at time 0 that approaches at `velocity_mps`.
    pub fn moving(amplitude: f64, range_m: f64, velocity_mps: f64) -> Self {
        Self::new(amplitude, move |t| range_m - velocity_mps * t)
    }

    /// The same target, whose reflection adds so many cycles to the phase.
    #[must_use]
    pub fn turned(self, cycles: f64) -> Self {
        Target { cycles, ..self }
    }

    /// Its range at a time, m and s.
    pub fn range_m(&self, time_s: f64) -> f64 {
        (self.range_m)(time_s)
    }
}
