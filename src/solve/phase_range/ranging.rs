//! From tones with phases to ranges by phase.

use super::PhaseRange;
use super::calibration::Calibration;
use super::comb::{Comb, SURE};
use super::cycles::Cycles;
use crate::acquire::sample::Segment;
use crate::error::ConfigError;
use crate::math::fixed_point::{in_steps, to_f32};
use crate::solve::equations::Chirp;
use crate::solve::target::Target;
use crate::solve::waveform::{SPEED_OF_LIGHT, Scale, metres};
use crate::tone::phasor::ToneWithPhase;
use crate::tone::sigma::bound_bins;
use crate::tone::{Usable, Verdict};
use core::f32::consts::TAU;
use fixed::types::I32F32;

/// What a ramp's waveform fixes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ramp {
    cycles: Cycles,
    /// The range of a beat of one cycle per sample, metres, of a target at rest.
    range: Scale,
    /// What a bent ramp adds to the range, for a square metre of range.
    bow: f32,
    /// The share of the carrier, where the phase is taken, that the sweep has made.
    swept: f32,
    /// Cycles by which a velocity's bend turns the phase of the fit, for a metre per second.
    bend: f32,
    /// The beat in hertz for a metre, and for a metre per second, without the receiver's orientation.
    beat: [f32; 2],
}

/// Solves for ranges by the phases of a chirp's beats.
///
/// ```
/// use picket_dsp::solve::phase_range::{Calibration, PhaseRanging};
/// use picket_dsp::{Chirp, Codes, Config, Pipeline, Real, Segment, Shape};
///
/// // 24 GHz and 1 GHz in 1.024 ms; a target at 4.2 m, whose phase at 0 m is 0.
/// let chirp = Chirp { shape: Shape::Sawtooth, bandwidth_hz: 1e9, ..Chirp::default() };
/// let mut pipeline = Pipeline::<Real, 1024>::new(Config::new(1e6, Codes::signed::<12>()).plan()?);
/// let ranging = PhaseRanging::new(&chirp, 1e6, 1024, false, Calibration::default())?;
/// let tau = 2.0 * 4.2 / 299_792_458.0;
/// let cycles = |t: f64| tau * (24e9 + 1e9 / 1.024e-3 * (t - 0.5 * tau));
/// let sample = |n: usize| 1500.0 * (std::f64::consts::TAU * cycles(n as f64 * 1e-6)).cos();
/// let samples: [i16; 1024] = std::array::from_fn(|n| sample(n).round() as i16);
/// let measurement = pipeline.record(&samples)?;
/// let line = pipeline.lines(&measurement, 1)[0];
/// let answer = ranging.at_rest(Segment::Up, &line);
/// assert!(answer.is_sure());
/// assert!((answer.range.to_num::<f64>() - 4.2).abs() < 1e-6); // a micrometre
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseRanging {
    /// Rising and falling.
    ramps: [Ramp; 2],
    /// The sign of an I/Q receiver's beats; 1 for real records.
    sign: f32,
    iq: bool,
    n: usize,
    /// Seconds from the rising ramp's record to the falling one's, and half a sample.
    apart: f32,
    half: f32,
    calibration: Calibration,
}

/// A range by frequency at the time of a phase, with everything that shifts it.
#[derive(Clone, Copy)]
struct FrequencyRange {
    range: I32F32,
    /// By the noise alone, and with the calibration.
    sigma: f32,
    spread: f32,
}

