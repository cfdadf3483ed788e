//! The cycles that the transmitter sends while the echo is under way.

use crate::math::fixed_point::{in_steps, to_f32};
use crate::solve::waveform::metres;
use fixed::types::I32F32;

/// Cycles over range: `per_metre R - square R^2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cycles {
    /// Cycles for a metre.
    per_metre: I32F32,
    /// The same as a float.
    slope: f32,
    /// Cycles for a square metre: a few at the far end, so a float holds them to 2e-6.
    square: f32,
}

impl Cycles {
    /// `None` if a metre has less than 2^-32 or more than 2^31 cycles.
    pub fn new(per_metre: f64, square: f64) -> Option<Self> {
        let fixed = I32F32::checked_from_num(per_metre).filter(|&fixed| fixed > 0)?;
        Some(Self { per_metre: fixed, slope: per_metre as f32, square: square as f32 })
    }

    /// The cycles of a range.
    pub fn at(&self, range: I32F32) -> I32F32 {
        let far = to_f32(range);
        metres(range.to_bits(), self.per_metre).saturating_sub(in_steps(self.square * far * far))
    }

    /// Cycles for a metre more, at this range.
    pub fn slope_at(&self, range: I32F32) -> f32 {
        self.slope - 2.0 * self.square * to_f32(range)
    }

    /// The range nearest to `near` whose cycles have the fraction `seen`.
    pub fn nearest(&self, seen: I32F32, near: I32F32) -> I32F32 {
        let slope = self.slope_at(near);
        let mut range = near;
        // The first step is right except for its rounding, which the second one sees.
        for _ in 0..2 {
            // The lower word of the difference is a fraction of -1/2 to 1/2.
            let rest = seen.to_bits().wrapping_sub(self.at(range).to_bits()) as i32;
            let turns = rest as f32 / 4_294_967_296.0;
            range = range.saturating_add(in_steps(turns / slope));
        }
        range
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cycles of ranges to 100 m, by the definition in double precision, and back.
    #[test]
    fn cycles_and_ranges_agree() {
        const C: f64 = 299_792_458.0;
        for (carrier_hz, slope) in [(24.1e9, 0.2e12), (77e9, 30e12), (122e9, 7e12), (193e12, 1e14)]
        {
            let (a, b) = (2.0 * carrier_hz / C, 2.0 * slope / (C * C));
            let cycles = Cycles::new(a, b).unwrap();
            for i in 1..200 {
                let range = I32F32::from_num(0.503_7 * f64::from(i));
                let far: f64 = range.to_num();
                let exact = a * far - b * far * far;
                let found: f64 = cycles.at(range).to_num();
                assert!(
                    (found - exact).abs() < 1e-6 * (1.0 + b * far * far),
                    "{far} {found} {exact}"
                );
                // From a third of a cycle away.
                let near = range.saturating_add(I32F32::from_num(0.33 / a));
                let back = cycles.nearest(cycles.at(range), near);
                let off: f64 = (back - range).to_num();
                assert!((off * a).abs() < 1e-3 && off.abs() < 2e-9, "{far} {off:e}");
            }
        }
    }
}
