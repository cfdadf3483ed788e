//! The first pass for codes of more than 13 bits, as in [`super::first`] but with sums of 32 bits.

use super::{Pair, Point};
use crate::spectrum::fft::assembly::kernel;
use crate::spectrum::fft::integer::DIAGONAL;

/// Four points by `integer::dft4` of the legs at `$a` to `$d`: points 0 in q6, q7 and 2 in q4, q5. Points 1 and 3 come from the difference
/// of legs 1 and 3 in q3, q2 and the difference of legs 0 and 2 at `$at` and 16 bytes above it.
macro_rules! four_points {
    ($a:literal, $b:literal, $c:literal, $d:literal, $at:literal) => {
        lines!(
            concat!("vldrh.u16 q0, [", $a, "], #16"),
            concat!("vldrh.u16 q2, [", $c, "], #16"),
            "vmovlb.s16 q1, q0",
            "vmovlt.s16 q0, q0",
            "vmovlb.s16 q3, q2",
            "vmovlt.s16 q2, q2",
            "vadd.i32 q4, q1, q3",
            "vadd.i32 q5, q0, q2",
            "vsub.i32 q1, q1, q3",
            "vsub.i32 q0, q0, q2",
            concat!("vstrw.32 q1, [sp, #", $at, "]"),
            concat!("vstrw.32 q0, [sp, #", $at, "+16]"),
            concat!("vldrh.u16 q2, [", $b, "], #16"),
            concat!("vldrh.u16 q6, [", $d, "], #16"),
            "vmovlb.s16 q3, q2",
            "vmovlt.s16 q2, q2",
            "vmovlb.s16 q7, q6",
            "vmovlt.s16 q6, q6",
            "vadd.i32 q0, q3, q7",
            "vadd.i32 q1, q2, q6",
            "vsub.i32 q3, q3, q7",
            "vsub.i32 q2, q2, q6",
            "vadd.i32 q6, q4, q0",
            "vadd.i32 q7, q5, q1",
            "vsub.i32 q4, q4, q0",
            "vsub.i32 q5, q5, q1"
        )
    };
}

/// Shifts vectors by `$by`.
macro_rules! shift {
    ($by:literal: $($q:literal)*) => { concat!($("vshl.s32 ", $q, ", ", $by, "\n",)*) };
}

/// Stores vectors at the stack pointer.
macro_rules! keep {
    ($($q:literal $at:literal),*) => { concat!($("vstrw.32 ", $q, ", [sp, #", $at, "]\n",)*) };
}

/// Loads vectors from the stack.
macro_rules! fetch {
    ($($q:literal $at:literal),*) => { concat!($("vldrw.u32 ", $q, ", [sp, #", $at, "]\n",)*) };
}

/// Stores the result of `$first` on the even part at `$e` and the odd part in `$o` at `$at` of the groups in q0, and the result of
/// `$second` 32 bytes above. Uses q2 and `$free`.
macro_rules! sums {
    ($e:literal, $o:literal, $at:literal, $first:literal, $second:literal, $free:literal $(, $then:literal)?) => {
        lines!(
            concat!("vldrw.u32 q2, [sp, #", $e, "]"),
            concat!($first, " ", $free, ", q2, ", $o),
            $(concat!($then, " ", $free, ", #1"),)?
            concat!("vstrw.32 ", $free, ", [q0, #", $at, "]"),
            concat!($second, " q2, q2, ", $o),
            concat!("vstrw.32 q2, [q0, #", $at, "+32]")
        )
    };
}

