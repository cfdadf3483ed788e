//! One piece of memory for either of two meters.

use core::mem::ManuallyDrop;

/// What a meter is before its first plan.
pub trait Idle {
    /// Waiting for a plan, in memory of zeros.
    const IDLE: Self;
}

impl Idle for () {
    const IDLE: Self = ();
}

union Memory<A, B> {
    first: ManuallyDrop<A>,
    second: ManuallyDrop<B>,
}

/// One of two, in memory that has room for either. What it holds is never dropped. An enum would do the same, but each change of it passes
/// over the stack, which has no room for a meter.
pub struct Either<A, B> {
    is_second: bool,
    memory: Memory<A, B>,
}

/// What is held.
pub enum Held<A, B> {
    /// The first of the two.
    First(A),
    /// The second.
    Second(B),
}

impl<A: Idle, B> Idle for Either<A, B> {
    const IDLE: Self =
        Self { is_second: false, memory: Memory { first: ManuallyDrop::new(A::IDLE) } };
}

impl<A: Idle, B: Idle> Either<A, B> {
    /// What is held.
    pub fn get(&self) -> Held<&A, &B> {
        // SAFETY: `is_second` says which one was written last.
        unsafe {
            if self.is_second {
                Held::Second(&self.memory.second)
            } else {
                Held::First(&self.memory.first)
            }
        }
    }

    /// What is held, for writing.
    pub fn get_mut(&mut self) -> Held<&mut A, &mut B> {
        // SAFETY: as for `get`; it is borrowed for writing.
        unsafe {
            if self.is_second {
                Held::Second(&mut self.memory.second)
            } else {
                Held::First(&mut self.memory.first)
            }
        }
    }

    /// Makes it an idle first one.
    pub fn first(&mut self) -> &mut A {
        self.memory.first = const { ManuallyDrop::new(A::IDLE) };
        self.is_second = false;
        // SAFETY: just written.
        unsafe { &mut self.memory.first }
    }

    /// Makes it an idle second one.
    pub fn second(&mut self) -> &mut B {
        self.memory.second = const { ManuallyDrop::new(B::IDLE) };
        self.is_second = true;
        // SAFETY: just written.
        unsafe { &mut self.memory.second }
    }
}
