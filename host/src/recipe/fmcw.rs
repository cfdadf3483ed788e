//! A corner reflector in front of a radar module whose frequency a sawtooth tunes.

use super::circuit::{CODE_V, Circuit, STEPS, Section};
use super::{Random, Recorded, Wanted, snr_db};
use picket_dsp::config::SPEED_OF_LIGHT;
use picket_dsp::{Chirp, Mixing, Shape};
use picket_simulator::{Receiver, Sensor, Target, Waveform};

const CARRIER_HZ: f64 = 24.0e9;
const BANDWIDTH_HZ: f64 = 200e6;
/// A ramp, s: 1,000 samples.
const RAMP_S: f64 = 5e-3;
/// Two stages of 1 + 100k/1k and 1 + 33k/1k; 1k in series with 100 nF twice, feedbacks beside 47 pF and 150 pF.
const AMPLIFIER: Circuit = Circuit {
    gain: 101.0 * 34.0,
    sections: &[
        Section::Above(1592.0),
        Section::Above(1592.0),
        Section::Below(33_900.0),
        Section::Below(32_200.0),
    ],
    rate_hz: 200e3,
};
/// By the radar equation: 16 dBm radiated, 8.6 dB of the receiving antenna, 6 dB of the mixer, 50 Ohm: the amplitude of 1 m2 at 10 m.
const LEVEL_V: f64 = 7.5e-6;
const LEVEL_M: f64 = 10.0;
/// 50 Ohm at a noise figure of 15 dB, V per root of a hertz.
const NOISE_V: f64 = 5e-9;
/// The oscillator's power rises along the ramp: so much of it is at the mixer's output, V.
const LEAK_V: f64 = 200e-6;
const RAMPS: u64 = 120;

pub fn record(wanted: Wanted, random: &mut Random) -> Result<Recorded, String> {
    let (range_m, speed) = (wanted.range_m.unwrap_or(12.0), wanted.velocity_mps.unwrap_or(0.0));
    let seconds = RAMPS as f64 * RAMP_S;
    if !(3.0..=100.0).contains(&range_m) || !(3.0..).contains(&(range_m - speed * seconds)) {
        return Err(
            "the reflector is 3 to 100 m away all the time: give another range or speed".into()
        );
    }
    let chirp = Chirp {
        shape: Shape::Sawtooth,
        wavelength_m: SPEED_OF_LIGHT / CARRIER_HZ,
        bandwidth_hz: BANDWIDTH_HZ,
        duration_s: RAMP_S,
        ..Chirp::default()
    };
    let fine_hz = AMPLIFIER.fine_hz();
    let receiver = Receiver {
        noise: NOISE_V * (fine_hz / 2.0).sqrt(),
        ..Receiver::ideal(fine_hz, false, Mixing::TxConjRx)
    };
    let waveform = Waveform::chirp(&chirp, RAMP_S);
    let range = move |t: f64| range_m - speed * t;
    let n = (RAMP_S * fine_hz).round() as usize;
    let mut volts = Vec::new();
    for lap in 0..RAMPS {
        let level = LEVEL_V * (LEVEL_M / range(lap as f64 * RAMP_S)).powi(2);
        let target = [Target::new(level, range)];
        let part = receiver.voltages(&waveform, &target, (lap, 0.0), n, || random.normal());
        let leak = |index: usize| LEAK_V * (index as f64 / n as f64 - 0.5);
        volts.extend(part.iter().enumerate().map(|(index, volt)| volt[0] + leak(index)));
    }
    volts.truncate(volts.len() / STEPS * STEPS);
    let usual = Receiver::ideal(AMPLIFIER.rate_hz, false, Mixing::TxConjRx);
    let sensor = Sensor::chirp(&chirp, usual, n / STEPS, RAMP_S);
    let beat_hz = AMPLIFIER.rate_hz * sensor.beat(&Target::new(1.0, range), (1, 0)).abs();
    let level = LEVEL_V * (LEVEL_M / range_m).powi(2) * AMPLIFIER.at(beat_hz) / CODE_V;
    let noise = AMPLIFIER.noise_codes(NOISE_V);
    Ok(Recorded {
        rate_hz: AMPLIFIER.rate_hz,
        codes: AMPLIFIER.codes(volts),
        truth: vec![
            format!(
                "{RAMPS} ramps of {:.0} samples, {:.0} MHz in {:.1} ms",
                RAMP_S * AMPLIFIER.rate_hz,
                BANDWIDTH_HZ / 1e6,
                RAMP_S * 1e3
            ),
            format!("a reflector of 1 m2 at {range_m:.3} m, {speed:.3} m/s: {beat_hz:.1} Hz"),
            format!(
                "amplitude {level:.0} codes, noise {noise:.1} codes, {:.1} dB",
                snr_db(level, noise)
            ),
        ],
    })
}
