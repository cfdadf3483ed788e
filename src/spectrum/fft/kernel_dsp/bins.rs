//! The loops that read a real record's points: the search and the bins around a peak.
//!
//! A branch to a wide instruction across two words takes an extra cycle (Cortex-M4 TRM, 3.3.1), so loops begin at a word.

use super::{Packed, Point};
use crate::spectrum::fft::assembly::{kernel, worth};

/// The state of the search, as [`pairs_outwards`] keeps it.
#[repr(C)]
pub(super) struct Seen {
    pub best: u64,
    pub total: u64,
    pub at: *const Point,
}

/// Adds the powers of the pairs of points beside the middle to `seen`, outwards to the point after `end` and its mirror. Splits the pairs
/// that may hold the strongest bin and keeps that bin, of equals the lowest (see [`crate::spectrum::scan`] for the bound).
///
/// # Safety
/// There must be points from `end` to `middle`, and equally many from there on. `factors` must be the factor of the pair nearest the
/// middle; the factors of the other pairs must lie before it.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn pairs_outwards(
    seen: &mut Seen,
    end: *const Point,
    middle: *const Point,
    factors: *const Packed,
) {
    kernel!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #24",
        "ldm r0, {{r4, r5, r10, r11, r12}}", // best, total, at
        "strd r0, r12, [sp]",
        "strd r4, r5, [sp, #8]",
        // r1: the end; r0: towards it; r2: away from it; r3 and half of r0: a factor.
        "sub r0, r2, #8",
        "add r2, r2, #8",
        "sub r3, r3, r0, lsr #1",
        "b 8f",
        ".p2align 2",
        "2:",
        "ldrd r4, r5, [r0], #-8",
        "ldrd r6, r7, [r2], #8",
        "smull r12, lr, r4, r4",
        "smlal r12, lr, r5, r5",
        "smlal r12, lr, r6, r6",
        "smlal r12, lr, r7, r7",
        "adds r10, r10, r12",
        "adc r11, r11, lr",
        "cmp r12, r8",
        "sbcs r12, lr, r9",
        "bhs 4f",
        "3:",
        "cmp r0, r1",
        "bhi 2b",
        "ldrd r0, r12, [sp]",
        "ldrd r8, r9, [sp, #8]",
        "stm r0, {{r8, r9, r10, r11, r12}}",
        "add sp, sp, #24",
        "pop {{r4-r11, pc}}",
        // A pair that may hold the strongest bin is split out of line.
        "4:",
        "add r12, r3, r0, lsr #1",
        "ldr lr, [r12, #4]",
        "ldrd r8, r9, [sp, #8]",
        "add r12, r4, r6",
        "sub r4, r4, r6",
        "sub r6, r5, r7",
        "add r5, r5, r7",
        "smulwt r7, r4, lr",
        "smulwb r4, r4, lr",
        "smlawt r4, r5, lr, r4",
        "smulwb r5, r5, lr",
        "sub r7, r7, r5",
        "add r5, r7, r12, asr #1",
        "rsb r7, r7, r12, asr #1",
        "add r12, r4, r6, asr #1",
        "sub r4, r4, r6, asr #1",
        // The power of the lower bin, which wins a tie against any bin above it.
        "smull r6, lr, r5, r5",
        "smlal r6, lr, r12, r12",
        "cmp r6, r8",
        "sbcs r5, lr, r9",
        "bhs 6f",
        // The power of the upper bin, which wins only if it is stronger than all below it.
        "smull r5, r6, r7, r7",
        "smlal r5, r6, r4, r4",
        "cmp r8, r5",
        "sbcs r7, r9, r6",
        "blo 7f",
        "ldrd r8, r9, [sp, #16]",
        "b 3b",
        "6:",
        "mov r8, r6",
        "mov r9, lr",
        "strd r8, r9, [sp, #8]",
        "add r5, r0, #8",
        "str r5, [sp, #4]",
        "smull r5, r6, r7, r7",
        "smlal r5, r6, r4, r4",
        "cmp r8, r5",
        "sbcs r7, r9, r6",
        "bhs 8f",
        "7:",
        "strd r5, r6, [sp, #8]",
        "sub r5, r2, #8",
        "str r5, [sp, #4]",
        // From the strongest bin.
        "8:",
        "ldrd r8, r9, [sp, #8]",
        worth!(),
        "strd r8, r9, [sp, #16]",
        "b 3b",
    )
}

