//! The search over the whole spectrum of a real record.

use super::Point;
use crate::math::products::power;
use crate::spectrum::fft::assembly::kernel;
use crate::spectrum::fft::integer::split_pair;
use crate::spectrum::fft::twiddle::{MAX_LENGTH, Packed};
use crate::spectrum::scan::{Scan, worth};
use core::mem::{MaybeUninit, offset_of};

/// Pairs in a group.
const GROUP: usize = 8;
/// The most groups of a record.
const GROUPS: usize = MAX_LENGTH / 4 / GROUP;

/// As [`crate::spectrum::scan::real`], but not in its order. It adds up the powers of groups of
/// pairs, and then splits pairs of the strongest group, and of those that may hold a stronger bin.
pub fn scan<const M: usize>(points: &[Point], table: &[Packed]) -> Scan {
    let middle = M / 2;
    if points.len() != M || table.len() < middle || !(4 * GROUP..=MAX_LENGTH / 2).contains(&M) {
        return Scan::from(middle);
    }
    let record = Record { points, table };
    let sum = |sum: u64, (p, q, _): (Point, Point, Packed)| {
        sum.wrapping_add(power(p)).wrapping_add(power(q))
    };
    let first = record.group(0).1.fold(0, sum);
    let mut places = [const { MaybeUninit::<u64>::uninit() }; GROUPS];
    let places = places.get_mut(..middle / GROUP - 1).unwrap_or_default();
    let mut sums = Sums { total: first, most: first, left: places.len() + 1 };
    // SAFETY: the groups lie inside `points`, from the second to the last below the middle and from
    // their mirrors downwards. The kernel writes all places.
    let others = unsafe {
        let upper = points.as_ptr().add(M + 1 - 2 * GROUP);
        let lower = points.as_ptr().add(GROUP);
        group_powers(&mut sums, lower, upper, places.len(), places.as_mut_ptr().cast());
        places.assume_init_ref()
    };
    let centre = points.get(middle).map_or(0, |&x| power(x));
    // The strongest pair of the strongest group has an eighth of its power or more, and one of the
    // pair's bins half of that.
    let sure = worth(sums.most >> 4).wrapping_sub(1);
    let mut scan = Scan { power: centre.max(sure), ..Scan::from(middle) };
    let strongest = (others.len() + 1).wrapping_sub(sums.left);
    record.visit(strongest, &mut scan);
    let mut least = worth(scan.power);
    for (group, &sum) in (0..).zip([first].iter().chain(others)) {
        if sum >= least && group != strongest {
            record.visit(group, &mut scan);
            least = worth(scan.power);
        }
    }
    Scan { total: centre.wrapping_add(sums.total), ..scan }
}

/// A record's points and the factors of its split.
struct Record<'a> {
    points: &'a [Point],
    table: &'a [Packed],
}

impl Record<'_> {
    /// The first bin of a group below the middle, and from there on the points, their mirrors and
    /// their factors. The first group has no pair at 0.
    #[inline(always)]
    fn group(&self, group: usize) -> (usize, impl Iterator<Item = (Point, Point, Packed)>) {
        let bins = (GROUP * group).max(1)..GROUP * (group + 1);
        let length = self.points.len() + 1;
        let mirrors = length.wrapping_sub(bins.end)..length.wrapping_sub(bins.start);
        let lower = self.points.get(bins.clone()).unwrap_or_default();
        let upper = self.points.get(mirrors).unwrap_or_default().iter().rev();
        let factors = self.table.get(bins.clone()).unwrap_or_default();
        let pairs = lower.iter().zip(upper).zip(factors);
        (bins.start, pairs.map(|((&p, &q), &w)| (p, q, w)))
    }

    /// Splits the pairs of a group that may hold the strongest bin.
    #[inline(never)]
    fn visit(&self, group: usize, scan: &mut Scan) {
        let (first, pairs) = self.group(group);
        let mut least = worth(scan.power);
        for (lower, (p, q, w)) in (first..).zip(pairs) {
            if power(p).wrapping_add(power(q)) >= least {
                let upper = self.points.len().wrapping_sub(lower);
                for (bin, x) in [lower, upper].into_iter().zip(split_pair(p, q, w)) {
                    let (bin, power) = (bin as i32, power(x));
                    // Of equals the lowest.
                    if power > scan.power || (power == scan.power && bin < scan.bin) {
                        (scan.power, scan.bin) = (power, bin);
                    }
                }
                least = worth(scan.power);
            }
        }
    }
}

/// The powers of groups.
#[repr(C)]
struct Sums {
    /// Their sum.
    total: u64,
    /// The largest.
    most: u64,
    /// How many groups were left when that one came, with it.
    left: usize,
}

/// Adds to `sums` the powers of as many groups as `count`, and stores each at `to`. The groups are
/// pairs of [`GROUP`] points from `lower` upwards and as many from `upper` downwards.
///
/// # Safety
/// All these points must be readable, `to` must be as many places, and `count` 1 or more.
#[unsafe(naked)]
unsafe extern "C" fn group_powers(
    sums: &mut Sums,
    lower: *const Point,
    upper: *const Point,
    count: usize,
    to: *mut u64,
) {
    kernel!(
        "ldr r12, [sp]",
        enter!(),
        "ldrd r6, r7, [r0, #{total}]",
        "ldrd r8, r9, [r0, #{most}]",
        "ldr r10, [r0, #{left}]",
        "dls lr, r3",
        "2:",
        "vldrw.u32 q0, [r1], #16",
        "vldrw.u32 q1, [r1], #16",
        "vldrw.u32 q2, [r1], #16",
        "vldrw.u32 q3, [r1], #16",
        "vldrw.u32 q4, [r2, #16]",
        "vldrw.u32 q5, [r2, #32]",
        "vldrw.u32 q6, [r2, #48]",
        "vldrw.u32 q7, [r2], #-64",
        "vmlaldav.s32 r4, r5, q0, q0",
        "vmlaldava.s32 r4, r5, q1, q1",
        "vmlaldava.s32 r4, r5, q2, q2",
        "vmlaldava.s32 r4, r5, q3, q3",
        "vmlaldava.s32 r4, r5, q4, q4",
        "vmlaldava.s32 r4, r5, q5, q5",
        "vmlaldava.s32 r4, r5, q6, q6",
        "vmlaldava.s32 r4, r5, q7, q7",
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
