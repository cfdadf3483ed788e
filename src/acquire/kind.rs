//! Work on records whose kind and length are known only at run time.

use super::sample::{Iq, Real, Record};

/// Work on records whose kind and length are known only at run time.
pub trait ForRecord {
    /// The result of the work.
    type Output;
    /// Does the work on records of kind `R` and `N` samples.
    fn run<R: Record, const N: usize>(self) -> Self::Output;
}

/// Runs `work` for records of this kind and length; `None` for a length that the FFT does not
/// support.
///
/// The program holds the code of all fourteen combinations and the memory of the one in use.
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
