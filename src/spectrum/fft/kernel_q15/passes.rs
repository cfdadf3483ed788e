//! The radix-4 passes.

use super::super::integer::Pair;
use super::super::q15::second;
use super::super::twiddle::Triple;
use crate::spectrum::fft::assembly::kernel;

/// The pass over sub-transforms of L points, as [`q15::radix4`](super::super::q15::radix4).
///
/// # Safety
/// `points` must be M aligned points and `table` the factors of M, and M must have such a pass.
#[inline(always)]
pub unsafe fn pass<const M: usize, const L: usize>(
    points: *mut Pair,
    table: *const Triple,
    twice: bool,
) -> bool {
    let stride = M / 4 / L * size_of::<Triple>();
    // SAFETY: the caller guarantees it. If there is more than one block, there are at least four.
    let q = unsafe {
        let end = points.add(M);
        match (4 * L == M, twice) {
            (true, false) => only::<L, false>(points, table),
            (true, true) => only::<L, true>(points, table),
            (false, false) => blocks::<L, false>(points, end, table, stride),
            (false, true) => blocks::<L, true>(points, end, table, stride),
        }
    };
    q != 0
}

/// x (cos - j sin) / 2 rounded, in place: $factor is packed as `cos | -sin << 16`, the rounding is
/// in r5.
macro_rules! turn {
    ($x:literal, $factor:literal, $free:literal) => {
        concat!(
            "smlsd ",
            $free,
            ", ",
            $x,
            ", ",
            $factor,
            ", r5\n",
            "smladx ",
            $x,
            ", ",
            $x,
            ", ",
            $factor,
            ", r5\n",
            "pkhtb ",
            $x,
            ", ",
            $x,
            ", ",
            $free,
            ", asr #16\n",
        )
    };
}

/// The sums of a butterfly, from leg 0, halved, in r10 and legs 1, 2, 3, turned, in r7, r9, r8.
/// They give points 0 r9, 1 r11, 2 r8, 3 r10.
macro_rules! sums {
    () => {
        lines!(
            "sadd16 r11, r7, r8",
            "ssub16 r7, r7, r8",
            "sadd16 r8, r10, r9",
            "ssub16 r10, r10, r9",
            ".if {twice}",
            "shadd16 r9, r8, r11",
            "shsub16 r8, r8, r11",
            "shsax r11, r10, r7",
            "shasx r10, r10, r7",
            ".else",
            "sadd16 r9, r8, r11",
            "ssub16 r8, r8, r11",
            "ssax r11, r10, r7",
            "sasx r10, r10, r7",
            ".endif"
        )
    };
}

/// Loads the rounding of products into r5 and that of halves into r6.
macro_rules! rounding {
    () => {
        lines!("mov r5, #0x8000", "mov r6, #0x10001")
    };
}

/// Halves all legs of a butterfly without factors.
macro_rules! halves {
    () => {
        lines!(
            "shadd16 r7, r7, r6",
            "shadd16 r8, r8, r6",
            "shadd16 r9, r9, r6",
            "shadd16 r10, r10, r6"
        )
    };
}

