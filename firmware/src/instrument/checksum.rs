//! CRC-32 (ISO-HDLC) of memory, in addition to `picket-instrument`'s of settings.

use core::ops::Range;
use core::ptr::{read_volatile, with_exposed_provenance};
pub use picket_instrument::checksum::*;

/// The checksum of memory at these addresses, one part after the other.
///
/// # Safety
/// Each part is memory, and reading it changes nothing.
pub unsafe fn of_memory(parts: impl IntoIterator<Item = Range<usize>>) -> u32 {
    // SAFETY: the caller promises that memory lies at these addresses.
    let byte = |address| unsafe { read_volatile(with_exposed_provenance::<u8>(address)) };
    of_stream(parts.into_iter().flatten().map(byte))
}
