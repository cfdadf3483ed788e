//! Kinds of numbers in files, and how their bytes become samples.

use super::Sample;

/// A kind of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I24,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// A kind of number in an order of bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Number {
    pub kind: Kind,
    /// The most significant byte comes first.
    pub big: bool,
}

impl Kind {
    /// With the least significant byte first.
    pub const fn little(self) -> Number {
        Number { kind: self, big: false }
    }

    /// Bytes.
    pub const fn width(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I24 => 3,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::I64 | Kind::U64 | Kind::F64 => 8,
        }
    }
}

impl Number {
    /// Bytes.
    pub const fn width(self) -> usize {
        self.kind.width()
    }

    /// Appends a sample for each frame of this many numbers: the number in the first place picked, and the one in the second as its
    /// quadrature part. Places count from 0. What is left at the end and is no whole frame is dropped.
    pub fn samples(
        self,
        bytes: &[u8],
        channels: usize,
        picked: (usize, Option<usize>),
        into: &mut Vec<Sample>,
    ) {
        let frame = Frame { bytes: channels * self.width(), picked, big: self.big };
        match self.kind {
            Kind::I8 => frame.samples(bytes, into, |[a]| f64::from(a as i8)),
            Kind::U8 => frame.samples(bytes, into, |[a]| f64::from(a)),
            Kind::I16 => frame.samples(bytes, into, |b| f64::from(i16::from_le_bytes(b))),
            Kind::U16 => frame.samples(bytes, into, |b| f64::from(u16::from_le_bytes(b))),
            Kind::I24 => frame
                .samples(bytes, into, |[a, b, c]| f64::from(i32::from_le_bytes([0, a, b, c]) >> 8)),
            Kind::I32 => frame.samples(bytes, into, |b| f64::from(i32::from_le_bytes(b))),
            Kind::U32 => frame.samples(bytes, into, |b| f64::from(u32::from_le_bytes(b))),
            Kind::I64 => frame.samples(bytes, into, |b| i64::from_le_bytes(b) as f64),
            Kind::U64 => frame.samples(bytes, into, |b| u64::from_le_bytes(b) as f64),
            Kind::F32 => frame.samples(bytes, into, |b| f64::from(f32::from_le_bytes(b))),
            Kind::F64 => frame.samples(bytes, into, f64::from_le_bytes),
        }
    }
}

/// The numbers that are picked of a frame.
struct Frame {
    bytes: usize,
    picked: (usize, Option<usize>),
    big: bool,
}

impl Frame {
    fn samples<const W: usize>(
        &self,
        bytes: &[u8],
        into: &mut Vec<Sample>,
        read: impl Fn([u8; W]) -> f64,
    ) {
        let part = |frame: &[u8], place: usize| {
            let mut number = [0; W];
            number.copy_from_slice(&frame[place * W..][..W]);
            if self.big {
                number.reverse();
            }
            read(number)
        };
        let (first, second) = self.picked;
        if self.bytes == W && second.is_none() && !self.big {
            let (numbers, _) = bytes.as_chunks::<W>();
            into.extend(numbers.iter().map(|&number| Sample::of(read(number), None)));
            return;
        }
        let frames = bytes.chunks_exact(self.bytes);
        match second {
            None => into.extend(frames.map(|frame| Sample::of(part(frame, first), None))),
            Some(second) => into.extend(
                frames.map(|frame| Sample::of(part(frame, first), Some(part(frame, second)))),
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_every_kind() {
        let of = |kind: Kind, bytes: &[u8]| {
            let read = |big, bytes: &[u8]| {
                let mut samples = Vec::new();
                Number { kind, big }.samples(bytes, 1, (0, None), &mut samples);
                assert_eq!(samples.len(), 1, "{kind:?}");
                samples[0].value.re
            };
            let reversed: Vec<u8> = bytes.iter().rev().copied().collect();
            assert_eq!(read(false, bytes), read(true, &reversed), "{kind:?}");
            read(false, bytes)
        };
        assert_eq!(of(Kind::I8, &[0xFF]), -1.0);
        assert_eq!(of(Kind::U8, &[0xFF]), 255.0);
        assert_eq!(of(Kind::I16, &[0x00, 0x80]), -32768.0);
        assert_eq!(of(Kind::U16, &[0x00, 0x80]), 32768.0);
        assert_eq!(of(Kind::I24, &[0xFE, 0xFF, 0xFF]), -2.0);
        assert_eq!(of(Kind::I32, &(-5i32).to_le_bytes()), -5.0);
        assert_eq!(of(Kind::U32, &u32::MAX.to_le_bytes()), 4_294_967_295.0);
        assert_eq!(of(Kind::I64, &(-7i64).to_le_bytes()), -7.0);
        assert_eq!(of(Kind::U64, &7u64.to_le_bytes()), 7.0);
        assert_eq!(of(Kind::F32, &0.25f32.to_le_bytes()), 0.25);
        assert_eq!(of(Kind::F64, &0.1f64.to_le_bytes()), 0.1);
    }

    #[test]
    fn channels_are_picked() {
        let bytes: Vec<u8> = (0i16..9).flat_map(i16::to_le_bytes).collect();
        let mut samples = Vec::new();
        Kind::I16.little().samples(&bytes[..17], 3, (2, Some(0)), &mut samples);
        assert_eq!(samples, [Sample::of(2.0, Some(0.0)), Sample::of(5.0, Some(3.0))]);
    }
}
