//! A tone on the DAC, in step with the samples: its frequency in cycles per sample is exact.

use super::chirp;

/// Samples for which the DAC holds a code.
pub const HOLD: usize = 2;
/// Codes in the table, a prime: the 1021 blocks after one begin elsewhere in it.
const CODES: usize = 1021;
/// Cycles in the table: 24.6 bins of 1024.
const CYCLES: usize = 49;

/// The code in the middle.
pub const MIDDLE: u16 = 2048;

/// Cycles per sample.
pub const FREQUENCY: f64 = CYCLES as f64 / (CODES * HOLD) as f64;

/// The code at a step. Noise of some codes covers the effect of the steps and of the DAC's unevenness.
pub fn code(step: usize) -> u16 {
    let step = step % CODES;
    let turns = (step * CYCLES % CODES) as f32 / CODES as f32;
    let tone = 800.0 * libm::sinf(core::f32::consts::TAU * turns);
    libm::rintf(f32::from(MIDDLE) + tone + noise(step as u32)) as u16
}

/// Noise from -7 to 7, evenly distributed: a step's number, scrambled.
fn noise(step: u32) -> f32 {
    let word = step.wrapping_mul(0x9E37_79B9);
    let word = (word ^ word >> 15).wrapping_mul(0x85EB_CA6B);
    let word = (word ^ word >> 13).wrapping_mul(0xC2B2_AE35);
    ((word ^ word >> 16) >> 16) as f32 * (14.0 / 65536.0) - 7.0
}

/// Lets the DAC play the tone from the next start of the samples on.
pub fn play() {
    if let Some(table) = chirp::table().and_then(|table| table.get_mut(..CODES)) {
        // The first code is already on the output when the table begins.
        table.iter_mut().enumerate().for_each(|(step, place)| *place = code(step + 1));
        chirp::play(code(0), table, HOLD as u16);
    }
}
