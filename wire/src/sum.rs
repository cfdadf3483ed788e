//! The sum behind a record. It follows the record, whose sequence is that of the sum's last block.

use crate::layout::{layout, record};

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

layout! {
    /// The sum behind the measurement before.
    Sum {
        /// Number of the last block.
        sequence: u32,
        /// Blocks that were added.
        blocks: u32,
        /// Natural logarithm of the probability that noise alone has such a line anywhere in the band.
        ln_chance: f32,
    }
}

record!(Sum, Sum, |sum| sum.ln_chance <= 0.0);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{self, Frame, Kind};
    use crate::layout::RecordError;

    #[test]
    fn a_sum_comes_back_as_it_was_and_others_are_refused() {
        let sum = Sum { sequence: 99, blocks: 100, ln_chance: -31.5 };
        let mut reader = frame::Reader::default();
        let frame = sum.to_frame().iter().find_map(|&byte| reader.push(byte)).unwrap().unwrap();
        assert_eq!(Sum::from_frame(&frame), Ok(sum));
        let mut newer = frame.clone();
        newer.payload[0] = 2;
        assert_eq!(Sum::from_frame(&newer), Err(RecordError::Version(2)));
        let mut cut = frame.clone();
        cut.payload.truncate(13);
        assert_eq!(Sum::from_frame(&cut), Err(RecordError::Field));
        for ln_chance in [f32::NAN, 1.0] {
            let none = Sum { ln_chance, ..sum };
            assert_eq!(Sum::from_bytes(&none.to_bytes()), Err(RecordError::Field));
        }
        let other = Frame { kind: Kind::Lines, ..frame };
        assert_eq!(Sum::from_frame(&other), Err(RecordError::Kind(Kind::Lines)));
    }
}
