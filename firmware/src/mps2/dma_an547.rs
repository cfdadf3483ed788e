//! AN547 as QEMU emulates it has no DMA controller. The core copies where another board starts a transfer, and an interrupt line without a
//! device signals the end.

use super::Line;
use cortex_m::peripheral::NVIC;

/// The interrupt at the end of a copy.
pub const DMA_IRQ: usize = 57;

/// The stand-in for the controller.
#[derive(Debug, Default)]
pub struct Dma {
    done: bool,
}

impl Dma {
    /// Idle.
    pub const fn new() -> Self {
        Self { done: false }
    }

    /// Copies `source` to `destination`; [`DMA_IRQ`] signals the end. Returns false and does nothing
    /// if the lengths differ.
    ///
    /// # Safety
    /// No other code may use `destination` meanwhile.
    pub unsafe fn start(&mut self, source: *const [u32], destination: *mut [u32]) -> bool {
        let words = source.len();
        if words != destination.len() || words == 0 {
            return false;
        }
        // SAFETY: both have this many words; the caller guarantees that they are valid and apart.
        unsafe {
            core::ptr::copy_nonoverlapping(source.cast::<u32>(), destination.cast::<u32>(), words);
        }
        self.done = true;
        NVIC::pend(Line(DMA_IRQ));
        true
    }

    /// Whether a copy had ended.
    pub fn finish(&mut self) -> bool {
        core::mem::take(&mut self.done)
    }
}
