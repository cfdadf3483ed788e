//! The search over a spectrum of a real record, and sums of powers.

use super::Point;
use crate::math::products::power;
use crate::spectrum::fft::assembly::{kernel, worth};
use crate::spectrum::fft::kernel_dsp::window;
use crate::spectrum::fft::twiddle::{MAX_LENGTH, Packed};
use crate::spectrum::scan::{Scan, over, worth};
use core::mem::{MaybeUninit, offset_of};
use core::ops::Range;

/// Pairs in a group.
const GROUP: usize = 16;
/// The most groups of a record.
const GROUPS: usize = MAX_LENGTH / 4 / GROUP;

/// The search of [`crate::spectrum::scan::real`] in another order. The kernel adds up the powers of groups of pairs, and then splits pairs
/// of the strongest group, and of the groups that may hold a stronger bin.
pub fn scan(points: &[Point], table: &[Packed], outermost: usize) -> Scan {
    let (length, middle) = (points.len(), points.len() / 2);
    let fits = (2 * GROUP..=MAX_LENGTH / 2).contains(&length) && (1..=middle).contains(&outermost);
    if table.len() < middle || !fits {
        return Scan::from(middle);
    }
    let start = points.as_ptr();
    let centre = points.get(middle).map_or(0, |&x| power(x));
    // The group of the outermost pair, which need not be whole, and its end.
    let (group, end) = (outermost / GROUP, outermost / GROUP * GROUP + GROUP);
    let mut places = [const { MaybeUninit::<u64>::uninit() }; GROUPS];
    let places = places.get_mut(group..middle / GROUP).unwrap_or_default();
    let [place, groups @ ..] = places else {
        return Scan { power: centre, total: centre, ..Scan::from(middle) };
    };
    // SAFETY: the first group are the pairs from `outermost` to its end. The other groups lie inside
    // `points`, from there to the last below the middle, and from their mirrors downwards; the kernel
    // writes all their places.
    let sums = unsafe {
        let first = power_sum(start.add(outermost), end - outermost, 0);
        let first = power_sum(start.add(length + 1 - end), end - outermost, first);
        let mut sums = Sums { total: first, most: first, left: groups.len() + 1 };
        if !groups.is_empty() {
            let upper = start.add(length + 1 - GROUP - end);
            let to = groups.as_mut_ptr().cast();
            group_powers(&mut sums, start.add(end), upper, groups.len(), to);
        }
        place.write(first);
        sums
    };
    // SAFETY: all places are written.
    let powers = unsafe { places.assume_init_ref() };
    // The strongest pair of the strongest group has a sixteenth of the group's power or more, and one of the pair's bins half of the
    // pair's.
    let best = centre.max(worth(sums.most / (2 * GROUP as u64)).wrapping_sub(1));
    let at = start.wrapping_add(middle);
    let mut seen = Seen { best, least: worth(best), at };
    let strongest = powers.len().saturating_sub(sums.left);
    visit_groups(powers, strongest, |index| {
        let before = GROUP * (group + index);
        let bin = before.max(outermost);
        let count = before + GROUP - bin;
        // SAFETY: the pairs from `bin` on lie inside `points`, their factors inside `table`.
        unsafe {
            let (lower, upper) = (start.add(bin), start.add(length - bin));
            split_pairs(&mut seen, lower, upper, table.as_ptr().add(bin), count);
        }
        seen.least
    });
    let bin = (seen.at as usize).wrapping_sub(start as usize) / size_of::<Point>();
    let total = centre.wrapping_add(sums.total);
    Scan { power: seen.best, total, ..Scan::from(bin) }
}

