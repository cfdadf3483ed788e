//! Particles that cross the fringes of two laser beams, in front of a photodiode with a transimpedance amplifier.

use super::circuit::{CODE_V, Circuit, Section};
use super::{Random, Recorded, Wanted, snr_db};
use picket_simulator::{Fringes, Particle};

/// 1 MOhm beside 2.2 pF; a second stage of 1 + 100k/1k behind 100 nF and 1.6 kOhm, 100k beside 27 pF.
const AMPLIFIER: Circuit = Circuit {
    gain: 101.0,
    sections: &[Section::Below(72_300.0), Section::Above(995.0), Section::Below(58_900.0)],
    rate_hz: 200e3,
};
/// The feedback of the first stage, Ohm.
const FEEDBACK_OHM: f64 = 1e6;
/// Shot noise of 8 nA, the resistor's noise and the amplifier's by the diode's capacitance, A per root of a hertz.
const NOISE_A: f64 = 2.3e-13;
/// 650 nm at 10 degrees between the beams: wavelength / (2 sin 5 degrees).
pub const FRINGE_M: f64 = 3.729e-6;
/// Radius of the crossing at which the light is down by exp(-2), m.
const RADIUS_M: f64 = 90e-6;
/// The light of a particle in the middle, A, and how deep the fringes cut it.
const CURRENT_A: f64 = 4e-9;
const VISIBILITY: f64 = 0.7;
const FRINGES: Fringes =
    Fringes { spacing_m: FRINGE_M, radius_m: RADIUS_M, visibility: VISIBILITY };
/// The flow's turbulence, and particles a second.
const TURBULENCE: f64 = 0.05;
const PARTICLES_HZ: f64 = 60.0;
const SECONDS: f64 = 1.0;

pub fn record(wanted: Wanted, random: &mut Random) -> Result<Recorded, String> {
    let mean = wanted.velocity_mps.unwrap_or(0.05).abs();
    if !(0.01..=0.15).contains(&mean) || wanted.range_m.is_some() {
        return Err("the flow is .01 to .15 m/s, and the laser takes no range".into());
    }
    let fine_hz = AMPLIFIER.fine_hz();
    let noise_v = FEEDBACK_OHM * NOISE_A;
    let count = (SECONDS * fine_hz) as usize;
    let noise = noise_v * (fine_hz / 2.0).sqrt();
    let mut volts: Vec<f64> = (0..count).map(|_| noise * random.normal()).collect();
    let (mut at_s, mut particles) = (0.0, 0);
    loop {
        at_s -= (1.0 - random.share()).ln() / PARTICLES_HZ;
        if at_s >= SECONDS {
            break;
        }
        particles += 1;
        let speed = mean * (1.0 + TURBULENCE * random.normal());
        // Particles of any size, and that pass beside the middle.
        let level = FEEDBACK_OHM * CURRENT_A * (0.4 * random.normal()).exp();
        let turns = random.share();
        let particle = Particle { middle_s: at_s, speed_mps: speed, level, turns };
        let half = (FRINGES.reach_s(&particle) * fine_hz) as i64;
        let middle = (at_s * fine_hz) as i64;
        for k in (middle - half).max(0)..(middle + half).min(count as i64) {
            if let Some(volt) = volts.get_mut(k as usize) {
                *volt += FRINGES.light(&particle, k as f64 / fine_hz);
            }
        }
    }
    let hertz = mean / FRINGE_M;
    let noise = AMPLIFIER.noise_codes(noise_v);
    let amplitude = FEEDBACK_OHM * CURRENT_A * VISIBILITY * AMPLIFIER.at(hertz) / CODE_V;
    Ok(Recorded {
        rate_hz: AMPLIFIER.rate_hz,
        codes: AMPLIFIER.codes(volts),
        truth: vec![
            format!(
                "flow {mean:.4} m/s, turbulence {:.0} %: {hertz:.1} Hz at {FRINGE_M:.3e} m a fringe",
                100.0 * TURBULENCE
            ),
            format!(
                "{particles} particles, envelope of {:.0} samples",
                RADIUS_M / 2.0 / mean * AMPLIFIER.rate_hz
            ),
            format!(
                "a usual one: amplitude {amplitude:.0} codes, noise {noise:.1} codes, {:.1} dB at the top",
                snr_db(amplitude, noise)
            ),
        ],
    })
}
