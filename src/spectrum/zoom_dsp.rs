//! The loops of [`super::zoom`] on cores with the DSP extension. Each equals its portable
//! definition bit for bit, on every input; the tests on emulated cores drive both. None branches on
//! data.
//!
//! The functions are naked: they change only the registers and memory that their instructions name.
//! All save `r4` to `r11` and return by `pop`.

use super::fft::assembly::kernel;
use super::fft::integer::{Pair, Point};
use super::zoom::{self, DIAGONAL, FACTORS, Factor, LONGEST, POINTS, shift};
use crate::acquire::sample::{Iq, Real, Record};
use core::mem::MaybeUninit;
use core::ops::Range;

/// The kernels for [`zoom::mix`].
pub fn mix<R: Record, const N: usize>(
    pairs: &[Pair],
    factors: &[Factor; LONGEST],
) -> [Point; POINTS] {
    let length = if R::IQ { N } else { N / 2 };
    let (from, factor) = (pairs.as_ptr(), factors.as_ptr());
    // The loops load two pairs at once, which must be aligned.
    let fits = length >= 2 * POINTS && N <= LONGEST * POINTS && pairs.len() == length;
    if !fits || !from.cast::<u32>().is_aligned() || !factor.cast::<u32>().is_aligned() {
        return zoom::mix::<R, N>(pairs, factors);
    }
    let mut points = MaybeUninit::<[Point; POINTS]>::uninit();
    let to = points.as_mut_ptr().cast::<Point>();
    // SAFETY: the kernels for N read no more pairs and factors than there are; they write 32 points.
    unsafe {
        summed::<R, N>(from, factor, to);
        points.assume_init()
    }
}

/// The sums of all blocks: in 32 bits if all fit. The first two blocks are tried before the others,
/// because loud codes of 16 bits do not fit anywhere.
///
/// # Safety
/// The conditions of [`weighed`] or [`turned`].
#[inline(never)] // otherwise the points are copied
unsafe fn summed<R: Record, const N: usize>(
    from: *const Pair,
    factors: *const Factor,
    to: *mut Point,
) {
    let block = if R::IQ { N } else { N / 2 } / POINTS;
    let fit = |blocks: Range<usize>| {
        let from = from.wrapping_add(blocks.start * block);
        let (to, end) = (to.wrapping_add(blocks.start), to.wrapping_add(blocks.end));
        // SAFETY: the caller guarantees it.
        let q = unsafe {
            if R::IQ {
                turned_briefly::<N>(from, factors, to, end)
            } else {
                weighed_briefly::<N>(from, factors, to, end)
            }
        };
        q == 0
    };
    if !(fit(0..2) && fit(2..POINTS)) {
        // SAFETY: the caller guarantees it.
        unsafe {
            if R::IQ { turned::<N>(from, factors, to) } else { weighed::<N>(from, factors, to) }
        }
    }
}

/// The kernels for [`zoom::transform`].
pub fn transform(mut points: [Point; POINTS]) -> [Point; POINTS] {
    let mut bins = MaybeUninit::<[Point; POINTS]>::uninit();
    // SAFETY: both arrays hold 32 points, and the second pass writes all of its own.
    unsafe {
        fours(points.as_mut_ptr(), FACTORS.as_ptr().cast());
        eights(points.as_mut_ptr(), bins.as_mut_ptr().cast());
        bins.assume_init()
    }
}

