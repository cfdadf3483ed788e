//! The segments of a chirp, as they arrive.

use crate::acquire::sample::{Segment, Stamp};

/// Segments as a set of bits `1 << segment`: all of a trapezoid, and all of a triangle.
pub(crate) const TRAPEZOID: u8 =
    1 << Segment::Up as u8 | 1 << Segment::Flat as u8 | 1 << Segment::Down as u8;
pub(crate) const TRIANGLE: u8 = 1 << Segment::Up as u8 | 1 << Segment::Down as u8;

/// The segments of the present chirp that have arrived. A block that does not follow the previous one starts a new chirp, so a target never
/// mixes two chirps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segments {
    held: u8,
    last: u32,
}

impl Segments {
    /// A chirp without segments so far.
    pub const fn new() -> Self {
        Self { held: 0, last: 0 }
    }

    /// The present chirp restarts.
    pub fn forget(&mut self) {
        self.held = 0;
    }

    /// Takes the next segment. Returns its place in [up, flat, down]; `None` outside a chirp.
    pub fn push(&mut self, stamp: &Stamp) -> Option<usize> {
        let follows = stamp.sequence == self.last.wrapping_add(1);
        if stamp.segment == Segment::Up || !follows {
            self.held = 0;
        }
        self.last = stamp.sequence;
        let index = match stamp.segment {
            Segment::Continuous => return None,
            Segment::Up => 0,
            Segment::Flat => 1,
            Segment::Down => 2,
        };
        self.held |= 1 << stamp.segment as u8;
        Some(index)
    }

    /// Whether this segment is the falling ramp, and all `wanted` segments have arrived with it.
    pub fn complete(&self, segment: Segment, wanted: u8) -> bool {
        segment == Segment::Down && self.held == wanted
    }
}
