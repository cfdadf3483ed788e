//! The first pass, which reads the record in sequence and writes it in digit-reversed order: four
//! groups at a time, one in each quarter of the points. Codes of at most 13 bits leave room for the
//! sum of eight in 16 bits.

use super::{Pair, Point};
use crate::spectrum::fft::assembly::kernel;

/// Begins a pass of M = r2 points in groups of 2^`$digits`. Afterwards r0 is 0 and counts vectors
/// with reversed bits, lr counts them down, r2 is the bytes of a leg of the record, r3 half of one
/// shifted up, and r12 what shifts a product by twice sqrt(1/2) in Q15 to that. The stack has the
/// points of the first four groups, and above them the step of r0.
macro_rules! begin {
    ($digits:literal) => {
        lines!(
            enter!(),
            "sub sp, sp, #64",
            concat!("lsr lr, r2, #2+", $digits),
            "clz r5, lr",
            "mov r6, #2",
            "lsl r5, r6, r5",
            "str r5, [sp, #16]",
            "mov r4, #0",
            "vidup.u32 q0, r4, #1",
            "lsl r4, r2, #1",
            "vmul.i32 q0, q0, r4",
            "vadd.i32 q0, q0, r1",
            "vstrw.32 q0, [sp]",
            "sub r12, r3, #16",
            "lsl r3, r6, r3",
            "lsr r3, r3, #2",
            "lsl r2, r2, #2",
            concat!("lsr r2, r2, #", $digits),
            "mov r4, r0",
            "mov r0, #0",
            "dls lr, lr"
        )
    };
}

/// Sets `$to` to the places of the next four groups of 2^`$digits` points. Uses r1 and r2.
macro_rules! places {
    ($to:literal, $digits:literal) => {
        lines!(
            // Twice the number with its digits in base 4 backwards.
            "rbit r1, r0",
            "and r2, r1, #0x55555555",
            "add r1, r1, r2",
            "add r1, r1, r2, lsl #1",
            concat!("lsl r1, r1, #2+", $digits),
            concat!("vldrw.u32 ", $to, ", [sp]"),
            concat!("vadd.i32 ", $to, ", ", $to, ", r1"),
            "ldr r2, [sp, #16]",
            "add r0, r0, r2"
        )
    };
}

/// Ends a pass.
macro_rules! end {
    () => {
        lines!("add sp, sp, #64", leave!())
    };
}

/// Stores the packed points in `$x`, shifted up, as point `$at` of the groups in `$places`.
/// `$then` is done to each part, in `$free` and `$x`.
macro_rules! widen {
    ($x:literal, $at:literal, $free:literal, $places:literal $(, $then:literal, $value:literal)?) => {
        lines!(
            concat!("vqdmullb.s16 ", $free, ", ", $x, ", r3"),
            $(concat!($then, " ", $free, ", ", $value),)?
            concat!("vstrw.32 ", $free, ", [", $places, ", #8*", $at, "]"),
            concat!("vqdmullt.s16 ", $x, ", ", $x, ", r3"),
            $(concat!($then, " ", $x, ", ", $value),)?
            concat!("vstrw.32 ", $x, ", [", $places, ", #8*", $at, "+4]")
        )
    };
}

/// The even part in `$e` and the odd part at `$odd` give points `$at` and `$at` + 4: `$first` of
/// the lower and `$second` of the upper products are added, `$plus` to the imaginary part.
/// Uses q2, q4 to q6 and `$e`.
macro_rules! diagonal {
    ($e:literal, $odd:literal, $at:literal, $re:literal, $im:literal, $plus:literal, $minus:literal) => {
        lines!(
            concat!("vqdmullb.s16 q2, ", $e, ", r3"),
            concat!("vqdmullt.s16 ", $e, ", ", $e, ", r3"),
            concat!("vldrw.u32 q4, [sp, #", $odd, "]"),
            "vqdmullb.s16 q5, q4, r1",
            "vqdmullt.s16 q4, q4, r1",
            "vshl.s32 q5, r12",
            "vshl.s32 q4, r12",
            concat!("vadd.i32 q6, q2, ", $re),
            concat!("vstrw.32 q6, [q3, #8*", $at, "]"),
            concat!($plus, " q6, ", $e, ", ", $im),
            concat!("vstrw.32 q6, [q3, #8*", $at, "+4]"),
            concat!("vsub.i32 q6, q2, ", $re),
            concat!("vstrw.32 q6, [q3, #8*", $at, "+32]"),
            concat!($minus, " q6, ", $e, ", ", $im),
            concat!("vstrw.32 q6, [q3, #8*", $at, "+36]")
        )
    };
}