/// The scan of `pairs::alone` by vectors: bins in a row, of which only bins with at least the power of the strongest so far are looked at.
pub fn alone(points: &[Point], table: &[Packed], bins: Range<usize>) -> Scan {
    let mut places = [MaybeUninit::uninit(); 2 * GROUP];
    let (mut scan, mut next) = (Scan::from(bins.start), bins.start);
    while next < bins.end {
        let count = (bins.end - next).min(places.len());
        let places = places.get_mut(..count).unwrap_or_default();
        let row = window(points, table, next, places);
        let total = powers(0, row);
        scan = if total > scan.power {
            scan.then(over(row, next, core::convert::identity))
        } else {
            Scan { total: scan.total.wrapping_add(total), ..scan }
        };
        next += count;
    }
    scan
}

/// The scan of [`crate::spectrum::scan::over`] over all bins of an I/Q record. A group has points at both ends.
pub fn scan_iq(points: &[Point]) -> Scan {
    let mut places = [const { MaybeUninit::<u64>::uninit() }; MAX_LENGTH / 2 / GROUP];
    let (count, rest) = (points.len() / 2 / GROUP, points.len() % (2 * GROUP));
    let Some(places) = places.get_mut(..count).filter(|_| count > 0 && rest == 0) else {
        return Scan::from(0);
    };
    let Range { start, end } = points.as_ptr_range();
    let mut sums = Sums { total: 0, most: 0, left: count };
    // SAFETY: the groups fill `points`; the kernel writes as many places as there are.
    let powers = unsafe {
        group_powers(&mut sums, start, end.sub(GROUP), count, places.as_mut_ptr().cast());
        places.assume_init_ref()
    };
    let mut seen = Seen { best: 0, least: 1, at: start };
    visit_groups(powers, count.saturating_sub(sums.left), |group| {
        let before = GROUP * group;
        // SAFETY: both halves of a group lie inside `points`.
        unsafe {
            keep_strongest(&mut seen, start.add(before), GROUP);
            keep_strongest(&mut seen, end.sub(before + GROUP), GROUP);
        }
        seen.best.max(1)
    });
    let bin = (seen.at as usize).wrapping_sub(start as usize) / size_of::<Point>();
    Scan { power: seen.best, total: sums.total, ..Scan::from(bin) }
}

/// Calls `visit` with the strongest group, then with every other group whose power is at least the number that `visit` returned last.
#[inline(always)]
fn visit_groups(powers: &[u64], strongest: usize, mut visit: impl FnMut(usize) -> u64) {
    let mut least = visit(strongest);
    let mut left = powers.len();
    while left > 0 {
        // SAFETY: `left` powers are left.
        left = unsafe { next_group(powers.as_ptr_range().end.sub(left), left, least) };
        let group = powers.len() - left;
        if left > 0 && group != strongest {
            least = visit(group);
        }
        left = left.saturating_sub(1);
    }
}

/// `sum` plus the powers of `count` points.
///
/// # Safety
/// All these points must be readable.
#[unsafe(naked)]
unsafe extern "C" fn power_sum(points: *const Point, count: usize, sum: u64) -> u64 {
    kernel!(
        "push {{r7, lr}}",
        "lsl r1, r1, #1",
        "wlstp.32 lr, r1, 3f",
        "2:",
        "vldrw.u32 q0, [r0], #16",
        "vmlaldava.s32 r2, r3, q0, q0",
        "letp lr, 2b",
        "3:",
        "mov r0, r2",
        "mov r1, r3",
        "pop {{r7, pc}}",
    )
}

/// `sum` plus the powers of these points.
pub fn powers(sum: u64, points: &[Point]) -> u64 {
    // SAFETY: the points are readable.
    unsafe { power_sum(points.as_ptr(), points.len(), sum) }
}

/// The powers of groups.
#[repr(C)]
struct Sums {
    /// The sum of all groups.
    total: u64,
    /// The largest group.
    most: u64,
    /// The number of groups left at the largest one, itself included.
    left: usize,
}

