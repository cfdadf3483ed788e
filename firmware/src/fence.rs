//! A fence at the end of the stack: memory without access. A stack that outgrows its room ends there by a fault, which the next boot record
//! reports, and changes no variable below.

use cortex_m::asm::{dsb, isb};
use cortex_m::peripheral::MPU;

/// The fence's size, bytes, a power of two: the smallest region of Armv6-M. `memory.x` leaves the room, just below the stack's end.
const SIZE: u32 = 256;
/// MPU_RASR (Armv7-M ARM, B3.5.9): ENABLE 0, SIZE 5:1, of 2^(SIZE + 1) bytes, AP 26:24 = 0 no access, XN 28.
const CLOSED: u32 = 1 | (SIZE.ilog2() - 1) << 1 | 1 << 28;
/// MPU_CTRL: ENABLE 0, PRIVDEFENA 2: memory outside of the regions keeps its default access. HFNMIENA 1 is 0: the fence does not apply to
/// the handler of the fault.
const ON: u32 = 1 | 1 << 2;

/// The end of the stack.
pub fn end() -> usize {
    unsafe extern "C" {
        static _stack_end: u32;
    }
    &raw const _stack_end as usize
}

/// Raises the fence.
pub fn raise() {
    // VALID 4 and REGION 3:0 = 0.
    let base = (end() as u32).wrapping_sub(SIZE) | 1 << 4;
    // SAFETY: the core has these registers, which nothing else writes, and no program uses memory in the region.
    unsafe {
        let mpu = &*MPU::PTR;
        mpu.rbar.write(base);
        mpu.rasr.write(CLOSED);
        mpu.ctrl.write(ON);
    }
    dsb();
    isb();
}
