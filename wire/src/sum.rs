//! What a record of a sum adds up, as bytes: little-endian, versioned, the same on every machine. It follows the record, whose
//! sequence is that of the sum's last block.
//!
//! | offset | field |
//! |---|---|
//! | 0 | version: u8 |
//! | 1 | zero: 3 bytes |
//! | 4 | sequence: u32 |
//! | 8 | blocks: u32 |
//! | 12 | natural logarithm of the probability that noise alone has such a line anywhere in the band: f32 |

use super::frame::{self, Frame, Kind};
use crate::bytes::{Reader, Writer};
use heapless::Vec;

/// The layout's version.
pub const VERSION: u8 = 1;

/// The blocks that were added for a record.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sum {
    /// The sequence number of the last block.
    pub sequence: u32,
    /// The blocks that were added.
    pub blocks: u32,
    /// The natural logarithm of the probability that noise alone has such a line anywhere in the band.
    pub ln_chance: f32,
}

impl Sum {
    /// Length of the layout, bytes.
    const BYTES: usize = 16;

    /// The sum as a frame.
    pub fn to_frame(&self) -> Vec<u8, { frame::WIRE }> {
        let mut payload = [0; Self::BYTES];
        let mut writer = Writer::new(&mut payload);
        writer.put([VERSION, 0, 0, 0]);
        writer.u32(self.sequence);
        writer.u32(self.blocks);
        writer.f32(self.ln_chance);
        frame::encode(Kind::Sum, &payload).unwrap_or_default()
    }

    /// The sum in a frame; `None` for a frame of another kind or version, one that is cut off, or one whose probability is not one.
    pub fn from_frame(frame: &Frame) -> Option<Self> {
        if frame.kind != Kind::Sum {
            return None;
        }
        let mut reader = Reader(&frame.payload);
        let [VERSION, _, _, _] = reader.take()? else { return None };
        let sum = Self { sequence: reader.u32()?, blocks: reader.u32()?, ln_chance: reader.f32()? };
        (sum.ln_chance <= 0.0).then_some(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_comes_back_as_it_was_and_others_are_refused() {
        let sum = Sum { sequence: 99, blocks: 100, ln_chance: -31.5 };
        let mut reader = frame::Reader::default();
        let frame = sum.to_frame().iter().find_map(|&byte| reader.push(byte)).unwrap().unwrap();
        assert_eq!(Sum::from_frame(&frame), Some(sum));
        let mut newer = frame.clone();
        newer.payload[0] = 2;
        assert_eq!(Sum::from_frame(&newer), None);
        let mut cut = frame.clone();
        cut.payload.truncate(15);
        assert_eq!(Sum::from_frame(&cut), None);
        for ln_chance in [f32::NAN, 1.0] {
            let none = Sum { ln_chance, ..sum };
            let frame = none.to_frame().iter().find_map(|&byte| reader.push(byte)).unwrap();
            assert_eq!(Sum::from_frame(&frame.unwrap()), None);
        }
        assert_eq!(Sum::from_frame(&Frame { kind: Kind::Lines, ..frame }), None);
    }
}
