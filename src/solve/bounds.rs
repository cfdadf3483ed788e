//! The ranges and velocities that a target may have, as far as the user knows the scene.

/// The ranges and velocities that a target may have, ends included; infinite where nothing is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The least and the largest range, metres.
    pub range: [f32; 2],
    /// The least and the largest velocity, metres per second; positive when approaching.
    pub velocity: [f32; 2],
}

/// An interval without ends.
const OPEN: [f32; 2] = [f32::NEG_INFINITY, f32::INFINITY];

impl Default for Bounds {
    fn default() -> Self {
        Self { range: OPEN, velocity: OPEN }
    }
}

impl Bounds {
    /// The bounds of a configuration, m and m/s. `None` if an end is not finite, or the low end is above the high one.
    pub(crate) fn new(
        range_m: Option<(f64, f64)>,
        velocity_mps: Option<(f64, f64)>,
    ) -> Option<Self> {
        let interval = |ends: Option<(f64, f64)>| {
            let Some((low, high)) = ends else { return Some(OPEN) };
            let [low_f32, high_f32] = [low as f32, high as f32];
            let right = low <= high && low_f32.is_finite() && high_f32.is_finite();
            right.then_some([low_f32, high_f32])
        };
        Some(Self { range: interval(range_m)?, velocity: interval(velocity_mps)? })
    }

    /// Whether the velocity has both ends.
    pub(crate) fn limit_velocity(&self) -> bool {
        let [low, high] = self.velocity;
        low.is_finite() && high.is_finite()
    }

    /// Whether a target may have this range and this velocity, each within its margin.
    pub(crate) fn hold(&self, range: [f32; 2], velocity: [f32; 2]) -> bool {
        let within = |[low, high]: [f32; 2], [value, margin]: [f32; 2]| {
            value + margin >= low && value - margin <= high
        };
        within(self.range, range) && within(self.velocity, velocity)
    }
}
