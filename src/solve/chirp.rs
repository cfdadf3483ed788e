//! Range and velocity from the beats of a chirp.
//!
//! The beats `y` of the rising ramp, of the flat segment and of the falling ramp are linear in range and velocity, see
//! [`super::equations`]. Three beats and two unknowns leave one condition, `n . y = 0`. So weighted least squares needs
//! no normal equations: each beat is corrected along `n` by its share of the violation, `y_i - v_i n_i (n . y) / (n . v n)`,
//! where `v` are the variances. Both ramps then give range and velocity.
//!
//! I/Q samples show the signs of the beats. Real samples show only magnitudes: of the four possible sign patterns the one that violates the
//! condition least is chosen, whatever the weights. Ye et al. 2022 (eqs 1 and 2) use the magnitudes as the signed beats, which is wrong
//! wherever the Doppler shift exceeds the range beat.
//!
//! A negative range is never good. I/Q records show a negative range if I and Q are exchanged, or if [`Mixing`] is set the wrong way round.

pub use super::beats::{contradiction, sawtooth};
pub use super::candidates::Ambiguity;
use super::equations::Equations;
use super::hypotheses::solve;
use super::hypothesis::Line;
pub use super::target::Target;
pub use super::waveform::{Mixing, Scale, Shape};
use crate::list::first;
use crate::tone::Tone;
use heapless::Vec;

/// Solves a trapezoid from its three tones. `signed` is true for I/Q beats, whose signs are known.
///
/// A slow target's flat beat is next to 0 Hz, where a line is `near-edge` or not seen at all. Then both ramps give range and velocity, and
/// the flat segment only excludes a larger Doppler shift.
pub fn trapezoid(tones: &[Tone; 3], signed: bool, equations: &Equations) -> Target {
    let lines = tones.each_ref().map(|tone| first([Line::from(*tone)].into_iter()));
    solve(&lines, 0, signed, equations, None)
}

/// Solves a triangle, or the two ramps of a trapezoid, from two tones (up, down).
///
/// Real beats fit two targets, with the roles of range and Doppler exchanged: the answer is [`Verdict::Ambiguous`](crate::Verdict::Ambiguous) unless the bounds of
/// range and velocity exclude one of them.
pub fn triangle(tones: &[Tone; 2], signed: bool, equations: &Equations) -> Target {
    let equations = &Equations { shape: Shape::Triangle, ..*equations };
    let [up, down] = tones.each_ref().map(|tone| first([Line::from(*tone)].into_iter()));
    solve(&[up, Vec::new(), down], 0, signed, equations, None)
}
