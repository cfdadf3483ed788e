//! The later passes, of radix 4.

use super::{Point, Triple};
use crate::spectrum::fft::assembly::kernel;

/// `integer::turn` of r0, r1 by the factor at `$at` and the next four bytes above the stack
/// pointer, to r4, r5. Uses r0 to r6.
macro_rules! turn {
    ($at:literal) => {
        concat!("ldr r2, [sp, #", $at, "]\n ldr r3, [sp, #", $at, "+4]\n", turn!())
    };
    // By the factor in r2, r3.
    () => {
        "uxth r5, r0
         asrs r0, r0, #16
         movs r4, r5
         muls r4, r2, r4
         muls r5, r3, r5
         asrs r4, r4, #16
         asrs r5, r5, #16
         movs r6, r0
         muls r6, r2, r6
         muls r0, r3, r0
         adds r4, r4, r6
         adds r5, r5, r0
         uxth r0, r1
         asrs r1, r1, #16
         movs r6, r0
         muls r6, r2, r6
         muls r0, r3, r0
         asrs r6, r6, #16
         asrs r0, r0, #16
         adds r5, r5, r6
         subs r4, r4, r0
         muls r2, r1, r2
         muls r1, r3, r1
         adds r5, r5, r2
         subs r4, r4, r1
        "
    };
}

/// A radix-4 pass over sub-transforms with legs of `leg` bytes. The outer loop takes one factor
/// after the other, the inner loop all blocks.
///
/// # Safety
/// `points..end` must be whole blocks of four legs, `table` the factors of a leg, `stride` bytes
/// apart.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn pass(
    points: *mut Point,
    end: *mut Point,
    leg: usize,
    table: *const Triple,
    stride: usize,
) {
    // r7 points to the fourth leg's point. r12 holds two legs minus two points, lr a leg minus a
    // point. The sum of legs two and four, in r4, r5 and in r0, r1 or r8, r9, goes to r8, r9, their
    // difference to r10, r11.
    macro_rules! outer {
        () => {
            "adds r2, r4, r0
             subs r4, r4, r0
             adds r3, r5, r1
             subs r5, r5, r1
             mov r8, r2
             mov r9, r3
             mov r10, r4
             mov r11, r5
            "
        };
    }
    // The rest, with the third leg in r4, r5 and the first at r7. The last store leaves r7 at the
    // next block's fourth leg.
    macro_rules! inner {
        () => {
            "ldm r7!, {{r0, r1}}
             subs r7, r7, #8
             asrs r0, r0, #1
             asrs r1, r1, #1
             adds r2, r0, r4
             subs r0, r0, r4
             adds r3, r1, r5
             subs r1, r1, r5
             mov r4, r8
             adds r5, r2, r4
             subs r2, r2, r4
             mov r4, r9
             adds r6, r3, r4
             subs r3, r3, r4
             stm r7!, {{r5, r6}}
             add r7, lr
             mov r4, r10
             mov r5, r11
             subs r6, r1, r4
             adds r4, r1, r4
             adds r1, r0, r5
             subs r0, r0, r5
             stm r7!, {{r1, r6}}
             add r7, lr
             stm r7!, {{r2, r3}}
             add r7, lr
             stm r7!, {{r0, r4}}
             ldr r0, [sp, #24]
             adds r7, r7, r0
             ldr r0, [sp, #28]
             cmp r7, r0
            "
        };
    }
    kernel!(
        "push {{r4-r7, lr}}",
        high_to_low!(),
        "push {{r4-r7}}",
        // The stack: three factors; four legs minus a point; the end; the first block's next point
        // and its last; the factors and their stride.
        "sub sp, sp, #52",
        "lsls r4, r2, #2",
        "adds r5, r0, r4",
        "subs r4, r4, #8",
        "str r4, [sp, #24]",
        "str r1, [sp, #28]",
        "str r5, [sp, #36]",
        "ldr r4, [sp, #52+36]",
        "str r4, [sp, #44]",
        "adds r3, r3, r4",
        "str r3, [sp, #40]",
        "subs r7, r5, r2",
        "movs r4, #8",
        "adds r5, r7, r4",
        "str r5, [sp, #32]",
        "subs r5, r2, r4",
        "mov lr, r5",
        "lsls r5, r2, #1",
        "adds r5, r5, r4",
        "rsbs r5, r5, #0",
        "mov r12, r5",
        // The factor 1.
        "2:",
        "ldm r7!, {{r0, r1}}",
        "add r7, r12",
        "ldm r7!, {{r4, r5}}",
        "add r7, lr",
        "asrs r0, r0, #1",
        "asrs r1, r1, #1",
        "asrs r4, r4, #1",
        "asrs r5, r5, #1",
        outer!(),
        "ldm r7!, {{r4, r5}}",
        "add r7, r12",
        "asrs r4, r4, #1",
        "asrs r5, r5, #1",
        inner!(),
        "blo 2b",
        // The other factors.
        "b 5f",
        "3:",
        "movs r0, r7",
        "adds r0, r0, #8",
        "str r0, [sp, #32]",
        "ldr r3, [sp, #40]",
        "ldr r4, [sp, #44]",
        "adds r4, r3, r4",
        "str r4, [sp, #40]",
        "ldm r3!, {{r0, r1, r2}}",
        "mov r3, sp",
        "sxth r4, r0",
        "asrs r5, r0, #16",
        "stm r3!, {{r4, r5}}",
        "sxth r4, r1",
        "asrs r5, r1, #16",
        "stm r3!, {{r4, r5}}",
        "sxth r4, r2",
        "asrs r5, r2, #16",
        "stm r3!, {{r4, r5}}",
        "4:",
        "ldm r7!, {{r0, r1}}",
        "add r7, r12",
        turn!(16),
        "mov r8, r4",
        "mov r9, r5",
        "ldm r7!, {{r0, r1}}",
        "add r7, lr",
        turn!(0),
        "mov r0, r8",
        "mov r1, r9",
        outer!(),
        "ldm r7!, {{r0, r1}}",
        "add r7, r12",
        turn!(8),
        inner!(),
        // The loop is longer than a conditional branch reaches.
        "bhs 5f",
        "b 4b",
        "5:",
        "ldr r7, [sp, #32]",
        "ldr r0, [sp, #36]",
        "cmp r7, r0",
        "beq 6f",
        "b 3b",
        "6:",
        "add sp, sp, #52",
        "pop {{r4-r7}}",
        low_to_high!(),
        "pop {{r4-r7, pc}}",
    )
}
