//! The converter of an RP2040, with the widths that its codes have (RP2040-E11).

use picket_firmware::pico::widths::{WIDE, curve};

/// The steps of the curve at the wide codes, codes.
const STEPS: [f64; 4] = [10.0, 9.0, 9.0, 10.0];

/// A converter: the voltages where its codes begin, in codes of an ideal one.
#[derive(Clone, Debug)]
pub struct Converter(Vec<f64>);

impl Converter {
    /// One whose steps are this many times those of the mean curve: 1 each is the curve itself.
    pub fn from_steps(factors: [f64; 4]) -> Self {
        let middle = |code: usize| {
            let changed = WIDE.iter().zip(STEPS).zip(factors).map(|((&wide, step), factor)| {
                // A wide code itself lies in the middle of its step.
                let passed = (code as f64 - f64::from(wide) + 1.0).clamp(0.0, 2.0) / 2.0;
                passed * step * (factor - 1.0)
            });
            code as f64 + f64::from(curve(code as i16)) + changed.sum::<f64>()
        };
        let wide = |code: usize| WIDE.iter().any(|&wide| usize::from(wide as u16) == code);
        // A wide code reaches to its neighbours, which are as wide as all others.
        let edge = |code: usize| match (wide(code - 1), wide(code)) {
            (true, _) => middle(code) - 0.5,
            (_, true) => middle(code - 1) + 0.5,
            _ => (middle(code - 1) + middle(code)) / 2.0,
        };
        let edges: Vec<f64> = (1..4096).map(edge).collect();
        // Its rails are those of an ideal one.
        let (low, high) = (edges[0], edges[edges.len() - 1]);
        Self(edges.iter().map(|edge| (edge - low) / (high - low) * 4094.0 + 0.5).collect())
    }

    /// Without errors.
    pub fn ideal() -> Self {
        Self((0..4095).map(|code| f64::from(code) + 0.5).collect())
    }

    /// The code for a voltage, which is in codes of an ideal converter.
    pub fn code(&self, voltage: f64) -> i16 {
        self.0.partition_point(|edge| *edge <= voltage) as i16
    }
}

impl Default for Converter {
    /// A converter with the mean curve.
    fn default() -> Self {
        Self::from_steps([1.0; 4])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_codes_are_ten_codes_wide() {
        let converter = Converter::default();
        let width = |code: i16| {
            let codes = (0..40_960).map(|v| converter.code(f64::from(v) / 10.0));
            codes.filter(|c| *c == code).count() as f64 / 10.0
        };
        for wide in WIDE {
            assert!((9.0..12.0).contains(&width(wide)), "{wide}: {}", width(wide));
            assert!((0.9..1.1).contains(&width(wide - 1)) && (0.9..1.1).contains(&width(wide + 1)));
        }
        assert!((0.9..1.1).contains(&width(700)));
        assert_eq!([-1.0, 0.0, 4094.9, 9e9].map(|v| converter.code(v)), [0, 0, 4095, 4095]);
        assert_eq!(Converter::ideal().code(2047.6), 2048);
        // Without its steps the curve keeps within a few codes of a line.
        let flat = Converter::from_steps([0.0; 4]);
        for code in (0..4096).step_by(7) {
            assert!((flat.code(f64::from(code)) - code).abs() <= 14, "{code}");
        }
    }
}
