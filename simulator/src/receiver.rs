//! What mixes an echo with the transmitter's wave and samples the product.

use crate::random::walk;
use crate::target::Target;
use crate::waveform::Waveform;
use core::f64::consts::TAU;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::{Codes, Mixing};

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

    /// The noise that leaves an echo of this amplitude this many decibels above it, per sample: `A^2 / (2 sigma^2)`.
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
        let delay_s = |target: &Target, local_s: f64| {
            2.0 * target.range_m(begin_s + local_s) / SPEED_OF_LIGHT
        };
        let local_s = |index: usize| from_s + index as f64 / self.rate_hz;
        // The transmitter's own phase, cycles: for each sample when it is taken, and when each echo was sent.
        let wandered = (waveform.linewidth_hz > 0.0).then(|| {
            let of = |index| {
                let taken_s = local_s(index);
                let sent_s = move |target| taken_s - delay_s(target, taken_s);
                core::iter::once(taken_s).chain(targets.iter().map(sent_s))
            };
            let times: Vec<f64> = (0..n).flat_map(of).collect();
            walk(&times, libm::sqrt(waveform.linewidth_hz / TAU), &mut normal)
        });
        let own = |index: usize, number: usize| {
            let walked = wandered.as_ref()?.get(index * (targets.len() + 1)..)?;
            Some(walked.first()? - walked.get(1 + number)?)
        };
        let mut walks = vec![0.0; targets.len()];
        let sample = |index: usize| {
            let local_s = local_s(index);
            let mut parts = self.offset;
            for (number, (target, walk)) in targets.iter().zip(&mut walks).enumerate() {
                let (amplitude, turned) = target.echo(begin_s + local_s);
                let cycles = waveform.cycles(local_s, delay_s(target, local_s)) + turned + *walk;
                let cycles = sign * (cycles + own(index, number).unwrap_or(0.0));
                let angle = TAU * (cycles - libm::floor(cycles));
                parts[0] += amplitude * libm::cos(angle);
                parts[1] += self.gain * amplitude * libm::sin(angle + self.quadrature_rad);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// An echo that is late by less than the samples of a record: what is left of the laser's phase is the walk of its delay.
    #[test]
    fn a_lasers_phase_walks_by_the_delay_of_the_echo() {
        let (rate_hz, linewidth_hz, delay_s) = (250e6, 200e3, 0.4e-6);
        let mut waveform = Waveform::continuous(1e9);
        waveform.linewidth_hz = linewidth_hz;
        let receiver = Receiver::ideal(rate_hz, true, Mixing::TxConjRx);
        let mut normal = crate::random::tests::normals();
        let target = Target::new(1.0, move |_| 0.5 * delay_s * SPEED_OF_LIGHT);
        let (mut squares, mut product, mut apart, records) = (0.0, 0.0, 0.0, 4000);
        for _ in 0..records {
            // Samples 50 ns, and 4 us apart: their walks have seven eighths of the delay in common, and nothing.
            let (samples, at) = (1100, [0, 12, 1000]);
            let record = receiver.voltages(
                &waveform,
                core::slice::from_ref(&target),
                (0, 0.0),
                samples,
                &mut normal,
            );
            let [a, b, c] = at.map(|k| libm::atan2(record[k][1], record[k][0]));
            squares += a * a;
            product += a * b;
            apart += a * c;
        }
        let variance = TAU * linewidth_hz * delay_s;
        let common = 1.0 - 12.0 / rate_hz / delay_s;
        // A mean of 4,000 squares is known to 2.2 %, one sigma.
        for (sum, stated) in [(squares, variance), (product, variance * common)] {
            let ratio = sum / f64::from(records) / stated;
            assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
        }
        assert!((apart / f64::from(records) / variance).abs() < 0.1, "{apart}");
    }
}
