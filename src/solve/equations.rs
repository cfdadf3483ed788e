//! The linear equations between a chirp's beats and a target's range and velocity.
//!
//! The transmitter's phase is `phi(t) = 2 pi integral f`. A target at range `R(t) = R0 - V (t - t0)` delays it by
//! `tau = 2 R(t) / c`, and the receiver multiplies one signal by the conjugate of the other: the beat's phase is
//! `s (phi(t) - phi(t - tau))`, with the sign `s` of [`Mixing`]. In a segment with slope `k` (Hz/s), with carrier `f` and
//! range `R` in the middle of the record, at time `t`, the beat there is
//!
//! ```text
//! y = s (k (2 R / c) (1 + 2 V / c) - 2 V f / c),    R = R0 - V (t - t0)
//! ```
//!
//! Up, flat and down give `s (fR - fD)`, `-s fD` and `-s (fR + fD)`, each with its own carrier and its own range. Except for the factor
//! `1 + 2 V / c`, which [`super::chirp`] applies to the solution, this is linear in `R0` and `V`: one row of two
//! coefficients a segment. The coefficients are computed in 64-bit floats when a plan is made. A record needs only products of
//! its beats with them.
//!
//! Ye et al. 2022 (section 1) give the magnitudes for one carrier and a range that does not change within the chirp.

use super::bounds::Bounds;
use super::waveform::{Mixing, SPEED_OF_LIGHT, Scale, Shape};
use crate::error::ConfigError;
use crate::tone::evidence::EDGE_BINS;

/// A frequency-modulated continuous wave, as the transmitter sends it.
///
/// The segments follow one another without a pause, and each lasts [`Chirp::duration_s`]: the carrier rises from `f0 = c / wavelength` by
/// the bandwidth, stays (a trapezoid's flat segment), and falls back.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Chirp {
    /// The segments.
    pub shape: Shape,
    /// Wavelength of the carrier at the bottom of a ramp, metres.
    pub wavelength_m: f64,
    /// The rise of a ramp, hertz.
    pub bandwidth_hz: f64,
    /// Duration of each segment, seconds; at least [`Chirp::guard_s`] and a record.
    pub duration_s: f64,
    /// Time from the start of a segment to the first sample of its record, seconds. Until the echo's delay has passed, the echo still comes
    /// from the segment before, so the guard should cover the delay.
    pub guard_s: f64,
    /// The signal that the receiver conjugates. It matters for I/Q records alone.
    pub mixing: Mixing,
    /// The height of a ramp's middle above the straight line between its ends, as a share of the bandwidth: above -1/4 and below 1/4. The
    /// carrier is `f0 + bandwidth (x + 4 sweep_curvature x (1 - x))`, where `x` goes from 0 to 1 as the ramp rises and back as it falls.
    pub sweep_curvature: f64,
}

impl Default for Chirp {
    /// A trapezoid at 24 GHz with 200 MHz in 1.024 ms, straight and without a guard; the receiver multiplies by the conjugate of the echo.
    fn default() -> Self {
        Self {
            shape: Shape::Trapezoid,
            wavelength_m: SPEED_OF_LIGHT / 24e9,
            bandwidth_hz: 200e6,
            duration_s: 1.024e-3,
            guard_s: 0.0,
            mixing: Mixing::TxConjRx,
            sweep_curvature: 0.0,
        }
    }
}

/// The middle of a segment's record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Middle {
    /// Seconds since the start of the chirp.
    time_s: f64,
    /// The carrier, hertz.
    pub(crate) carrier_hz: f64,
    /// The carrier's slope, hertz per second.
    pub(crate) slope: f64,
}

impl Middle {
    /// The beat in hertz per metre of range at time `t0` and per metre per second of velocity, for `s = 1`.
    fn row(&self, t0: f64) -> [f64; 2] {
        let Self { time_s, carrier_hz, slope } = *self;
        [slope, -(slope * (time_s - t0) + carrier_hz)].map(|per| 2.0 / SPEED_OF_LIGHT * per)
    }
}

/// The coefficients that turn a chirp's beats into a range and a velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Equations {
    /// The segments.
    pub shape: Shape,
    /// Metres of range per cycle per sample of the rising and of the falling beat, at the mean of the middles of the chirp's records. For a
    /// sawtooth: per cycle per sample of the beat of a target at rest; the second coefficient is 0.
    pub range: [Scale; 2],
    /// Metres per second of velocity per cycle per sample of the rising and of the falling beat. For a sawtooth: per cycle per sample of
    /// Doppler shift of the carrier at sample `n / 2`.
    pub velocity: [Scale; 2],
    /// The reduction of a bent ramp's beat, in cycles per sample per square metre of range: the echo comes from a place of the ramp with
    /// another slope. 0 for straight ramps.
    pub warp: f32,
    /// The variance, in cycles per sample squared, of a beat of which is known only that it is within 1.5 bins of 0 Hz: there a tone cannot
    /// be distinguished from an offset or from its mirror image. The distribution is uniform, so the variance is a third of the square.
    pub edge: f32,
    /// The flat and the falling beat's weights in the condition `up + flat + down = 0` that the three beats of a target
    /// satisfy; 0 for the other shapes.
    pub condition: [Scale; 2],
    /// The rise of the rising ramp's beat within a record, in cycles per sample for one metre per second: a target's motion moves its range
    /// and its Doppler shift. The falling ramp's beat rises by as much the other way.
    pub rise: f32,
    /// The rise of a bent ramp's beat within a record, in cycles per sample for one metre of range; 0 for straight ramps.
    pub bent: f32,
    /// Seconds from the record of the rising ramp to that of the falling one.
    pub apart: f32,
    /// Samples in a record: the error of a line's level falls with it. With 0 no level is known.
    pub samples: f32,
    /// The ranges and velocities that a target may have.
    pub bounds: Bounds,
}

