//! The widths of the converter's codes (RP2040-E11): the codes [`WIDE`] are some ten codes wide, so that all codes above each of them read
//! too low. A table moves each code to the middle of its voltages.
//!
//! The curve is the mean of five boards, measured by kitanokitsune, *rp2040adc_correction*
//! (<https://github.com/kitanokitsune/rp2040adc_correction>): steps of 10, 9, 9 and 10 codes. A board's
//! own steps may differ by a third, see [`widen`].

use super::N;
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_dsp::tone::Tone;

/// The wide codes.
pub const WIDE: [i16; 4] = [511, 1535, 2559, 3583];

/// Pairs of a code and a height: from this code on, a voltage lies higher than its code says by this number of codes.
pub const CURVE: [(i16, i16); 17] = [
    (0, -15),
    (511, -10),
    (512, -5),
    (895, -6),
    (1407, -7),
    (1535, -3),
    (1536, 2),
    (1664, 1),
    (2047, 0),
    (2048, -1),
    (2431, -2),
    (2559, 3),
    (2560, 7),
    (2943, 6),
    (3455, 5),
    (3583, 10),
    (3584, 15),
];
/// From this code on the height is one code less again.
const LAST: i16 = 3711;

/// The move of each code: by the curve, stretched so that the rails do not move.
// A place out of range would be a compile error.
#[allow(clippy::indexing_slicing)]
pub static MOVES: [i8; 4096] = {
    let mut moves = [0; 4096];
    let (low, high) = (curve(0) as i32, 4095 + curve(4095) as i32);
    let mut code = 0;
    while code < 4096 {
        let voltage = code + curve(code as i16) as i32 - low;
        moves[code as usize] = ((2 * 4095 * voltage / (high - low) + 1) / 2 - code) as i8;
        code += 1;
    }
    moves
};

/// The curve at a code.
pub const fn curve(code: i16) -> i16 {
    let mut rest: &[(i16, i16)] = &CURVE;
    while let [before @ .., (first, higher)] = rest {
        if *first <= code {
            return if code >= LAST { *higher - 1 } else { *higher };
        }
        rest = before;
    }
    0
}

/// A code, moved by the table.
pub fn corrected(code: i16) -> i16 {
    code + MOVES.get(code as usize).map_or(0, |&move_by| move_by.into())
}

/// The height of a step that remains after the correction, codes: a third of the whole, as the step may be too large or too small by this
/// share, and the curve's own steps in between.
const LEFT: f32 = 3.2;
/// The height of a step without the correction, codes.
const STEP: f32 = 9.5;
/// The curve's own steps of a code between the large ones, as a sum of squares.
const SMALL: f32 = 3.0;
/// Harmonics of a step below these orders count: of a real record, and of pairs, whose frequency has less noise.
const ORDERS: [u32; 2] = [48, 128];
/// Steps of a frequency in a bin.
const BIN: f32 = 4_294_967_296.0 / N as f32;
/// Lines farther away than eight bins raise the noise in the fit, and with it its sigma.
const NEAR: u32 = (8.0 * BIN) as u32;

/// The pull of the steps on a tone's frequency, as a variance in squared cycles per sample.
///
/// A step of `h` codes within a tone of amplitude A makes lines of `2 h / (pi k)` at k times its frequency. Sampling folds them, and a line
/// that comes to lie within some bins of the tone pulls it, by up to `3 / pi^2` times the slope of their window. Lines of all steps, of
/// both signs and at any phase, add up as noise does.
fn pull(tone: &Tone, step: f32, orders: u32) -> f32 {
    let turn = tone.frequency.0.to_bits() as u32;
    let (mut at, mut sum) = (turn, 0.0);
    for order in 2..orders {
        // The harmonics beside this multiple of the tone are as far from the tone as it is from 0.
        at = at.wrapping_add(turn);
        if at.wrapping_add(NEAR) < 2 * NEAR {
            let bins = (at as i32).unsigned_abs() as f32 / BIN;
            let slope = if bins < 0.7 { 0.42 } else { 0.3 / bins };
            let ratio = slope / (order - 1).max(2) as f32;
            sum += ratio * ratio;
        }
    }
    // Many tones have no such line beside them.
    if sum == 0.0 {
        return 0.0;
    }
    // A tone that spans more codes may lie on more steps.
    let steps = (1.0 + tone.amplitude / 512.0).min(WIDE.len() as f32);
    let whole = tone.amplitude.max(1.0) * N as f32;
    0.2 * sum * (steps * step * step + SMALL) / (whole * whole)
}

/// Widens a measurement's sigma by the pull of the steps on its tone: of the steps that remain after the correction, or of the whole steps.
// Within the instrument's loop it would find no registers left.
#[inline(never)]
pub fn widen(measurement: &mut Measurement, corrected: bool, iq: bool) {
    let tone = &mut measurement.tone;
    let [real, pairs] = ORDERS;
    let orders = if iq { pairs } else { real };
    let pull = pull(tone, if corrected { LEFT } else { STEP }, orders);
    let square = tone.sigma * tone.sigma;
    // A smaller pull changes sigma by less than half a percent.
    if pull > 0.01 * square && square > 0.0 {
        let sigma = libm::sqrtf(square + pull);
        if let Outcome::Velocity(velocity) = &mut measurement.result {
            velocity.sigma *= sigma / tone.sigma;
        }
        tone.sigma = sigma;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_move_to_their_voltages_and_rails_stay() {
        assert_eq!([0, 1, 4094, 4095].map(corrected), [0, 1, 4094, 4095]);
        for code in 1..4095i16 {
            let before = corrected(code - 1);
            let step = corrected(code) - before;
            let beside = WIDE.iter().any(|&wide| code == wide || code == wide + 1);
            // Other codes are a little narrower than a code of an ideal converter, and the curve has steps of -1.
            assert!(
                if beside { (5..8).contains(&step) } else { (-1..3).contains(&step) },
                "{code}"
            );
        }
        assert_eq!(curve(4095), 14);
        // No table for numbers that are not codes.
        assert_eq!([-1, 4096].map(corrected), [-1, 4096]);
    }

    /// A third of the rate has every second and fourth harmonic on it; a rate of no such ratio has none near.
    #[test]
    fn sigma_widens_where_a_harmonic_is_folded_onto_the_tone() {
        let at = |cycles: f64| {
            let mut measurement = Measurement::default();
            let tone = &mut measurement.tone;
            tone.frequency.0 = fixed::types::I0F32::from_num(cycles);
            (tone.sigma, tone.amplitude) = (1e-8, 1900.0);
            let mut whole = measurement;
            widen(&mut measurement, true, false);
            widen(&mut whole, false, false);
            assert!(whole.tone.sigma >= measurement.tone.sigma);
            measurement.tone.sigma / 1e-8
        };
        assert!(at(1.0 / 3.0 + 1e-4) > 10.0, "{}", at(1.0 / 3.0 + 1e-4));
        assert_eq!(at(0.381_966), 1.0);
    }
}
