//! Consistent Overhead Byte Stuffing (Cheshire and Baker 1999). The encoded bytes contain no zero,
//! so a zero ends a frame, and a reader that lost its place finds it again at the next zero.

use heapless::Vec;

/// The output has no room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Full;

/// The largest encoded size of `n` bytes without the closing zero: one byte more, and one for each
/// 254.
pub const fn encoded_len(n: usize) -> usize {
    n + n / 254 + 1
}

/// Appends the encoding of `data` to `out`, without the closing zero.
///
/// # Errors
/// `out` has no room for the whole; it then holds a part.
pub fn encode<const M: usize>(data: &[u8], out: &mut Vec<u8, M>) -> Result<(), Full> {
    let mut start = open(out)?;
    let mut code = 1u8;
    for &byte in data {
        if byte != 0 {
            out.push(byte).map_err(|_| Full)?;
            code += 1;
        }
        if byte == 0 || code == 0xFF {
            close(out, start, code);
            start = open(out)?;
            code = 1;
        }
    }
    close(out, start, code);
    Ok(())
}

/// Reserves the place of a group's code.
fn open<const M: usize>(out: &mut Vec<u8, M>) -> Result<usize, Full> {
    out.push(0).map_err(|_| Full)?;
    Ok(out.len() - 1)
}

fn close<const M: usize>(out: &mut Vec<u8, M>, start: usize, code: u8) {
    if let Some(place) = out.get_mut(start) {
        *place = code;
    }
}

/// Decodes byte by byte.
#[derive(Clone, Copy, Debug, Default)]
pub struct Decoder {
    /// Bytes left in the current group.
    left: u8,
    /// Whether a zero stands between this group and the next.
    zero: bool,
}

impl Decoder {
    /// Takes a byte other than zero. Returns the data byte that it completes. A group's code
    /// completes a zero, or none if none is due: then the result is `None`.
    pub fn push(&mut self, byte: u8) -> Option<u8> {
        if self.left > 0 {
            self.left -= 1;
            return Some(byte);
        }
        let due = self.zero;
        self.left = byte.wrapping_sub(1);
        self.zero = byte != 0xFF;
        due.then_some(0)
    }

    /// Whether the bytes so far end a group. Only there may an encoding end.
    pub const fn complete(&self) -> bool {
        self.left == 0
    }
}
