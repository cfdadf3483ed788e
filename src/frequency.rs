//! A frequency without a rate: signed cycles per sample.

use crate::math::scalar::Scalar;
use fixed::types::{I0F32, I2F30};

/// Signed cycles per sample, full scale one turn: -0.5..0.5 in steps of 2^-32.
///
/// An I/Q frequency of 0.5 wraps to -0.5, as it does on the circle. Times the sample rate it is
/// in Hz; the step is 0.06 Hz at 250 MS/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Frequency(pub I0F32);

/// Steps in one turn.
const STEPS: f32 = 4_294_967_296.0;

#[cfg(feature = "defmt")]
impl defmt::Format for Frequency {
    fn format(&self, f: defmt::Formatter) {
        defmt::write!(f, "{=i32}/2^32", self.0.to_bits());
    }
}

/// Prints cycles per sample, to the step's last digit.
impl core::fmt::Display for Frequency {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:.10} cycles/sample", self.cycles())
    }
}

impl Frequency {
    /// The standard deviation of a step's rounding, in cycles per sample: a step over the root of 12.
    pub(crate) const ROUNDING: f32 = 0.288_675_13 / STEPS;

    /// Bin `peak` of an `n`-point record plus `offset` bins; `None` where `offset` is not finite.
    /// The peak's share is exact, the offset's is rounded to the nearest step.
    // Inlined where the length is known, so that its quotients are constants.
    #[inline]
    pub fn from_bins<T: Scalar>(peak: i32, offset: T, n: usize) -> Option<Self> {
        let steps = (offset * T::new(4_294_967_296.0 / n.max(1) as f64)).round();
        let steps = steps.to_i64()?;
        Some(Self::from_steps(peak, steps, n))
    }

    /// Bin `peak` of an `n`-point record plus an offset in fixed point (Q30, in bins).
    pub fn from_fixed(peak: i32, offset: I2F30, n: usize) -> Self {
        // From 2^-30 bin to 2^-32 cycles: times 4 / n, rounded to nearest.
        let shift = n.max(1).trailing_zeros();
        let steps = ((i64::from(offset.to_bits()) << 3) >> shift).wrapping_add(1) >> 1;
        Self::from_steps(peak, steps, n)
    }

    #[inline]
    fn from_steps(peak: i32, offset: i64, n: usize) -> Self {
        let step = (1i64 << 32) / n.max(1) as i64;
        let bits = (i64::from(peak) * step).wrapping_add(offset);
        // The upper half of the circle is negative frequency: keep the low 32 bits.
        Self(I0F32::from_bits(bits as i32))
    }

    /// The frequency in bins of an `n`-point record.
    pub fn bins(self, n: usize) -> f64 {
        self.cycles() * n as f64
    }

    /// The frequency in cycles per sample, exactly.
    pub fn cycles(self) -> f64 {
        f64::from(self.0.to_bits()) / 4_294_967_296.0
    }

    /// The frequency in cycles per sample, rounded to `f32`.
    pub fn cycles_f32(self) -> f32 {
        self.0.to_bits() as f32 / STEPS
    }

    /// The distance beyond `other`, in cycles per sample, the short way round the circle.
    pub fn beyond(self, other: Self) -> f32 {
        Self(I0F32::from_bits(self.0.to_bits().wrapping_sub(other.0.to_bits()))).cycles_f32()
    }

    /// The frequency moved by this many cycles per sample, round the circle.
    pub fn moved(self, cycles: f32) -> Self {
        // A cast saturates.
        let steps = libm::rintf(cycles * STEPS) as i32;
        Self(I0F32::from_bits(self.0.to_bits().wrapping_add(steps)))
    }

    /// The frequency in hertz at a sample rate of `rate_hz`.
    pub fn hertz(self, rate_hz: f64) -> f64 {
        self.cycles() * rate_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_and_offset_add_exactly() {
        for n in [64, 1024, 4096] {
            for peak in [0, 1, n as i32 / 2 - 1] {
                for offset in [-0.5, -0.1, 0.0, 0.25, 0.4999] {
                    let f = Frequency::from_bins(peak, offset, n).unwrap();
                    let exact = f64::from(peak) + offset;
                    assert!((f.bins(n) - exact).abs() < 0.51 * n as f64 / 4_294_967_296.0);
                    let fixed = Frequency::from_fixed(peak, I2F30::from_num(offset), n);
                    assert!((fixed.0.to_bits() - f.0.to_bits()).abs() <= 1);
                }
            }
        }
    }

    #[test]
    fn the_upper_half_of_an_iq_record_is_negative() {
        assert_eq!(Frequency::from_bins(1023, 0.0, 1024).unwrap().bins(1024), -1.0);
        assert_eq!(Frequency::from_bins(512, 0.0f32, 1024).unwrap().bins(1024), -512.0);
        assert_eq!(Frequency::from_bins(3, f32::NAN, 1024), None);
    }
}