/// Adds the powers of `count` groups to `sums`, and stores each at `to`. A group is [`GROUP`] points from `lower` upwards and equally many
/// from `upper` downwards.
///
/// # Safety
/// All these points must be readable, `to` must have a place for each group, and `count` must be 1 or more.
#[unsafe(naked)]
unsafe extern "C" fn group_powers(
    sums: &mut Sums,
    lower: *const Point,
    upper: *const Point,
    count: usize,
    to: *mut u64,
) {
    macro_rules! add {
        ($($q:literal),*) => {
            concat!($("vmlaldava.s32 r4, r5, ", $q, ", ", $q, "\n",)*)
        };
    }
    macro_rules! next {
        ($($q:literal),*) => {
            concat!($("vldrw.u32 ", $q, ", [r1], #16\n",)*)
        };
    }
    macro_rules! at {
        ($($q:literal, $at:literal);*) => {
            concat!($("vldrw.u32 ", $q, ", [r2, #", $at, "]\n",)*)
        };
    }
    kernel!(
        "ldr r12, [sp]",
        enter!(),
        "ldrd r6, r7, [r0, #{total}]",
        "ldrd r8, r9, [r0, #{most}]",
        "ldr r10, [r0, #{left}]",
        "dls lr, r3",
        "2:",
        next!("q0", "q1", "q2", "q3"),
        at!("q4", "16"; "q5", "32"; "q6", "48"; "q7", "64"),
        "vmlaldav.s32 r4, r5, q0, q0",
        add!("q1", "q2", "q3", "q4", "q5", "q6", "q7"),
        next!("q0", "q1", "q2", "q3"),
        at!("q4", "80"; "q5", "96"; "q6", "112"),
        "vldrw.u32 q7, [r2], #-128",
        add!("q0", "q1", "q2", "q3", "q4", "q5", "q6", "q7"),
        "strd r4, r5, [r12], #8",
        "adds r6, r6, r4",
        "adc r7, r7, r5",
        "cmp r8, r4",
        "sbcs r11, r9, r5",
        "blo 4f",
        "3:",
        "le lr, 2b",
        "strd r6, r7, [r0, #{total}]",
        "strd r8, r9, [r0, #{most}]",
        "str r10, [r0, #{left}]",
        leave!(),
        "4:",
        "mov r8, r4",
        "mov r9, r5",
        "mov r10, lr",
        "b 3b",
        total = const offset_of!(Sums, total),
        most = const offset_of!(Sums, most),
        left = const offset_of!(Sums, left),
    )
}

/// The number of powers left, itself included, at the first of `count` powers that is `least` or more; 0 if none is.
///
/// # Safety
/// All these powers must be readable.
#[unsafe(naked)]
unsafe extern "C" fn next_group(powers: *const u64, count: usize, least: u64) -> usize {
    kernel!(
        "push {{r4, r5, r7, lr}}",
        "wls lr, r1, 3f",
        "2:",
        "ldrd r4, r5, [r0], #8",
        "cmp r4, r2",
        "sbcs r12, r5, r3",
        "bhs 3f",
        "le lr, 2b",
        "mov lr, #0",
        "3:",
        "mov r0, lr",
        "pop {{r4, r5, r7, pc}}",
    )
}

/// The strongest bin so far.
#[repr(C)]
struct Seen {
    best: u64,
    /// The least power of a group that may hold a stronger bin, by [`worth`].
    least: u64,
    at: *const Point,
}

/// Keeps the strongest of these points; of equals the lowest.
///
/// # Safety
/// The points must be readable. `count` must be 1 or more.
#[unsafe(naked)]
unsafe extern "C" fn keep_strongest(seen: &mut Seen, points: *const Point, count: usize) {
    kernel!(
        "push {{r4-r8, lr}}",
        "ldrd r4, r5, [r0, #{best}]",
        "dls lr, r2",
        "2:",
        "ldrd r6, r7, [r1], #8",
        "smull r8, r12, r6, r6",
        "smlal r8, r12, r7, r7",
        "cmp r8, r4",
        "sbcs r6, r12, r5",
        "bhs 4f",
        "3:",
        "le lr, 2b",
        "strd r4, r5, [r0, #{best}]",
        "pop {{r4-r8, pc}}",
        "4:",
        "sub r7, r1, #8",
        "cmp r8, r4",
        "it eq",
        "cmpeq r12, r5",
        "bne 5f",
        "ldr r6, [r0, #{at}]",
        "cmp r7, r6",
        "bhs 3b",
        "5:",
        "mov r4, r8",
        "mov r5, r12",
        "str r7, [r0, #{at}]",
        "b 3b",
        best = const offset_of!(Seen, best),
        at = const offset_of!(Seen, at),
    )
}

