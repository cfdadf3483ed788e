//! The converter whose codes a file holds.

use super::{Levels, Scaling};

/// A converter's codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Converter {
    /// Their width.
    pub bits: u32,
    /// They count from 0.
    pub unsigned: bool,
}

impl Converter {
    /// Whether its codes are others than signed ones of 16 bits.
    pub(super) fn is_narrow(self) -> bool {
        self.unsigned || self.bits < 16
    }

    /// How numbers of these levels become its codes: whole ones are codes, others are spread over them as `spread` does over 16 bits.
    pub(super) fn scaling(self, levels: &Levels, spread: Scaling) -> Scaling {
        let middle =
            if self.unsigned && self.bits < 16 { (f64::from(self.bits) - 1.0).exp2() } else { 0.0 };
        if levels.whole {
            let shift = if self.unsigned && self.bits >= 16 { -32768.0 } else { 0.0 };
            return Scaling { factor: 1.0, shift };
        }
        let share = (f64::from(self.bits) - 16.0).exp2();
        Scaling { factor: share * spread.factor, shift: share * spread.shift + middle }
    }
}
