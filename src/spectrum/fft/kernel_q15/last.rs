//! The last pass, which has one block.

use super::super::integer::Pair;
use super::super::q15::second;
use super::super::twiddle::Triple;
use super::passes::LONGEST;
use crate::spectrum::fft::assembly::kernel;

/// The last pass by two neighbouring butterflies at a time. If `TWICE`, the pass halves a second time.
///
/// # Safety
/// `block` must be 4 L aligned points, L from 4 to 128, and `table` the factors of 4 L points.
#[unsafe(naked)]
pub unsafe extern "C" fn by_twos<const L: usize, const TWICE: bool>(
    block: *mut Pair,
    table: *const Triple,
) -> u32 {
    // Two neighbours of a leg; r0 is 8 bytes before leg 2's neighbours.
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
        // No caller needs longer legs, but the assembler sees such lengths.
        l = const if L <= LONGEST { L } else { 4 },
    )
}

/// The last pass with long legs. If `TWICE`, the pass halves a second time.
///
/// # Safety
/// `block` must be 4 L aligned points, `table` the factors of 4 L points.
#[unsafe(naked)]
pub unsafe extern "C" fn by_ones<const L: usize, const TWICE: bool>(
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
