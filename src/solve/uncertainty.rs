//! The whole error of an answer: what its block's noise does, and what is not known of the sensor.
//!
//! A sigma covers the noise alone. A wrong crystal, sweep or angle is the same in each block, so a mean over blocks lessens the noise's part
//! and nothing else. [`Uncertainty`] holds one standard deviation of each, and propagates them by the law of JCGM 100:2008 (equation 10;
//! where the first derivative vanishes, by the term of second order of the note to 5.1.2).

use super::phase_range::PhaseRange;
use super::target::Target;
use crate::math::fixed_point::to_f32;
use crate::math::scalar::Scalar as _;
use core::f32::consts::PI;

/// What is not known of a sensor, each as one standard deviation. The default knows everything.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Uncertainty {
    /// Of the sample clock, parts per million.
    pub clock_ppm: f32,
    /// Of the carrier, parts per million: for a range by phase, of the carrier in the middle of the record.
    pub carrier_ppm: f32,
    /// Of the sweep's slope, parts per million.
    pub slope_ppm: f32,
    /// Of the angle between beam and motion, radians.
    pub angle_rad: f32,
    /// Of the range's offset, metres.
    pub range_offset_m: f32,
    /// Of the phase of a target at 0 m, radians: for ranges by phase.
    pub phase_rad: f32,
}

/// What an uncertainty comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Source {
    /// The noise of the block.
    #[default]
    Noise,
    /// The sample clock.
    Clock,
    /// The carrier.
    Carrier,
    /// The sweep's slope.
    Slope,
    /// The angle between beam and motion.
    Angle,
    /// The range's offset.
    RangeOffset,
    /// The phase of a target at 0 m.
    Phase,
}

impl Source {
    /// The name that tables and JSON show.
    pub const fn name(self) -> &'static str {
        match self {
            Source::Noise => "noise",
            Source::Clock => "clock",
            Source::Carrier => "carrier",
            Source::Slope => "slope",
            Source::Angle => "angle",
            Source::RangeOffset => "range-offset",
            Source::Phase => "phase",
        }
    }
}

/// One source's part, as a standard deviation of the answer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Part {
    /// The source.
    pub source: Source,
    /// Of the range, metres.
    pub range: f32,
    /// Of the velocity, metres per second.
    pub velocity: f32,
}

/// One standard deviation of each number of an answer by all sources together (k = 1); 0 where the answer has no such number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Total {
    /// Of the frequency, cycles per sample.
    pub frequency: f32,
    /// Of the range, metres.
    pub range: f32,
    /// Of the velocity, metres per second.
    pub velocity: f32,
}

/// The parts of an answer's error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Budget {
    /// Each source's part, the noise's first.
    pub parts: [Part; 7],
}

impl Budget {
    /// One standard deviation of range and velocity by all sources together (k = 1), m and m/s.
    pub fn total(&self) -> [f32; 2] {
        let sum = |of: fn(&Part) -> f32| {
            self.parts.iter().map(|part| of(part) * of(part)).sum::<f32>().root()
        };
        [sum(|part| part.range), sum(|part| part.velocity)]
    }

    /// The budget of the mean of `blocks` blocks: the noise falls by the root of their number, the rest stays.
    #[must_use]
    pub fn of_mean(mut self, blocks: u32) -> Self {
        let share = 1.0 / (blocks.max(1) as f32).root();
        for part in self.parts.iter_mut().filter(|part| part.source == Source::Noise) {
            (part.range, part.velocity) = (part.range * share, part.velocity * share);
        }
        self
    }
}

impl Uncertainty {
    /// Whether all are finite and none is negative.
    pub fn is_valid(&self) -> bool {
        let Self { clock_ppm, carrier_ppm, slope_ppm, angle_rad, range_offset_m, phase_rad } =
            *self;
        [clock_ppm, carrier_ppm, slope_ppm, angle_rad, range_offset_m, phase_rad]
            .into_iter()
            .all(|x| x >= 0.0 && x.is_finite())
    }

    /// The budget of a target by its beats. `angle_rad` is the angle between beam and motion for which its velocity was solved. A velocity
    /// that is not known has no parts.
    ///
    /// ```
    /// use picket_dsp::Target;
    /// use picket_dsp::fixed::types::I32F32;
    /// use picket_dsp::solve::uncertainty::Uncertainty;
    ///
    /// let known = Uncertainty { clock_ppm: 20.0, slope_ppm: 100.0, range_offset_m: 1e-3, ..Uncertainty::default() };
    /// let target = Target { range: I32F32::from_num(30), sigma_range: 2e-3, ..Target::default() };
    /// let budget = known.of_target(&target, 0.0);
    /// let [range, _] = budget.total();
    /// assert!((range - 3.79e-3).abs() < 1e-5); // of 30 m: 2 mm, 0.6 mm, 3 mm, 1 mm
    /// assert!(budget.of_mean(100).total()[0] > 3.2e-3); // most of it stays
    /// ```
    pub fn of_target(&self, target: &Target, angle_rad: f32) -> Budget {
        let far = to_f32(target.range);
        let speed = to_f32(target.velocity.unwrap_or_default());
        let known = target.velocity.is_some();
        let share = |ppm: f32, of: f32| (1e-6 * ppm * of).abs();
        // V / cos: the derivatives are V tan and V (1 + 2 tan^2).
        let beam = f32::unit(angle_rad / (2.0 * PI));
        let tangent = beam.im / beam.re;
        let first = speed * tangent * self.angle_rad;
        let second = speed * (1.0 + 2.0 * tangent * tangent) * self.angle_rad * self.angle_rad;
        let angle = (first * first + 0.5 * second * second).root();
        let part = |source, range, velocity| Part { source, range, velocity };
        Budget {
            parts: [
                part(
                    Source::Noise,
                    target.sigma_range,
                    if known { target.sigma_velocity } else { 0.0 },
                ),
                part(Source::Clock, share(self.clock_ppm, far), share(self.clock_ppm, speed)),
                part(Source::Carrier, 0.0, share(self.carrier_ppm, speed)),
                part(Source::Slope, share(self.slope_ppm, far), 0.0),
                part(Source::Angle, 0.0, angle),
                part(Source::RangeOffset, self.range_offset_m, 0.0),
                part(Source::Phase, 0.0, 0.0),
            ],
        }
    }

    /// The budget of a range by phase, for a carrier's wavelength in metres. Where the cycle is sure, the range depends on the carrier in the
    /// middle of the record and on the phase at 0 m; elsewhere it is that of the frequency.
    pub fn of_phase_range(&self, answer: &PhaseRange, wavelength_m: f32) -> Budget {
        let target = Target {
            range: answer.range,
            velocity: answer.velocity,
            sigma_range: answer.sigma,
            sigma_velocity: answer.sigma_velocity,
            ..Target::default()
        };
        match answer.is_sure() {
            true => self.of_range_by_phase(&target, wavelength_m),
            false => self.of_target(&target, 0.0),
        }
    }

    /// The budget of a target whose range is by a phase whose cycle is sure.
    pub fn of_range_by_phase(&self, target: &Target, wavelength_m: f32) -> Budget {
        let mut budget = self.of_target(target, 0.0);
        let far = to_f32(target.range);
        for part in &mut budget.parts {
            part.range = match part.source {
                Source::Noise => part.range,
                Source::Carrier => (1e-6 * self.carrier_ppm * far).abs(),
                Source::Phase => self.phase_rad * wavelength_m / (4.0 * PI),
                Source::Clock | Source::Slope | Source::Angle | Source::RangeOffset => 0.0,
            };
        }
        budget
    }
}
