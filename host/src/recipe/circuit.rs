//! The amplifier between a sensor and a converter, and the converter.

use std::f64::consts::PI;

/// A part of an amplifier that passes some frequencies: one resistor and one capacitor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Section {
    /// What is above this frequency, Hz.
    Above(f64),
    /// What is below it.
    Below(f64),
}

/// An amplifier, and a converter of 12 bits from 0 to 3.3 V about half of that.
#[derive(Clone, Copy, Debug)]
pub struct Circuit {
    /// The gain in the pass band.
    pub gain: f64,
    /// What limits the band.
    pub sections: &'static [Section],
    /// Samples per second.
    pub rate_hz: f64,
}

/// Steps of the analog side for each sample.
pub const STEPS: usize = 8;
/// One code, V.
pub const CODE_V: f64 = 3.3 / 4096.0;

impl Circuit {
    /// The gain at a frequency.
    pub fn at(&self, hz: f64) -> f64 {
        self.sections.iter().fold(self.gain, |gain, section| {
            gain * match *section {
                Section::Above(corner) => (hz / corner) / (hz / corner).hypot(1.0),
                Section::Below(corner) => (hz / corner).hypot(1.0).recip(),
            }
        })
    }

    /// The rate of the analog side, Hz.
    pub const fn fine_hz(&self) -> f64 {
        self.rate_hz * STEPS as f64
    }

    /// Standard deviation at the converter of white noise of this many volts per root of a hertz at the input, in codes.
    pub fn noise_codes(&self, density_v: f64) -> f64 {
        let (steps, most_hz) = (20_000, 20.0 * self.rate_hz);
        let square =
            |step: i32| self.at(most_hz * (f64::from(step) + 0.5) / f64::from(steps)).powi(2);
        let integral = (0..steps).map(square).sum::<f64>() * most_hz / f64::from(steps);
        density_v * integral.sqrt() / CODE_V
    }

    /// The codes of a voltage at the input, which is given at the fine rate.
    pub fn codes(&self, mut volts: Vec<f64>) -> Vec<i16> {
        for section in self.sections {
            // Both by the bilinear transform, which bends no frequency far below the fine rate.
            let (corner, own) = match *section {
                Section::Above(corner) => (corner, -1.0),
                Section::Below(corner) => (corner, 1.0),
            };
            let c = (PI * corner / self.fine_hz()).tan();
            let (scale, back) = (1.0 / (1.0 + c), (1.0 - c) / (1.0 + c));
            let scale = if own > 0.0 { c * scale } else { scale };
            let (mut x1, mut y1) = (volts.first().copied().unwrap_or(0.0), 0.0);
            if own > 0.0 {
                y1 = x1;
            }
            for volt in &mut volts {
                let x = *volt;
                y1 = scale * (x + own * x1) + back * y1;
                x1 = x;
                *volt = y1;
            }
        }
        let code = |volt: &f64| {
            // A cast saturates before the rails would be passed.
            ((volt * self.gain + 1.65) / CODE_V).floor().clamp(0.0, 4095.0) as i16
        };
        volts.iter().step_by(STEPS).map(code).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A sine comes out as large as the formula says, to a hundredth; half a code of rounding beside.
    #[test]
    fn a_circuit_passes_what_its_formula_says() {
        let sections = &[Section::Above(100.0), Section::Below(2000.0), Section::Below(3000.0)];
        let circuit = Circuit { gain: 50.0, sections, rate_hz: 20e3 };
        for hz in [30.0, 100.0, 700.0, 2000.0, 6000.0] {
            let level = 500.0 * CODE_V / circuit.at(hz);
            let sine = |k: usize| level * (TAU * hz * k as f64 / circuit.fine_hz()).sin();
            let codes = circuit.codes((0..STEPS * 40_000).map(sine).collect());
            // The first half is the switching on.
            let later = &codes[20_000..];
            let mean = later.iter().map(|&c| f64::from(c)).sum::<f64>() / 20_000.0;
            let power =
                later.iter().map(|&c| (f64::from(c) - mean).powi(2)).sum::<f64>() / 20_000.0;
            let amplitude = (2.0 * power).sqrt();
            assert!((amplitude - 500.0).abs() < 5.0, "{hz} Hz: {amplitude}");
        }
    }
}
