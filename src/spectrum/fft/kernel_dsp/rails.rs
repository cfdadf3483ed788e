//! Samples that touch a rail.

use crate::spectrum::fft::assembly::kernel;

/// The first group of 16 words of which a word's halves have squares that add up to `-less` or more; `to` if there is none.
/// Codes of a record that is weak enough are seen to be inside any rails beyond, in half the time of a look at each.
///
/// # Safety
/// `from..to` must be groups of 16 words, at least one. `less` must be below 0.
#[cfg(feature = "methods")]
#[unsafe(naked)]
pub(super) unsafe extern "C" fn first_strong(
    from: *const u32,
    to: *const u32,
    less: i32,
) -> *const u32 {
    macro_rules! look {
        ($($x:literal),*) => {
            // No sum overflows: the squares of -32768 add up to 2^31. The sign bit shows the outcome.
            concat!($("smlad ", $x, ", ", $x, ", ", $x, ", r2\n and r12, r12, ", $x, "\n",)*)
        };
    }
    kernel!(
        "push {{r4-r11, lr}}",
        "mov r12, #-1",
        "2:",
        "ldm r0!, {{r4-r11}}",
        look!("r4", "r5", "r6", "r7", "r8", "r9", "r10", "r11"),
        "ldm r0!, {{r4-r11}}",
        look!("r4", "r5", "r6", "r7", "r8", "r9", "r10", "r11"),
        "cmp r12, #0",
        "bpl 3f",
        "cmp r0, r1",
        "blo 2b",
        "pop {{r4-r11, pc}}",
        "3:",
        "sub r0, r0, #64",
        "pop {{r4-r11, pc}}",
    )
}

/// Nonzero if a half of some word is outside `low..=high`, each of which is given in both halves.
///
/// # Safety
/// `from..to` must be groups of eight words, at least one.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn any_outside(
    from: *const u32,
    to: *const u32,
    low: u32,
    high: u32,
) -> u32 {
    macro_rules! look {
        ($($x:literal, $y:literal);*) => {
            concat!($(
                // The larger of each half goes to lr, the smaller to the other register.
                "ssub16 lr, ", $x, ", ", $y, "\n sel lr, ", $x, ", ", $y, "\n sel ", $x, ", ", $y, ", ", $x, "\n",
                // The sign bit shows it.
                "qsub16 lr, r3, lr\n orr r12, r12, lr\n qsub16 lr, ", $x, ", r2\n orr r12, r12, lr\n",
            )*)
        };
    }
    kernel!(
        "push {{r4-r11, lr}}",
        "mov r12, #0",
        "2:",
        "ldm r0!, {{r4-r11}}",
        look!("r4", "r5"; "r6", "r7"; "r8", "r9"; "r10", "r11"),
        "cmp r0, r1",
        "blo 2b",
        "and r0, r12, #0x80008000",
        "pop {{r4-r11, pc}}",
    )
}

/// How many halves of words are outside `low..=high`, each of which is given in both halves.
///
/// # Safety
/// `from..to` must be pairs of words, at least one, and at most 2^16 words.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn all_outside(
    from: *const u32,
    to: *const u32,
    low: u32,
    high: u32,
) -> u32 {
    macro_rules! look {
        ($($x:literal),*) => {
            concat!($(
                "qsub16 lr, ", $x, ", r2\n qsub16 ", $x, ", r3, ", $x, "\n orr lr, lr, ", $x, "\n",
                "and lr, lr, #0x80008000\n add r12, r12, lr, lsr #15\n",
            )*)
        };
    }
    kernel!(
        "push {{r4, r5, lr}}",
        "mov r12, #0",
        "2:",
        "ldm r0!, {{r4, r5}}",
        look!("r4", "r5"),
        "cmp r0, r1",
        "blo 2b",
        // Each half has its own count.
        "uxth r0, r12",
        "add r0, r0, r12, lsr #16",
        "pop {{r4, r5, pc}}",
    )
}
