//! A person who walks towards an HB100.

use super::circuit::{CODE_V, Circuit, STEPS, Section};
use super::{Random, Recorded, Wanted, snr_db};
use picket_dsp::Mixing;
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_simulator::{Receiver, Target, Waveform};
use std::f64::consts::TAU;

const CARRIER_HZ: f64 = 10.525e9;
/// Two stages of 1 + 100k/1k and 1 + 10k/1k; each 1k in series with 22 uF, each feedback beside a capacitor of 1 nF and of 10 nF; at
/// the converter 1k and 33 nF.
const AMPLIFIER: Circuit = Circuit {
    gain: 101.0 * 11.0,
    sections: &[
        Section::Above(7.2),
        Section::Above(7.2),
        Section::Below(1592.0),
        Section::Below(1592.0),
        Section::Below(4823.0),
    ],
    rate_hz: 8000.0,
};
/// The module's data sheet: 200 uV peak to peak at 93 dB of loss, which is a person at 15 m; 5 uV rms of noise from 3 to 80 Hz.
const LEVEL_V: f64 = 100e-6;
const LEVEL_M: f64 = 15.0;
const NOISE_V: f64 = 5e-6;
const NOISE_BAND_HZ: f64 = 77.0;
/// The body sways by so much, m/s, at two steps a second; the legs swing about it and reflect so much.
const SWAY_MPS: f64 = 0.08;
const STEPS_HZ: f64 = 1.9;
const LEGS: f64 = 0.15;

pub fn record(wanted: Wanted, random: &mut Random) -> Result<Recorded, String> {
    let (range_m, speed) = (wanted.range_m.unwrap_or(14.0), wanted.velocity_mps.unwrap_or(1.2));
    if !(0.2..=20.0).contains(&speed.abs()) || range_m > 100.0 {
        return Err("a person walks at .2 to 20 m/s within 100 m: give other values".into());
    }
    // To 4 m before the sensor, or for 8 s.
    let seconds = if speed > 0.0 { ((range_m - 4.0) / speed).clamp(2.0, 8.0) } else { 8.0 };
    let fine_hz = AMPLIFIER.fine_hz();
    let density = NOISE_V / NOISE_BAND_HZ.sqrt();
    let receiver = Receiver {
        noise: density * (fine_hz / 2.0).sqrt(),
        ..Receiver::ideal(fine_hz, false, Mixing::RxConjTx)
    };
    let body = move |t: f64| {
        range_m - speed * t + SWAY_MPS / (TAU * STEPS_HZ) * (TAU * STEPS_HZ * t).cos()
    };
    // A step forward and the standing still: the legs' speed goes from nothing to twice the body's.
    let legs =
        move |t: f64| body(t) + speed / (0.5 * TAU * STEPS_HZ) * (0.5 * TAU * STEPS_HZ * t).cos();
    let waveform = Waveform::continuous(CARRIER_HZ);
    let level = |range: f64| LEVEL_V * (LEVEL_M / range.max(0.5)).powi(2);
    let chunk = (fine_hz / 100.0) as usize;
    let mut volts = Vec::new();
    while volts.len() < (seconds * fine_hz) as usize {
        let from_s = volts.len() as f64 / fine_hz;
        let amplitude = level(body(from_s));
        let targets = [Target::new(amplitude, body), Target::new(LEGS * amplitude, legs)];
        let part = receiver.voltages(&waveform, &targets, (0, from_s), chunk, || random.normal());
        volts.extend(part.iter().map(|volt| volt[0]));
    }
    volts.truncate(volts.len() / STEPS * STEPS);
    let shift_hz = 2.0 * speed.abs() * CARRIER_HZ / SPEED_OF_LIGHT;
    let noise = AMPLIFIER.noise_codes(density);
    let codes_at = |range: f64| level(range) * AMPLIFIER.at(shift_hz) / CODE_V;
    let last_m = range_m - speed * seconds;
    let line = |range: f64| {
        let codes = codes_at(range);
        format!(
            "at {range:5.1} m: amplitude {codes:6.0} codes, {:.1} dB above the noise",
            snr_db(codes, noise)
        )
    };
    Ok(Recorded {
        rate_hz: AMPLIFIER.rate_hz,
        codes: AMPLIFIER.codes(volts),
        truth: vec![
            format!(
                "speed {speed:.3} m/s, swaying by {SWAY_MPS} m/s: {shift_hz:.2} Hz; noise {noise:.1} codes"
            ),
            line(range_m),
            line(last_m),
        ],
    })
}
