//! What a soak has seen.

use std::ops::AddAssign;

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// An interrupt is served late, or not at all before the next.
    Late,
    /// An interrupt without a cause.
    Doubled,
    /// An interrupt is held up between two of its accesses.
    HeldUp,
    /// A transfer fails.
    Transfer,
    /// The converter overruns.
    Overrun,
    /// The samples stop and start again.
    Pause,
    /// The main loop holds every slot at the end of a block.
    Stall,
}

impl Fault {
    /// Every fault with its key in JSON.
    pub const ALL: [(Fault, &'static str); 7] = [
        (Fault::Late, "late"),
        (Fault::Doubled, "doubled"),
        (Fault::HeldUp, "held_up"),
        (Fault::Transfer, "transfer"),
        (Fault::Overrun, "overrun"),
        (Fault::Pause, "pause"),
        (Fault::Stall, "stall"),
    ];
}

/// Counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Runs from power-on.
    pub lives: u64,
    /// Blocks that came out, each right.
    pub blocks: u64,
    /// Blocks that were lost, each counted.
    pub lost: u64,
    /// Runs in which the sequence or the clock wrapped.
    pub wraps: u64,
    /// Damaged frames, and those of them that were accepted.
    pub damaged: u64,
    /// Faults, in the order of [`Fault::ALL`].
    pub faults: [u64; 7],
}

impl Tally {
    /// Counts a fault.
    pub fn fault(&mut self, fault: Fault) {
        self.faults[fault as usize] += 1;
    }

    /// All faults.
    pub fn all_faults(&self) -> u64 {
        self.faults.iter().sum()
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, more: Self) {
        self.lives += more.lives;
        self.blocks += more.blocks;
        self.lost += more.lost;
        self.wraps += more.wraps;
        self.damaged += more.damaged;
        self.faults.iter_mut().zip(more.faults).for_each(|(sum, more)| *sum += more);
    }
}
