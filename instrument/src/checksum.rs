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

/// The checksum of many bytes.
pub fn of_stream(bytes: impl IntoIterator<Item = u8>) -> u32 {
    let (mut digest, mut bytes) = (CRC.digest(), bytes.into_iter());
    loop {
        let (mut piece, mut length) = ([0; 64], 0);
        for (place, byte) in piece.iter_mut().zip(bytes.by_ref()) {
            *place = byte;
            length += 1;
        }
        if length == 0 {
            return digest.finalize();
        }
        update(&mut digest, piece.get(..length).unwrap_or(&[]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_the_same_however_the_bytes_come() {
        // The catalogue of CRCs gives this value for "123456789".
        assert_eq!(of_bytes(b"123456789"), 0xCBF4_3926);
        let bytes: std::vec::Vec<u8> = (0..=255).cycle().step_by(7).take(640).collect();
        for length in [0, 4, 60, 64, 68, 128, 132, 640] {
            let bytes = &bytes[..length];
            assert_eq!(of_stream(bytes.iter().copied()), of_bytes(bytes));
            let words = bytes.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word));
            assert_eq!(of_words(words), of_bytes(bytes));
        }
    }
}
