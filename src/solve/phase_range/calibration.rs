//! The calibration of a sensor by a measurement at a known distance.

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
