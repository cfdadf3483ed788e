//! Blocks from samples that come one by one, for boards without a DMA controller.

use crate::shared::Shared;
use crate::slot::Slot;
use core::mem::replace;
use picket_dsp::acquire::frontend::{Blocks, Counters, Dma, FrontEnd, Status, Timing};
use static_cell::ConstStaticCell;

/// The memory and both ends of a front end whose blocks have `N` samples without a guard: a `static`
/// of the board. While the main loop measures one slot, samples go to the other. Its initial value,
/// about 8 bytes a sample, stands in flash.
pub struct Sampler<const N: usize> {
    memory: [ConstStaticCell<[u32; N]>; 2],
    front_end: ConstStaticCell<FrontEnd<Slot<N>, 2>>,
    filler: Shared<Filling<N>>,
}

impl<const N: usize> Default for Sampler<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Sampler<N> {
    /// A sampler that waits for its start.
    pub const fn new() -> Self {
        Self {
            memory: [const { ConstStaticCell::new([0; N]) }; 2],
            front_end: ConstStaticCell::new(FrontEnd::new()),
            filler: Shared::new(),
        }
    }

    /// Takes samples from now on, for I/Q blocks or real ones. Returns the main loop's end; `None`
    /// at the second call.
    pub fn start(&'static self, iq: bool, timing: Timing) -> Option<Blocks<'static, Slot<N>>> {
        let [slot, spare] = self.memory.each_ref().map(|cell| cell.try_take().map(Slot::new));
        let filling = Filling { slot: slot?, filled: 0, iq };
        let (filler, blocks) = self.front_end.try_take()?.split(filling, timing, [spare?]);
        self.filler.set(filler);
        Some(blocks)
    }

    /// Takes a sample of each converter, 0 to 4095; the second one counts only in I/Q blocks. The
    /// timer's interrupt calls this. Cost: a few words, and an exchange at the end of a block.
    pub fn push(&self, codes: [u16; 2]) {
        self.filler.with(|filler| {
            if filler.dma().push(codes) {
                filler.interrupt();
            }
        });
    }

    /// The front end's counters so far.
    pub fn counters(&self) -> Counters {
        self.filler.counters()
    }
}

/// The slot that is being filled, in place of a controller.
struct Filling<const N: usize> {
    slot: Slot<N>,
    /// Samples in the slot.
    filled: usize,
    iq: bool,
}

impl<const N: usize> Filling<N> {
    /// Stores a sample; true at the end of the block.
    fn push(&mut self, codes: [u16; 2]) -> bool {
        let [i, q] = codes.map(u32::from);
        let odd = self.filled % 2 == 1;
        let index = if self.iq { self.filled } else { self.filled / 2 };
        if let Some(word) = self.slot.memory().get_mut(index) {
            // Little-endian: I before Q, and of two real samples the first one.
            *word = match (self.iq, odd) {
                (true, _) => i | q << 16,
                (false, false) => i,
                (false, true) => *word | i << 16,
            };
        }
        self.filled = (self.filled + 1) % N;
        self.filled == 0
    }
}

impl<const N: usize> Dma for Filling<N> {
    type Slot = Slot<N>;

    fn status(&mut self) -> Status {
        // The status is read at the end of each block only.
        Status { completed: 1, ..Status::default() }
    }

    fn exchange(&mut self, empty: Slot<N>) -> Result<Slot<N>, Slot<N>> {
        Ok(replace(&mut self.slot, empty))
    }

    fn restart(&mut self) -> u32 {
        1
    }
}
