//! The fundamental of a block's harmonics as bytes: little-endian, versioned, the same on every machine.
//! It follows the block's telemetry.
//!
//! | offset | field |
//! |---|---|
//! | 0 | version: u8 |
//! | 1 | segment: u8 |
//! | 2 | verdict: u8 |
//! | 3 | what applies beside the verdict: u8 |
//! | 4 | sequence: u32 |
//! | 8 | orders that were seen: u32, bit k stands for order k + 1 |
//! | 12 | frequency: i32 in 2^-32 cycles per sample |
//! | 16 | sigma: f32 in cycles per sample |
//! | 20 | signal-to-noise ratio of all lines together: f32 as a power ratio |
//! | 24 | amplitude of order 1: f32 in codes, 0 if it is not seen |

use super::frame::{self, Frame, Kind};
use crate::bytes::{Reader, Writer};
use fixed::types::I0F32;
use heapless::Vec;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::harmonic::Harmonic;
use picket_dsp::tone::{Tone, Verdict, Verdicts};

/// The layout's version.
pub const VERSION: u8 = 1;

/// The fundamental of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fundamental {
    /// The block's sequence number.
    pub sequence: u32,
    /// The block's segment.
    pub segment: Segment,
    /// The fundamental. Its sample rate is that of the block's telemetry, and 0 here.
    pub harmonic: Harmonic,
}

impl Fundamental {
    /// Length of the layout, bytes.
    const BYTES: usize = 28;

    /// Labels the fundamental of a block with the block's stamp.
    pub fn from_harmonic(stamp: &Stamp, mut harmonic: Harmonic) -> Self {
        harmonic.tone.rate_hz = 0.0;
        Self { sequence: stamp.sequence, segment: stamp.segment, harmonic }
    }

    /// The fundamental as a frame.
    pub fn to_frame(&self) -> Vec<u8, { frame::WIRE }> {
        let Harmonic { tone, orders } = &self.harmonic;
        let mut payload = [0; Self::BYTES];
        let mut writer = Writer::new(&mut payload);
        writer.put([VERSION, self.segment as u8, tone.verdict as u8, tone.also.bits()]);
        writer.u32(self.sequence);
        writer.u32(*orders);
        writer.i32(tone.frequency.0.to_bits());
        for number in [tone.sigma, tone.snr, tone.amplitude] {
            writer.f32(number);
        }
        frame::encode(Kind::Fundamental, &payload).unwrap_or_default()
    }

    /// The fundamental in a frame; `None` for a frame of another kind or version, one that is cut off,
    /// or one with an unknown value or one that the verdict forbids.
    pub fn from_frame(frame: &Frame) -> Option<Self> {
        if frame.kind != Kind::Fundamental {
            return None;
        }
        let mut reader = Reader(&frame.payload);
        let [VERSION, segment, verdict, also] = reader.take()? else { return None };
        let (sequence, orders) = (reader.u32()?, reader.u32()?);
        let frequency = Frequency(I0F32::from_bits(reader.i32()?));
        let [sigma, snr, amplitude] = [reader.f32()?, reader.f32()?, reader.f32()?];
        let (verdict, also) = (Verdict::from_u8(verdict)?, Verdicts::from_bits(also));
        let tone = Tone { frequency, sigma, snr, amplitude, verdict, also, ..Tone::default() };
        if !tone.is_consistent() {
            return None;
        }
        let harmonic = Harmonic { tone, orders };
        Some(Self { sequence, segment: Segment::from_u8(segment)?, harmonic })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fundamental_comes_back_as_it_was_and_others_are_refused() {
        let stamp = Stamp { sequence: 9, segment: Segment::Flat, ..Stamp::default() };
        let frequency = Frequency(I0F32::from_bits(-123_456_789));
        let tone = Tone { frequency, sigma: 1e-6, snr: 40.0, rate_hz: 5e5, ..Tone::default() };
        let fundamental = Fundamental::from_harmonic(&stamp, Harmonic { tone, orders: 0b1110 });
        let mut reader = frame::Reader::default();
        let bytes = fundamental.to_frame();
        let frame = bytes.iter().find_map(|&byte| reader.push(byte)).unwrap().unwrap();
        assert_eq!(Fundamental::from_frame(&frame), Some(fundamental));
        for (place, value) in [(0, 2), (1, 9), (2, 99)] {
            let mut frame = frame.clone();
            frame.payload[place] = value;
            assert_eq!(Fundamental::from_frame(&frame), None);
        }
        let mut cut = frame.clone();
        cut.payload.truncate(27);
        assert_eq!(Fundamental::from_frame(&cut), None);
        assert_eq!(Fundamental::from_frame(&Frame { kind: Kind::Lines, ..frame }), None);
    }
}
