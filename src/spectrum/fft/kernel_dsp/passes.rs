//! The later passes, of radix 4.

use super::{FineTriple, Point, Triple};
use crate::spectrum::fft::assembly::kernel;

/// A load or store of a leg's point.
macro_rules! leg {
    ($do:literal, $x:literal, $y:literal, $leg:literal) => {
        concat!($do, " ", $x, ", ", $y, ", [r0, #", $leg, "*8*{l}]\n")
    };
}

/// Ends a butterfly, and advances to the next block with the last store.
macro_rules! finish {
    () => {
        concat!(
            leg!("ldrd", "r7", "lr", 0),
            sum_all_legs!(),
            store!("r8", "r6", "r0", "8*{l}"),
            store!("r11", "r7", "r0", "16*{l}"),
            store!("r10", "r9", "r0", "24*{l}"),
            // Beyond the reach of a STR that advances.
            "strd lr, r5, [r0], #32*{l}\n",
        )
    };
}

/// The butterflies of all blocks with factors of 1; advances r0 from the first to the end.
macro_rules! plain_blocks {
    () => {
        concat!(
            ".p2align 2\n 2:\n",
            plain_legs!(
                leg!("ldrd", "r7", "r9", 1),
                leg!("ldrd", "r10", "r11", 3),
                leg!("ldrd", "r10", "r9", 2)
            ),
            finish!(),
            "cmp r0, r1\n blo 2b\n",
        )
    };
}

/// A radix-4 pass over sub-transforms of L points. The outer loop takes one factor after the other,
/// the inner loop all blocks, of which there are at least four.
///
/// # Safety
/// `points..end` must be whole pairs of blocks of 4 L points, `table` the factors, `stride` bytes
/// apart.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn short<const L: usize>(
    points: *mut Point,
    end: *mut Point,
    table: *const Triple,
    stride: usize,
) {
    kernel!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #16",
        "add r4, r0, #8",
        "add r5, r0, #8*{l}",
        "add r2, r2, r3",
        "strd r4, r5, [sp]",    // the next point of a leg, and the leg's end
        "strd r2, r3, [sp, #8]", // its factors, and the stride
        plain_blocks!(),
        "3:",
        "ldr r0, [sp]",
        "ldrd r5, r6, [sp, #8]",
        "ldm r5, {{r2, r3, r4}}",
        "add r5, r5, r6",
        "str r5, [sp, #8]",
        "add r5, r0, #8",
        "str r5, [sp]",
        ".p2align 2",
        "4:",
        outer_legs!(leg!("ldrd", "r5", "r6", 1), "r2", leg!("ldrd", "r5", "r7", 3), "r4"),
        middle_leg!(leg!("ldrd", "r7", "r9", 2), "r3", "r11"),
        finish!(),
        "cmp r0, r1",
        "blo 4b",
        "ldrd r4, r5, [sp]",
        "cmp r4, r5",
        "blo 3b",
        "add sp, sp, #16",
        "pop {{r4-r11, pc}}",
        l = const L,
    )
}

/// [`short`] with factors of 32 bits. Three of a triple's six numbers are in registers, the others on the stack.
///
/// # Safety
/// The conditions of [`short`].
#[unsafe(naked)]
pub(super) unsafe extern "C" fn short_finely<const L: usize>(
    points: *mut Point,
    end: *mut Point,
    table: *const FineTriple,
    stride: usize,
) {
    kernel!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #28",
        "add r4, r0, #8",
        "add r5, r0, #8*{l}",
        "add r2, r2, r3",
        "strd r4, r5, [sp]",    // the next point of a leg, and the leg's end
        "strd r2, r3, [sp, #8]", // its factors, and the stride
        plain_blocks!(),
        "3:",
        "ldr r0, [sp]",
        "ldrd r5, r6, [sp, #8]",
        "ldrd r8, r9, [r5]",
        "ldrd r4, r7, [r5, #8]",
        "ldrd r2, r3, [r5, #16]",
        "strd r8, r9, [sp, #16]",
        "str r7, [sp, #24]",
        "add r5, r5, r6",
        "str r5, [sp, #8]",
        "add r5, r0, #8",
        "str r5, [sp]",
        ".p2align 2",
        "4:",
        leg!("ldrd", "r5", "r7", 1),
        "ldrd r8, r9, [sp, #16]",
        turn_finely!("r12", "r6", "r5", "r7", "r8", "r9"),
        leg!("ldrd", "r5", "r7", 3),
        turn_finely!("r10", "r11", "r5", "r7", "r2", "r3"),
        sum_outer_legs!("r10", "r11"),
        leg!("ldrd", "r7", "r11", 2),
        "ldr lr, [sp, #24]",
        turn_finely!("r10", "r9", "r7", "r11", "r4", "lr"),
        finish!(),
        "cmp r0, r1",
        "blo 4b",
        "ldrd r4, r5, [sp]",
        "cmp r4, r5",
        "blo 3b",
        "add sp, sp, #28",
        "pop {{r4-r11, pc}}",
        l = const L,
    )
}

