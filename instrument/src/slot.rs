//! The memory of a block, which has one owner at a time.

use picket_dsp::acquire::sample::Record;
use picket_wire::settings::GUARD;

/// The right to a block's memory: `WORDS` words of 32 bits. A sample of a real record takes half a
/// word, an I/Q sample a whole one.
#[derive(Debug)]
pub struct Slot<const WORDS: usize>(&'static mut [u32; WORDS]);

impl<const WORDS: usize> Slot<WORDS> {
    /// The right to this memory.
    pub const fn new(memory: &'static mut [u32; WORDS]) -> Self {
        Self(memory)
    }

    /// The block's samples after `guard` guard samples. There are at most [`GUARD`] guard samples, and 0 in a slot without room for a
    /// guard.
    pub fn samples<R: Record, const N: usize>(&self, guard: u16) -> &[R::Sample; N] {
        let before = Self::before::<R, N>(guard);
        // SAFETY: guard and block fit in the memory, and the memory is aligned, see `before`. A sample
        // is one or two i16 (`Record` is sealed), for which every bit pattern is valid. The slot is
        // borrowed as long as the samples.
        unsafe { &*self.0.as_ptr().cast::<R::Sample>().add(before).cast() }
    }

    /// The block's samples after `guard` guard samples, for writing.
    pub fn samples_mut<R: Record, const N: usize>(&mut self, guard: u16) -> &mut [R::Sample; N] {
        let before = Self::before::<R, N>(guard);
        // SAFETY: as for `samples`; the slot is borrowed for writing as long as the samples.
        unsafe { &mut *self.0.as_mut_ptr().cast::<R::Sample>().add(before).cast() }
    }

    /// The number of samples in front of a block that fits in the memory behind them.
    fn before<R: Record, const N: usize>(guard: u16) -> usize {
        const {
            assert!(size_of::<[R::Sample; N]>() <= size_of::<[u32; WORDS]>());
            assert!(align_of::<R::Sample>() <= align_of::<u32>());
        }
        let spare = const { 4 * WORDS / size_of::<R::Sample>() - N };
        usize::from(guard.min(GUARD)).min(spare)
    }

    /// The memory, for writing.
    pub fn memory(&mut self) -> &mut [u32; WORDS] {
        self.0
    }

    /// The address of the memory, for a DMA controller.
    pub fn address(&self) -> u32 {
        self.0.as_ptr().expose_provenance() as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_dsp::acquire::sample::{Iq, Real};
    use std::boxed::Box;

    #[test]
    fn samples_lie_behind_their_guard() {
        let memory = Box::leak(Box::new([0; 8 + 2]));
        let mut slot = Slot::new(memory);
        slot.memory().iter_mut().zip(0..).for_each(|(word, n)| *word = n << 16 | (n + 100));
        let pairs: &[[i16; 2]; 8] = slot.samples::<Iq, 8>(2);
        assert_eq!((pairs[0], pairs[7]), ([102, 2], [109, 9]));
        assert_eq!(slot.samples::<Real, 8>(3)[..2], [1, 102]);
        slot.samples_mut::<Iq, 8>(2)[7] = [5, 6];
        assert_eq!(slot.samples::<Iq, 8>(2)[7], [5, 6]);
        // A guard that does not fit is cut.
        assert_eq!(slot.samples::<Iq, 8>(9)[0], [102, 2]);
    }
}
