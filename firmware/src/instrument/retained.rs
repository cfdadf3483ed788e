//! Words that survive a reset, in memory that the start-up code does not touch.

use core::cell::UnsafeCell;
use core::ptr::{read_volatile, write_volatile};

/// `LENGTH` words, of any value after power-on. They belong into a section whose name begins with `.uninit`.
#[repr(transparent)]
pub struct Retained<const LENGTH: usize>(UnsafeCell<[u32; LENGTH]>);

// SAFETY: every access is volatile and of one word, by the main loop before anything else runs, or
// by the code that ends the program.
unsafe impl<const LENGTH: usize> Sync for Retained<LENGTH> {}

impl<const LENGTH: usize> Default for Retained<LENGTH> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const LENGTH: usize> Retained<LENGTH> {
    /// A place for the words.
    pub const fn new() -> Self {
        Retained(UnsafeCell::new([0; LENGTH]))
    }

    /// The words.
    pub fn words(&self) -> [u32; LENGTH] {
        let mut words = [0; LENGTH];
        let first = self.0.get().cast::<u32>();
        for (index, word) in words.iter_mut().enumerate() {
            // SAFETY: within the array; the chip's memory holds some value.
            *word = unsafe { read_volatile(first.add(index)) };
        }
        words
    }

    /// Keeps these words.
    pub fn keep(&self, words: &[u32; LENGTH]) {
        let first = self.0.get().cast::<u32>();
        for (index, &word) in words.iter().enumerate() {
            // SAFETY: within the array, to which nothing else refers.
            unsafe { write_volatile(first.add(index), word) };
        }
    }
}
