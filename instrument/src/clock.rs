//! The clock's part in the error of a measurement.

use picket_dsp::pipeline::{Measurement, Outcome};
use picket_wire::boot::Clock;

/// Standard deviation of an internal oscillator's rate, as a share of it: 1 % at most at 25 degrees (STM32F446 data sheet, HSI), evenly
/// spread, which is 1 % over the root of three.
pub const INTERNAL: f32 = 0.005_773_503;

/// Widens sigma of frequency and velocity by the clock's part in their errors. A crystal adds some ten ppm, which the calibration corrects;
/// an internal oscillator adds more than most measurements.
pub fn widen(clock: Clock, measurement: &mut Measurement) {
    if clock == Clock::External {
        return;
    }
    let tone = &mut measurement.tone;
    tone.sigma = wider(tone.sigma, tone.frequency.0.to_bits() as f32);
    match &mut measurement.result {
        Outcome::None => {}
        Outcome::Velocity(velocity) => {
            velocity.sigma = wider(velocity.sigma, velocity.velocity.to_bits() as f32);
        }
        // Its range is counted in samples of the ramp, and the clock paces both.
        Outcome::Target(target) => {
            let velocity = target.velocity.unwrap_or_default();
            target.sigma_velocity = wider(target.sigma_velocity, velocity.to_bits() as f32);
        }
    }
}

/// Sigma of a number that is in proportion to the clock's rate; `bits` of it are 2^-32.
fn wider(sigma: f32, bits: f32) -> f32 {
    const UNIT: f32 = 1.0 / 4_294_967_296.0;
    let share = INTERNAL * UNIT * bits;
    libm::sqrtf(sigma * sigma + share * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fixed::types::{I0F32, I32F32};
    use picket_dsp::solve::chirp::Target;
    use picket_dsp::solve::doppler::Velocity;
    use picket_dsp::tone::Tone;
    use picket_dsp::tone::frequency::Frequency;

    fn measured(result: Outcome) -> Measurement {
        let frequency = Frequency(I0F32::from_num(-0.1));
        let tone = Tone { frequency, sigma: 1e-6, ..Tone::default() };
        Measurement { tone, result, ..Measurement::default() }
    }

    #[test]
    fn an_internal_oscillator_widens_by_its_one_percent() {
        assert!((INTERNAL - 0.01 / 3f32.sqrt()).abs() < 1e-9);
        let velocity =
            Velocity { velocity: I32F32::from_num(-20), sigma: 0.1, ..Velocity::default() };
        let target = Target {
            velocity: Some(I32F32::from_num(3)),
            range: I32F32::from_num(50),
            sigma_range: 0.01,
            ..Target::default()
        };
        for clock in [Clock::Internal, Clock::Slow] {
            let mut wide = measured(Outcome::Velocity(velocity));
            widen(clock, &mut wide);
            let wanted = f32::hypot(1e-6, 0.1 * INTERNAL);
            assert!((wide.tone.sigma / wanted - 1.0).abs() < 1e-6, "{wide:?}");
            let Outcome::Velocity(found) = wide.result else { panic!("a velocity") };
            let wanted = f32::hypot(0.1, 20.0 * INTERNAL);
            assert!((found.sigma / wanted - 1.0).abs() < 1e-6, "{found:?}");
            let mut wide = measured(Outcome::Target(target));
            widen(clock, &mut wide);
            let Outcome::Target(found) = wide.result else { panic!("a target") };
            assert!((found.sigma_velocity / (3.0 * INTERNAL) - 1.0).abs() < 1e-6, "{found:?}");
            assert_eq!(found.sigma_range, 0.01);
            // A measurement without a signal has no sigma, and gets none.
            let mut none = measured(Outcome::None);
            none.tone.sigma = f32::INFINITY;
            widen(clock, &mut none);
            assert_eq!(none.tone.sigma, f32::INFINITY);
        }
        let mut same = measured(Outcome::Velocity(velocity));
        widen(Clock::External, &mut same);
        assert_eq!(same, measured(Outcome::Velocity(velocity)));
    }
}