impl PhaseRanging {
    /// For records of `n` samples at `rate_hz` of a chirp of any shape; `iq` for I/Q records.
    ///
    /// # Errors
    /// The errors of [`Chirp::equations`]; [`ConfigError::Scene`] for a calibration that is not finite or has a negative deviation.
    pub fn new(
        chirp: &Chirp,
        rate_hz: f64,
        n: usize,
        iq: bool,
        calibration: Calibration,
    ) -> Result<Self, ConfigError> {
        let equations = chirp.equations(rate_hz, n, iq)?;
        if !calibration.is_valid() {
            return Err(ConfigError::Scene);
        }
        // All sweeps scale alike.
        let sweep = 1.0 + 1e-6 * f64::from(calibration.slope_ppm);
        let chirp = Chirp { bandwidth_hz: chirp.bandwidth_hz * sweep, ..*chirp };
        let sign = if iq { f64::from(chirp.mixing.sign()) } else { 1.0 };
        let record_s = n as f64 / rate_hz;
        let per_metre = 2.0 / SPEED_OF_LIGHT;
        // Half the second derivative of the carrier.
        let half = -4.0 * chirp.sweep_curvature * chirp.bandwidth_hz
            / (chirp.duration_s * chirp.duration_s);
        let of = |up: bool| {
            // The phase is that of sample n / 2, the frequency that of the middle, half a sample before.
            let at = |time_s: f64| {
                let way = (chirp.guard_s + time_s) / chirp.duration_s;
                chirp.ramp(if up { way } else { 1.0 - way })
            };
            let [middle, phased] = [0.5 * (record_s - 1.0 / rate_hz), 0.5 * record_s].map(at);
            let direction = if up { 1.0 } else { -1.0 };
            let slope = direction * middle.slope;
            // A phase that bends by q turns per square of the record's length is q/12 off at the middle.
            let bent = half * per_metre * record_s * record_s / 12.0;
            let cycles = Cycles::new(
                per_metre * phased.carrier_hz + bent,
                0.5 * direction * phased.slope * per_metre * per_metre,
            );
            Ok(Ramp {
                cycles: cycles.ok_or(ConfigError::Scale)?,
                range: Scale::new(sign * rate_hz / (slope * per_metre))
                    .ok_or(ConfigError::Scale)?,
                bow: (half * per_metre / slope) as f32,
                swept: (1.0 - SPEED_OF_LIGHT / chirp.wavelength_m / phased.carrier_hz) as f32,
                bend: (-slope * per_metre * record_s * record_s / 12.0) as f32,
                beat: [(per_metre * slope) as f32, (-per_metre * phased.carrier_hz) as f32],
            })
        };
        Ok(Self {
            ramps: [of(true)?, of(false)?],
            sign: sign as f32,
            iq,
            n,
            apart: equations.apart,
            half: (0.5 / rate_hz) as f32,
            calibration,
        })
    }

    /// The range of a target at rest from the tone of one ramp: of a sawtooth, or of either ramp of another shape.
    ///
    /// A target that moves by v shifts the range by frequency by `v f0 / S`, and the phase with the range: use [`PhaseRanging::moving`] or
    /// [`PhaseRanging::of_target`] then. Cost: some two hundred operations, and thirty exponentials.
    pub fn at_rest(&self, segment: Segment, phasor: &ToneWithPhase) -> PhaseRange {
        let ramp = self.ramp(segment);
        let mirrored = self.mirrored(ramp, [1.0, 0.0]);
        let steps = i64::from(phasor.tone.frequency.0.to_bits());
        let steps = if mirrored { -steps } else { steps };
        let range = metres(steps, ramp.range.fixed);
        let far = to_f32(range);
        let range = range.saturating_add(in_steps(ramp.bow * far * far));
        let sigma = (ramp.range.float * phasor.tone.sigma).abs();
        let verdict = phasor.tone.verdict;
        self.solved(ramp, phasor, mirrored, range, sigma, 0.0, verdict)
    }

    /// The range by the phase of one ramp of a target whose range and velocity in the middle of the record are known otherwise, as those of
    /// a frame of chirps.
    pub fn of_target(
        &self,
        segment: Segment,
        phasor: &ToneWithPhase,
        target: &Target,
    ) -> PhaseRange {
        let ramp = self.ramp(segment);
        let velocity = to_f32(target.velocity.unwrap_or_default());
        let mirrored = self.mirrored(ramp, [to_f32(target.range), velocity]);
        let verdict = phasor.tone.verdict.max(target.verdict);
        let answer = self.solved(
            ramp,
            phasor,
            mirrored,
            target.range,
            target.sigma_range,
            velocity,
            verdict,
        );
        PhaseRange { velocity: target.velocity, sigma_velocity: target.sigma_velocity, ..answer }
    }

