//! The two ends of a queue between an interrupt and the main loop, without a panic left in them.
//!
//! heapless takes its indices modulo the queue's length, which the types do not show to be above 0 after `split`. The
//! comparison here shows it, so that no test for a division by 0 is left in an image.

use heapless::spsc::{Consumer, Producer};

/// Puts an item into the queue.
///
/// # Errors
/// Gives the item back where the queue is full.
pub fn put<T>(queue: &mut Producer<'_, T>, item: T) -> Result<(), T> {
    if queue.capacity() == usize::MAX { Err(item) } else { queue.enqueue(item) }
}

/// Takes the oldest item; `None` where the queue is empty.
pub fn take<T>(queue: &mut Consumer<'_, T>) -> Option<T> {
    if queue.capacity() == usize::MAX { None } else { queue.dequeue() }
}
