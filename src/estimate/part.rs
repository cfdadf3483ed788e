//! One part of a record's samples: the real one, I or Q.

use crate::acquire::sample::Record;

/// One part of a record's samples: of real ones the only one. Not generic, so that programs have the loops once.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    numbers: &'a [i16],
    /// How many parts there are.
    parts: usize,
    which: usize,
    /// In samples.
    pub length: usize,
}

impl<'a> Part<'a> {
    /// The first part of a record.
    pub fn first<R: Record>(samples: &'a [R::Sample]) -> Self {
        let numbers = R::pairs(samples).as_flattened();
        let parts = if R::IQ { 2 } else { 1 };
        Self { numbers, parts, which: 0, length: samples.len() }
    }

    /// The other part, if there are two.
    pub fn second(self) -> Option<Self> {
        (self.parts > 1).then_some(Self { which: 1, ..self })
    }

    /// The numbers from sample `n` on, with those of the other part between them.
    #[inline(always)]
    pub fn from(&self, n: usize) -> &'a [i16] {
        self.numbers.get(n.wrapping_mul(self.parts)..).unwrap_or_default()
    }

    /// How many numbers there are from one sample to the next: 1 or 2.
    pub const fn stride(&self) -> usize {
        self.parts
    }

    /// Which of a sample's numbers is this part's.
    pub const fn which(&self) -> usize {
        self.which
    }
}
