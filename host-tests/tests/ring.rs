//! The ordering of the queues between interrupt and main loop, on two cores: every way in which two threads may interleave and
//! memory may reorder, by loom. What holds on two cores holds on one, where the interrupt's half runs as a whole.
//!
//! The queue here has the steps of heapless 0.9's `spsc::Queue`, which loom cannot see into: each end loads the other's index by
//! Acquire before it touches a place, and stores its own by Release after it.

use loom::cell::UnsafeCell;
use loom::sync::Arc;
use loom::sync::atomic::{AtomicUsize, Ordering};
use loom::thread;

/// Places of a queue; one stays empty.
const PLACES: usize = 3;
/// Blocks that are filled, and how often the main loop looks.
const ROUNDS: u32 = 3;

struct Queue<const RELEASE: bool> {
    head: AtomicUsize,
    tail: AtomicUsize,
    places: [UnsafeCell<usize>; PLACES],
}

impl<const RELEASE: bool> Queue<RELEASE> {
    /// How an index is stored: by Release, or, to see the test fail, by Relaxed.
    const STORE: Ordering = if RELEASE { Ordering::Release } else { Ordering::Relaxed };

    fn new() -> Self {
        let (head, tail) = (AtomicUsize::new(0), AtomicUsize::new(0));
        Self { head, tail, places: std::array::from_fn(|_| UnsafeCell::new(usize::MAX)) }
    }

    fn put(&self, item: usize) -> Result<(), usize> {
        let tail = self.tail.load(Ordering::Relaxed);
        let next = (tail + 1) % PLACES;
        if next == self.head.load(Ordering::Acquire) {
            return Err(item);
        }
        // SAFETY: loom fails where another access may meet this one.
        self.places[tail].with_mut(|place| unsafe { *place = item });
        self.tail.store(next, Self::STORE);
        Ok(())
    }

    fn take(&self) -> Option<usize> {
        let head = self.head.load(Ordering::Relaxed);
        if head == self.tail.load(Ordering::Acquire) {
            return None;
        }
        // SAFETY: as above.
        let item = self.places[head].with(|place| unsafe { *place });
        self.head.store((head + 1) % PLACES, Self::STORE);
        Some(item)
    }
}

/// Two spare slots and one that the controller holds, and the memory of each.
struct FrontEnd<const RELEASE: bool> {
    full: Queue<RELEASE>,
    empty: Queue<RELEASE>,
    memory: [UnsafeCell<u32>; 3],
}

// SAFETY: loom watches each access to the cells, and fails where two may meet.
unsafe impl<const RELEASE: bool> Sync for FrontEnd<RELEASE> {}
// SAFETY: as above.
unsafe impl<const RELEASE: bool> Send for FrontEnd<RELEASE> {}

/// The interrupt's half fills slots and exchanges them, the main loop's half reads them and gives them back.
fn blocks_pass<const RELEASE: bool>() {
    loom::model(|| {
        let front_end = Arc::new(FrontEnd::<RELEASE> {
            full: Queue::new(),
            empty: Queue::new(),
            memory: std::array::from_fn(|_| UnsafeCell::new(0)),
        });
        front_end.empty.put(1).unwrap();
        front_end.empty.put(2).unwrap();
        let interrupts = {
            let front_end = front_end.clone();
            thread::spawn(move || {
                let mut held = 0;
                for number in 1..=ROUNDS {
                    // SAFETY: as above.
                    front_end.memory[held].with_mut(|block| unsafe { *block = number });
                    // Without an empty slot the block is dropped, and its slot filled again.
                    if let Some(empty) = front_end.empty.take() {
                        front_end.full.put(held).expect("room for every spare slot");
                        held = empty;
                    }
                }
            })
        };
        let mut last = 0;
        for _ in 0..ROUNDS {
            // loom switches threads here and at each access.
            thread::yield_now();
            if let Some(slot) = front_end.full.take() {
                // SAFETY: as above.
                let number = front_end.memory[slot].with(|block| unsafe { *block });
                assert!(number > last, "block {number} after {last}");
                last = number;
                front_end.empty.put(slot).expect("room for every spare slot");
            }
        }
        interrupts.join().unwrap();
    });
}

#[test]
fn no_slot_is_read_while_it_is_written() {
    blocks_pass::<true>();
}

/// Without the release the test above would see it.
#[test]
#[should_panic(expected = "Causality violation")]
fn without_the_release_it_is() {
    blocks_pass::<false>();
}
