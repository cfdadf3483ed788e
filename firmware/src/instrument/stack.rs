//! The stack that a program has used.

use core::ptr::{read_volatile, with_exposed_provenance};
use core::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// What the start-up code writes below the stack.
const PAINT: u32 = 0xCCCC_CCCC;
/// The most words with the start-up code's paint below the last used one: an array in a frame that the program has not written.
const WINDOW: usize = 512;

/// The upper and the lower end of the stack.
fn ends() -> [usize; 2] {
    unsafe extern "C" {
        static mut _stack_start: u32;
        static mut _stack_end: u32;
    }
    [&raw const _stack_start as usize, &raw const _stack_end as usize]
}

/// Whether the program has not written this word, which lies between the ends.
fn is_free(place: usize) -> bool {
    // SAFETY: the callers stay between the two ends of the stack, which is only read.
    unsafe { read_volatile(with_exposed_provenance::<u32>(place)) == PAINT }
}

/// The room for the stack, bytes.
pub fn room() -> u32 {
    let [top, bottom] = ends();
    top.saturating_sub(bottom) as u32
}

/// The largest stack so far, bytes, however much of its frames the program has left unwritten. Cost: a read for each free word.
pub fn used() -> u32 {
    let [top, bottom] = ends();
    let free = (bottom..top).step_by(4).take_while(|place| is_free(*place)).count();
    room().saturating_sub(4 * free as u32)
}

/// The largest stack so far, bytes. Cost: some reads for each word of growth, and a window.
pub fn high_water() -> u32 {
    /// Bytes of the stack that are known to have been in use.
    static KNOWN: AtomicUsize = AtomicUsize::new(0);
    let [top, bottom] = ends();
    let mut known = KNOWN.load(Relaxed);
    let (mut place, mut clean) = (top.saturating_sub(known), 0);
    while clean < WINDOW && place > bottom.saturating_add(4) {
        place -= 4;
        clean += 1;
        if !is_free(place) {
            (known, clean) = (top.saturating_sub(place), 0);
        }
    }
    KNOWN.store(known, Relaxed);
    known as u32
}
