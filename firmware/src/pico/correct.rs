//! The codes of a block, moved by the table of [`widths`](super::widths): 6 cycles a code. The compiler's own code takes half as long
//! again, since it checks each index of the table.

use super::N;
use super::widths::MOVES;
use core::arch::naked_asm;

/// Corrects codes, two in a word.
pub fn correct(pairs: &mut [u32; N / 2]) {
    let end = pairs.as_mut_ptr_range().end;
    // SAFETY: the converter's codes have 12 bits (DS 4.9.6), and the table has an entry for each.
    unsafe { move_codes(pairs.as_mut_ptr(), &raw const MOVES, end) };
}

/// Adds to each code its entry of the table: four words at a time.
///
/// # Safety
/// From the first to the last address are words, a multiple of four, with codes of 12 bits.
// SAFETY: the function reads and writes the memory that the caller names, and restores the registers that it must.
#[unsafe(naked)]
unsafe extern "C" fn move_codes(pairs: *mut u32, moves: *const [i8; 4096], end: *mut u32) {
    naked_asm!(
        "push {{r4-r7, lr}}",
        "mov r12, r2",
        "1: ldmia r0!, {{r2-r5}}",
        // A move is added with its sign: the sum of the lower half keeps within it.
        "uxth r6, r2",
        "lsrs r7, r2, #16",
        "ldrsb r6, [r1, r6]",
        "ldrsb r7, [r1, r7]",
        "lsls r7, r7, #16",
        "adds r2, r2, r6",
        "adds r2, r2, r7",
        "uxth r6, r3",
        "lsrs r7, r3, #16",
        "ldrsb r6, [r1, r6]",
        "ldrsb r7, [r1, r7]",
        "lsls r7, r7, #16",
        "adds r3, r3, r6",
        "adds r3, r3, r7",
        "uxth r6, r4",
        "lsrs r7, r4, #16",
        "ldrsb r6, [r1, r6]",
        "ldrsb r7, [r1, r7]",
        "lsls r7, r7, #16",
        "adds r4, r4, r6",
        "adds r4, r4, r7",
        "uxth r6, r5",
        "lsrs r7, r5, #16",
        "ldrsb r6, [r1, r6]",
        "ldrsb r7, [r1, r7]",
        "lsls r7, r7, #16",
        "adds r5, r5, r6",
        "adds r5, r5, r7",
        "subs r0, #16",
        "stmia r0!, {{r2-r5}}",
        "cmp r0, r12",
        "blo 1b",
        "pop {{r4-r7, pc}}",
    )
}
