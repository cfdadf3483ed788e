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
    // SAFETY: the caller guarantees it. If there is more than one block, there are at least four.
    let q = unsafe {
        match (4 * L == M, L > LONGEST, twice) {
            (true, false, false) => last_by_twos::<L, false>(points, table),
            (true, false, true) => last_by_twos::<L, true>(points, table),
            (true, true, false) => last::<L, false>(points, table),
            (true, true, true) => last::<L, true>(points, table),
            (false, _, false) => blocks::<M, L, false>(points, table),
            (false, _, true) => blocks::<M, L, true>(points, table),
        }
    };
    q != 0
}

/// The longest legs of a last pass that one pointer reaches with instructions that load two words.
const LONGEST: usize = 128;

/// x (cos - j sin) / 2 rounded, in place: $factor is packed as `cos | -sin << 16`, the rounding is
/// in $half.
macro_rules! turn {
    ($x:literal, $factor:literal, $free:literal, $half:literal) => {
        concat!(
            "smlsd ",
            $free,
            ", ",
            $x,
            ", ",
            $factor,
            ", ",
            $half,
            "\n",
            "smladx ",
            $x,
            ", ",
            $x,
            ", ",
            $factor,
            ", ",
            $half,
            "\n",
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

/// The sums of a butterfly in place, from leg 0, halved, in $a and legs 1, 2, 3, turned, in $b, $c,
/// $d. They give points 0 $c, 1 $free, 2 $d, 3 $a, and $b is free.
macro_rules! sums {
    ($a:literal, $b:literal, $c:literal, $d:literal, $free:literal) => {
        concat!(
            "sadd16 ",
            $free,
            ", ",
            $b,
            ", ",
            $d,
            "\n ssub16 ",
            $b,
            ", ",
            $b,
            ", ",
            $d,
            "\n",
            "sadd16 ",
            $d,
            ", ",
            $a,
            ", ",
            $c,
            "\n ssub16 ",
            $a,
            ", ",
            $a,
            ", ",
            $c,
            "\n",
            ".if {twice}\n",
            "shadd16 ",
            $c,
            ", ",
            $d,
            ", ",
            $free,
            "\n shsub16 ",
            $d,
            ", ",
            $d,
            ", ",
            $free,
            "\n",
            "shsax ",
            $free,
            ", ",
            $a,
            ", ",
            $b,
            "\n shasx ",
            $a,
            ", ",
            $a,
            ", ",
            $b,
            "\n",
            ".else\n",
            "sadd16 ",
            $c,
            ", ",
            $d,
            ", ",
            $free,
            "\n ssub16 ",
            $d,
            ", ",
            $d,
            ", ",
            $free,
            "\n",
            "ssax ",
            $free,
            ", ",
            $a,
            ", ",
            $b,
            "\n sasx ",
            $a,
            ", ",
            $a,
            ", ",
            $b,
            "\n",
            ".endif\n",
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
    // Goes on with the next four blocks at $label, then to the next points of all.
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
        // No caller asks for a longer pass, but the assembler sees such lengths.
        l = const if L <= 128 { L } else { 4 },
        m = const M,
        stride = const M / 4 / L * size_of::<Triple>(),
        next = const if L < 128 { 16 * L } else { 0 },
    )
}

/// The last pass, which has one block, two neighbouring butterflies at a time. If `TWICE`, it halves
/// a second time.
///
/// # Safety
/// `block` must be 4 L aligned points, L from 4 to 128, and `table` the factors of that many.
#[unsafe(naked)]
unsafe extern "C" fn last_by_twos<const L: usize, const TWICE: bool>(
    block: *mut Pair,
    table: *const Triple,
) -> u32 {
    // Two neighbours of a leg; r0 is 8 bytes before those of leg 2.
    macro_rules! leg {
        ($do:literal, $x:literal, $y:literal, $leg:literal) => {
            concat!($do, " ", $x, ", ", $y, ", [r0, #8-8*{l}+", $leg, "*4*{l}]\n")
        };
    }
    macro_rules! load {
        () => {
            concat!(
                leg!("ldrd", "r4", "r5", 1),
                leg!("ldrd", "r6", "r7", 3),
                leg!("ldrd", "r8", "r9", 2)
            )
        };
    }
    // Legs 1, 2 and 3 by the next factors.
    macro_rules! turned {
        ($b:literal, $c:literal, $d:literal) => {
            concat!(
                "ldm r1!, {{r2, r3, r10}}\n",
                turn!($b, "r2", "r11", "lr"),
                turn!($c, "r3", "r11", "lr"),
                turn!($d, "r10", "r11", "lr"),
            )
        };
    }
    macro_rules! finish {
        () => {
            concat!(
                leg!("ldrd", "r2", "r3", 0),
                "shadd16 r2, r2, r12\n shadd16 r3, r3, r12\n",
                sums!("r2", "r4", "r8", "r6", "r10"),
                sums!("r3", "r5", "r9", "r7", "r11"),
                leg!("strd", "r8", "r9", 0),
                leg!("strd", "r10", "r11", 1),
                leg!("strd", "r2", "r3", 3),
                "strd r6, r7, [r0, #8]!\n",
            )
        };
    }
    macro_rules! two {
        () => {
            concat!(
                "eor r12, r12, #{turns}\n",
                load!(),
                turned!("r4", "r8", "r6"),
                turned!("r5", "r9", "r7"),
                finish!(),
            )
        };
    }
    kernel!(
        enter!(4),
        "add r1, r1, #12",
        "add r0, r0, #8*{l}-8",
        "add r2, r0, #4*{l}",
        "str r2, [sp]",
        "mov lr, #0x8000",
        "mov r12, #0x10001",
        load!(),
        "shadd16 r4, r4, r12",
        "shadd16 r6, r6, r12",
        "shadd16 r8, r8, r12",
        turned!("r5", "r9", "r7"),
        finish!(),
        two!(),
        ".if {l} > 4",
        ".p2align 2",
        "2:",
        two!(),
        two!(),
        "ldr r2, [sp]",
        "cmp r0, r2",
        "blo 2b",
        ".endif",
        leave!(4),
        twice = const TWICE as u32,
        turns = const 0x1_0001 * (1 ^ second(TWICE)),
        // No caller asks for longer legs, but the assembler sees such lengths.
        l = const if L <= LONGEST { L } else { 4 },
    )
}

/// The last pass, which has one block, with long legs. If `TWICE`, it halves a second time.
///
/// # Safety
/// `block` must be 4 L aligned points, `table` the factors of that many.
#[unsafe(naked)]
unsafe extern "C" fn last<const L: usize, const TWICE: bool>(
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
                turn!("r7", "r3", "r9", "r5"),
                turn!("r8", "lr", "r9", "r5"),
                "ldr r9, [r1, #0-{bias}]\n",
                turn!("r9", "r4", "r10", "r5"),
                "ldr r10, [r0, #0-{bias}]\n",
                "shadd16 r10, r10, r6\n",
                sums!("r10", "r7", "r9", "r8", "r11"),
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
        sums!("r10", "r7", "r9", "r8", "r11"),
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
