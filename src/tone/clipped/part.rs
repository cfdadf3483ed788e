//! One part of a record's samples: the real one, I or Q.

use crate::acquire::sample::Data;
use heapless::VecView;

/// One part of a record's samples: the only one of a real record, I or Q of an I/Q record. The type is not generic, so that programs hold
/// its loops once.
#[derive(Clone, Copy)]
pub(in crate::tone) struct Part<'a> {
    numbers: &'a [i16],
    /// The number of parts: 1 or 2.
    parts: usize,
    which: usize,
    /// The length in samples.
    pub length: usize,
}

impl<'a> Part<'a> {
    /// The first part of a record.
    pub fn first(data: Data<'a>) -> Self {
        let numbers = data.parts();
        let parts = if data.iq { 2 } else { 1 };
        Self { numbers, parts, which: 0, length: numbers.len() / parts }
    }

    /// The other part, if there are two.
    pub fn second(self) -> Option<Self> {
        (self.parts > 1).then_some(Self { which: 1, ..self })
    }

    /// The samples from sample `n` on. If there are two parts, the samples are copied to `places`, up to its capacity.
    #[inline(always)]
    pub fn from<'b>(&self, n: usize, places: &'b mut VecView<i16>) -> &'b [i16]
    where
        'a: 'b,
    {
        let numbers = self.numbers.get(n.wrapping_mul(self.parts)..).unwrap_or_default();
        if self.parts == 1 {
            return numbers;
        }
        self.copied(numbers.as_chunks().0, places)
    }

    #[inline(never)]
    fn copied<'b>(&self, pairs: &[[i16; 2]], places: &'b mut VecView<i16>) -> &'b [i16] {
        places.clear();
        for pair in pairs.iter().take(places.capacity()) {
            // There is room for all of them.
            let _ = places.push(pair.get(self.which).copied().unwrap_or_default());
        }
        places
    }
}
