//! The calibration of a sensor by measurements at a known distance.

use super::PhaseRanging;
use crate::math::scalar::Scalar as _;
use crate::tone::phasor::ToneWithPhase;
use core::f32::consts::TAU;
use fixed::types::I32F32;

/// The errors of a sensor apart from its waveform's, each with one standard deviation. The default is a perfect sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Calibration {
    /// The phase of a target at 0 m on the rising ramp, radians, as a fit shows it.
    pub phase_rad: f32,
    /// One standard deviation of this phase, radians.
    pub sigma_phase_rad: f32,
    /// What the frequency shows of a target at 0 m, metres.
    pub offset_m: f32,
    /// One standard deviation of the offset, metres.
    pub sigma_offset_m: f32,
    /// The sweep's true slope over the stated one less 1, parts per million.
    pub slope_ppm: f32,
    /// One standard deviation of the slope, parts per million.
    pub sigma_slope_ppm: f32,
}

impl Calibration {
    /// Whether each number is finite and no standard deviation negative.
    pub(super) fn is_valid(&self) -> bool {
        let values = [self.phase_rad, self.offset_m, self.slope_ppm];
        let sigmas = [self.sigma_phase_rad, self.sigma_offset_m, self.sigma_slope_ppm];
        values.iter().chain(&sigmas).all(|x| x.is_finite()) && sigmas.iter().all(|&x| x >= 0.0)
    }

    /// The calibration with the slope by a second known distance: `seen_m` is the distance from the first target to the second by frequency, `true_m` the
    /// known one, each with one standard deviation. `None` where either is not positive.
    #[must_use]
    pub fn with_slope(
        self,
        [seen_m, sigma_seen]: [f32; 2],
        [true_m, sigma_true]: [f32; 2],
    ) -> Option<Self> {
        // A range by frequency is too large by the share by which the slope is larger than stated.
        if !(seen_m > 0.0 && true_m > 0.0 && seen_m.is_finite() && true_m.is_finite()) {
            return None;
        }
        let slope_ppm = 1e6 * (seen_m - true_m) / true_m;
        let sigma_slope_ppm = 1e6 * libm::hypotf(sigma_seen, sigma_true) / true_m;
        let calibration = Self { slope_ppm, sigma_slope_ppm, ..self };
        calibration.is_valid().then_some(calibration)
    }
}

impl PhaseRanging {
    /// [`PhaseRanging::calibrate`] by the tones of several records: their mean, weighted by what their noise leaves, whose sigmas fall with the
    /// number of records, but for the part of the known range. Tones that may not be used are passed over; `None` if none is left.
    pub fn calibrate_all<'a>(
        &self,
        phasors: impl IntoIterator<Item = &'a ToneWithPhase>,
        known_m: f64,
        sigma_m: f32,
    ) -> Option<Calibration> {
        let known = I32F32::checked_from_num(known_m)?;
        if sigma_m.is_nan() || sigma_m < 0.0 {
            return None;
        }
        let mut first = None;
        // Phases beyond the first one and offsets, each with its weights.
        let (mut phase, mut offset) = (Mean::default(), Mean::default());
        for phasor in phasors {
            let Some(one) = self.calibrate(phasor, known_m, 0.0) else { continue };
            let Calibration { phase_rad, .. } = *first.get_or_insert(one);
            let turns = (one.phase_rad - phase_rad) / TAU;
            phase.add(TAU * (turns - libm::roundf(turns)), one.sigma_phase_rad);
            offset.add(one.offset_m, one.sigma_offset_m);
        }
        let first = first?;
        let [beyond, sigma_phase] = phase.value()?;
        let [offset_m, sigma_offset] = offset.value()?;
        let turns = (first.phase_rad + beyond) / TAU;
        let calibration = Calibration {
            phase_rad: TAU * (turns - libm::roundf(turns)),
            sigma_phase_rad: libm::hypotf(sigma_phase, self.radians_per_metre(known) * sigma_m),
            offset_m,
            sigma_offset_m: libm::hypotf(sigma_offset, sigma_m),
            ..first
        };
        calibration.is_valid().then_some(calibration)
    }
}

/// A weighted mean.
#[derive(Clone, Copy, Default)]
struct Mean {
    weights: f32,
    sum: f32,
}

impl Mean {
    fn add(&mut self, value: f32, sigma: f32) {
        let weight = 1.0 / (sigma * sigma).max(f32::MIN_POSITIVE);
        self.weights += weight;
        self.sum += weight * value;
    }

    /// The mean and its standard deviation; `None` without a value.
    fn value(&self) -> Option<[f32; 2]> {
        let Self { weights, sum } = *self;
        (weights > 0.0 && weights.is_finite()).then(|| [sum / weights, 1.0 / weights.root()])
    }
}