/// A pass over at least four blocks. The outer loop takes one factor after the other, the inner
/// loop all blocks. If `TWICE`, the pass halves a second time.
///
/// # Safety
/// `points..end` must be whole pairs of blocks of 4 L aligned points, `table` the factors, `stride`
/// bytes apart.
#[unsafe(naked)]
unsafe extern "C" fn blocks<const L: usize, const TWICE: bool>(
    points: *mut Pair,
    end: *mut Pair,
    table: *const Triple,
    stride: usize,
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
                sums!(),
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
                turn!("r7", "r2", "r9"),
                turn!("r8", "r4", "r9"),
                leg!("ldr", "r9", 2, $b),
                turn!("r9", "r3", "r10"),
                leg!("ldr", "r10", 0, $b),
                "shadd16 r10, r10, r6\n",
                sums!(),
                look!("r7": "r9", "r11", "r8", "r10"),
                store!($b),
            )
        };
    }
    // The offsets of a second block of 256 points and more do not fit in an instruction.
    macro_rules! between {
        () => {
            ".if {next} == 0\n add r0, r0, #16*{l}\n .endif\n"
        };
    }
    kernel!(
        enter!(16),
        "add r4, r0, #4",
        "add r5, r0, #4*{l}",
        "add r2, r2, r3",
        "strd r4, r5, [sp]",     // the next point of a leg, and the leg's end
        "strd r2, r3, [sp, #8]", // its factors, and the stride
        rounding!(),
        "mov r12, #0",
        "mov lr, #{turns}", // what turns one rounding of leg 0 into the other
        ".p2align 2",
        "2:",
        first!(0),
        between!(),
        first!(1),
        "add r0, r0, #{rest}",
        "cmp r0, r1",
        "blo 2b",
        "3:",
        "eor r6, r6, r12",  // at every other factor
        "eor r12, r12, lr",
        "ldr r0, [sp]",
        "ldrd r7, r8, [sp, #8]",
        "ldm r7, {{r2, r3, r4}}",
        "add r7, r7, r8",
        "str r7, [sp, #8]",
        "add r7, r0, #4",
        "str r7, [sp]",
        "4:",
        turned!(0),
        between!(),
        turned!(1),
        "add r0, r0, #{rest}",
        "cmp r0, r1",
        "blo 4b",
        "ldrd r7, r8, [sp]",
        "cmp r7, r8",
        "blo 3b",
        leave!(16),
        twice = const TWICE as u32,
        turns = const 0x1_0001 * (1 ^ second(TWICE)),
        // No caller asks for a longer pass, but the assembler sees such lengths.
        l = const if L <= 256 { L } else { 4 },
        next = const if L < 256 { 16 * L } else { 0 },
        rest = const if L < 256 { 32 * L } else { 16 * 256 },
    )
}

/// The last pass, which has one block. If `TWICE`, it halves a second time.
///
/// # Safety
/// `block` must be 4 L aligned points, `table` the factors of that many.
#[unsafe(naked)]
unsafe extern "C" fn only<const L: usize, const TWICE: bool>(
    block: *mut Pair,
    table: *const Triple,
) -> u32 {
    macro_rules! store {
        () => {
            lines!(
                "str r11, [r0, #4*{l}-{bias}]",
                "str r10, [r1, #4*{l}-{bias}]",
                ".if {bias}",
                "str r9, [r0, #-4]",
                "str r8, [r1, #-4]",
                "add r0, r0, #4",
                "add r1, r1, #4",
                ".else",
                "str r9, [r0], #4",
                "str r8, [r1], #4",
                ".endif"
            )
        };
    }
    macro_rules! turned {
        () => {
            concat!(
                "ldm r2!, {{r3, r4, lr}}\n",
                "ldr r7, [r0, #4*{l}-{bias}]\n",
                "ldr r8, [r1, #4*{l}-{bias}]\n",
                turn!("r7", "r3", "r9"),
                turn!("r8", "lr", "r9"),
                "ldr r9, [r1, #0-{bias}]\n",
                turn!("r9", "r4", "r10"),
                "ldr r10, [r0, #0-{bias}]\n",
                "shadd16 r10, r10, r6\n",
                sums!(),
                store!(),
            )
        };
    }
    kernel!(
        enter!(4),
        // One pointer reaches legs 0 and 1, the other legs 2 and 3.
        "add r2, r1, #12",
        "add r0, r0, #{bias}",
        "add r1, r0, #8*{l}",
        "add r12, r0, #4*{l}",
        "str r12, [sp]",
        "mov r12, #{turns}", // one rounding of leg 0 into the other
        rounding!(),
        "ldr r7, [r0, #4*{l}-{bias}]",
        "ldr r8, [r1, #4*{l}-{bias}]",
        "ldr r9, [r1, #0-{bias}]",
        "ldr r10, [r0, #0-{bias}]",
        halves!(),
        sums!(),
        store!(),
        turned!(),
        ".p2align 2",
        "2:",
        "eor r6, r6, r12",
        turned!(),
        turned!(),
        "ldr r7, [sp]",
        "cmp r0, r7",
        "blo 2b",
        leave!(4),
        twice = const TWICE as u32,
        turns = const 0x1_0001 * (1 ^ second(TWICE)),
        l = const L,
        // An offset is at most 4095.
        bias = const if L >= 1024 { 4 } else { 0 },
    )
}
