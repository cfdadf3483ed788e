//! The later passes, of radix 4: four butterflies at a time.
//!
//! The first butterflies of a block have a factor 1. A predicate leaves their points unchanged.

use super::factors::{Vectors, factors};
use crate::spectrum::fft::assembly::kernel;
use crate::spectrum::fft::integer::Pair;
use crate::spectrum::fft::q15::second;

/// The pass over sub-transforms of L points: the kernels for [`q15::radix4`](crate::spectrum::fft::q15::radix4).
///
/// # Safety
/// `points` must be M aligned points, and M must have a pass of this length.
#[inline(always)]
pub unsafe fn pass<const M: usize, const L: usize>(points: *mut Pair, twice: bool) -> bool {
    let table = const { factors(L) }.as_ptr();
    let blocks = const { M / 4 / L };
    // SAFETY: the caller guarantees it. If there is more than one block, there are at least four.
    let q = unsafe {
        match (const { Loop::from_lengths(M, L) }, twice) {
            (Loop::Only, false) => only::<false>(points, L, table, blocks),
            (Loop::Only, true) => only::<true>(points, L, table, blocks),
            (Loop::Rows, false) => rows::<false>(points, L, table, blocks),
            (Loop::Rows, true) => rows::<true>(points, L, table, blocks),
            (Loop::Columns, false) => columns::<L, false>(points, blocks, table),
            (Loop::Columns, true) => columns::<L, true>(points, blocks, table),
        }
    };
    q != 0
}

/// The order of a pass.
enum Loop {
    /// The last pass, whose headroom is not tested.
    Only,
    /// One block after the other.
    Rows,
    /// One vector of factors after the other, each over all blocks: short blocks.
    Columns,
}

impl Loop {
    const fn from_lengths(m: usize, length: usize) -> Self {
        match length {
            _ if 4 * length == m => Loop::Only,
            ..32 => Loop::Columns,
            _ => Loop::Rows,
        }
    }
}

/// Saves the registers that a pass changes, clears QC, and sets the rounding of four points in q7 and the predicate that leaves out the
/// first. Uses r12.
macro_rules! begin {
    () => {
        lines!(
            enter!(),
            "mov r12, #0",
            "vmsr fpscr_nzcvqc, r12",
            "mov r12, #{second}",
            "vmov.i16 q7, #1",
            "vmov d15, r12, r12",
            "movw r12, #0xfff0",
            "vmsr p0, r12"
        )
    };
}

/// Returns QC.
macro_rules! end {
    () => {
        lines!("vmrs r0, fpscr_nzcvqc", "and r0, r0, #0x08000000", leave!())
    };
}

/// The point $x by the factor $w, doubled, to $to.
macro_rules! turn {
    ($to:literal, $x:literal, $w:literal) => {
        lines!(
            concat!("vqdmlsdh.s16 ", $to, ", ", $x, ", ", $w),
            concat!("vqdmladhx.s16 ", $to, ", ", $x, ", ", $w)
        )
    };
}

/// [`turn`] where there is a predicate, the point alone elsewhere.
macro_rules! turn_others {
    ($to:literal, $x:literal, $w:literal) => {
        lines!(
            concat!("vqdmlsdht.s16 ", $to, ", ", $x, ", ", $w),
            concat!("vqdmladhxt.s16 ", $to, ", ", $x, ", ", $w)
        )
    };
}

/// Loads a vector.
macro_rules! load {
    ($x:literal, $at:literal) => {
        concat!("vldrw.u32 ", $x, ", ", $at, "\n")
    };
}

/// Legs 1 and 3 at these places by the factors in q5, q6, doubled: q2, q3.
macro_rules! outer {
    ($b:literal, $d:literal) => {
        lines!(load!("q0", $b), load!("q1", $d), turn!("q2", "q0", "q5"), turn!("q3", "q1", "q6"))
    };
}

/// Leg 2 by the factor at $w, doubled: q4.
macro_rules! inner {
    ($c:literal, $w:literal) => {
        lines!(load!("q2", $c), load!("q3", $w), turn!("q4", "q2", "q3"))
    };
}

/// [`outer`] for the first four butterflies of a block.
macro_rules! first_outer {
    ($b:literal, $d:literal) => {
        lines!(
            load!("q0", $b),
            load!("q1", $d),
            "vmov q2, q0",
            "vmov q3, q1",
            "vpstttt",
            turn_others!("q2", "q0", "q5"),
            turn_others!("q3", "q1", "q6")
        )
    };
}

/// [`inner`] for the first four butterflies of a block.
macro_rules! first_inner {
    ($c:literal, $w:literal) => {
        lines!(
            load!("q2", $c),
            load!("q3", $w),
            "vmov q4, q2",
            "vpstt",
            turn_others!("q4", "q2", "q3")
        )
    };
}

/// Four butterflies of leg 0 at $a; the other arguments load the other legs. Points 0, 1, 2, 3 are q4, q0, q3, q2.
macro_rules! butterflies {
    ($outer:expr, $inner:expr, $a:literal) => {
        lines!(
            $outer,
            "vrshr.s16 q2, q2, #1",
            "vrshr.s16 q3, q3, #1",
            "vadd.i16 q0, q2, q3",
            "vsub.i16 q1, q2, q3",
            $inner,
            load!("q2", $a),
            "vrshr.s16 q4, q4, #1",
            "vhadd.s16 q2, q2, q7",
            "vadd.i16 q3, q2, q4",
            "vsub.i16 q2, q2, q4",
            ".if {twice}",
            "vhadd.s16 q4, q3, q0",
            "vhsub.s16 q3, q3, q0",
            "vhcadd.s16 q0, q2, q1, #270",
            "vhcadd.s16 q2, q2, q1, #90",
            ".else",
            "vadd.i16 q4, q3, q0",
            "vsub.i16 q3, q3, q0",
            "vcadd.i16 q0, q2, q1, #270",
            "vcadd.i16 q2, q2, q1, #90",
            ".endif"
        )
    };
}

