//! One part of a record's samples: the real one, I or Q.

use crate::acquire::sample::Record;

/// One part of a record's samples: the only one of a real record, I or Q of another. It is not
/// generic, so that programs hold its loops once.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    numbers: &'a [i16],
    /// The number of parts: 1 or 2.
    parts: usize,
    which: usize,
    /// The length in samples.
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

    /// The numbers from sample `n` on. Those of the other part lie between them.
    #[inline(always)]
    pub fn from(&self, n: usize) -> &'a [i16] {
        self.numbers.get(n.wrapping_mul(self.parts)..).unwrap_or_default()
    }

    /// The distance from one sample to the next in numbers: 1 or 2.
    pub const fn stride(&self) -> usize {
        self.parts
    }

    /// The position of this part's number in a sample.
    pub const fn which(&self) -> usize {
        self.which
    }
}
