//! The converter's codes and their rails.

/// The codes a converter can make. A sample at a rail has touched it; no sample lies beyond.
///
/// The codes decide by how many bits the integer FFT may shift samples up (growth bound: [`crate::spectrum::fft::integer`]) and which
/// samples count as clipped. They have no default, because a record read with the wrong codes is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Codes {
    low: i16,
    high: i16,
}

impl Codes {
    /// Signed codes of `BITS` bits, 8 to 16. With 12 bits they are -2048..=2047.
    pub const fn signed<const BITS: u32>() -> Self {
        const { assert!(8 <= BITS && BITS <= 16, "signed codes have 8 to 16 bits") };
        Self { low: (-1i32 << (BITS - 1)) as i16, high: ((1i32 << (BITS - 1)) - 1) as i16 }
    }

    /// Unsigned codes of `BITS` bits, 8 to 15, as a microcontroller's converter makes them. With 12 bits they are 0..=4095. Unsigned codes
    /// of 16 bits do not fit a sample; a [`Framer`](crate::acquire::framer::Framer) turns them into signed ones. The constant offset falls
    /// into bin 0, which no estimator reads.
    pub const fn unsigned<const BITS: u32>() -> Self {
        const { assert!(8 <= BITS && BITS <= 15, "unsigned codes have 8 to 15 bits") };
        Self { low: 0, high: ((1i32 << BITS) - 1) as i16 }
    }

    /// Codes from `low` to `high`, for example of a converter that sums several conversions. `None` for fewer than 256 codes.
    pub const fn between(low: i16, high: i16) -> Option<Self> {
        if high as i32 - (low as i32) < 255 { None } else { Some(Self { low, high }) }
    }

    /// [`Codes::signed`] or [`Codes::unsigned`] with `bits` bits, for a width known only at run time. `None` for a width that these
    /// functions refuse.
    pub const fn from_bits(signed: bool, bits: u32) -> Option<Self> {
        match bits {
            8..=16 if signed => {
                Self::between((-1i32 << (bits - 1)) as i16, ((1i32 << (bits - 1)) - 1) as i16)
            }
            8..=15 if !signed => Self::between(0, ((1i32 << bits) - 1) as i16),
            _ => None,
        }
    }

    /// No codes, as zeros: the codes of a placeholder plan.
    pub(crate) const IDLE: Self = Self { low: 0, high: 0 };

    /// The rails: the lowest and the highest code.
    pub const fn rails(self) -> (i16, i16) {
        (self.low, self.high)
    }

    /// The middle between the rails, rounded up.
    pub const fn middle(self) -> i16 {
        ((self.low as i32 + self.high as i32 + 1) >> 1) as i16
    }

    /// The width of a code as a signed number, in bits: 12 to 16. The transform reads narrower
    /// codes as codes of 12 bits.
    pub const fn bits(self) -> u32 {
        // The bits of the farther rail without its sign.
        let farther = (if self.low < 0 { !self.low } else { self.low } | self.high) as u32;
        let bits = 33 - farther.leading_zeros();
        if bits < 12 { 12 } else { bits }
    }

    /// Codes whose rails lie one further out; `None` if a sample cannot hold them.
    pub(crate) const fn wider(self) -> Option<Self> {
        match (self.low.checked_sub(1), self.high.checked_add(1)) {
            (Some(low), Some(high)) => Some(Self { low, high }),
            _ => None,
        }
    }
}

/// The codes strictly between two others.
#[derive(Clone, Copy)]
pub(crate) struct Between {
    first: i32,
    count: u32,
}

impl Between {
    pub fn new((low, high): (i16, i16)) -> Self {
        let first = i32::from(low) + 1;
        Self { first, count: (i32::from(high) - first).max(0) as u32 }
    }

    /// The first and the last of these codes.
    #[cfg(dsp)]
    pub const fn ends(self) -> [i16; 2] {
        let last = self.first.wrapping_add(self.count as i32).wrapping_sub(1);
        [self.first as i16, last as i16]
    }

    #[inline(always)]
    pub fn holds(self, x: i16) -> bool {
        (i32::from(x).wrapping_sub(self.first) as u32) < self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rails_middle_and_width() {
        for (codes, rails, middle, bits) in [
            (Codes::signed::<12>(), (-2048, 2047), 0, 12),
            (Codes::unsigned::<12>(), (0, 4095), 2048, 13),
            (Codes::signed::<16>(), (i16::MIN, i16::MAX), 0, 16),
            (Codes::signed::<14>(), (-8192, 8191), 0, 14),
            (Codes::unsigned::<15>(), (0, i16::MAX), 16384, 16),
            (Codes::unsigned::<8>(), (0, 255), 128, 12),
            (Codes::between(-3000, 100).unwrap(), (-3000, 100), -1450, 13),
        ] {
            assert_eq!((codes.rails(), codes.middle(), codes.bits()), (rails, middle, bits));
        }
        for bits in 0..20 {
            assert_eq!(Codes::from_bits(true, bits).is_some(), (8..=16).contains(&bits));
            assert_eq!(Codes::from_bits(false, bits).is_some(), (8..=15).contains(&bits));
        }
        assert_eq!(Codes::from_bits(true, 12), Some(Codes::signed::<12>()));
        assert_eq!(Codes::from_bits(false, 10), Some(Codes::unsigned::<10>()));
        assert_eq!(Codes::between(0, 200), None);
        assert_eq!(Codes::signed::<16>().wider(), None);
    }
}