/// Two words of a block and of the next block times the same factors, r6 to r9, summed in r2, r3 and in r4, r5. For the first word, then
/// for the second, an instruction and a factor of the real and of the imaginary part; last, the numbers to which the first word's products
/// are added.
macro_rules! two_blocks {
    ($load:literal, $re:literal $w:literal, $im:literal $v:literal; $re2:literal $w2:literal, $im2:literal $v2:literal; $a:literal $b:literal $c:literal $d:literal) => {
        concat!(
            $load,
            "\n ldrd r10, r11, [r0], #8\n",
            $re,
            " r2, r10, ",
            $w,
            $a,
            "\n ",
            $im,
            " r3, r10, ",
            $v,
            $b,
            "\n",
            $re2,
            " r2, r11, ",
            $w2,
            ", r2\n ",
            $im2,
            " r3, r11, ",
            $v2,
            ", r3\n",
            "ldrd r10, r11, [r0, #{block}-8]\n",
            $re,
            " r4, r10, ",
            $w,
            $c,
            "\n ",
            $im,
            " r5, r10, ",
            $v,
            $d,
            "\n",
            $re2,
            " r4, r11, ",
            $w2,
            ", r4\n ",
            $im2,
            " r5, r11, ",
            $v2,
            ", r5\n",
        )
    };
}

/// Sums of two blocks at once in 32 bits, until the points reach `end`: $first for their first two words, $next for the others. Returns Q,
/// which is set by a sum that does not fit.
macro_rules! briefly {
    ($first:expr, $next:expr) => {
        concat!(
            "push {{r4-r11, lr}}
             mov lr, r2
             mov r12, r3
             mov r4, #0
             msr apsr_nzcvq, r4
             .p2align 2
             2:\n",
            $first,
            ".rept {groups}-1\n",
            $next,
            ".endr
             asr r2, r2, #{shift}
             asr r3, r3, #{shift}
             strd r2, r3, [lr], #8
             asr r4, r4, #{shift}
             asr r5, r5, #{shift}
             strd r4, r5, [lr], #8
             add r0, r0, #{block}
             sub r1, r1, #{factors}
             cmp lr, r12
             bne 2b
             mrs r0, apsr
             and r0, r0, #0x08000000
             pop {{r4-r11, pc}}"
        )
    };
}

/// Real samples: `zoom::weighed` and its shift for whole pairs of blocks, if their sums fit 32 bits;
/// returns 0 if so.
///
/// # Safety
/// The conditions of [`weighed`]; `to..end` must be an even number of points, at least two, and `from` their blocks.
#[unsafe(naked)]
unsafe extern "C" fn weighed_briefly<const N: usize>(
    from: *const Pair,
    factors: *const Factor,
    to: *mut Point,
    end: *mut Point,
) -> u32 {
    macro_rules! words {
        ($op:literal $($sum:literal)*) => {
            two_blocks!(
                "ldm r1!, {{r6, r7, r8, r9}}",
                $op "r6", $op "r7"; "smlad" "r8", "smlad" "r9"; $($sum)*
            )
        };
    }
    kernel!(
        briefly!(words!("smuad" "" "" "" ""), words!("smlad" ", r2" ", r3" ", r4" ", r5")),
        // No caller asks for fewer samples, but the assembler sees them.
        groups = const if N >= 128 { N / POINTS / 4 } else { 1 },
        block = const N / POINTS * size_of::<i16>(),
        factors = const N / POINTS * size_of::<Factor>(),
        shift = const shift::<Real, N>(),
    )
}

/// I/Q samples: `zoom::turned` and its shift for whole pairs of blocks, if their sums fit 32 bits; returns 0 if so.
///
/// # Safety
/// The conditions of [`turned`] and [`weighed_briefly`].
#[unsafe(naked)]
unsafe extern "C" fn turned_briefly<const N: usize>(
    from: *const Pair,
    factors: *const Factor,
    to: *mut Point,
    end: *mut Point,
) -> u32 {
    macro_rules! words {
        ($re:literal $im:literal $($sum:literal)*) => {
            two_blocks!(
                "ldrd r6, r7, [r1], #8",
                $re "r6", $im "r6"; "smlsd" "r7", "smladx" "r7"; $($sum)*
            )
        };
    }
    kernel!(
        briefly!(
            words!("smusd" "smuadx" "" "" "" ""),
            words!("smlsd" "smladx" ", r2" ", r3" ", r4" ", r5")
        ),
        groups = const N / POINTS / 2,
        block = const N / POINTS * size_of::<Pair>(),
        factors = const N / POINTS * size_of::<Factor>(),
        shift = const shift::<Iq, N>(),
    )
}

