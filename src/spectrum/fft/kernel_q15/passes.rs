//! The radix-4 passes.

use super::super::integer::Pair;
use super::super::q15::second;
use super::super::twiddle::Triple;
use super::last;
use crate::spectrum::fft::assembly::kernel;

/// The pass over sub-transforms of L points: the kernels for [`q15::radix4`](super::super::q15::radix4).
///
/// # Safety
/// `points` must be M aligned points and `table` the factors of M, and M must have a pass of this length.
#[inline(always)]
pub unsafe fn pass<const M: usize, const L: usize>(
    points: *mut Pair,
    table: *const Triple,
    twice: bool,
) -> bool {
    // SAFETY: the caller guarantees it. If there is more than one block, there are at least four.
    let q = unsafe {
        match (4 * L == M, L > LONGEST, twice) {
            (true, false, false) => last::by_twos::<L, false>(points, table),
            (true, false, true) => last::by_twos::<L, true>(points, table),
            (true, true, false) => last::by_ones::<L, false>(points, table),
            (true, true, true) => last::by_ones::<L, true>(points, table),
            (false, _, false) => blocks::<M, L, false>(points, table),
            (false, _, true) => blocks::<M, L, true>(points, table),
        }
    };
    q != 0
}

/// The longest legs of a last pass that one pointer reaches with instructions that load two words.
pub const LONGEST: usize = 128;

/// A pass over at least four blocks. The outer loop takes one factor after the other, the inner
/// loop all blocks, four at once. If `TWICE`, the pass halves a second time.
///
/// # Safety
/// `points` must be M aligned points, `table` the factors of M, and M a power of 4 times 4 L.
#[unsafe(naked)]
unsafe extern "C" fn blocks<const M: usize, const L: usize, const TWICE: bool>(
    points: *mut Pair,
    table: *const Triple,
) -> u32 {
    macro_rules! leg {
        ($do:literal, $x:literal, $leg:literal, $block:literal) => {
            concat!($do, " ", $x, ", [r0, #", $leg, "*4*{l}+", $block, "*{next}]\n")
        };
    }
    macro_rules! store {
        ($b:literal) => {
            concat!(
                leg!("str", "r9", 0, $b),
                leg!("str", "r11", 1, $b),
                leg!("str", "r8", 2, $b),
                leg!("str", "r10", 3, $b),
            )
        };
    }
    macro_rules! first {
        ($b:literal) => {
            concat!(
                leg!("ldr", "r7", 1, $b),
                leg!("ldr", "r8", 3, $b),
                leg!("ldr", "r9", 2, $b),
                leg!("ldr", "r10", 0, $b),
                halves!(),
                sums!("r10", "r7", "r9", "r8", "r11"),
                look!("r7": "r9", "r11", "r8", "r10"),
                store!($b),
            )
        };
    }
    macro_rules! turned {
        ($b:literal) => {
            concat!(
                leg!("ldr", "r7", 1, $b),
                leg!("ldr", "r8", 3, $b),
                turn!("r7", "r2", "r9", "r5"),
                turn!("r8", "r4", "r9", "r5"),
                leg!("ldr", "r9", 2, $b),
                turn!("r9", "r3", "r10", "r5"),
                leg!("ldr", "r10", 0, $b),
                "shadd16 r10, r10, r6\n",
                sums!("r10", "r7", "r9", "r8", "r11"),
                look!("r7": "r9", "r11", "r8", "r10"),
                store!($b),
            )
        };
    }
    // Four butterflies. The offsets of blocks of 512 points do not fit in an instruction.
    macro_rules! four {
        ($one:ident) => {
            concat!(
                $one!(0),
                between!(),
                $one!(1),
                between!(),
                $one!(2),
                between!(),
                $one!(3),
                between!(),
            )
        };
    }
    macro_rules! between {
        () => {
            ".if {next} == 0\n add r0, r0, #16*{l}\n .endif\n"
        };
    }
    // Continues with the next four blocks at $label, then with the next points of all blocks.
    macro_rules! advance {
        ($label:literal) => {
            concat!(
                ".if {next} != 0\n .if {m} == 16*{l}\n",
                "add r0, r0, #4\n",
                ".else\n",
                "add r0, r0, #64*{l}\n cmp r0, r1\n blo ",
                $label,
                "b\n",
                ".endif\n .endif\n",
                ".if {next} == 0 || {m} > 16*{l}\n",
                "sub r0, r0, #4*{m}\n add r0, r0, #4\n",
                ".endif\n",
            )
        };
    }
    kernel!(
        enter!(4),
        "add lr, r1, #{stride}", // the next factor
        "add r12, r0, #4*{l}",
        "str r12, [sp]", // the leg's end
        "add r1, r0, #4*{m}",
        rounding!(),
        "mov r12, #0",
        ".p2align 2",
        "2:",
        four!(first),
        advance!("2"),
        "3:",
        "eor r6, r6, r12", // at every other factor, one rounding of leg 0 into the other
        "eor r12, r12, #{turns}",
        "ldm lr, {{r2, r3, r4}}",
        "add lr, lr, #{stride}",
        ".p2align 2",
        "4:",
        four!(turned),
        advance!("4"),
        "ldr r7, [sp]",
        "cmp r0, r7",
        "blo 3b",
        leave!(4),
        twice = const TWICE as u32,
        turns = const 0x1_0001 * (1 ^ second(TWICE)),
        // No caller needs a longer pass, but the assembler sees such lengths.
        l = const if L <= 256 { L } else { 4 },
        m = const M,
        stride = const M / 4 / L * size_of::<Triple>(),
        next = const if L < 128 { 16 * L } else { 0 },
    )
}
