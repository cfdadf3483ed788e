//! The search.

use super::super::integer::Pair;
use super::super::twiddle::Packed;
use crate::spectrum::fft::assembly::kernel;
use crate::spectrum::q15_bins;
use crate::spectrum::scan::{SPARSE, Scan};

/// As [`q15_bins::scan`].
pub fn scan<const M: usize>(points: &[Pair], table: &[Packed]) -> Scan {
    let middle = M / 2;
    if points.len() != M || table.len() < middle || middle <= SPARSE {
        return Scan::from(middle);
    }
    let centre = points.get(middle).map_or(0, |&p| q15_bins::power(p));
    let from = points.as_ptr();
    let mut seen = Seen { total: centre as u64, best: centre, at: from.wrapping_add(middle) };
    // SAFETY: the pairs from middle-1 and middle+1 to 1 and the last, an odd number, lie inside
    // `points`, their factors inside `table`.
    unsafe {
        let (lower, upper) = (from.add(SPARSE), from.add(M - SPARSE));
        seen.best = centre.max((strongest_pair(lower, upper) >> 1) - 1);
        let factors = (table.as_ptr() as usize).wrapping_sub(from as usize);
        pairs_outwards(&mut seen, from, from.add(middle), factors);
    }
    let bin = (seen.at as usize).wrapping_sub(from as usize) / size_of::<Pair>();
    q15_bins::scanned(bin, seen.best, seen.total)
}

/// The state of the search, as [`pairs_outwards`] keeps it.
#[repr(C)]
struct Seen {
    total: u64,
    best: i32,
    at: *const Pair,
}

/// Scans the pairs of points beside `middle`, outwards to the second point and the last.
///
/// # Safety
/// There must be an odd number of pairs, three or more, in aligned points from `points` on.
/// `factors` is the distance in bytes from a point to its factor.
#[unsafe(naked)]
unsafe extern "C" fn pairs_outwards(
    seen: &mut Seen,
    points: *const Pair,
    middle: *const Pair,
    factors: usize,
) {
    // Points $p and $q, below and above. Adds the sum of their powers to r10, r11. If that sum is
    // as strong as r8, the code jumps out of line.
    macro_rules! pair {
        ($p:literal, $q:literal, $out:literal, $back:literal) => {
            concat!(
                "smuad r12, ",
                $p,
                ", ",
                $p,
                "\n smlad lr, ",
                $q,
                ", ",
                $q,
                ", r12\n",
                "adds r10, r10, lr\n adc r11, r11, #0\n cmp lr, r8\n bge ",
                $out,
                "f\n",
                $back,
                ":\n",
            )
        };
    }
    // The lower bin wins a tie against any above it; the upper bin must be stronger than all below
    // it. $down and $up are how far r0 and r2 have moved beyond the bins.
    macro_rules! risen {
        ($p:literal, $q:literal, $out:literal, $back:literal, $down:literal, $up:literal) => {
            concat!(
                $out,
                ":\n add r9, r0, #",
                $down,
                "\n ldr r9, [r3, r9]\n",
                "smuadx ",
                $p,
                ", ",
                $p,
                ", ",
                $q,
                "\n rsb r12, lr, r12, lsl #1\n",
                "smulwt r12, r12, r9\n smulwb ",
                $p,
                ", ",
                $p,
                ", r9\n sub r12, r12, ",
                $p,
                ", lsl #1\n",
                "add ",
                $p,
                ", r12, lr, asr #1\n rsb r12, r12, lr, asr #1\n",
                "cmp ",
                $p,
                ", r8\n itt ge\n movge r8, ",
                $p,
                "\n addge r1, r0, #",
                $down,
                "\n",
                "cmp r12, r8\n itt gt\n movgt r8, r12\n subgt r1, r2, #",
                $up,
                "\n",
                "b ",
                $back,
                "b\n",
            )
        };
    }
    kernel!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #8",
        "strd r0, r1, [sp]",
        "ldm r0, {{r10, r11}}",
        "ldr r8, [r0, #8]",
        "mov r1, r2",     // the strongest bin
        "sub r0, r2, #4", // downwards
        "add r2, r2, #4", // upwards
        "ldr r5, [r0], #-4",
        "ldr r6, [r2], #4",
        pair!("r5", "r6", "10", "11"),
        // Two pairs at once, each of two words.
        "sub r0, r0, #4",
        ".p2align 2",
        "2:",
        "ldrd r4, r5, [r0], #-8",
        "ldrd r6, r7, [r2], #8",
        pair!("r5", "r6", "20", "21"),
        pair!("r4", "r7", "30", "31"),
        "ldr r9, [sp, #4]",
        "cmp r0, r9",
        "bhs 2b",
        "ldr r0, [sp]",
        "strd r10, r11, [r0]",
        "strd r8, r1, [r0, #8]",
        "add sp, sp, #8",
        "pop {{r4-r11, pc}}",
        risen!("r5", "r6", "10", "11", "4", "4"),
        risen!("r5", "r6", "20", "21", "12", "8"),
        risen!("r4", "r7", "30", "31", "8", "4"),
    )
}

/// The largest sum of powers of every [`SPARSE`]-th pair of points, from the outermost pair inwards
/// until they meet.
///
/// # Safety
/// `lower..=upper` must be aligned points, more than one.
#[unsafe(naked)]
unsafe extern "C" fn strongest_pair(lower: *const Pair, upper: *const Pair) -> i32 {
    kernel!(
        "push {{r4, lr}}",
        "mov r12, #0",
        ".p2align 2",
        "2:",
        "ldr r2, [r0], #4*{sparse}",
        "ldr r3, [r1], #-4*{sparse}",
        "smuad r2, r2, r2",
        "smlad r2, r3, r3, r2",
        "cmp r2, r12",
        "it gt",
        "movgt r12, r2",
        "cmp r0, r1",
        "blo 2b",
        "mov r0, r12",
        "pop {{r4, pc}}",
        sparse = const SPARSE,
    )
}
