//! CRC-32 (ISO-HDLC) of settings and of the program. It needs no table.

use core::ops::Range;
use core::ptr::{read_volatile, with_exposed_provenance};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// The checksum of bytes.
pub fn of_bytes(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// The checksum of words, each from its lowest byte on.
pub fn of_words(words: impl IntoIterator<Item = u32>) -> u32 {
    let mut digest = CRC.digest();
    words.into_iter().for_each(|word| digest.update(&word.to_le_bytes()));
    digest.finalize()
}

/// The checksum of memory at these addresses, one part after the other.
///
/// # Safety
/// Each part is memory, and reading it changes nothing.
pub unsafe fn of_memory(parts: impl IntoIterator<Item = Range<usize>>) -> u32 {
    let mut digest = CRC.digest();
    for address in parts.into_iter().flatten() {
        // SAFETY: the caller promises that memory lies at this address.
        digest.update(&[unsafe { read_volatile(with_exposed_provenance::<u8>(address)) }]);
    }
    digest.finalize()
}
