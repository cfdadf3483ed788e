//! The search over a spectrum of 16 bits.

use super::super::integer::Pair;
use super::super::twiddle::Packed;
use crate::spectrum::fft::assembly::kernel;
use crate::spectrum::q15_bins;
use crate::spectrum::scan::{SPARSE, Scan};

/// The kernel for [`q15_bins::scan`].
///
/// `outermost` is the middle or one above a multiple of four.
pub fn scan<const M: usize>(points: &[Pair], table: &[Packed], outermost: usize) -> Scan {
    let middle = M / 2;
    let pairs = middle.wrapping_sub(outermost);
    if points.len() != M || table.len() < middle || !(pairs == 0 || pairs % 4 == 3) {
        return Scan::from(middle);
    }
    let centre = points.get(middle).map_or(0, |&p| q15_bins::power(p));
    let from = points.as_ptr();
    let mut seen = Seen { total: centre as u64, best: centre, at: from.wrapping_add(middle) };
    // SAFETY: the pairs from middle-1 and middle+1 to `outermost` and its mirror, a multiple of four but
    // one, lie inside `points`, their factors inside `table`.
    unsafe {
        let sparse = outermost.div_ceil(SPARSE) * SPARSE;
        if sparse < middle {
            let (lower, upper) = (from.add(sparse), from.add(M - sparse));
            seen.best = centre.max((strongest_pair(lower, upper) >> 1) - 1);
        }
        if pairs > 0 {
            let factors = (table.as_ptr() as usize).wrapping_sub(from as usize);
            pairs_outwards(&mut seen, from.add(outermost - 1), from.add(middle), factors);
        }
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

/// Scans the pairs of points beside `middle`, outwards to the point after `end` and its mirror.
///
/// # Safety
/// There must be 4 i + 3 pairs of aligned points, of which the lower ones lie between `end` and `middle`.
/// `factors` is the distance in bytes from a point to its factor.
#[unsafe(naked)]
unsafe extern "C" fn pairs_outwards(
    seen: &mut Seen,
    end: *const Pair,
    middle: *const Pair,
    factors: usize,
) {
    // Points $p and $q, below and above. Puts the sum of their powers into $sum. If the sum is at least r8, the code jumps out of line.
    macro_rules! pair {
        ($p:literal, $q:literal, $sum:literal, $out:literal, $back:literal) => {
            concat!(
                "smuad r12, ",
                $p,
                ", ",
                $p,
                "\n",
                "smlad ",
                $sum,
                ", ",
                $q,
                ", ",
                $q,
                ", r12\n",
                "cmp ",
                $sum,
                ", r8\n bge ",
                $out,
                "f\n",
                $back,
                ":\n",
            )
        };
    }
    // Two pairs. The powers of four points sum to less than 2^32.
    macro_rules! two_pairs {
        ($out:literal, $back:literal, $out2:literal, $back2:literal) => {
            concat!(
                "ldrd r4, r5, [r0], #-8\n ldrd r6, r7, [r2], #8\n",
                pair!("r5", "r6", "lr", $out, $back),
                pair!("r4", "r7", "r9", $out2, $back2),
                "add lr, lr, r9\n adds r10, r10, lr\n adc r11, r11, #0\n",
            )
        };
    }
    // The lower bin wins a tie against any above it; the upper bin must be stronger than all below it. $down and $up are the distances that
    // r0 and r2 have moved beyond the bins.
    macro_rules! risen {
        ($p:literal, $q:literal, $sum:literal, $w:literal, $out:literal, $back:literal, $down:literal, $up:literal) => {
            concat!(
                $out,
                ":\n add ",
                $w,
                ", r0, #",
                $down,
                "\n ldr ",
                $w,
                ", [r3, ",
                $w,
                "]\n",
                "smuadx ",
                $p,
                ", ",
                $p,
                ", ",
                $q,
                "\n",
                "rsb r12, ",
                $sum,
                ", r12, lsl #1\n",
                "smulwt r12, r12, ",
                $w,
                "\n smulwb ",
                $p,
                ", ",
                $p,
                ", ",
                $w,
                "\n",
                "sub r12, r12, ",
                $p,
                ", lsl #1\n",
                "add ",
                $p,
                ", r12, ",
                $sum,
                ", asr #1\n rsb r12, r12, ",
                $sum,
                ", asr #1\n",
                "cmp ",
                $p,
                ", r8\n ittt ge\n movge r8, ",
                $p,
                "\n",
                "addge ",
                $q,
                ", r0, #",
                $down,
                "\n strge ",
                $q,
                ", [sp, #4]\n",
                "cmp r12, r8\n ittt gt\n movgt r8, r12\n",
                "subgt ",
                $q,
                ", r2, #",
                $up,
                "\n strgt ",
                $q,
                ", [sp, #4]\n",
                "b ",
                $back,
                "b\n",
            )
        };
    }
    kernel!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #12",
        "strd r0, r2, [sp]", // at [sp, #4] is the strongest bin
        "ldm r0, {{r10, r11}}",
        "ldr r8, [r0, #8]",
        "sub r0, r2, #4", // downwards to r1
        "add r2, r2, #4", // upwards
        "ldr r5, [r0], #-4",
        "ldr r6, [r2], #4",
        pair!("r5", "r6", "lr", "10", "11"),
        "adds r10, r10, lr",
        "adc r11, r11, #0",
        // Two pairs at once, each of two words.
        "sub r0, r0, #4",
        "b 3f",
        ".p2align 2",
        "2:",
        two_pairs!("20", "21", "30", "31"),
        "3:",
        two_pairs!("40", "41", "50", "51"),
        "cmp r0, r1",
        "bhs 2b",
        "ldrd r0, r1, [sp]",
        "strd r10, r11, [r0]",
        "strd r8, r1, [r0, #8]",
        "add sp, sp, #12",
        "pop {{r4-r11, pc}}",
        risen!("r5", "r6", "lr", "r9", "10", "11", "4", "4"),
        risen!("r5", "r6", "lr", "r9", "20", "21", "12", "8"),
        risen!("r4", "r7", "r9", "r5", "30", "31", "8", "4"),
        risen!("r5", "r6", "lr", "r9", "40", "41", "12", "8"),
        risen!("r4", "r7", "r9", "r5", "50", "51", "8", "4"),
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
