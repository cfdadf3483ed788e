//! The later passes, of radix 4: four butterflies at a time.

use super::Point;
use super::factors::Vectors;
use crate::spectrum::fft::assembly::kernel;

/// Loads four points at `$at`: real parts to `$re`, imaginary parts to the next register `$im`.
macro_rules! load {
    ($re:literal, $im:literal, $at:literal) => {
        lines!(
            concat!("vld20.32 {{", $re, ", ", $im, "}}, [", $at, "]"),
            concat!("vld21.32 {{", $re, ", ", $im, "}}, [", $at, "]")
        )
    };
}

/// Stores four points at `$at` and advances it.
macro_rules! store {
    ($re:literal, $im:literal, $at:literal) => {
        lines!(
            concat!("vst20.32 {{", $re, ", ", $im, "}}, [", $at, "]"),
            concat!("vst21.32 {{", $re, ", ", $im, "}}, [", $at, "]!")
        )
    };
}

/// Loads a factor's cosine and sine.
macro_rules! factor {
    ($cos:literal, $sin:literal) => {
        lines!(
            concat!("vldrw.u32 ", $cos, ", [r4], #16"),
            concat!("vldrw.u32 ", $sin, ", [r4], #16")
        )
    };
}

/// An instruction with three registers.
macro_rules! op {
    ($name:literal, $to:literal, $a:literal, $b:literal) => {
        concat!($name, " ", $to, ", ", $a, ", ", $b, "\n")
    };
}

/// `integer::turn`, or `integer::turn_finely` with "vadd.i32" for `$re` and a negation.
macro_rules! pass {
    ($(#[$doc:meta])* $name:ident, $re:literal, $($negate:literal)?) => {
        $(#[$doc])*
        #[unsafe(naked)]
        pub(super) unsafe extern "C" fn $name(
            points: *mut Point,
            leg: usize,
            table: *const Vectors,
            blocks: usize,
        ) {
            // The point $x, $y by the factor $c, $s: to $to and $y. Uses $t.
            macro_rules! turn {
                ($x:literal, $y:literal, $c:literal, $s:literal, $to:literal, $t:literal) => {
                    concat!(
                        op!("vmulh.s32", $to, $x, $c),
                        op!("vmulh.s32", $t, $y, $s),
                        op!("vmulh.s32", $y, $y, $c),
                        $(concat!($negate, " ", $s, ", ", $s, "\n"),)?
                        op!("vmulh.s32", $x, $x, $s),
                        op!($re, $to, $to, $t),
                        op!("vadd.i32", $y, $y, $x),
                    )
                };
            }
            // Four butterflies; the last sums by $add and $sub.
            macro_rules! butterflies {
                ($add:literal, $sub:literal) => {
                    concat!(
                        load!("q0", "q1", "r1"),
                        factor!("q2", "q3"),
                        turn!("q0", "q1", "q2", "q3", "q4", "q5"),
                        load!("q2", "q3", "r3"),
                        factor!("q5", "q6"),
                        turn!("q2", "q3", "q5", "q6", "q0", "q7"),
                        // Legs 1 and 3: sum q0, q4; difference, in memory and q5.
                        op!("vsub.i32", "q2", "q4", "q0"),
                        op!("vadd.i32", "q0", "q4", "q0"),
                        op!("vadd.i32", "q4", "q1", "q3"),
                        op!("vsub.i32", "q5", "q1", "q3"),
                        "vstrw.32 q2, [r1]\n",
                        load!("q6", "q7", "r2"),
                        factor!("q1", "q2"),
                        // Leg 2: q6, q7.
                        op!("vmulh.s32", "q3", "q6", "q1"),
                        op!("vmulh.s32", "q1", "q7", "q1"),
                        op!("vmulh.s32", "q7", "q7", "q2"),
                        $(concat!($negate, " q2, q2\n"),)?
                        op!("vmulh.s32", "q2", "q6", "q2"),
                        op!($re, "q6", "q3", "q7"),
                        op!("vadd.i32", "q7", "q1", "q2"),
                        load!("q2", "q3", "r0"),
                        // Legs 0 and 2: sum q1, q2; difference q6, q7.
                        op!("vadd.i32", "q1", "q2", "q6"),
                        op!("vsub.i32", "q6", "q2", "q6"),
                        op!("vadd.i32", "q2", "q3", "q7"),
                        op!("vsub.i32", "q7", "q3", "q7"),
                        op!($sub, "q3", "q1", "q0"),
                        op!($add, "q0", "q1", "q0"),
                        op!($add, "q1", "q2", "q4"),
                        op!($sub, "q4", "q2", "q4"),
                        store!("q0", "q1", "r0"),
                        store!("q3", "q4", "r2"),
                        "vldrw.u32 q4, [r1]\n",
                        op!($add, "q0", "q6", "q5"),
                        op!($sub, "q1", "q7", "q4"),
                        store!("q0", "q1", "r1"),
                        op!($sub, "q6", "q6", "q5"),
                        op!($add, "q7", "q7", "q4"),
                        store!("q6", "q7", "r3"),
                    )
                };
            }
            kernel!(
                enter!(),
                "mov r5, r2",              // the table
                "mov r6, r1",              // bytes of a leg
                "lsr r8, r1, #5",          // vectors of a leg
                "add r12, r1, r1, lsl #1", // from a leg's end to its place in the next block
                "lsrs r7, r3, #2",         // groups of four blocks
                "add r1, r0, r6",
                "add r2, r1, r6",
                "add r3, r2, r6",
                "mov r10, #1",             // blocks that are no leg 0
                "mov r11, #0",             // whether there is another pass
                "beq 4f",
                "mov r11, #1",
                // The first block is a leg 0 of the next pass.
                "2:",
                "mov r4, r5",
                "dls lr, r8",
                "3:",
                butterflies!("vhadd.s32", "vhsub.s32"),
                "le lr, 3b",
                "add r0, r0, r12",
                "add r1, r1, r12",
                "add r2, r2, r12",
                "add r3, r3, r12",
                "mov r10, #3",
                // The others are not.
                "4:",
                "mov r4, r5",
                "dls lr, r8",
                "5:",
                butterflies!("vadd.i32", "vsub.i32"),
                "le lr, 5b",
                // The first point of this block will be multiplied by 1.
                "sub r4, r0, r6",
                "ldrd r9, lr, [r4]",
                "orr r9, r9, r11",
                "orr lr, lr, r11",
                "strd r9, lr, [r4]",
                "add r0, r0, r12",
                "add r1, r1, r12",
                "add r2, r2, r12",
                "add r3, r3, r12",
                "subs r10, r10, #1",
                "bne 4b",
                "subs r7, r7, #1",
                "bgt 2b",
                leave!(),
            )
        }
    };
}

pass! {
    /// A radix-4 pass over blocks of four legs of `leg` bytes: one block, or four or a multiple. Leg 0 is already halved, and the first
    /// points of the other legs are odd. Where there are several blocks, another pass follows, which takes every fourth block as its leg 0.
    ///
    /// # Safety
    /// `points` must be the blocks, `leg` 32 or a multiple, and `table` the factors of a block's number of points.
    short, "vsub.i32",
}

pass! {
    /// [`short`] with factors of 32 bits.
    ///
    /// # Safety
    /// The conditions of [`short`].
    fine, "vadd.i32", "vneg.s32"
}