/// Splits pairs that may hold the strongest bin and keeps that bin; of equals the lowest.
///
/// # Safety
/// `count` pairs must be readable, from `lower` upwards and from `upper` downwards, and equally many factors. `count` must be 1 or more.
#[unsafe(naked)]
unsafe extern "C" fn split_pairs(
    seen: &mut Seen,
    lower: *const Point,
    upper: *const Point,
    factors: *const Packed,
    count: usize,
) {
    // A bin of power r6, r11 at $at, which is $from and 8 bytes $way. If the bin is no stronger than r8, r9, the code goes to $not.
    macro_rules! keep {
        ($way:literal, $from:literal, $not:literal) => {
            lines!(
                concat!($way, " r12, ", $from, ", #8"),
                "cmp r8, r6",
                "sbcs r5, r9, r11",
                "blo 5f",
                "cmp r8, r6",
                "it eq",
                "cmpeq r9, r11",
                concat!("bne ", $not),
                "ldr r5, [r0, #{at}]",
                "cmp r5, r12",
                concat!("bls ", $not),
                "5:",
                "mov r8, r6",
                "mov r9, r11",
                "str r12, [r0, #{at}]"
            )
        };
    }
    kernel!(
        "ldr r12, [sp]",
        "push {{r4-r12, lr}}",
        "ldrd r8, r9, [r0, #{least}]",
        "sub r3, r3, r1, lsr #1",
        "dls lr, r12",
        "2:",
        "ldrd r4, r5, [r1], #8",
        "ldrd r6, r7, [r2], #-8",
        "smull r10, r11, r4, r4",
        "smlal r10, r11, r5, r5",
        "smlal r10, r11, r6, r6",
        "smlal r10, r11, r7, r7",
        "cmp r10, r8",
        "sbcs r12, r11, r9",
        "bhs 4f",
        "3:",
        "le lr, 2b",
        "strd r8, r9, [r0, #{least}]",
        "pop {{r4-r12, pc}}",
        "4:",
        "add r12, r3, r1, lsr #1",
        "ldr r12, [r12, #-4]",
        "ldrd r8, r9, [r0, #{best}]",
        "add r10, r4, r6",
        "sub r4, r4, r6",
        "sub r6, r5, r7",
        "add r5, r5, r7",
        "smulwt r7, r4, r12",
        "smulwb r4, r4, r12",
        "smlawt r4, r5, r12, r4",
        "smulwb r5, r5, r12",
        "sub r7, r7, r5",
        "add r5, r7, r10, asr #1",
        "rsb r7, r7, r10, asr #1",
        "add r10, r4, r6, asr #1",
        "sub r4, r4, r6, asr #1",
        "smull r6, r11, r5, r5",
        "smlal r6, r11, r10, r10",
        keep!("sub", "r1", "6f"),
        "6:",
        "smull r6, r11, r7, r7",
        "smlal r6, r11, r4, r4",
        keep!("add", "r2", "7f"),
        "7:",
        "strd r8, r9, [r0, #{best}]",
        worth!(),
        "orrs r4, r8, r9",
        "it eq",
        "moveq r8, #1",
        "b 3b",
        best = const offset_of!(Seen, best),
        least = const offset_of!(Seen, least),
        at = const offset_of!(Seen, at),
    )
}