/// Four groups of eight, whose last sums are by `$add` and `$sub`.
macro_rules! eight {
    ($add:literal, $sub:literal $(, $odd:literal)?) => {
        lines!(
            // The even part.
            four_points!("r4", "r6", "r8", "r10", "160"),
            shift!("r3": "q4" "q5" "q6" "q7"),
            keep!("q6" "32", "q7" "48", "q4" "96", "q5" "112"),
            fetch!("q1" "160", "q0" "176"),
            "vadd.i32 q6, q1, q2",
            "vsub.i32 q7, q0, q3",
            "vsub.i32 q1, q1, q2",
            "vadd.i32 q0, q0, q3",
            shift!("r3": "q6" "q7" "q1" "q0"),
            keep!("q6" "64", "q7" "80", "q1" "128", "q0" "144"),
            // The odd part.
            four_points!("r5", "r7", "r9", "r11", "160"),
            shift!("r3": "q4" "q5" "q6" "q7"),
            keep!("q3" "192", "q2" "208"),
            places!("q0"),
            sums!("32", "q6", "0", $add, $sub, "q1" $(, $odd)?),
            sums!("48", "q7", "4", $add, $sub, "q1" $(, $odd)?),
            sums!("96", "q5", "16", $add, $sub, "q1"),
            sums!("112", "q4", "20", $sub, $add, "q1"),
            // Points 1 and 3 of the odd part, by an eighth of a turn.
            fetch!("q4" "160", "q5" "176", "q6" "192", "q7" "208"),
            "vadd.i32 q1, q4, q7",
            "vsub.i32 q2, q5, q6",
            "vsub.i32 q4, q4, q7",
            "vadd.i32 q5, q5, q6",
            "vadd.i32 q3, q1, q2",
            "vsub.i32 q1, q2, q1",
            "vsub.i32 q6, q5, q4",
            "vadd.i32 q4, q4, q5",
            shift!("r12": "q3" "q1" "q6" "q4"),
            "vqdmulh.s32 q3, q3, r2",
            "vqdmulh.s32 q1, q1, r2",
            "vqdmulh.s32 q6, q6, r2",
            "vqdmulh.s32 q4, q4, r2",
            sums!("64", "q3", "8", $add, $sub, "q5"),
            sums!("80", "q1", "12", $add, $sub, "q5"),
            sums!("128", "q6", "24", $add, $sub, "q5"),
            sums!("144", "q4", "28", $sub, $add, "q5")
        )
    };
}

/// The pass of [`super::first::eights`] for codes of any width: `integer::first8`.
///
/// # Safety
/// The conditions of [`super::first::eights`].
#[unsafe(naked)]
pub(super) unsafe extern "C" fn eights(
    from: *const Pair,
    to: *mut Point,
    m: usize,
    shift: u32,
    places: *const u16,
) {
    kernel!(
        begin!("3", "224"),
        legs!("r4" "r5" "r6" "r7" "r8" "r9" "r10" "r11"),
        "add r3, r12, #16",
        "add r12, r12, #17",
        // Half of sqrt(1/2) in a lane, because the product is doubled.
        "movw r2, #({root}<<14)&0xffff",
        "movt r2, #{root}>>2",
        vectors!(eight!("vhadd.s32", "vhsub.s32"), eight!("vadd.i32", "vsub.i32", "vorr.i32")),
        end!("224"),
        root = const DIAGONAL,
    )
}

/// Four groups of four, shifted up by `$by`.
macro_rules! four {
    ($by:literal $(, $odd:literal)?) => {
        lines!(
            four_points!("r4", "r5", "r6", "r7", "32"),
            shift!($by: "q4" "q5" "q6" "q7"),
            places!("q0"),
            $(concat!($odd, " q6, #1\n ", $odd, " q7, #1"),)?
            "vstrw.32 q6, [q0]",
            "vstrw.32 q7, [q0, #4]",
            "vstrw.32 q4, [q0, #16]",
            "vstrw.32 q5, [q0, #20]",
            fetch!("q4" "32", "q5" "48"),
            "vadd.i32 q6, q4, q2",
            "vsub.i32 q7, q5, q3",
            "vsub.i32 q4, q4, q2",
            "vadd.i32 q5, q5, q3",
            shift!($by: "q4" "q5" "q6" "q7"),
            "vstrw.32 q6, [q0, #8]",
            "vstrw.32 q7, [q0, #12]",
            "vstrw.32 q4, [q0, #24]",
            "vstrw.32 q5, [q0, #28]"
        )
    };
}

/// The pass of [`super::first::fours`] for codes of any width: `integer::first4`.
///
/// # Safety
/// The conditions of [`super::first::fours`].
#[unsafe(naked)]
pub(super) unsafe extern "C" fn fours(
    from: *const Pair,
    to: *mut Point,
    m: usize,
    shift: u32,
    places: *const u16,
) {
    kernel!(
        begin!("2", "64"),
        legs!("r4" "r5" "r6" "r7"),
        "add r3, r12, #16",
        "add r12, r12, #15",
        vectors!(four!("r12"), four!("r3", "vorr.i32")),
        end!("64"),
    )
}
