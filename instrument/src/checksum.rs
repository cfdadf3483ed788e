//! CRC-32 (ISO-HDLC) of settings and of the program. It needs no table.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, NoTable};

const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// Takes more bytes into account. Compiled once: it is long, and settings are short.
#[inline(never)]
fn update(digest: &mut Digest<'static, u32, NoTable>, bytes: &[u8]) {
    digest.update(bytes);
}

/// The checksum of bytes.
pub fn of_bytes(bytes: &[u8]) -> u32 {
    let mut digest = CRC.digest();
    update(&mut digest, bytes);
    digest.finalize()
}

/// The checksum of words, each from its lowest byte on.
pub fn of_words(words: impl IntoIterator<Item = u32>) -> u32 {
    let mut digest = CRC.digest();
    words.into_iter().for_each(|word| update(&mut digest, &word.to_le_bytes()));
    digest.finalize()
}

/// The checksum of many bytes, one by one.
pub fn of_stream(bytes: impl IntoIterator<Item = u8>) -> u32 {
    let mut digest = CRC.digest();
    bytes.into_iter().for_each(|byte| digest.update(&[byte]));
    digest.finalize()
}