/// A radix-4 pass over one block with legs of `leg` bytes, 64 or more, and every `STRIDE`-th factor.
///
/// # Safety
/// `block` must be the four legs, `table` the factors of a block's number of points.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn long<const STRIDE: usize>(
    block: *mut Point,
    leg: usize,
    table: *const Triple,
) {
    macro_rules! turned {
        () => {
            concat!(
                outer_legs!(
                    "ldr lr, [r4, #-4]\n ldrd r5, r6, [r1]\n",
                    "lr",
                    "ldr lr, [r4, #4]\n ldrd r5, r7, [r3]\n",
                    "lr"
                ),
                middle_leg!("ldr lr, [r4], #12*{stride}\n ldrd r7, r9, [r2]\n", "lr", "r11"),
                "ldrd r7, lr, [r0]\n",
                sum_all_legs!(),
                store_to_legs!(),
            )
        };
    }
    kernel!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #4",
        "add r4, r2, #12*{stride}+4",
        "add r3, r0, r1",
        "str r3, [sp]",
        "add r2, r3, r1",
        "add r1, r2, r1",
        // r3, r2, r1 are legs 1, 2, 3; this instruction sequence puts them in order.
        "mov r5, r1",
        "mov r1, r3",
        "mov r3, r5",
        plain_of_legs!(),
        turned!(),
        ".p2align 2",
        "2:",
        turned!(),
        turned!(),
        "ldr r5, [sp]",
        "cmp r0, r5",
        "blo 2b",
        "add sp, sp, #4",
        "pop {{r4-r11, pc}}",
        stride = const STRIDE,
    )
}

/// [`long`] with factors of 32 bits, which lie `stride` bytes apart; legs of 128 bytes or more.
///
/// # Safety
/// `block` must be the four legs, `table` the factors of a block's number of points.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn fine(
    block: *mut Point,
    leg: usize,
    table: *const FineTriple,
    stride: usize,
) {
    macro_rules! turned {
        () => {
            concat!(
                "ldrd r5, r7, [r1]\n ldrd r8, r9, [r4]\n",
                turn_finely!("r12", "r6", "r5", "r7", "r8", "r9"),
                "ldrd r5, r7, [r3]\n ldrd r8, r9, [r4, #16]\n",
                turn_finely!("r10", "r11", "r5", "r7", "r8", "r9"),
                sum_outer_legs!("r10", "r11"),
                "ldrd r7, r11, [r2]\n ldr lr, [r4, #8]\n",
                "smmul r10, r7, lr\n smmul r9, r11, lr\n",
                "ldr lr, [r4, #12]\n",
                "smmla r10, r11, lr, r10\n smmls r9, r7, lr, r9\n",
                "ldrd r7, lr, [r0]\n",
                sum_all_legs!(),
                store_to_legs!(),
                "ldr r5, [sp, #4]\n add r4, r4, r5\n",
            )
        };
    }
    kernel!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #12",
        "add r4, r2, r3",
        "str r3, [sp, #4]",
        "add r5, r0, r1",
        "str r5, [sp]",
        "add r2, r5, r1",
        "add r3, r2, r1",
        "mov r1, r5",
        plain_of_legs!(),
        turned!(),
        ".p2align 2",
        "2:",
        turned!(),
        turned!(),
        "ldr r5, [sp]",
        "cmp r0, r5",
        "blo 2b",
        "add sp, sp, #12",
        "pop {{r4-r11, pc}}",
    )
}

/// [`long`] for legs of 32 points, which one pointer reaches, so registers are free to load a triple at once.
///
/// # Safety
/// `block` must be 128 points, `table` the factors of 128 `STRIDE` points.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn near<const STRIDE: usize>(block: *mut Point, table: *const Triple) {
    kernel!(
        "push {{r4-r11, lr}}",
        "add r2, r1, #12*{stride}",
        "add r1, r0, #256",
        plain_legs!(
            "ldrd r7, r9, [r0, #256]\n",
            "ldrd r10, r11, [r0, #768]\n",
            "ldrd r10, r9, [r0, #512]\n"
        ),
        "b 3f",
        ".p2align 2",
        "2:",
        "ldm r2, {{r3, r4, lr}}",
        "add r2, r2, #12*{stride}",
        outer_legs!("ldrd r5, r6, [r0, #256]\n", "r3", "ldrd r5, r7, [r0, #768]\n", "lr"),
        middle_leg!("ldrd r7, r9, [r0, #512]\n", "r4", "r11"),
        "3:",
        "ldrd r7, lr, [r0]",
        sum_all_legs!(),
        store!("r8", "r6", "r0", "256"),
        store!("r11", "r7", "r0", "512"),
        store!("r10", "r9", "r0", "768"),
        store_and_go!("lr", "r5", "r0"),
        "cmp r0, r1",
        "blo 2b",
        "pop {{r4-r11, pc}}",
        stride = const STRIDE,
    )
}

/// [`long`] with every factor, for legs of 128 points, which one pointer reaches.
///
/// # Safety
/// `block` must be 512 points, `table` the factors of 512 points.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn even(block: *mut Point, table: *const Triple) {
    kernel!(
        "push {{r4-r11, lr}}",
        "add r2, r1, #12",
        "add r1, r0, #1024",
        plain_legs!(
            load!("r7", "r9", "r0", "1024"),
            load!("r10", "r11", "r0", "3072"),
            load!("r10", "r9", "r0", "2048")
        ),
        "b 3f",
        ".p2align 2",
        "2:",
        "ldm r2!, {{r4, r11, lr}}",
        outer_legs!(load!("r5", "r6", "r0", "1024"), "r4", load!("r5", "r7", "r0", "3072"), "lr"),
        middle_leg!(load!("r7", "r9", "r0", "2048"), "r11", "r4"),
        "3:",
        "ldrd r7, lr, [r0]",
        sum_all_legs!(),
        store!("r8", "r6", "r0", "1024"),
        store!("r11", "r7", "r0", "2048"),
        store!("r10", "r9", "r0", "3072"),
        store_and_go!("lr", "r5", "r0"),
        "cmp r0, r1",
        "blo 2b",
        "pop {{r4-r11, pc}}",
    )
}
