//! The waveform of a transmitter.

use crate::scene::{self, Shape};

/// A stretch of time in which the carrier is a polynomial of second order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    /// Carrier at the start, Hz.
    pub start_hz: f64,
    /// Slope at the start, Hz/s.
    pub slope: f64,
    /// Half the change of the slope, Hz/s^2.
    pub bend: f64,
    /// Duration, s.
    pub duration_s: f64,
}

impl Segment {
    /// A constant carrier.
    pub const fn steady(start_hz: f64, duration_s: f64) -> Self {
        Segment { start_hz, slope: 0.0, bend: 0.0, duration_s }
    }

    /// The carrier's cycles in the `span` seconds before `to`, in seconds since the start of the segment.
    fn cycles(&self, to: f64, span: f64) -> f64 {
        let mean = self.start_hz
            + self.slope * (to - span / 2.0)
            + self.bend * (to * to - to * span + span * span / 3.0);
        mean * span
    }
}

/// A transmitter's carrier over time. It repeats for ever, without a phase of its own at the seams.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Waveform {
    segments: Vec<Segment>,
    /// From one repetition to the next, s.
    period_s: f64,
}

impl Waveform {
    /// A continuous wave.
    pub fn continuous(carrier_hz: f64) -> Self {
        Self::new(vec![Segment::steady(carrier_hz, f64::INFINITY)], f64::INFINITY)
    }

    /// These segments again and again, `period_s` seconds apart. Until the next repetition the carrier rests where the first
    /// segment starts.
    pub fn new(mut segments: Vec<Segment>, period_s: f64) -> Self {
        let taken: f64 = segments.iter().map(|segment| segment.duration_s).sum();
        let rest = segments.first().map_or(0.0, |segment| segment.start_hz);
        if period_s > taken {
            segments.push(Segment::steady(rest, period_s - taken));
        }
        Self { segments, period_s: period_s.max(taken) }
    }

    /// Ramps from the lower end of a band, whose middle lies above a straight line by a share of the bandwidth.
    pub fn ramps(of: &scene::Waveform) -> Self {
        let (low, high, duration_s) = (of.carrier_hz, of.carrier_hz + of.bandwidth_hz, of.ramp_s);
        let (slope, e) = (of.bandwidth_hz / duration_s, 4.0 * of.curvature);
        let bend = -e * slope / duration_s;
        let up = Segment { start_hz: low, slope: slope * (1.0 + e), bend, duration_s };
        let down = Segment { start_hz: high, slope: -slope * (1.0 - e), bend, duration_s };
        let flat = Segment::steady(high, duration_s);
        let segments = match of.shape {
            Shape::Trapezoid => vec![up, flat, down],
            Shape::Triangle => vec![up, down],
            _ => vec![up],
        };
        Self::new(segments, of.period_s)
    }

    /// From one repetition to the next, s.
    pub const fn period_s(&self) -> f64 {
        self.period_s
    }

    /// When a segment starts, in seconds since the repetition's start.
    pub fn start_s(&self, segment: usize) -> f64 {
        self.segments.iter().take(segment).map(|segment| segment.duration_s).sum()
    }

    /// The carrier's cycles in the last `delay_s` seconds before a moment, which is in seconds since the start of a repetition.
    /// The delay must be less than a repetition. A continuous wave has neither beginning nor end.
    pub fn cycles(&self, moment_s: f64, delay_s: f64) -> f64 {
        if let [segment] = self.segments[..]
            && segment.duration_s.is_infinite()
        {
            return segment.cycles(moment_s, delay_s);
        }
        let (mut ends, mut left, mut cycles) = (moment_s, delay_s, 0.0);
        // The segments of this repetition up to the moment, then those of the repetition before.
        for begin in [0.0, -self.period_s] {
            for (index, segment) in self.segments.iter().enumerate().rev() {
                let start = if index == 0 { begin } else { begin + self.start_s(index) };
                if start >= ends {
                    continue;
                }
                // Where the rest of the delay lies in one segment, its length has all of its digits.
                let span = left.min(ends - start);
                cycles += segment.cycles(ends - start, span);
                left -= span;
                if left <= 0.0 {
                    return cycles;
                }
                ends = start;
            }
        }
        cycles
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sum of the carrier over small steps, apart from the polynomials.
    fn summed(waveform: &Waveform, moment_s: f64, delay_s: f64) -> f64 {
        let steps = 200_000;
        let carrier = |t: f64| {
            let mut t = t.rem_euclid(waveform.period_s);
            for segment in &waveform.segments {
                if t < segment.duration_s {
                    return segment.start_hz + segment.slope * t + segment.bend * t * t;
                }
                t -= segment.duration_s;
            }
            f64::NAN
        };
        let step = delay_s / f64::from(steps);
        (0..steps).map(|i| carrier(moment_s - (f64::from(i) + 0.5) * step) * step).sum()
    }

    #[test]
    fn cycles_are_the_integral_of_the_carrier_across_segments() {
        let of = scene::Waveform {
            carrier_hz: 1e9,
            bandwidth_hz: 0.3e9,
            ramp_s: 1e-6,
            curvature: 0.05,
            ..scene::Waveform::default()
        };
        for (shape, period_s) in
            [(Shape::Trapezoid, 0.0), (Shape::Triangle, 3e-6), (Shape::Sawtooth, 0.0)]
        {
            let waveform = Waveform::ramps(&scene::Waveform { shape, period_s, ..of.clone() });
            for moment_s in [1e-9, 0.4e-6, 0.999e-6] {
                for delay_s in [1e-10, 0.2e-6, 0.9e-6] {
                    let (exact, summed) =
                        (waveform.cycles(moment_s, delay_s), summed(&waveform, moment_s, delay_s));
                    assert!((exact - summed).abs() < 2e-3, "{shape:?} {moment_s} {delay_s}");
                }
            }
        }
    }

    #[test]
    fn the_middle_of_a_bent_ramp_is_off_by_its_curvature() {
        let of = scene::Waveform {
            shape: Shape::Trapezoid,
            bandwidth_hz: 200e6,
            ramp_s: 1e-3,
            curvature: 0.01,
            ..scene::Waveform::default()
        };
        let waveform = Waveform::ramps(&of);
        for segment in [0, 2] {
            let Segment { start_hz, slope, bend, duration_s } = waveform.segments[segment];
            let t = duration_s / 2.0;
            let share = (start_hz + slope * t + bend * t * t - of.carrier_hz) / of.bandwidth_hz;
            assert!((share - 0.51).abs() < 1e-9, "{share}");
        }
    }
}