    /// Range and velocity by the phases of both ramps of a triangle or trapezoid. `target` is what the frequencies show
    /// ([`chirp::trapezoid`](super::super::chirp::trapezoid), [`chirp::triangle`](super::super::chirp::triangle)); the range belongs to the
    /// same moment.
    pub fn moving(&self, up: &ToneWithPhase, down: &ToneWithPhase, target: &Target) -> PhaseRange {
        let [rising, falling] = &self.ramps;
        let tones = up.tone.verdict.max(down.tone.verdict);
        let velocity = to_f32(target.velocity.unwrap_or_default());
        let place = self.place(target.range, target.sigma_range);
        let answer = by_frequency(target, &place, tones.max(target.verdict));
        let steady = [up, down].into_iter().all(is_steady);
        if answer.verdict.usable() > Usable::WithinSigma || !steady || target.velocity.is_none() {
            return answer;
        }
        // Where the phases were taken.
        let way = in_steps(0.5 * self.apart * velocity);
        let early = place.range.saturating_add(way);
        let late = place.range.saturating_sub(way);
        let [first, last] =
            [(rising, up, early), (falling, down, late)].map(|(ramp, phasor, near)| {
                let mirrored = self.mirrored(ramp, [to_f32(near), velocity]);
                let seen = self.seen(ramp, phasor, mirrored, velocity);
                let nearest = ramp.cycles.nearest(seen, near);
                let slope = ramp.cycles.slope_at(near);
                (
                    to_f32(nearest.saturating_sub(near)),
                    1.0 / slope,
                    self.sigma_phase(phasor) / (TAU * slope),
                )
            });
        let ((off_early, half_wave, sigma_early), (off_late, _, sigma_late)) = (first, last);
        let both = libm::hypotf(sigma_early, sigma_late);
        // The way between them: it is that of the velocity, except for whole turns.
        let sigma_way = libm::hypotf(self.apart * target.sigma_velocity, both);
        let apart = off_early - off_late;
        let turns = libm::roundf(apart / half_wave);
        let apart = apart - turns * half_wave;
        let (_, odds_way) = Comb::new(I32F32::ZERO, apart, half_wave, sigma_way);
        let known = odds_way >= SURE;
        // The middle of both: neighbours are half a wavelength apart, or half of that where the way is not known.
        let spacing = if known { half_wave } else { 0.5 * half_wave };
        let middle = 0.5 * (off_early + off_late - turns * half_wave);
        let middle = middle - spacing * libm::roundf(middle / spacing);
        // Both were taken half a sample after the moment of the target.
        let faster = if known { velocity + apart / self.apart } else { velocity };
        let nearest = place.range.saturating_add(in_steps(middle + self.half * faster));
        let sigma = 0.5 * both;
        let [first_own, last_own] = [rising, falling].map(|ramp| self.own(ramp, place.range));
        let own = 0.5 * (first_own + last_own);
        let spread = libm::hypotf(place.spread, libm::hypotf(sigma, own));
        let (comb, odds) = Comb::new(nearest, middle, spacing, spread);
        let odds = if known { 1.0 / (1.0 / odds + 1.0 / odds_way) } else { odds.min(odds_way) };
        let answer = PhaseRange { comb, odds, sigma_by_phase: sigma, ..answer };
        if !answer.is_sure() {
            return answer;
        }
        PhaseRange {
            range: nearest,
            sigma,
            uncertainty: libm::hypotf(sigma, own),
            velocity: Some(in_steps(faster)),
            sigma_velocity: both / self.apart,
            ..answer
        }
    }

    /// The calibration that a target at rest at a known range makes of its tone on the rising ramp: the phase at 0 m and the range's offset.
    /// `known_m` is a range and one standard deviation, metres. The slope stays. `None` for a tone that may not be used, or a range that is not finite.
    ///
    /// The known range should be exact to a tenth of a wavelength if ranges are to be absolute; with a less exact one, ranges are exact
    /// relative to each other, as `sigma_phase_rad` states.
    pub fn calibrate(
        &self,
        phasor: &ToneWithPhase,
        known_m: f64,
        sigma_m: f32,
    ) -> Option<Calibration> {
        let [ramp, _] = &self.ramps;
        let known = I32F32::checked_from_num(known_m)?;
        if phasor.tone.verdict.usable() > Usable::WithinSigma || sigma_m.is_nan() || sigma_m < 0.0 {
            return None;
        }
        let plain = Self { calibration: Calibration::default(), ..*self };
        let seen = plain.at_rest(Segment::Up, phasor);
        let rest = plain
            .seen(ramp, phasor, false, 0.0)
            .to_bits()
            .wrapping_sub(ramp.cycles.at(known).to_bits());
        let turns = rest as i32 as f32 / 4_294_967_296.0;
        let slope = self.radians_per_metre(known);
        let calibration = Calibration {
            phase_rad: self.sign * TAU * turns,
            sigma_phase_rad: libm::hypotf(self.sigma_phase(phasor), slope * sigma_m),
            offset_m: to_f32(seen.by_frequency.saturating_sub(known)),
            sigma_offset_m: libm::hypotf(seen.sigma_by_frequency, sigma_m),
            ..self.calibration
        };
        calibration.is_valid().then_some(calibration)
    }

    /// By how much the phase on the rising ramp turns for a metre more at this range.
    pub(super) fn radians_per_metre(&self, range: I32F32) -> f32 {
        let [rising, _] = &self.ramps;
        TAU * rising.cycles.slope_at(range)
    }

    fn ramp(&self, segment: Segment) -> &Ramp {
        let [rising, falling] = &self.ramps;
        if segment == Segment::Down { falling } else { rising }
    }

