//! Bytes of hosts at several ports, a queue each. A frame is passed on whole, so that the frames of two hosts do not mix.

use heapless::Deque;

/// Room for bytes of one host: two of the largest frames.
pub const IN: usize = 512;

/// What waits at one port.
struct Waiting {
    bytes: Deque<u8, IN>,
    /// Ends of frames among them: a frame ends with a zero.
    ends: usize,
}

impl Waiting {
    const EMPTY: Self = Self { bytes: Deque::new(), ends: 0 };

    /// Whether a frame is whole, or so long that it is none.
    fn due(&self) -> bool {
        self.ends > 0 || self.bytes.is_full()
    }
}

/// The queues of `PORTS` ports.
pub struct Inbox<const PORTS: usize> {
    waiting: [Waiting; PORTS],
    /// The port whose frame is being passed on.
    current: usize,
    within: bool,
}

impl<const PORTS: usize> Default for Inbox<PORTS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const PORTS: usize> Inbox<PORTS> {
    /// Nothing waits.
    pub const fn new() -> Self {
        Self { waiting: [const { Waiting::EMPTY }; PORTS], current: 0, within: false }
    }

    /// Takes a byte of a port. One without room spoils its frame, which is then refused.
    pub fn put(&mut self, port: usize, byte: u8) {
        if let Some(waiting) = self.waiting.get_mut(port)
            && waiting.bytes.push_back(byte).is_ok()
        {
            waiting.ends += usize::from(byte == 0);
        }
    }

    /// Whether a byte can be taken.
    pub fn due(&self) -> bool {
        self.waiting.iter().any(Waiting::due) || self.within && self.next().is_some()
    }

    /// The port in turn, if it has a byte.
    fn next(&self) -> Option<&Waiting> {
        self.waiting.get(self.current).filter(|waiting| !waiting.bytes.is_empty())
    }

    /// The next byte: of the frame that is being passed on, or of the next whole one, the ports in turn.
    pub fn take(&mut self) -> Option<u8> {
        if !self.within {
            let turns = (1..=PORTS).map(|turn| (self.current + turn) % PORTS.max(1));
            let due = |port: &usize| self.waiting.get(*port).is_some_and(Waiting::due);
            self.current = { turns }.find(due)?;
            self.within = true;
        }
        let waiting = self.waiting.get_mut(self.current)?;
        let Some(byte) = waiting.bytes.pop_front() else {
            // The rest of what was too long for a frame: a zero ends it for the reader.
            self.within = false;
            return Some(0);
        };
        if byte == 0 {
            self.within = false;
            waiting.ends = waiting.ends.saturating_sub(1);
        }
        Some(byte)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn taken<const PORTS: usize>(inbox: &mut Inbox<PORTS>) -> Vec<u8> {
        core::iter::from_fn(|| inbox.take()).collect()
    }

    #[test]
    fn frames_of_two_ports_stay_whole() {
        let mut inbox = Inbox::<2>::new();
        for (one, other) in [(1, 11), (2, 12), (0, 13), (3, 0), (0, 14)] {
            inbox.put(0, one);
            inbox.put(1, other);
            if one == 2 {
                assert!(!inbox.due() && inbox.take().is_none());
            }
        }
        assert!(inbox.due());
        assert_eq!(taken(&mut inbox), [11, 12, 13, 0, 1, 2, 0, 3, 0]);
        assert!(!inbox.due());
        inbox.put(1, 0);
        assert_eq!(taken(&mut inbox), [14, 0]);
    }

    #[test]
    fn noise_without_an_end_is_passed_on_and_keeps_nobody_waiting() {
        let mut inbox = Inbox::<2>::new();
        for byte in 0..2 * IN {
            inbox.put(0, 1 + (byte % 255) as u8);
        }
        inbox.put(1, 7);
        inbox.put(1, 0);
        let taken = taken(&mut inbox);
        // Its end is made, and the other's frame comes in turn.
        assert_eq!(taken.len(), IN + 1 + 2);
        assert_eq!(taken[..2], [7, 0]);
        assert_eq!(taken.last(), Some(&0));
        assert!(!inbox.due());
    }
}
