//! CRC-32 (ISO-HDLC) of settings and of the program. It needs no table.

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// The checksum of bytes.
pub fn of_bytes(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// The checksum of words, each from its lowest byte on.
pub fn of_words(words: impl IntoIterator<Item = u32>) -> u32 {
    of_pieces(words.into_iter().map(u32::to_le_bytes))
}

/// The checksum of bytes that come in pieces.
pub fn of_pieces<const L: usize>(pieces: impl IntoIterator<Item = [u8; L]>) -> u32 {
    let mut digest = CRC.digest();
    pieces.into_iter().for_each(|piece| digest.update(&piece));
    digest.finalize()
}
