//! What mixes an echo with the transmitter's wave and samples the product.

use crate::target::Target;
use crate::waveform::Waveform;
use core::f64::consts::TAU;
use picket::config::SPEED_OF_LIGHT;
use picket::{Codes, Mixing};

/// A mixer and its converter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Whether it has a second mixer and converter, in quadrature.
    pub iq: bool,
    /// Which signal it conjugates.
    pub mixing: Mixing,
    /// Standard deviation of the noise of each converter, codes.
    pub noise: f64,
    /// Offsets of both converters, codes.
    pub offset: [f64; 2],
    /// Gain of the second channel over the first.
    pub gain: f64,
    /// By how much the second mixer's phase is off a quarter turn, radians.
    pub quadrature_rad: f64,
    /// The converters' codes; what lies beyond them ends at their rails.
    pub codes: Codes,
}

impl Receiver {
    /// A receiver without faults and noise, with signed codes of 12 bits.
    pub const fn ideal(rate_hz: f64, iq: bool, mixing: Mixing) -> Self {
        Receiver {
            rate_hz,
            iq,
            mixing,
            noise: 0.0,
            offset: [0.0; 2],
            gain: 1.0,
            quadrature_rad: 0.0,
            codes: Codes::signed::<12>(),
        }
    }

    /// The noise that leaves an echo of this amplitude so many decibels above it, per sample: `A^2 / (2 sigma^2)`.
    pub fn with_snr(self, amplitude: f64, snr_db: f64) -> Self {
        Receiver { noise: amplitude / libm::sqrt(2.0 * libm::exp10(snr_db / 10.0)), ..self }
    }

    /// The voltages of `n` samples, in codes that are neither rounded nor cut. The first one is taken `from_s` seconds after the start of
    /// the waveform's repetition `lap`. `normal` draws normal numbers; a real record's second part is 0.
    pub fn voltages(
        &self,
        waveform: &Waveform,
        targets: &[Target],
        (lap, from_s): (u64, f64),
        n: usize,
        mut normal: impl FnMut() -> f64,
    ) -> Vec<[f64; 2]> {
        let sign = f64::from(self.mixing.sign());
        let begin_s = if lap == 0 { 0.0 } else { lap as f64 * waveform.period_s() };
        let mut walks = vec![0.0; targets.len()];
        let sample = |index: usize| {
            let local_s = from_s + index as f64 / self.rate_hz;
            let mut parts = self.offset;
            for (target, walk) in targets.iter().zip(&mut walks) {
                let delay_s = 2.0 * target.range_m(begin_s + local_s) / SPEED_OF_LIGHT;
                let cycles = sign * (waveform.cycles(local_s, delay_s) + target.cycles + *walk);
                let angle = TAU * (cycles - libm::floor(cycles));
                parts[0] += target.amplitude * libm::cos(angle);
                parts[1] += self.gain * target.amplitude * libm::sin(angle + self.quadrature_rad);
                if target.linewidth_hz > 0.0 {
                    *walk += libm::sqrt(target.linewidth_hz / (TAU * self.rate_hz)) * normal();
                }
            }
            parts.map(|part| if self.noise > 0.0 { part + self.noise * normal() } else { part })
        };
        let both = (0..n).map(sample);
        both.map(|[i, q]| [i, if self.iq { q } else { 0.0 }]).collect()
    }

    /// The codes of a voltage.
    pub fn convert(&self, voltage: [f64; 2]) -> [i16; 2] {
        let (low, high) = self.codes.rails();
        let (middle, [i, q]) = (f64::midpoint(low.into(), high.into()) + 0.5, voltage);
        // A cast saturates.
        let code = |x: f64| libm::rint(middle + x).clamp(low.into(), high.into()) as i16;
        [code(i), if self.iq { code(q) } else { 0 }]
    }

    /// The codes of `n` samples, see [`Receiver::voltages`].
    pub fn record(
        &self,
        waveform: &Waveform,
        targets: &[Target],
        at: (u64, f64),
        n: usize,
        normal: impl FnMut() -> f64,
    ) -> Vec<[i16; 2]> {
        let voltages = self.voltages(waveform, targets, at, n, normal);
        voltages.into_iter().map(|voltage| self.convert(voltage)).collect()
    }
}
