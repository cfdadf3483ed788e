//! A transmitter, a receiver, and when it takes its records.

use crate::receiver::Receiver;
use crate::target::Target;
use crate::waveform::Waveform;
use core::f64::consts::TAU;
use picket_dsp::Chirp;

/// A radar, a lidar or a velocimeter. It takes a record of `n` samples in each segment of its waveform, and begins anew with each
/// repetition, the lap.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// What is sent.
    pub waveform: Waveform,
    /// What takes the records.
    pub receiver: Receiver,
    /// Samples in a record.
    pub n: usize,
    /// When the first sample of each record is taken, in seconds since the lap's start.
    starts_s: Vec<f64>,
}

impl Sensor {
    /// A chirp every `period_s` seconds, or without a pause where that is less.
    pub fn chirp(chirp: &Chirp, receiver: Receiver, n: usize, period_s: f64) -> Self {
        let start_s = |segment: usize| segment as f64 * chirp.duration_s + chirp.guard_s;
        let starts_s = (0..chirp.shape.segments().len()).map(start_s).collect();
        Self { waveform: Waveform::chirp(chirp, period_s), receiver, n, starts_s }
    }

    /// A continuous wave. Its only lap has one record, with the first sample at time 0: whoever wants more of them moves the
    /// targets.
    pub fn continuous(carrier_hz: f64, receiver: Receiver, n: usize) -> Self {
        Self { waveform: Waveform::continuous(carrier_hz), receiver, n, starts_s: vec![0.0] }
    }

    /// The same sensor with another receiver.
    #[must_use]
    pub fn received_by(self, receiver: Receiver) -> Self {
        Self { receiver, ..self }
    }

    /// The records of a lap.
    pub fn segments(&self) -> usize {
        self.starts_s.len()
    }

    /// The mean of the middles of the first and the last record, in seconds since the lap's start: the moment to which the range
    /// of a chirp refers.
    pub fn middle_s(&self) -> f64 {
        let ends =
            [self.starts_s.first(), self.starts_s.last()].map(|start| *start.unwrap_or(&0.0));
        f64::midpoint(ends[0], ends[1]) + 0.5 * (self.n.max(1) - 1) as f64 / self.receiver.rate_hz
    }

    /// The voltages of a segment's record, see [`Receiver::voltages`].
    pub fn voltages(
        &self,
        targets: &[Target],
        (lap, segment): (u64, usize),
        normal: impl FnMut() -> f64,
    ) -> Vec<[f64; 2]> {
        let start_s = self.starts_s.get(segment).copied().unwrap_or(0.0);
        self.receiver.voltages(&self.waveform, targets, (lap, start_s), self.n, normal)
    }

    /// The codes of a segment's record.
    pub fn record(
        &self,
        targets: &[Target],
        at: (u64, usize),
        normal: impl FnMut() -> f64,
    ) -> Vec<[i16; 2]> {
        let voltages = self.voltages(targets, at, normal);
        voltages.into_iter().map(|voltage| self.receiver.convert(voltage)).collect()
    }

    /// The mean frequency of a target's echo in a segment's record, signed cycles per sample, as a receiver without faults and noise
    /// shows it: the slope of the line through its phases, by least squares.
    pub fn beat(&self, target: &Target, at: (u64, usize)) -> f64 {
        let Receiver { rate_hz, mixing, .. } = self.receiver;
        let receiver = Receiver::ideal(rate_hz, true, mixing);
        let voltages =
            Self { receiver, ..self.clone() }.voltages(core::slice::from_ref(target), at, || 0.0);
        let middle = 0.5 * (voltages.len().max(1) - 1) as f64;
        let (mut last, mut turns) = ([1.0, 0.0], 0.0);
        let (mut moment, mut spread) = (0.0, 0.0);
        for (index, [re, im]) in voltages.into_iter().enumerate() {
            let [before_re, before_im] = last;
            let (cross, dot) = (im * before_re - re * before_im, re * before_re + im * before_im);
            turns += libm::atan2(cross, dot) / TAU;
            last = [re, im];
            let place = index as f64 - middle;
            moment += place * turns;
            spread += place * place;
        }
        moment / spread
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_dsp::config::SPEED_OF_LIGHT;
    use picket_dsp::{Mixing, Shape};

    /// What a receiver shows of the three segments, as the textbooks have it: at 24 GHz 30 m and 3 m/s, to a share of what they
    /// leave out.
    #[test]
    fn beats_have_a_receivers_signs() {
        let chirp = Chirp { guard_s: 10e-6, duration_s: 1.1e-3, ..Chirp::default() };
        let range_hz = chirp.bandwidth_hz / chirp.duration_s * 2.0 * 30.0 / SPEED_OF_LIGHT;
        let shift_hz = 2.0 * 3.0 / chirp.wavelength_m;
        for mixing in Mixing::ALL {
            let receiver = Receiver::ideal(1e6, true, mixing);
            let sensor = Sensor::chirp(&chirp, receiver, 1024, 0.0);
            assert_eq!((sensor.segments(), chirp.shape), (3, Shape::Trapezoid));
            let target = Target::moving(1.0, 30.0 + 3.0 * sensor.middle_s(), 3.0);
            let wanted = [range_hz - shift_hz, -shift_hz, -range_hz - shift_hz];
            for (segment, wanted) in wanted.into_iter().enumerate() {
                let seen = f64::from(mixing.sign()) * 1e6 * sensor.beat(&target, (0, segment));
                // The carrier rises by less than a hundredth, the target moves by 4 mm.
                assert!(
                    (seen - wanted).abs() < 0.01 * shift_hz + 6.0,
                    "{segment}: {seen}, not {wanted}"
                );
            }
        }
    }

    #[test]
    fn a_continuous_wave_has_one_record() {
        let receiver = Receiver::ideal(1e6, true, Mixing::RxConjTx);
        let sensor = Sensor::continuous(24e9, receiver, 1000);
        assert!(sensor.segments() == 1 && (sensor.middle_s() - 0.4995e-3).abs() < 1e-12);
        let shift = sensor.beat(&Target::moving(1.0, 5.0, 2.0), (0, 0));
        assert!((1e6 * shift - 2.0 * 2.0 * 24e9 / SPEED_OF_LIGHT).abs() < 1e-3, "{shift}");
    }
}
