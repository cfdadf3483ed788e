//! The two ends of a queue between an interrupt and the main loop, free of panics.
//!
//! heapless takes its indices modulo the queue's length. After `split` the types no longer show
//! that this length is above 0. The comparison here shows it, so no image keeps a test for a
//! division by 0.

use heapless::spsc::{Consumer, Producer};

/// Puts an item into the queue.
///
/// # Errors
/// Returns the item if the queue is full.
pub fn put<T>(queue: &mut Producer<'_, T>, item: T) -> Result<(), T> {
    if queue.capacity() == usize::MAX { Err(item) } else { queue.enqueue(item) }
}

/// Takes the oldest item; `None` if the queue is empty.
pub fn take<T>(queue: &mut Consumer<'_, T>) -> Option<T> {
    if queue.capacity() == usize::MAX { None } else { queue.dequeue() }
}
