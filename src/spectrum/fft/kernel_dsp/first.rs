//! The first pass, which reads the record in digit-reversed order.

use super::{Pair, Point};
use crate::spectrum::fft::assembly::kernel;

/// Begins four groups, 4 h to 4 h + 3. Their first digits are the last digits of their place. Sets lr to the place of the first group.
///
/// r3 counts in its upper half, which [`widen`] ignores: h, and above it the group, in two bits that carry.
macro_rules! begin {
    () => {
        "rbit r5, r3
         ubfx r5, r5, #16-{digits}, #{digits}
         and r6, r5, #0x55555555
         add.w r5, r5, r6 // wide, so that the groups begin at a word
         add r5, r5, r6, lsl #1 // twice h with its digits in base 4 backwards
         add lr, r0, r5, lsl #1
         add r3, r3, #1<<16"
    };
}

/// Ends a group, which began at `3:`, and the four groups, which began at `2:`.
macro_rules! end {
    () => {
        "adds r3, r3, #1<<30
         bcc 3b
         tst r3, #{outer}<<16
         beq 2b"
    };
}

/// Stores the packed point in `$x` at `$at`, multiplied by the lower half of r3. Uses r7.
macro_rules! widen {
    ($x:literal, $at:literal) => {
        concat!(
            "smulbb r7, ",
            $x,
            ", r3\n smultb ",
            $x,
            ", ",
            $x,
            ", r3\n ",
            store!("r7", $x, "r1", $at),
        )
    };
}

/// The first pass in groups of eight: `integer::first8` for codes of at most 13 bits. `one` is 1 shifted up, by at most 14 bits, and `root`
/// is `integer::DIAGONAL` shifted up by equally many.
///
/// # Safety
/// `from` and `to` must be M pairs and M points, M = 8 4^d of at most 2048.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn eights<const M: usize>(
    from: *const Pair,
    to: *mut Point,
    root: i32,
    one: u32,
) {
    kernel!(
        "push {{r4-r11, lr}}",
        ".p2align 2",
        "2:",
        begin!(),
        "3:",
        "ldr r4, [lr]",
        "ldr r5, [lr, #{leg}]",
        "ldr r6, [lr, #2*{leg}]",
        "ldr r7, [lr, #3*{leg}]",
        "add r11, lr, #4*{leg}",
        "ldr r8, [r11]",
        "ldr r9, [r11, #{leg}]",
        "ldr r10, [r11, #2*{leg}]",
        "ldr r11, [r11, #3*{leg}]",
        "add lr, lr, #{leg}/4",
        "sadd16 r12, r4, r8",
        "ssub16 r8, r4, r8",
        "sadd16 r4, r6, r10",
        "ssub16 r10, r6, r10",
        "sadd16 r6, r12, r4",  // e0
        "ssub16 r12, r12, r4", // e2
        "ssax r4, r8, r10",    // e1
        "sasx r8, r8, r10",    // e3
        "sadd16 r10, r5, r9",
        "ssub16 r9, r5, r9",
        "sadd16 r5, r7, r11",
        "ssub16 r11, r7, r11",
        "sadd16 r7, r10, r5",  // o0
        "ssub16 r10, r10, r5", // o2
        "ssax r5, r9, r11",    // o1
        "sasx r9, r9, r11",    // o3
        "sadd16 r11, r6, r7",
        "ssub16 r6, r6, r7",
        widen!("r11", "0"),
        widen!("r6", "32"),
        "ssax r11, r12, r10",
        "sasx r10, r12, r10",
        widen!("r11", "16"),
        widen!("r10", "48"),
        // Points 1 and 5. The sum and the difference of an odd point's parts fit in 16 bits, because four of the eight codes are at most
        // 2^12 - 1. Where p is added to e, e - p is 2 e less this sum.
        "ssax r6, r5, r5",
        "smulbb r7, r4, r3",
        "smultb r4, r4, r3",
        "smlawb r10, r2, r6, r7",
        "smlawt r11, r2, r6, r4",
        store!("r10", "r11", "r1", "8"),
        "rsb r7, r10, r7, lsl #1",
        "rsb r4, r11, r4, lsl #1",
        store!("r7", "r4", "r1", "40"),
        // Points 3 and 7, of which the imaginary part has the other sign.
        "ssax r9, r9, r9",
        "smulbb r7, r8, r3",
        "smultb r8, r8, r3",
        "smlawt r10, r2, r9, r7",
        "smlawb r6, r2, r9, r8",
        "rsb r11, r6, r8, lsl #1",
        store!("r10", "r11", "r1", "24"),
        "rsb r5, r10, r7, lsl #1",
        store!("r5", "r6", "r1", "56"),
        "add r1, r1, #64",
        end!(),
        "pop {{r4-r11, pc}}",
        // No caller needs more than 2048 points, but the assembler sees such lengths.
        leg = const if M <= 2048 { M / 8 * 4 } else { 4 },
        outer = const M / 32,
        digits = const digits(M / 32),
    )
}

/// The first pass in groups of four: `integer::first4` for codes of at most 13 bits. `one` is 1 shifted up.
///
/// # Safety
/// `from` and `to` must be M pairs and M points, M = 4^d of at most 1024.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn fours<const M: usize>(from: *const Pair, to: *mut Point, one: u32) {
    kernel!(
        "push {{r4-r11, lr}}",
        "mov r3, r2",
        ".p2align 2",
        "2:",
        begin!(),
        "3:",
        "ldr r8, [lr]",
        "ldr r9, [lr, #{leg}]",
        "ldr r10, [lr, #2*{leg}]",
        "ldr r11, [lr, #3*{leg}]",
        "add lr, lr, #{leg}/4",
        "sadd16 r12, r8, r10",
        "ssub16 r10, r8, r10",
        "sadd16 r8, r9, r11",
        "ssub16 r11, r9, r11",
        "sadd16 r9, r12, r8",
        "ssub16 r12, r12, r8",
        "ssax r8, r10, r11",
        "sasx r10, r10, r11",
        widen!("r9", "0"),
        widen!("r8", "8"),
        widen!("r12", "16"),
        widen!("r10", "24"),
        "add r1, r1, #32",
        end!(),
        "pop {{r4-r11, pc}}",
        leg = const if M <= 1024 { M / 4 * 4 } else { 4 },
        outer = const M / 16,
        digits = const digits(M / 16),
    )
}

/// Bits of a counter below `count`, a power of two; at least one, because a field has a width.
const fn digits(count: usize) -> u32 {
    let digits = count.trailing_zeros();
    if digits > 0 { digits } else { 1 }
}