/// Sums in r4, r5 and r6, r7, over 32 blocks of `{groups}` times two pairs with four factors each.
macro_rules! blocks {
    ($($sum:literal)*) => {
        concat!(
            "push {{r4-r11, lr}}
             add r3, r2, #256
             2:
             mov r4, #0
             mov r5, #0
             mov r6, #0
             mov r7, #0
             .rept {groups}\n",
            $($sum, "\n",)*
            ".endr
             lsr r4, r4, #{shift}
             lsr r6, r6, #{shift}
             orr r4, r4, r5, lsl #32-{shift}
             orr r6, r6, r7, lsl #32-{shift}
             strd r4, r6, [r2], #8
             sub r1, r1, #{factors}
             cmp r2, r3
             bne 2b
             pop {{r4-r11, pc}}"
        )
    };
}

/// Real samples: `zoom::weighed` and its shift, for all blocks.
///
/// # Safety
/// `from` must be the N/2 pairs of a record of N = 128 to 4096 samples, `factors` N/32 factors,
/// both aligned to words, and `to` 32 points.
#[unsafe(naked)]
unsafe extern "C" fn weighed<const N: usize>(
    from: *const Pair,
    factors: *const Factor,
    to: *mut Point,
) {
    kernel!(
        blocks!(
            "ldrd r8, r9, [r0], #8"
            "ldm r1!, {{r10, r11, r12, lr}}"
            "smlald r4, r5, r8, r10"
            "smlald r6, r7, r8, r11"
            "smlald r4, r5, r9, r12"
            "smlald r6, r7, r9, lr"
        ),
        groups = const N / POINTS / 4,
        factors = const N / POINTS * size_of::<Factor>(),
        shift = const shift::<Real, N>(),
    )
}

/// I/Q samples: `zoom::turned` and its shift, for all blocks.
///
/// # Safety
/// The conditions of [`weighed`], for the N pairs of N = 64 to 4096 samples.
#[unsafe(naked)]
unsafe extern "C" fn turned<const N: usize>(
    from: *const Pair,
    factors: *const Factor,
    to: *mut Point,
) {
    kernel!(
        blocks!(
            "ldrd r8, r9, [r0], #8"
            "ldrd r10, r11, [r1], #8"
            "smlsld r4, r5, r8, r10"
            "smlaldx r6, r7, r8, r10"
            "smlsld r4, r5, r9, r11"
            "smlaldx r6, r7, r9, r11"
        ),
        groups = const N / POINTS / 2,
        factors = const N / POINTS * size_of::<Factor>(),
        shift = const shift::<Iq, N>(),
    )
}