/// The first pass in groups of eight: `integer::first8` for codes of at most 13 bits, shifted up by
/// `shift`. The first point of each group is made odd.
///
/// # Safety
/// `from` and `to` must be `m` pairs and `m` points, m = 8 4^d of 32 or more; `shift` 1 to 15.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn eights(from: *const Pair, to: *mut Point, m: usize, shift: u32) {
    kernel!(
        begin!("3"),
        "add r5, r4, r2",
        "add r6, r5, r2",
        "add r7, r6, r2",
        "add r8, r7, r2",
        "add r9, r8, r2",
        "add r10, r9, r2",
        "add r11, r10, r2",
        "2:",
        // The odd part: q3, q2, and points 1 and 3 times 1 - j in memory.
        "vldrw.u32 q0, [r5], #16",
        "vldrw.u32 q1, [r9], #16",
        "vadd.i16 q2, q0, q1",
        "vsub.i16 q0, q0, q1",
        "vldrw.u32 q1, [r7], #16",
        "vldrw.u32 q3, [r11], #16",
        "vadd.i16 q4, q1, q3",
        "vsub.i16 q1, q1, q3",
        "vadd.i16 q3, q2, q4",
        "vsub.i16 q2, q2, q4",
        "vcadd.i16 q4, q0, q1, #270",
        "vcadd.i16 q0, q0, q1, #90",
        "vcadd.i16 q4, q4, q4, #270",
        "vcadd.i16 q0, q0, q0, #270",
        "vstrw.32 q4, [sp, #32]",
        "vstrw.32 q0, [sp, #48]",
        // The even part: points 0 and 2 in q7, q6; the terms of the others in q1, q5.
        "vldrw.u32 q1, [r4], #16",
        "vldrw.u32 q5, [r8], #16",
        "vadd.i16 q6, q1, q5",
        "vsub.i16 q1, q1, q5",
        "vldrw.u32 q5, [r6], #16",
        "vldrw.u32 q7, [r10], #16",
        "vadd.i16 q4, q5, q7",
        "vsub.i16 q5, q5, q7",
        "vadd.i16 q7, q6, q4",
        "vsub.i16 q6, q6, q4",
        "vadd.i16 q4, q7, q3",
        "vsub.i16 q7, q7, q3",
        places!("q3", "3"),
        widen!("q4", "0", "q0", "q3", "vorr.i32", "#1"),
        widen!("q7", "4", "q0", "q3"),
        "vcadd.i16 q4, q6, q2, #270",
        "vcadd.i16 q6, q6, q2, #90",
        widen!("q4", "2", "q0", "q3"),
        widen!("q6", "6", "q0", "q3"),
        "vcadd.i16 q0, q1, q5, #270",
        "vcadd.i16 q1, q1, q5, #90",
        "movw r1, #23170",
        diagonal!("q0", "32", "1", "q5", "q4", "vadd.i32", "vsub.i32"),
        diagonal!("q1", "48", "3", "q4", "q5", "vsub.i32", "vadd.i32"),
        "le lr, 2b",
        end!(),
    )
}

/// The first pass in groups of four: `integer::first4`, as [`eights`].
///
/// # Safety
/// As [`eights`], m = 4^d of 16 or more.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn fours(from: *const Pair, to: *mut Point, m: usize, shift: u32) {
    kernel!(
        begin!("2"),
        "add r5, r4, r2",
        "add r6, r5, r2",
        "add r7, r6, r2",
        "2:",
        "vldrw.u32 q0, [r4], #16",
        "vldrw.u32 q1, [r6], #16",
        "vadd.i16 q2, q0, q1",
        "vsub.i16 q0, q0, q1",
        "vldrw.u32 q1, [r5], #16",
        "vldrw.u32 q3, [r7], #16",
        "vadd.i16 q4, q1, q3",
        "vsub.i16 q1, q1, q3",
        places!("q7", "2"),
        "vadd.i16 q3, q2, q4",
        "vsub.i16 q2, q2, q4",
        "vcadd.i16 q4, q0, q1, #270",
        "vcadd.i16 q0, q0, q1, #90",
        widen!("q3", "0", "q5", "q7", "vorr.i32", "#1"),
        widen!("q4", "1", "q5", "q7"),
        widen!("q2", "2", "q5", "q7"),
        widen!("q0", "3", "q5", "q7"),
        "le lr, 2b",
        end!(),
    )
}
