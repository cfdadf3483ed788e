//! The first pass, which reads the record in digit-reversed order.

use super::{Pair, Point};
use crate::spectrum::fft::assembly::kernel;
use crate::spectrum::fft::integer::DIAGONAL;

/// The first pass in groups of eight: `integer::first8` for codes of at most 13 bits, M of at most 2048.
///
/// The kernel adds two codes at once, as `re + 2^16 im`: the sum of eight fits in 16 bits.
///
/// # Safety
/// `from` and `to` must be M pairs, aligned to words, and M points, M = 8 4^d.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn eights<const M: usize, const SHIFT: u32>(
    from: *const Pair,
    to: *mut Point,
) {
    // The transform of the four pairs from r7 on, M bytes apart: 0 in r3 and 2 in r4 as sums of
    // pairs, 1 in r6, r1, and 3 in r2, r0. A pair with its lower sign turned is such a sum plus
    // 2^15, so with four of them the sum is 2^17 too large.
    macro_rules! four {
        () => {
            "movs r6, #0x80
             lsls r6, r6, #8
             ldr r0, [r7]
             add r7, r8
             ldr r1, [r7]
             add r7, r8
             ldr r2, [r7]
             add r7, r8
             ldr r3, [r7]
             eors r0, r6
             eors r1, r6
             eors r2, r6
             eors r3, r6
             adds r4, r0, r2
             subs r0, r0, r2
             adds r2, r1, r3
             subs r1, r1, r3
             adds r3, r4, r2
             subs r4, r4, r2
             lsls r2, r6, #2
             subs r3, r3, r2
             sxth r2, r0
             subs r0, r0, r2
             asrs r0, r0, #16
             sxth r5, r1
             subs r1, r1, r5
             asrs r1, r1, #16
             adds r6, r2, r1
             subs r2, r2, r1
             subs r1, r0, r5
             adds r0, r0, r5
            "
        };
    }
    // Splits the sum of pairs in `$x` into its parts and shifts them up: the first goes to `$re`,
    // the second stays.
    macro_rules! parts {
        ($re:literal, $x:literal) => {
            concat!(
                "sxth ",
                $re,
                ", ",
                $x,
                "\n",
                "subs ",
                $x,
                ", ",
                $x,
                ", ",
                $re,
                "\n",
                "asrs ",
                $x,
                ", ",
                $x,
                ", #16-{shift}\n",
                "lsls ",
                $re,
                ", ",
                $re,
                ", #{shift}\n",
            )
        };
    }
    kernel!(
        "push {{r4-r7, lr}}",
        high_to_low!(),
        "push {{r4-r7}}",
        "sub sp, sp, #36",
        "movs r2, #{root}>>8",
        "lsls r2, r2, #8",
        "adds r2, r2, #{root}&255",
        "str r2, [sp, #24]",
        "movs r2, #{m}/32",
        "lsls r3, r2, #4",
        "lsls r2, r2, #5",
        "mov r8, r2",
        "mov r9, r0",
        "adds r0, r0, r3",
        "mov r10, r0",
        "mov r11, r1",
        "lsls r2, r2, #3",
        "adds r1, r1, r2",
        "mov r12, r1",
        "movs r0, #0",
        "mov lr, r0",
        "2:",
        "mov r7, r9",
        "add r7, lr",
        four!(),
        "lsls r6, r6, #{shift}",
        "lsls r1, r1, #{shift}",
        "lsls r2, r2, #{shift}",
        "lsls r0, r0, #{shift}",
        "str r3, [sp]",
        "str r4, [sp, #4]",
        "str r6, [sp, #8]",
        "str r1, [sp, #12]",
        "str r2, [sp, #16]",
        "str r0, [sp, #20]",
        "mov r7, r10",
        "add r7, lr",
        four!(),
        "str r3, [sp, #28]",
        "str r4, [sp, #32]",
        // An eighth of a turn.
        "ldr r5, [sp, #24]",
        "adds r7, r6, r1",
        "subs r1, r1, r6",
        "muls r7, r5, r7",
        "muls r1, r5, r1",
        "asrs r7, r7, #16-{shift}",
        "asrs r1, r1, #16-{shift}",
        "subs r6, r0, r2",
        "adds r0, r0, r2",
        "muls r6, r5, r6",
        "muls r0, r5, r0",
        "asrs r6, r6, #16-{shift}",
        "asrs r0, r0, #16-{shift}",
        "mov r3, r11",
        // 3 and 7.
        "ldr r2, [sp, #16]",
        "ldr r4, [sp, #20]",
        "adds r5, r2, r6",
        "subs r2, r2, r6",
        "subs r6, r4, r0",
        "adds r4, r4, r0",
        "str r5, [r3, #24]",
        "str r6, [r3, #28]",
        "str r2, [r3, #56]",
        "str r4, [r3, #60]",
        // 1 and 5.
        "ldr r0, [sp, #8]",
        "ldr r2, [sp, #12]",
        "adds r4, r0, r7",
        "subs r0, r0, r7",
        "adds r5, r2, r1",
        "subs r2, r2, r1",
        "str r4, [r3, #8]",
        "str r5, [r3, #12]",
        "str r0, [r3, #40]",
        "str r2, [r3, #44]",
        // 0 and 4.
        "ldr r0, [sp]",
        "ldr r1, [sp, #28]",
        "adds r2, r0, r1",
        "subs r0, r0, r1",
        parts!("r4", "r2"),
        "str r4, [r3]",
        "str r2, [r3, #4]",
        parts!("r4", "r0"),
        "str r4, [r3, #32]",
        "str r0, [r3, #36]",
        // 2 and 6.
        "ldr r0, [sp, #4]",
        "ldr r1, [sp, #32]",
        parts!("r4", "r0"),
        parts!("r5", "r1"),
        "adds r2, r4, r1",
        "subs r4, r4, r1",
        "subs r1, r0, r5",
        "adds r0, r0, r5",
        "str r2, [r3, #16]",
        "str r1, [r3, #20]",
        "str r4, [r3, #48]",
        "str r0, [r3, #52]",
        "adds r3, r3, #64",
        "mov r11, r3",
        // Increments the first digit, and carries into the next if it was three.
        "mov r0, lr",
        "mov r1, r8",
        "lsrs r1, r1, #3",
        "3:",
        "adds r0, r0, r1",
        "lsls r2, r1, #2",
        "tst r0, r2",
        "beq 4f",
        "subs r0, r0, r2",
        "lsrs r1, r1, #2",
        "b 3b",
        "4:",
        "mov lr, r0",
        "cmp r3, r12",
        "beq 5f",
        "b 2b",
        "5:",
        "add sp, sp, #36",
        "pop {{r4-r7}}",
        low_to_high!(),
        "pop {{r4-r7, pc}}",
        m = const M,
        shift = const SHIFT,
        root = const DIAGONAL,
    )
}
