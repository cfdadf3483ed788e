//! The option bytes, which only the image that is built for it writes.

use super::registers::{flash, put};
use super::start::within;
use super::words::guard::{LONGEST_MS, brown_out};

/// Sets the brown-out level, once in the chip's life. If the power fails meanwhile, the option bytes may hold any value, even a read
/// protection: the usual images leave them alone.
pub fn set() {
    const KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];
    let flash = flash();
    let Some(word) = brown_out(flash.optcr().read().bits()) else { return };
    let idle = || within(LONGEST_MS, || flash.sr().read().bits() & 1 << 16 == 0);
    if !idle() {
        return;
    }
    KEYS.iter().for_each(|&key| {
        put!(flash.optkeyr(), key);
    });
    put!(flash.optcr(), word);
    // OPTSTRT 1; BSY 16; OPTLOCK 0 (RM 3.6.2).
    put!(flash.optcr(), word | 1 << 1);
    let _ = idle();
    put!(flash.optcr(), word | 1);
}