/// Stores the points, leg 0 last.
macro_rules! store {
    ($a:literal, $b:literal, $c:literal, $d:literal) => {
        lines!(
            concat!("vstrw.32 q0, ", $b),
            concat!("vstrw.32 q3, ", $c),
            concat!("vstrw.32 q2, ", $d),
            concat!("vstrw.32 q4, ", $a)
        )
    };
}

/// Sets QC if a part is large.
macro_rules! look {
    () => {
        lines!(
            "vqshl.s16 q0, q0, #2",
            "vqshl.s16 q3, q3, #2",
            "vqshl.s16 q2, q2, #2",
            "vqshl.s16 q4, q4, #2"
        )
    };
}

/// A pass over blocks of at most 64 points, at least two. If `TWICE`, the pass halves a second time. Returns nonzero if a part is large.
///
/// # Safety
/// `points` must be `blocks` blocks of 4 L aligned points, `table` the factors of L.
#[unsafe(naked)]
unsafe extern "C" fn columns<const L: usize, const TWICE: bool>(
    points: *mut Pair,
    blocks: usize,
    table: *const Vectors,
) -> u32 {
    macro_rules! store_all {
        () => {
            store!("[r0], #16*{l}", "[r0, #4*{l}]", "[r0, #8*{l}]", "[r0, #12*{l}]")
        };
    }
    kernel!(
        begin!(),
        "mov r3, r0",
        load!("q5", "[r2], #16"),
        load!("q6", "[r2], #16"),
        "dls lr, r1",
        "2:",
        butterflies!(
            first_outer!("[r0, #4*{l}]", "[r0, #12*{l}]"),
            first_inner!("[r0, #8*{l}]", "[r2]"),
            "[r0]"
        ),
        store_all!(),
        look!(),
        "le lr, 2b",
        ".if {l} > 4",
        "mov r12, #{l}/4-1",
        "3:",
        "add r2, r2, #16",
        "add r3, r3, #16",
        "mov r0, r3",
        load!("q5", "[r2], #16"),
        load!("q6", "[r2], #16"),
        "dls lr, r1",
        "4:",
        butterflies!(
            outer!("[r0, #4*{l}]", "[r0, #12*{l}]"),
            inner!("[r0, #8*{l}]", "[r2]"),
            "[r0]"
        ),
        store_all!(),
        look!(),
        "le lr, 4b",
        "subs r12, r12, #1",
        "bne 3b",
        ".endif",
        end!(),
        twice = const TWICE as u32,
        second = const 0x1_0001 * second(TWICE),
        // No caller needs a longer pass, but the assembler sees such lengths.
        l = const if L <= 16 { L } else { 4 },
    )
}

/// Defines a pass over one block after the other; the last argument tests for large parts.
macro_rules! blocks {
    ($(#[$doc:meta])* $name:ident, $look:expr) => {
        $(#[$doc])*
        #[unsafe(naked)]
        unsafe extern "C" fn $name<const TWICE: bool>(
            points: *mut Pair,
            length: usize,
            table: *const Vectors,
            blocks: usize,
        ) -> u32 {
            macro_rules! factors {
                () => {
                    lines!(load!("q5", "[r4], #16"), load!("q6", "[r4], #16"))
                };
            }
            macro_rules! store_all {
                () => {
                    store!("[r0], #16", "[r1], #16", "[r2], #16", "[r3], #16")
                };
            }
            kernel!(
                begin!(),
                "mov r5, r2",
                "mov r7, r3",
                "lsr r8, r1, #2",          // vectors of a leg after its first
                "sub r8, r8, #1",
                "lsl r6, r1, #2",          // bytes of a leg
                "add r12, r6, r6, lsl #1", // from a leg's end to its place in the next block
                "add r1, r0, r6",
                "add r2, r1, r6",
                "add r3, r2, r6",
                "2:",
                "mov r4, r5",
                "dls lr, r8",
                factors!(),
                butterflies!(first_outer!("[r1]", "[r3]"), first_inner!("[r2]", "[r4], #16"), "[r0]"),
                store_all!(),
                $look,
                "3:",
                factors!(),
                butterflies!(outer!("[r1]", "[r3]"), inner!("[r2]", "[r4], #16"), "[r0]"),
                store_all!(),
                $look,
                "le lr, 3b",
                "add r0, r0, r12",
                "add r1, r1, r12",
                "add r2, r2, r12",
                "add r3, r3, r12",
                "subs r7, r7, #1",
                "bne 2b",
                end!(),
                twice = const TWICE as u32,
                second = const 0x1_0001 * second(TWICE),
            )
        }
    };
}

blocks! {
    /// A pass over sub-transforms of `length` points, 8 or more. If `TWICE`, the pass halves a second time. Returns nonzero if a part is
    /// large.
    ///
    /// # Safety
    /// `points` must be `blocks` blocks of 4 `length` aligned points, `table` the factors.
    rows, look!()
}

blocks! {
    /// [`rows`] without the test for large parts.
    ///
    /// # Safety
    /// The conditions of [`rows`].
    only, ""
}
