//! The transmitted waveform, and the values of a beat.

use crate::acquire::sample::Segment;
use fixed::types::I32F32;

/// The speed of light in vacuum, m/s.
pub const SPEED_OF_LIGHT: f64 = 299_792_458.0;

/// The value of one cycle per sample, in SI units: in fixed point for results, in float for sigmas.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scale {
    /// The scale for results.
    pub fixed: I32F32,
    /// The scale for sigmas.
    pub float: f32,
}

impl Scale {
    /// A scale of `per_cycle` units per cycle per sample; `None` if it does not fit in 31 bits, or is less than a step of 2^-32: results
    /// would be 0, and an infinite sigma times 0 would be NaN.
    pub fn new(per_cycle: f64) -> Option<Self> {
        let fixed = I32F32::checked_from_num(per_cycle).filter(|&fixed| fixed != I32F32::ZERO)?;
        Some(Scale { fixed, float: per_cycle as f32 })
    }
}

/// A frequency in steps of 2^-32 cycles per sample times a scale, rounded down to 2^-32 units. The
/// product saturates. The frequency may be the sum of two.
pub(crate) fn metres(steps: i64, scale: I32F32) -> I32F32 {
    let product = (i128::from(steps) * i128::from(scale.to_bits())) >> 32;
    I32F32::from_bits(product.clamp(i128::from(i64::MIN), i128::from(i64::MAX)) as i64)
}

/// The shape of the frequency ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Shape {
    /// Up, flat, down: range and signed velocity, both unique.
    #[default]
    Trapezoid,
    /// Up, down: with real samples, range and velocity may be exchanged.
    Triangle,
    /// Up only: one beat cannot separate range and velocity.
    Sawtooth,
}

impl Shape {
    /// The segments, in order.
    pub const fn segments(self) -> &'static [Segment] {
        match self {
            Shape::Sawtooth => &[Segment::Up],
            Shape::Triangle => &[Segment::Up, Segment::Down],
            Shape::Trapezoid => &[Segment::Up, Segment::Flat, Segment::Down],
        }
    }
}

/// The signal that an I/Q receiver conjugates before it multiplies the two: it sets the sign of every beat.
///
/// Exchanging I and Q exchanges the variants. Real samples are equal for both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Mixing {
    /// Transmitted times the conjugate of received: an echo from a target at rest beats at a positive frequency while the ramp rises,
    /// and an approaching target's Doppler shift is negative.
    #[default]
    TxConjRx = 0,
    /// Received times the conjugate of transmitted: an approaching target's Doppler shift is positive.
    RxConjTx = 1,
}

impl Mixing {
    /// Both variants.
    pub const ALL: [Mixing; 2] = [Mixing::TxConjRx, Mixing::RxConjTx];

    /// The name that settings and flags use.
    pub const fn name(self) -> &'static str {
        match self {
            Mixing::TxConjRx => "tx-conj-rx",
            Mixing::RxConjTx => "rx-conj-tx",
        }
    }

    /// The mixing with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mixing| mixing.name() == name)
    }

    /// The sign of a beat: of the transmitter's phase now less its phase when the echo left.
    pub const fn sign(self) -> i8 {
        match self {
            Mixing::TxConjRx => 1,
            Mixing::RxConjTx => -1,
        }
    }
}