/// Defines a search of bins in ascending order, each split by itself as the search above splits a pair. `$lower` and `$upper` load the
/// point below the middle and the point above it, `$factor` the factor; `$re` and `$im` make the bin from the even part in lr, r6 and the
/// odd part in r7, r4.
#[cfg(not(mve))]
macro_rules! alone {
    ($(#[$doc:meta])* $name:ident, $lower:literal, $upper:literal, $factor:literal, $re:literal, $im:literal) => {
        $(#[$doc])*
        #[unsafe(naked)]
        pub(super) unsafe extern "C" fn $name(
            seen: &mut Seen,
            here: *const Point,
            there: *const Point,
            factors: *const Packed,
            end: *const Point,
        ) {
            kernel!(
                "push {{r0, r4-r11, lr}}",
                "ldrd r8, r9, [r0]",
                "ldrd r10, r11, [r0, #8]",
                "mov r0, r1",
                "mov r1, r2",
                "mov r2, r3",
                "ldr r3, [sp, #40]",
                ".p2align 2",
                "2:",
                $lower, // r4, r5
                $upper, // r6, r7
                $factor, // r12
                "add lr, r4, r6",
                "sub r4, r4, r6",
                "sub r6, r5, r7",
                "add r5, r5, r7",
                "smulwt r7, r4, r12",
                "smulwb r4, r4, r12",
                "smlawt r4, r5, r12, r4",
                "smulwb r5, r5, r12",
                "sub r7, r7, r5",
                $re, // r5
                $im, // r12
                "smull r6, lr, r5, r5",
                "smlal r6, lr, r12, r12",
                "adds r10, r10, r6",
                "adc r11, r11, lr",
                "cmp r8, r6",
                "sbcs r5, r9, lr",
                "blo 4f",
                "3:",
                "cmp r0, r3",
                "bne 2b",
                "ldr r0, [sp], #4",
                "strd r8, r9, [r0]",
                "strd r10, r11, [r0, #8]",
                "pop {{r4-r11, pc}}",
                // The strongest so far.
                "4:",
                "mov r8, r6",
                "mov r9, lr",
                "ldr r5, [sp]",
                "str r0, [r5, #16]",
                "b 3b",
            )
        }
    };
}

#[cfg(not(mve))]
alone! {
    /// Adds the powers of bins below the middle to `seen` and keeps the strongest, of equals the lowest, by the place after it.
    ///
    /// # Safety
    /// For each point in `here..end` there must be one from `there` downwards, and a factor from `factors` upwards. There must be at least
    /// one.
    alone_below, "ldrd r4, r5, [r0], #8", "ldrd r6, r7, [r1], #-8", "ldr r12, [r2], #4",
    "add r5, r7, lr, asr #1", "add r12, r4, r6, asr #1"
}

#[cfg(not(mve))]
alone! {
    /// [`alone_below`] for bins above the middle.
    ///
    /// # Safety
    /// The conditions of [`alone_below`], but with the factors from `factors` downwards.
    alone_above, "ldrd r4, r5, [r1], #-8", "ldrd r6, r7, [r0], #8", "ldr r12, [r2], #-4",
    "rsb r5, r7, lr, asr #1", "sub r12, r4, r6, asr #1"
}

/// The two halves of `integer::split_pair` up to its last sums. From the point $p in r5, r6 and its mirror $q in r7, r8 the macro makes re
/// in r8, im in r5, and twice the even part in r9, r7.
macro_rules! split_pair {
    () => {
        "add r9, r5, r7
         sub r5, r5, r7
         sub r7, r6, r8
         add r6, r6, r8
         smulwt r8, r5, r10
         smulwb r5, r5, r10
         smlawt r5, r6, r10, r5
         smulwb r6, r6, r10
         sub r8, r8, r6"
    };
}

/// Bins below the middle, in ascending order.
///
/// # Safety
/// For each bin in `to..end` there must be a point from `here` upwards, one from `there` downwards,
/// and a factor from `factors` upwards. There must be at least one bin.
#[unsafe(naked)]
pub unsafe extern "C" fn span_below(
    here: *const Point,
    there: *const Point,
    factors: *const Packed,
    to: *mut Point,
    end: *mut Point,
) {
    kernel!(
        "ldr r12, [sp]",
        "push {{r4-r10, lr}}",
        ".p2align 2",
        "2:",
        "ldrd r5, r6, [r0], #8",
        "ldrd r7, r8, [r1], #-8",
        "ldr r10, [r2], #4",
        split_pair!(),
        "add r8, r8, r9, asr #1",
        "add r5, r5, r7, asr #1",
        store_and_go!("r8", "r5", "r3"),
        "cmp r3, r12",
        "blo 2b",
        "pop {{r4-r10, pc}}",
    )
}

/// Bins above the middle, in ascending order.
///
/// # Safety
/// The conditions of [`span_below`], but with the factors from `factors` downwards.
#[unsafe(naked)]
pub unsafe extern "C" fn span_above(
    here: *const Point,
    there: *const Point,
    factors: *const Packed,
    to: *mut Point,
    end: *mut Point,
) {
    kernel!(
        "ldr r12, [sp]",
        "push {{r4-r10, lr}}",
        ".p2align 2",
        "2:",
        "ldrd r7, r8, [r0], #8",
        "ldrd r5, r6, [r1], #-8",
        "ldr r10, [r2], #-4",
        split_pair!(),
        "rsb r8, r8, r9, asr #1",
        "sub r5, r5, r7, asr #1",
        store_and_go!("r8", "r5", "r3"),
        "cmp r3, r12",
        "blo 2b",
        "pop {{r4-r10, pc}}",
    )
}

/// Defines bins in ascending order, each from the point at r0 and its mirror at r1, with factors of 32 bits: `integer::split_here`. The
/// sine is in `$sin` and the cosine in `$cos`: r9 is read upwards, r10 downwards. `$re` adds the products with the cosine to the real part,
/// `$im` to the imaginary part.
macro_rules! fine_span {
    ($(#[$doc:meta])* $name:ident, $sin:literal, $cos:literal, $re:literal, $im:literal) => {
        $(#[$doc])*
        #[unsafe(naked)]
        pub(super) unsafe extern "C" fn $name(
            here: *const Point,
            there: *const Point,
            upwards: *const i32,
            downwards: *const i32,
            to: *mut Point,
            end: *mut Point,
        ) {
            kernel!(
                "push {{r4-r11, lr}}",
                "ldrd r4, r12, [sp, #36]",
                ".p2align 2",
                "2:",
                "ldrd r5, r6, [r0], #8",
                "ldrd r7, r8, [r1], #-8",
                "ldr r9, [r2], #4",
                "ldr r10, [r3], #-4",
                "add r11, r5, r7",
                "sub r5, r5, r7",
                "sub r7, r6, r8",
                "add r6, r6, r8",
                "asr r11, r11, #1",
                "asr r7, r7, #1",
                concat!($re, " r11, r6, ", $cos, ", r11"),
                concat!("smmls r11, r5, ", $sin, ", r11"),
                concat!("smmls r7, r6, ", $sin, ", r7"),
                concat!($im, " r7, r5, ", $cos, ", r7"),
                store_and_go!("r11", "r7", "r4"),
                "cmp r4, r12",
                "blo 2b",
                "pop {{r4-r11, pc}}",
            )
        }
    };
}

fine_span! {
    /// [`span_below`] with factors of 32 bits.
    ///
    /// # Safety
    /// The conditions of [`span_below`], but with the sines from `upwards` upwards and the cosines from `downwards` downwards.
    fine_below, "r9", "r10", "smmla", "smmls"
}

fine_span! {
    /// [`span_above`] with factors of 32 bits.
    ///
    /// # Safety
    /// The conditions of [`span_below`], but with the negated cosines from `upwards` upwards and the sines from `downwards` downwards.
    fine_above, "r10", "r9", "smmls", "smmla"
}
