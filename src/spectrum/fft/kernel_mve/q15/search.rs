//! The search over the whole spectrum.

use super::powers::{
    GROUP, SHARE, Sums, group_powers, last_group, next_strong, power_sum, strongest_of,
    strongest_pair,
};
use crate::spectrum::fft::assembly::kernel;
use crate::spectrum::fft::integer::Pair;
use crate::spectrum::fft::twiddle::{MAX_LENGTH, Packed};
use crate::spectrum::q15_bins::{self, SQUARES, power};
use crate::spectrum::scan::{SPARSE, Scan};
use core::mem::MaybeUninit;

/// The most groups of a record.
const GROUPS: usize = MAX_LENGTH / 2 / GROUP;
/// Bytes of a point.
const BYTES: usize = size_of::<Pair>();

/// The search of [`q15_bins::scan`] in its order, but only in groups of pairs whose power is [`worth`] it.
pub fn scan<const M: usize>(points: &[Pair], table: &[Packed], outermost: usize) -> Scan {
    let middle = M / 2;
    let fits = (2 * GROUP..=MAX_LENGTH / 2).contains(&M) && (1..=middle).contains(&outermost);
    if points.len() != M || table.len() < middle || !fits {
        return Scan::from(middle);
    }
    let start = points.as_ptr();
    let centre = points.get(middle).map_or(0, |&p| power(p));
    // The group of the outermost pair, which need not be whole, and its end.
    let (group, end) = (outermost / GROUP, outermost / GROUP * GROUP + GROUP);
    let mut places = [const { MaybeUninit::<u32>::uninit() }; GROUPS / 2];
    let places = places.get_mut(group..middle / GROUP).unwrap_or_default();
    let [place, groups @ ..] = places else {
        return q15_bins::scanned(middle, centre, u64::from(centre as u32));
    };
    // SAFETY: the first group are the pairs from `outermost` to its end. The other groups lie inside
    // `points`, from there to the last below the middle, and from their mirrors downwards; the kernel
    // writes all their places.
    let sums = unsafe {
        let first = power_sum(start.add(outermost), end - outermost, 0);
        let first = power_sum(start.add(M + 1 - end), end - outermost, first);
        let share = (first >> SHARE) as u32;
        let mut sums = Sums { total: first, most: share, left: groups.len() + 1 };
        if !groups.is_empty() {
            let upper = start.add(M + 1 - GROUP - end);
            let to = groups.as_mut_ptr().cast();
            group_powers(&mut sums, start.add(end), upper, groups.len(), to);
        }
        place.write(share);
        sums
    };
    // SAFETY: all places are written.
    let powers = unsafe { places.assume_init_ref() };
    let total = u64::from(centre as u32).wrapping_add(sums.total);
    if total == 0 {
        return q15_bins::scanned(outermost, 0, 0);
    }
    // Every SPARSE-th below the middle.
    let (inmost, count) = (middle - SPARSE, middle / SPARSE - outermost.div_ceil(SPARSE));
    // SAFETY: these pairs lie inside `points`.
    let sparse =
        unsafe { strongest_pair::<SPARSE>(start.add(inmost), start.add(M - inmost), count) };
    let mut seen = Seen { power: centre.max((sparse >> 1) - 1), at: start.wrapping_add(middle) };
    let (first, count) = pairs(group + powers.len().saturating_sub(sums.left), outermost);
    let inmost = first + count - 1;
    // SAFETY: the pairs of a group lie inside `points`.
    let most = unsafe { strongest_pair::<1>(start.add(inmost), start.add(M - inmost), count) };
    let least = worth(most >> 1);
    let mut left = powers.len();
    while left > 0 {
        let worth = (least.max(seen.power) as u32) >> SHARE;
        // SAFETY: `left` powers are left. So are the pairs of a group inside `points`, and their factors inside `table`.
        unsafe {
            left = last_group(powers.as_ptr().add(left), left, worth);
            if left > 0 {
                left -= 1;
                let pairs = pairs(group + left, outermost);
                visit::<M>(&mut seen, start, table.as_ptr(), pairs, least);
            }
        }
    }
    let bin = (seen.at as usize).wrapping_sub(start as usize) / BYTES;
    q15_bins::scanned(bin, seen.power, total)
}

/// The first pair of a group of a real record, and the number of its pairs from the outermost of all on.
const fn pairs(group: usize, outermost: usize) -> (usize, usize) {
    let first = if GROUP * group > outermost { GROUP * group } else { outermost };
    (first, GROUP * group + GROUP - first)
}

/// The least power of a group of pairs that [`q15_bins::scan`] needs, if some bin has the power `sure`.
///
/// The scan splits a pair of power S if S is at least the strongest bin so far, and by its rounding a bin of the pair has at most
/// `S + S 2^-15 + 4`. So a pair of less than `worth` that is left out affects only which of the later pairs within its bound are split.
/// Such a pair again affects only pairs up to its own bound, and so on: over 1024 pairs the bound grows by 3.2 % and 4300. That is still
/// less than `sure`, so it does not affect the result.
const fn worth(sure: i32) -> i32 {
    (sure - (sure >> 3)).saturating_sub(1 << 14)
}

