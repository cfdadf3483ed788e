//! The place of a code in a word of the converter.

use super::codes::Codes;

mod sealed {
    pub trait Sealed {}
}

/// A word as a DMA controller stores it: an integer of 8, 16 or 32 bits.
pub trait Word: sealed::Sealed + Copy {
    /// The bits of the word, as the low end of 32 bits.
    fn bits(self) -> u32;
}

macro_rules! words {
    ($($word:ty: $unsigned:ty),*) => {
        $(
            impl sealed::Sealed for $word {}
            impl Word for $word {
                fn bits(self) -> u32 {
                    u32::from(self as $unsigned)
                }
            }
        )*
    };
}

words!(u8: u8, i8: u8, u16: u16, i16: u16, u32: u32, i32: u32);

/// The place of the code in a word, and the conversion of the code to a sample of 16 bits.
///
/// ```
/// use picket_dsp::{Codes, Format};
///
/// // A microcontroller's converter, left-aligned in 16 bits.
/// let format = Format::unsigned::<12>().left_aligned_in::<16>();
/// assert_eq!(format.code(0xFFF0u16), 4095);
/// assert_eq!(format.codes(), Codes::unsigned::<12>());
/// // A microphone: 24 bits at the high end of a 32-bit slot; a sample keeps the upper 16.
/// let format = Format::i2s::<8>().left_aligned_in::<32>();
/// assert_eq!(format.code(0x8000_0000u32), i16::MIN);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Format {
    signed: bool,
    /// Bits of a code.
    bits: u32,
    /// Bits below the code in the word.
    below: u32,
    /// Bits at the low end of the code that are dropped.
    drop: u32,
}

impl Format {
    /// Signed codes of `BITS` bits, 8 to 16, at the low end of a word.
    pub const fn signed<const BITS: u32>() -> Self {
        const { assert!(8 <= BITS && BITS <= 16, "signed codes have 8 to 16 bits") };
        Self { signed: true, bits: BITS, below: 0, drop: 0 }
    }

    /// Unsigned codes of `BITS` bits, 8 to 16, at the low end of a word. Codes of 16 bits become
    /// signed ones.
    pub const fn unsigned<const BITS: u32>() -> Self {
        const { assert!(8 <= BITS && BITS <= 16, "unsigned codes have 8 to 16 bits") };
        Self { signed: false, bits: BITS, below: 0, drop: 0 }
    }

    /// Signed codes of 24 bits, as I2S microphones and audio converters make them, without their lowest `SHIFT` bits, 0 to 16. A shift of 8
    /// keeps the whole range. A smaller shift makes a weak signal larger and clips a strong one.
    pub const fn i2s<const SHIFT: u32>() -> Self {
        const { assert!(SHIFT <= 16, "a shift is 0 to 16 bits") };
        Self { signed: true, bits: 24, below: 0, drop: SHIFT }
    }

    /// The format with its code at the high end of a word of `WORD` bits, 16 or 32.
    #[must_use]
    pub const fn left_aligned_in<const WORD: u32>(mut self) -> Self {
        const { assert!(WORD == 16 || WORD == 32, "a word has 16 or 32 bits") };
        self.below = WORD.saturating_sub(self.bits);
        self
    }

    /// The codes of this format's samples.
    pub const fn codes(self) -> Codes {
        let bits = self.bits.saturating_sub(self.drop);
        let codes = if !self.signed && bits < 16 {
            Codes::from_bits(false, bits)
        } else {
            Codes::from_bits(true, if bits < 16 { bits } else { 16 })
        };
        match codes {
            Some(codes) => codes,
            // No format has fewer than 8 bits.
            None => Codes::signed::<16>(),
        }
    }

    /// The code in a word. Other bits of the word are ignored. Cost: two shifts, a subtraction and a
    /// clamp.
    #[inline]
    pub fn code(self, word: impl Word) -> i16 {
        // The bits of the code, below it and dropped are 32 at most.
        let up = 32u32.saturating_sub(self.bits + self.below);
        let upper = word.bits() << (up & 31);
        let down = 32u32.saturating_sub(self.bits) & 31;
        let code = if self.signed { upper as i32 >> down } else { (upper >> down) as i32 };
        let centre = if !self.signed && self.bits == 16 { 1 << 15 } else { 0 };
        ((code - centre) >> self.drop).clamp(i16::MIN.into(), i16::MAX.into()) as i16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_every_width_and_alignment() {
        for bits in 8..=16 {
            let (signed, unsigned) = (
                Format { signed: true, bits, below: 0, drop: 0 },
                Format { signed: false, bits, below: 0, drop: 0 },
            );
            let top = (1u32 << bits) - 1;
            for format in [signed, unsigned] {
                let (low, high) = format.codes().rails();
                let left = Format { below: 16 - bits, ..format };
                let codes = [0, 1, top / 2, top / 2 + 1, top].map(|raw: u32| {
                    // Bits beside the code are ignored.
                    let beside = if bits < 16 { 1 << bits } else { 0 };
                    let code = format.code((raw | beside) as u16);
                    assert_eq!(left.code((raw << (16 - bits)) as u16), code);
                    assert_eq!(left.code((raw << (16 - bits)) as u16 as i16), code);
                    code
                });
                let half = ((top / 2) as i32, (top / 2 + 1) as i32);
                let expected = if format.signed {
                    [0, 1, half.0, -half.1, -1]
                } else if bits == 16 {
                    [-32768, -32767, -1, 0, 32767]
                } else {
                    [0, 1, half.0, half.1, top as i32]
                };
                assert_eq!(codes.map(i32::from), expected, "{format:?}");
                assert_eq!(codes.iter().min(), Some(&low));
                assert_eq!(codes.iter().max(), Some(&high));
            }
        }
    }

    #[test]
    fn words_of_24_bits_by_their_shift() {
        let whole = Format::i2s::<8>();
        assert_eq!(whole.code(0x007F_FFFFu32), i16::MAX);
        assert_eq!(whole.code(0x0080_0000u32), i16::MIN);
        assert_eq!(whole.code(0xFFFF_FF00u32 as i32), -1);
        let louder = Format::i2s::<2>();
        assert_eq!(louder.code(0x0000_4000u32), 0x1000);
        assert_eq!(louder.code(0x0020_0000u32), i16::MAX);
        assert_eq!(louder.code(0x00C0_0000u32), i16::MIN);
        let quiet = Format::i2s::<16>();
        assert_eq!((quiet.code(0x0080_0000u32), quiet.codes()), (-128, Codes::signed::<8>()));
        let left = Format::i2s::<8>().left_aligned_in::<32>();
        assert_eq!(left.code(0x1234_5678u32), 0x1234);
    }
}
