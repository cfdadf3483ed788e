//! Noise powers.

use crate::math::scalar::Scalar;

/// The least noise of a converter: its own rounding, one twelfth of a squared code for each part.
pub(crate) const ROUNDING: f64 = 1.0 / 12.0;

/// A noise power and its accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Power per sample (I/Q: of both parts together) in squared codes, not below the converter's
    /// rounding.
    pub power: f32,
    /// Degrees of freedom: the relative variance of the power is two over this number.
    pub dof: f32,
}

/// The rounding of a record's samples.
pub(crate) const fn rounding(iq: bool) -> f32 {
    ROUNDING as f32 * if iq { 2.0 } else { 1.0 }
}

/// The signal-to-noise ratio per sample of a squared amplitude over a noise power. The noise
/// within the fitted amplitude is subtracted. Not negative.
#[inline(always)] // where the size is known at compile time, nothing is divided
pub fn ratio<T: Scalar>(iq: bool, n: usize, amplitude_squared: T, power: T) -> T {
    let ratio = amplitude_squared / power;
    let share = T::from_i32(n.max(1) as i32).recip();
    let ratio = if iq { ratio - share } else { ratio * T::new(0.5) - T::new(2.0) * share };
    ratio.max(T::zero())
}