impl Chirp {
    /// The equations of records of `n` samples at `rate_hz`. I/Q records have beats with signs.
    ///
    /// # Errors
    /// A value is out of its range, the record does not fit in its segment, or the coefficients are too large or too small.
    pub fn equations(&self, rate_hz: f64, n: usize, iq: bool) -> Result<Equations, ConfigError> {
        let Self { shape, wavelength_m, bandwidth_hz, duration_s, guard_s, .. } = *self;
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if ![wavelength_m, bandwidth_hz, duration_s].into_iter().all(positive) {
            return Err(ConfigError::Scene);
        }
        if self.sweep_curvature.is_nan() || self.sweep_curvature.abs() >= 0.25 {
            return Err(ConfigError::Scene);
        }
        // Guard and duration are often given in rounded seconds: half a sample of tolerance covers the rounding.
        let filled = guard_s * rate_hz + n as f64 - 0.5;
        if guard_s.is_nan() || guard_s < 0.0 || filled > duration_s * rate_hz {
            return Err(ConfigError::Ramp);
        }
        let orientation = if iq { f64::from(self.mixing.sign()) } else { 1.0 };
        let scale =
            |per_hz: f64| Scale::new(orientation * rate_hz * per_hz).ok_or(ConfigError::Scale);
        let within = guard_s + 0.5 * (n as f64 - 1.0) / rate_hz;
        let rising = self.ramp(within / duration_s);
        let up = Middle { time_s: within, ..rising };
        let last = (shape.segments().len().max(1) - 1) as f64 * duration_s;
        let fallen = self.ramp(1.0 - within / duration_s);
        let down = Middle { time_s: within + last, slope: -fallen.slope, ..fallen };
        let t0 = 0.5 * (up.time_s + down.time_s);
        let (a, b) = (up.row(t0), down.row(t0));
        let per_metre = 2.0 / SPEED_OF_LIGHT;
        let (none, samples, bounds) = (Scale::default(), n as f32, Bounds::default());
        let rise = -2.0 * orientation * per_metre * rising.slope * n as f64 / (rate_hz * rate_hz);
        let (rise, apart) = (rise as f32, last as f32);
        let edge = EDGE_BINS / n.max(1) as f32;
        let edge = edge * edge / 3.0;
        // The carrier's second derivative, half of it, times the square of the delay.
        let half = -4.0 * self.sweep_curvature * bandwidth_hz / (duration_s * duration_s);
        let warp = (orientation * half * per_metre * per_metre / rate_hz) as f32;
        let bent = (orientation * 2.0 * half * per_metre * n as f64 / (rate_hz * rate_hz)) as f32;
        if shape == Shape::Sawtooth {
            let [range, _] = up.row(up.time_s);
            // Phases refer to sample n / 2.
            let phased = self.ramp((guard_s + 0.5 * n as f64 / rate_hz) / duration_s);
            let doppler = 2.0 * phased.carrier_hz / SPEED_OF_LIGHT;
            return Ok(Equations {
                shape,
                warp,
                edge,
                range: [scale(1.0 / range)?, none],
                velocity: [scale(1.0 / doppler)?, none],
                condition: [none; 2],
                rise,
                bent,
                apart,
                samples,
                bounds,
            });
        }
        let determinant = a[0] * b[1] - a[1] * b[0];
        let range = [scale(b[1] / determinant)?, scale(-a[1] / determinant)?];
        let velocity = [scale(-b[0] / determinant)?, scale(a[0] / determinant)?];
        let mut condition = [none; 2];
        if shape == Shape::Trapezoid {
            let flat = Middle {
                time_s: within + duration_s,
                carrier_hz: SPEED_OF_LIGHT / wavelength_m + bandwidth_hz,
                slope: 0.0,
            };
            // The flat beat does not depend on the range: the rest of the two ramps without the range belongs to the velocity.
            let weight = -a[0] / b[0];
            let share = -(a[1] + weight * b[1]) / flat.row(t0)[1];
            let share = Scale::new(share).ok_or(ConfigError::Scale)?;
            condition = [share, Scale::new(weight).ok_or(ConfigError::Scale)?];
        }
        Ok(Equations {
            shape,
            range,
            velocity,
            warp,
            edge,
            condition,
            rise,
            bent,
            apart,
            samples,
            bounds,
        })
    }

    /// Carrier and slope of a rising ramp, at the share `x` of its way up. A falling ramp goes back the same way.
    pub(crate) fn ramp(&self, x: f64) -> Middle {
        let Self { wavelength_m, bandwidth_hz, duration_s, sweep_curvature, .. } = *self;
        let bend = 4.0 * sweep_curvature;
        Middle {
            time_s: 0.0,
            carrier_hz: SPEED_OF_LIGHT / wavelength_m + bandwidth_hz * (x + bend * x * (1.0 - x)),
            slope: bandwidth_hz / duration_s * (1.0 + bend * (1.0 - 2.0 * x)),
        }
    }
}
