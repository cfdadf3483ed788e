//! Samples that touch a rail.

use crate::spectrum::fft::assembly::kernel;

/// The first group of 32 words in which the squares of a word's halves add up to `2^31 - room` or more; `to` if there is none. A record
/// with weak codes is found to be inside any rails beyond in a third of the time of comparing each code.
///
/// # Safety
/// `from..to` must be groups of 32 words, at least one. `room` must not be below 0.
#[cfg(not(mve))]
#[unsafe(naked)]
pub(super) unsafe extern "C" fn first_strong(
    from: *const u32,
    to: *const u32,
    room: i32,
) -> *const u32 {
    macro_rules! look {
        ($($x:literal),*) => {
            // A sum without room sets the flag Q, which stays.
            concat!("ldm r0!, {{r4-r11}}\n", $("smlad r12, ", $x, ", ", $x, ", r2\n",)*)
        };
    }
    kernel!(
        "push {{r4-r11, lr}}",
        "mov r12, #0",
        "msr apsr_nzcvq, r12",
        ".p2align 2",
        "2:",
        look!("r4", "r5", "r6", "r7", "r8", "r9", "r10", "r11"),
        look!("r4", "r5", "r6", "r7", "r8", "r9", "r10", "r11"),
        look!("r4", "r5", "r6", "r7", "r8", "r9", "r10", "r11"),
        look!("r4", "r5", "r6", "r7", "r8", "r9", "r10", "r11"),
        "mrs r12, apsr",
        "tst r12, #1<<27",
        "bne 3f",
        "cmp r0, r1",
        "blo 2b",
        "pop {{r4-r11, pc}}",
        "3:",
        "sub r0, r0, #128",
        "pop {{r4-r11, pc}}",
    )
}

/// The first group of eight words in which a word has a half outside `low..=high`, each of which is given in both halves; `to` if there is
/// none.
///
/// # Safety
/// `from..to` must be groups of eight words, at least one.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn first_outside(
    from: *const u32,
    to: *const u32,
    low: u32,
    high: u32,
) -> *const u32 {
    macro_rules! look {
        ($($x:literal),*) => {
            // The distance of a half above the lowest code, and the excess of this distance over the highest.
            concat!($(
                "usub16 ", $x, ", ", $x, ", r2\n uqsub16 ", $x, ", ", $x, ", r3\n orrs r12, r12, ", $x, "\n",
            )*)
        };
    }
    kernel!(
        "push {{r4-r11, lr}}",
        "mov r12, #0",
        "usub16 r3, r3, r2",
        ".p2align 2",
        "2:",
        "ldm r0!, {{r4-r11}}",
        look!("r4", "r5", "r6", "r7", "r8", "r9", "r10", "r11"),
        "bne 3f",
        "cmp r0, r1",
        "blo 2b",
        "pop {{r4-r11, pc}}",
        "3:",
        "sub r0, r0, #32",
        "pop {{r4-r11, pc}}",
    )
}

/// The number of halves of words that are outside `low..=high`, each of which is given in both halves.
///
/// # Safety
/// `from..to` must be groups of four words, at least one, and at most 2^16 words.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn all_outside(
    from: *const u32,
    to: *const u32,
    low: u32,
    high: u32,
) -> u32 {
    macro_rules! look {
        ($($x:literal),*) => {
            // The flags of a half that is inside choose 0.
            concat!($(
                "usub16 ", $x, ", ", $x, ", r2\n usub16 ", $x, ", r3, ", $x, "\n",
                "sel ", $x, ", lr, r8\n add r12, r12, ", $x, "\n",
            )*)
        };
    }
    kernel!(
        "push {{r4-r8, lr}}",
        "mov r12, #0",
        "mov lr, #0",
        "mov r8, #0x10001",
        "usub16 r3, r3, r2",
        ".p2align 2",
        "2:",
        "ldm r0!, {{r4-r7}}",
        look!("r4", "r5", "r6", "r7"),
        "cmp r0, r1",
        "blo 2b",
        // Each half has its own count.
        "uxth r0, r12",
        "add r0, r0, r12, lsr #16",
        "pop {{r4-r8, pc}}",
    )
}
