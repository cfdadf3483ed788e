//! The option bytes, which only the image that is built for it writes.

use super::registers::flash;
use super::start::within;
use super::words::guard::LONGEST_MS;

/// Sets the brown-out level, once in the chip's life: the chip resets below 2.7 V, where flash can no longer be written by words. If the
/// power fails meanwhile, the option bytes may hold any value, even a read protection: the usual images leave them alone.
pub fn set() {
    const KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];
    let flash = flash();
    let idle = || within(LONGEST_MS, || !flash.sr().read().bsy().bit());
    // Level 3 has the code 0 (RM 3.8.5); the crate's names run the other way.
    if flash.optcr().read().bor_lev().bits() == 0 || !idle() {
        return;
    }
    KEYS.iter().for_each(|&key| {
        flash.optkeyr().write(|w| w.set(key));
    });
    // RM 3.6.2. Unlocked, OPTLOCK is clear.
    flash.optcr().modify(|_, w| w.bor_lev().set(0));
    flash.optcr().modify(|_, w| w.optstrt().set_());
    let _ = idle();
    flash.optcr().modify(|_, w| w.optstrt().clear_bit().optlock().set_());
}