    /// Whether a real record shows the beat at this range and velocity with the other sign.
    fn mirrored(&self, ramp: &Ramp, [range, velocity]: [f32; 2]) -> bool {
        let [per_metre, per_mps] = ramp.beat;
        !self.iq && per_metre * range + per_mps * velocity < 0.0
    }

    /// The range by frequency less the offset.
    fn place(&self, range: I32F32, sigma: f32) -> FrequencyRange {
        let Calibration { offset_m, sigma_offset_m, sigma_slope_ppm, .. } = self.calibration;
        let range = range.saturating_sub(in_steps(offset_m));
        let slope = 1e-6 * sigma_slope_ppm * to_f32(range);
        let known = libm::hypotf(sigma_offset_m, slope);
        FrequencyRange { range, sigma, spread: libm::hypotf(sigma, known) }
    }

    /// One standard deviation of a range by phase by the calibration: by the phase at 0 m, and by the slope, with which the carrier varies where the
    /// phase is taken.
    fn own(&self, ramp: &Ramp, range: I32F32) -> f32 {
        let Calibration { sigma_phase_rad, sigma_slope_ppm, .. } = self.calibration;
        let slope = 1e-6 * sigma_slope_ppm * ramp.swept * to_f32(range);
        libm::hypotf(sigma_phase_rad / (TAU * ramp.cycles.slope_at(range)), slope)
    }

    /// The fraction of a cycle that a phase shows, at rest in the middle of the record.
    fn seen(&self, ramp: &Ramp, phasor: &ToneWithPhase, mirrored: bool, velocity: f32) -> I32F32 {
        let phase = if mirrored { -phasor.phase } else { phasor.phase };
        let turns = self.sign * (phase - self.calibration.phase_rad) / TAU;
        in_steps(turns - ramp.bend * velocity)
    }

    /// One standard deviation of a phase, wider by the factor by which the judgement widened that of the frequency.
    fn sigma_phase(&self, phasor: &ToneWithPhase) -> f32 {
        let n = self.n as f32;
        let bound = bound_bins(self.iq, self.n, phasor.tone.snr);
        let wider = (n * phasor.tone.sigma / bound).max(1.0);
        phasor.sigma_phase * wider
    }

    #[expect(clippy::too_many_arguments, reason = "what a range by phase follows from")]
    fn solved(
        &self,
        ramp: &Ramp,
        phasor: &ToneWithPhase,
        mirrored: bool,
        range: I32F32,
        sigma: f32,
        velocity: f32,
        verdict: Verdict,
    ) -> PhaseRange {
        let place = self.place(range, sigma);
        let target =
            Target { sigma_range: sigma, sigma_velocity: f32::INFINITY, ..Target::default() };
        let least = if is_steady(phasor) { Verdict::Good } else { Verdict::Unresolved };
        let answer = by_frequency(&target, &place, verdict.max(least));
        if answer.verdict.usable() > Usable::WithinSigma {
            return answer;
        }
        let seen = self.seen(ramp, phasor, mirrored, velocity);
        let nearest = ramp.cycles.nearest(seen, place.range);
        let beyond = to_f32(nearest.saturating_sub(place.range));
        let slope = ramp.cycles.slope_at(place.range);
        let per_radian = 1.0 / (TAU * slope);
        let sigma = self.sigma_phase(phasor) * per_radian;
        let uncertainty = libm::hypotf(sigma, self.own(ramp, place.range));
        let (comb, odds) =
            Comb::new(nearest, beyond, 1.0 / slope, libm::hypotf(place.spread, uncertainty));
        let answer = PhaseRange { comb, odds, sigma_by_phase: sigma, ..answer };
        if !answer.is_sure() {
            return answer;
        }
        // Half a sample before the phase was taken the target was farther by what it approached in it.
        let range = nearest.saturating_add(in_steps(self.half * velocity));
        PhaseRange { range, sigma, uncertainty, ..answer }
    }
}

/// Whether the phase is that of one steady tone. A line that changes within a ramp beyond what motion does to it is more often two echoes
/// in one cell, which turn the phase.
fn is_steady(phasor: &ToneWithPhase) -> bool {
    phasor.tone.reasons().all(|reason| reason != Verdict::Moving)
}

/// The answer without a phase. A negative range is not usable.
fn by_frequency(target: &Target, place: &FrequencyRange, verdict: Verdict) -> PhaseRange {
    let least = if place.range < 0 { Verdict::Unresolved } else { Verdict::Good };
    PhaseRange {
        range: place.range,
        sigma: place.sigma,
        uncertainty: place.spread,
        velocity: target.velocity,
        sigma_velocity: target.sigma_velocity,
        by_frequency: place.range,
        sigma_by_frequency: place.sigma,
        verdict: verdict.max(least),
        ..PhaseRange::default()
    }
}
