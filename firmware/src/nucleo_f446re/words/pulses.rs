//! Rises of the sync input: the one that opens the gate for a chirp, and those in vain, while a chirp runs or the samples stand. Registers
//! are read elsewhere.

/// What TIM2 shows since the last look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Look {
    /// Rises: 0, 1, or 2 for at least two (CC2IF and CC2OF, RM 17.4.5).
    pub rises: u32,
    /// Whether the last of them was captured at the gate's first ticks, so that it opened the gate.
    pub early: bool,
    /// Whether the gate has closed (UIF).
    pub closed: bool,
}

/// The rises of the sync input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rises {
    /// Whether a rise opens the gate.
    armed: bool,
    /// Whether the gate's own rise was seen, and its close was not.
    open: bool,
    /// Rises in vain since the last one that opened the gate.
    meanwhile: u32,
}

impl Rises {
    /// Whether a chirp runs, as far as was seen.
    pub const fn open(&self) -> bool {
        self.open
    }

    /// Takes a look. Returns the rises in vain before the chirp that now begins: their blocks are between its blocks and those of the last
    /// chirp.
    pub fn see(&mut self, look: Look) -> u32 {
        let Look { rises, early, closed } = look;
        if !self.armed {
            self.meanwhile = self.meanwhile.saturating_add(rises);
            return 0;
        }
        // Rises of the chirp that is over or still runs, of which one opened it.
        let next = u32::from(closed && early && rises > 0);
        let own = rises.saturating_sub(next);
        let begins = own > 0 && !self.open;
        let mut due = if begins { core::mem::take(&mut self.meanwhile) } else { 0 };
        self.meanwhile = self.meanwhile.saturating_add(own.saturating_sub(begins.into()));
        self.open = if closed { next > 0 } else { self.open || begins };
        if next > 0 {
            due = due.saturating_add(core::mem::take(&mut self.meanwhile));
        }
        due
    }

    /// The samples stand: rises open nothing.
    pub fn stop(&mut self) {
        (self.armed, self.open) = (false, false);
    }

    /// Rises open the gate again. Returns those that were in vain.
    pub fn arm(&mut self) -> u32 {
        self.armed = true;
        core::mem::take(&mut self.meanwhile)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rise(rises: u32, early: bool) -> Look {
        Look { rises, early, closed: false }
    }

    const CLOSED: Look = Look { rises: 0, early: false, closed: true };

    #[test]
    fn a_rise_during_a_chirp_counts_before_the_next_one() {
        let mut rises = Rises::default();
        assert_eq!(rises.arm(), 0);
        assert_eq!(rises.see(rise(1, true)), 0);
        assert!(rises.open());
        assert_eq!((rises.see(rise(1, false)), rises.see(CLOSED)), (0, 0));
        assert!(!rises.open());
        assert_eq!(rises.see(rise(1, true)), 1);
        assert_eq!((rises.see(CLOSED), rises.see(rise(1, true))), (0, 0));
    }

    #[test]
    fn late_looks_count_the_same() {
        // The close and the next chirp's rise in one look, with a rise in vain before them that nothing has told apart.
        let mut rises = Rises::default();
        rises.arm();
        rises.see(rise(1, true));
        assert_eq!(rises.see(Look { rises: 2, early: true, closed: true }), 1);
        assert!(rises.open());
        // A whole chirp in one look: its own rise is none in vain.
        assert_eq!(rises.see(CLOSED), 0);
        assert_eq!(rises.see(Look { rises: 1, early: false, closed: true }), 0);
        assert!(!rises.open());
        // Its rise was overwritten by one in vain.
        assert_eq!(rises.see(rise(2, false)), 0);
        assert_eq!((rises.see(CLOSED), rises.see(rise(1, true))), (0, 1));
    }

    #[test]
    fn while_the_samples_stand_every_rise_is_in_vain() {
        let mut rises = Rises::default();
        rises.arm();
        rises.see(rise(1, true));
        rises.see(rise(1, false));
        rises.stop();
        assert_eq!(rises.see(Look { rises: 2, early: true, closed: true }), 0);
        assert!(!rises.open());
        assert_eq!(rises.arm(), 3);
    }
}
