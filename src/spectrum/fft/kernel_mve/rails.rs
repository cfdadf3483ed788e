//! Samples that touch a rail, eight at a time.

use crate::spectrum::fft::assembly::kernel;

/// Nonzero if a half of some word is outside `low..=high`, each of which is given in both halves.
///
/// # Safety
/// `from..to` must be groups of eight words, at least one.
#[unsafe(naked)]
pub unsafe extern "C" fn any_outside(from: *const u32, to: *const u32, low: u32, high: u32) -> u32 {
    kernel!(
        "push {{r7, lr}}",
        "sub r1, r1, r0",
        "lsr r1, r1, #5",
        // The largest and the smallest.
        "vdup.16 q0, r2",
        "vdup.16 q1, r3",
        "dls lr, r1",
        "2:",
        "vldrh.u16 q2, [r0], #16",
        "vldrh.u16 q3, [r0], #16",
        "vmax.s16 q0, q0, q2",
        "vmin.s16 q1, q1, q2",
        "vmax.s16 q0, q0, q3",
        "vmin.s16 q1, q1, q3",
        "le lr, 2b",
        "sxth r2, r2",
        "sxth r3, r3",
        "mov r0, r2",
        "mov r1, r3",
        "vmaxv.s16 r0, q0",
        "vminv.s16 r1, q1",
        "sxth r0, r0",
        "sxth r1, r1",
        "sub r3, r3, r0",
        "sub r1, r1, r2",
        "orr r0, r1, r3",
        "lsr r0, r0, #31",
        "pop {{r7, pc}}",
    )
}

/// The number of halves of words that are outside `low..=high`, each of which is given in both halves.
///
/// # Safety
/// `from..to` must be groups of eight words, at least one, and at most 2^16 words.
#[unsafe(naked)]
pub unsafe extern "C" fn all_outside(from: *const u32, to: *const u32, low: u32, high: u32) -> u32 {
    kernel!(
        "push {{r4, lr}}",
        "sub r1, r1, r0",
        "lsr r1, r1, #4",
        "vmov.i32 q0, #0",
        "mov r4, #1",
        "dls lr, r1",
        "2:",
        "vldrh.u16 q1, [r0], #16",
        "vpt.s16 gt, q1, r3",
        "vaddt.i16 q0, q0, r4",
        "vpt.s16 lt, q1, r2",
        "vaddt.i16 q0, q0, r4",
        "le lr, 2b",
        "vaddv.u16 r0, q0",
        "pop {{r4, pc}}",
    )
}