/// Transforms four points at `$step` bytes from each other: 0 to r8, r9; 1 to r6, r7; 2 to r10,
/// r11; 3 to r2, r3.
macro_rules! four {
    ($first:literal, $step:literal) => {
        concat!(
            "ldrd r2, r3, [r0, #",
            $first,
            "]
             ldrd r4, r5, [r0, #",
            $first,
            "+",
            $step,
            "]
             ldrd r6, r7, [r0, #",
            $first,
            "+2*",
            $step,
            "]
             ldrd r8, r9, [r0, #",
            $first,
            "+3*",
            $step,
            "]
             add r10, r2, r6
             add r11, r3, r7
             sub r2, r2, r6
             sub r3, r3, r7
             add r6, r4, r8
             add r7, r5, r9
             sub r4, r4, r8
             sub r5, r5, r9
             add r8, r10, r6
             add r9, r11, r7
             sub r10, r10, r6
             sub r11, r11, r7
             add r6, r2, r5
             sub r7, r3, r4
             sub r2, r2, r5
             add r3, r3, r4\n"
        )
    };
}

/// `zoom::turn` of a point by the next factor, stored at `$at`.
macro_rules! turn {
    ($re:literal, $im:literal, $at:literal) => {
        concat!(
            "ldrd r4, r5, [r1], #8\n",
            "smmulr r12, ",
            $re,
            ", r4\n smmlsr r12, ",
            $im,
            ", r5, r12\n",
            "smmulr lr, ",
            $re,
            ", r5\n smmlar lr, ",
            $im,
            ", r4, lr\n",
            "strd r12, lr, [r0, #",
            $at,
            "]\n"
        )
    };
}

/// The first pass: eight transforms of four points, turned.
///
/// # Safety
/// `points` must be 32 points, `factors` the factors [`zoom::FACTORS`].
#[unsafe(naked)]
unsafe extern "C" fn fours(points: *mut Point, factors: *const Point) {
    kernel!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #4",
        "add r2, r0, #64",
        "str r2, [sp]",
        "2:",
        four!("0", "64"),
        turn!("r6", "r7", "64"),
        turn!("r10", "r11", "128"),
        turn!("r2", "r3", "192"),
        "asr r8, r8, #1",
        "asr r9, r9, #1",
        "strd r8, r9, [r0], #8",
        "ldr r2, [sp]",
        "cmp r0, r2",
        "bne 2b",
        "add sp, sp, #4",
        "pop {{r4-r11, pc}}",
    )
}

/// Stores the sum of an even part at `$even` and an odd part at `$sum`, and their difference at
/// `$difference`. `$re` and `$im` are added to the real and to the imaginary part, by `$add` and
/// `$sub`.
macro_rules! butterfly {
    ($even:literal, $re:literal, $im:literal, $add:literal, $sub:literal, $sum:literal, $difference:literal) => {
        concat!(
            "ldrd r4, r5, [r0, #",
            $even,
            "]\n",
            "add lr, r4, ",
            $re,
            "\n sub r4, r4, ",
            $re,
            "\n",
            $add,
            " r12, r5, ",
            $im,
            "\n ",
            $sub,
            " r5, r5, ",
            $im,
            "\n",
            "strd lr, r12, [r1, #",
            $sum,
            "]\n strd r4, r5, [r1, #",
            $difference,
            "]\n"
        )
    };
}

/// The second pass: four transforms of eight points, each giving every fourth bin.
///
/// # Safety
/// `points` and `bins` must be 32 points each.
#[unsafe(naked)]
unsafe extern "C" fn eights(points: *mut Point, bins: *mut Point) {
    kernel!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #4",
        "add r2, r1, #32",
        "str r2, [sp]",
        "2:",
        four!("0", "16"),
        "strd r8, r9, [r0]",
        "strd r6, r7, [r0, #16]",
        "strd r10, r11, [r0, #32]",
        "strd r2, r3, [r0, #48]",
        four!("8", "16"),
        // Points 1 and 3 by an eighth of a turn, halved.
        "movw r12, #{low}",
        "movt r12, #{high}",
        "add r4, r6, r7",
        "sub r5, r7, r6",
        "smmulr r6, r4, r12",
        "smmulr r7, r5, r12",
        "add r4, r2, r3",
        "sub r5, r3, r2",
        "smmulr r2, r4, r12",
        "smmulr r3, r5, r12",
        butterfly!("0", "r8", "r9", "add", "sub", "0", "128"),
        butterfly!("16", "r6, lsl #1", "r7, lsl #1", "add", "sub", "32", "160"),
        butterfly!("32", "r11", "r10", "sub", "add", "64", "192"),
        butterfly!("48", "r3, lsl #1", "r2, lsl #1", "sub", "add", "96", "224"),
        "add r0, r0, #64",
        "add r1, r1, #8",
        "ldr r2, [sp]",
        "cmp r1, r2",
        "bne 2b",
        "add sp, sp, #4",
        "pop {{r4-r11, pc}}",
        low = const DIAGONAL & 0xffff,
        high = const DIAGONAL >> 16,
    )
}
