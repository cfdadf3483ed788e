//! Work on records whose kind and length are known only when the program runs.

use super::sample::{Iq, Real, Record};

/// Work to be done with records of a kind and length that are known only at run time.
pub trait ForRecord {
    /// What comes of it.
    type Output;
    /// Does it.
    fn run<R: Record, const N: usize>(self) -> Self::Output;
}

/// Does `work` for records of this kind and length; `None` for a length the FFT does not support.
///
/// The code of all fourteen combinations is in the program, the memory of one in use.
pub fn for_record<W: ForRecord>(iq: bool, n: usize, work: W) -> Option<W::Output> {
    Some(match (iq, n) {
        (false, 64) => work.run::<Real, 64>(),
        (false, 128) => work.run::<Real, 128>(),
        (false, 256) => work.run::<Real, 256>(),
        (false, 512) => work.run::<Real, 512>(),
        (false, 1024) => work.run::<Real, 1024>(),
        (false, 2048) => work.run::<Real, 2048>(),
        (false, 4096) => work.run::<Real, 4096>(),
        (true, 64) => work.run::<Iq, 64>(),
        (true, 128) => work.run::<Iq, 128>(),
        (true, 256) => work.run::<Iq, 256>(),
        (true, 512) => work.run::<Iq, 512>(),
        (true, 1024) => work.run::<Iq, 1024>(),
        (true, 2048) => work.run::<Iq, 2048>(),
        (true, 4096) => work.run::<Iq, 4096>(),
        _ => return None,
    })
}
