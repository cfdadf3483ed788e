//! The interrupt's half of a front end, as a `static` that interrupts and the main loop share.

use core::cell::RefCell;
use cortex_m::interrupt::{Mutex, free};
use picket_dsp::acquire::frontend::{Counters, Dma, Filler};

/// Sleeps until an interrupt. It returns at once if something `waits`.
pub fn sleep(waits: impl FnOnce() -> bool) {
    free(|_| {
        if !waits() {
            // An interrupt ends the sleep, though it is served only after the critical section.
            cortex_m::asm::dsb();
            cortex_m::asm::wfi();
        }
    });
}

/// A [`Filler`], empty until the converter starts. Interrupts are masked during each access.
pub struct Shared<D: Dma + 'static>(Mutex<RefCell<Option<Filler<'static, D>>>>);

impl<D: Dma + 'static> Default for Shared<D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<D: Dma + 'static> Shared<D> {
    /// A place without a filler.
    pub const fn new() -> Self {
        Self(Mutex::new(RefCell::new(None)))
    }

    /// Puts the filler in its place.
    pub fn set(&self, filler: Filler<'static, D>) {
        free(|token| {
            if let Ok(mut place) = self.0.borrow(token).try_borrow_mut() {
                *place = Some(filler);
            }
        });
    }

    /// Works with the filler; `None` if it is not there yet.
    pub fn with<T>(&self, work: impl FnOnce(&mut Filler<'static, D>) -> T) -> Option<T> {
        free(|token| self.0.borrow(token).try_borrow_mut().ok()?.as_mut().map(work))
    }

    /// Handles the interrupt at the end of a block, and every fault interrupt.
    pub fn interrupt(&self) {
        self.with(Filler::interrupt);
    }

    /// The front end's counters so far.
    pub fn counters(&self) -> Counters {
        self.with(|filler| *filler.counters()).unwrap_or_default()
    }
}