/// Looks at the pairs of a group outwards, like [`q15_bins::scan`], but not at pairs of less than `least`.
///
/// # Safety
/// `points` must be M aligned points, `table` their factors, the pairs below their middle.
#[inline(always)]
unsafe fn visit<const M: usize>(
    seen: &mut Seen,
    points: *const Pair,
    table: *const Packed,
    (first, mut left): (usize, usize),
    least: i32,
) {
    let factors = (table as usize).wrapping_sub(points as usize);
    while left > 0 {
        // SAFETY: the caller guarantees these pairs and their factors.
        unsafe {
            let inmost = first + left - 1;
            let (lower, upper) = (points.add(inmost), points.add(M - inmost));
            left = next_strong(lower, upper, left, least.max(seen.power));
            if left > 0 {
                // The pair is one of four.
                let (inmost, count) = (first + left - 1, left.min(4));
                let (lower, upper) = (points.add(inmost), points.add(M - inmost));
                split_pairs(seen, lower, upper, factors, count);
                left -= count;
            }
        }
    }
}

/// The scan of [`q15_bins::over`] over all bins of an I/Q record. A group has points at both ends.
pub fn scan_iq(points: &[Pair]) -> Scan {
    let mut places = [const { MaybeUninit::<u32>::uninit() }; GROUPS];
    let (count, rest) = (points.len() / 2 / GROUP, points.len() % (2 * GROUP));
    let Some(places) = places.get_mut(..count).filter(|_| count > 0 && rest == 0) else {
        return Scan::from(0);
    };
    let start = points.as_ptr();
    let mut sums = Sums { total: 0, most: 0, left: count };
    // SAFETY: the groups fill `points`; the kernel writes as many places as there are.
    let powers = unsafe {
        let upper = start.add(points.len() - GROUP);
        group_powers(&mut sums, start, upper, count, places.as_mut_ptr().cast());
        places.assume_init_ref()
    };
    let (mut most, mut at) = (0, start);
    let mut look = |group: usize, most: u32| {
        let before = GROUP * group;
        // SAFETY: both halves of a group lie inside `points`.
        let spans = unsafe { [start.add(before), start.add(points.len() - GROUP - before)] };
        spans.into_iter().fold(most, |most, span| {
            // SAFETY: both halves of a group lie inside `points`, as above.
            let power = unsafe { strongest_of(span, GROUP) };
            if power > most || (power == most && span < at) {
                at = span;
            }
            power.max(most)
        })
    };
    let strongest = count.saturating_sub(sums.left);
    most = look(strongest, most);
    for (group, &share) in powers.iter().enumerate() {
        if group != strongest && share >= most >> SHARE {
            most = look(group, most);
        }
    }
    let before = (at as usize).wrapping_sub(start as usize) / BYTES;
    let span = points.get(before..).unwrap_or_default();
    let within = span.iter().position(|&bin| power(bin) as u32 == most).unwrap_or(0);
    let power = u64::from(most) << SQUARES;
    Scan { power, total: sums.total << SQUARES, ..Scan::from(before.wrapping_add(within)) }
}

/// The strongest bin so far.
#[repr(C)]
struct Seen {
    power: i32,
    at: *const Pair,
}

/// Looks at `count` pairs, points from `lower` downwards and from `upper` upwards. `factors` is the
/// distance in bytes from a lower point to its factor.
///
/// # Safety
/// All these points and factors must be readable, and `count` 1 or more.
#[unsafe(naked)]
unsafe extern "C" fn split_pairs(
    seen: &mut Seen,
    lower: *const Pair,
    upper: *const Pair,
    factors: usize,
    count: usize,
) {
    kernel!(
        "push {{r4-r11, lr}}",
        "ldr r12, [sp, #36]",
        "ldrd r8, r9, [r0]",
        "dls lr, r12",
        "2:",
        "ldr r4, [r1], #-4",
        "ldr r5, [r2], #4",
        "smuad r6, r4, r4",
        "smuad r7, r5, r5",
        "add r10, r6, r7",
        "cmp r10, r8",
        "bge 4f",
        "3:",
        "le lr, 2b",
        "strd r8, r9, [r0]",
        "pop {{r4-r11, pc}}",
        "4:",
        "add r11, r1, r3",
        "ldr r11, [r11, #4]",
        "smuadx r12, r4, r5",
        "sub r6, r6, r7",
        "smulwt r6, r6, r11",
        "smulwb r12, r12, r11",
        "sub r6, r6, r12, lsl #1",
        "add r7, r6, r10, asr #1",
        "rsb r6, r6, r10, asr #1",
        // The lower bin wins a tie against any above it; the upper bin must be stronger.
        "cmp r7, r8",
        "itt ge",
        "movge r8, r7",
        "addge r9, r1, #4",
        "cmp r6, r8",
        "itt gt",
        "movgt r8, r6",
        "subgt r9, r2, #4",
        "b 3b",
    )
}
