//! Powers of points, of pairs of points and of groups of pairs, four at a time.

use crate::spectrum::fft::assembly::kernel;
use crate::spectrum::fft::integer::Pair;
use crate::spectrum::q15_bins::SQUARES;
use core::mem::offset_of;

/// Pairs of points in a group.
pub(super) const GROUP: usize = 16;
/// A group's power is stored shifted down by this many bits, and then fits in 32.
pub(super) const SHARE: u32 = 5;

/// `sum` plus the powers of these points in units of bins.
pub fn powers(sum: u64, points: &[Pair]) -> u64 {
    // SAFETY: the points are readable.
    sum.wrapping_add(unsafe { power_sum(points.as_ptr(), points.len(), 0) } << SQUARES)
}

/// `sum` plus the powers of `count` points.
///
/// # Safety
/// All these points must be readable.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn power_sum(points: *const Pair, count: usize, sum: u64) -> u64 {
    kernel!(
        "push {{r7, lr}}",
        "lsl r1, r1, #1",
        "wlstp.16 lr, r1, 3f",
        "2:",
        "vldrh.u16 q0, [r0], #16",
        "vmlaldava.s16 r2, r3, q0, q0",
        "letp lr, 2b",
        "3:",
        "mov r0, r2",
        "mov r1, r3",
        "pop {{r7, pc}}",
    )
}

/// The powers of groups.
#[repr(C)]
pub(super) struct Sums {
    /// The sum of all groups.
    pub total: u64,
    /// The largest group, shifted down by [`SHARE`].
    pub most: u32,
    /// The number of groups left at the largest one, itself included.
    pub left: usize,
}

/// Adds the powers of `count` groups to `sums`, and stores each at `to`, shifted down by [`SHARE`]. A group is [`GROUP`] points from
/// `lower` upwards and equally many from `upper` downwards.
///
/// # Safety
/// All these points must be readable and aligned, `to` must have a place for each group, and `count` must be 1 or more.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn group_powers(
    sums: &mut Sums,
    lower: *const Pair,
    upper: *const Pair,
    count: usize,
    to: *mut u32,
) {
    macro_rules! load {
        ($from:literal: $($q:literal),*) => {
            concat!($("vldrw.u32 ", $q, ", [", $from, "], #16\n",)*)
        };
    }
    macro_rules! add {
        ($($q:literal),*) => {
            concat!($("vmlaldava.s16 r4, r5, ", $q, ", ", $q, "\n",)*)
        };
    }
    kernel!(
        "ldr r12, [sp]",
        "push {{r4-r9, lr}}",
        "ldrd r6, r7, [r0, #{total}]",
        "ldrd r8, r9, [r0, #{most}]",
        "dls lr, r3",
        "2:",
        load!("r1": "q0", "q1", "q2", "q3"),
        "vmlaldav.s16 r4, r5, q0, q0",
        add!("q1", "q2", "q3"),
        "vldrw.u32 q1, [r2, #16]",
        "vldrw.u32 q2, [r2, #32]",
        "vldrw.u32 q3, [r2, #48]",
        "vldrw.u32 q0, [r2], #-64",
        add!("q1", "q2", "q3", "q0"),
        "adds r6, r6, r4",
        "adc r7, r7, r5",
        "lsrl r4, r5, #{share}",
        "str r4, [r12], #4",
        "cmp r8, r4",
        "blo 4f",
        "3:",
        "le lr, 2b",
        "strd r6, r7, [r0, #{total}]",
        "strd r8, r9, [r0, #{most}]",
        "pop {{r4-r9, pc}}",
        "4:",
        "mov r8, r4",
        "mov r9, lr",
        "b 3b",
        share = const SHARE,
        total = const offset_of!(Sums, total),
        most = const offset_of!(Sums, most),
    )
}

/// Four points in `$p` become their powers. Uses `$free`.
macro_rules! powers {
    ($p:literal, $free:literal) => {
        lines!(
            concat!("vmullb.s16 ", $free, ", ", $p, ", ", $p),
            concat!("vmullt.s16 ", $p, ", ", $p, ", ", $p),
            concat!("vadd.i32 ", $p, ", ", $p, ", ", $free)
        )
    };
}

/// The largest sum of powers of `count` pairs of points, every STEP-th: from `lower` downwards and
/// from `upper` upwards.
///
/// # Safety
/// All these points must be readable and aligned.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn strongest_pair<const STEP: usize>(
    lower: *const Pair,
    upper: *const Pair,
    count: usize,
) -> i32 {
    kernel!(
        "push {{r4, lr}}",
        "vpush {{d8-d11}}",
        "mov r4, #0",
        "vidup.u32 q0, r4, #4",
        "mov r4, #{step}",
        "vmul.i32 q0, q0, r4",
        "sub r1, r1, #16*{step}",
        "vadd.i32 q5, q0, r1",
        "vneg.s32 q0, q0",
        "add r0, r0, #16*{step}",
        "vadd.i32 q4, q0, r0",
        "mov r0, #0",
        "vmov.i32 q0, #0",
        "wlstp.32 lr, r2, 3f",
        "2:",
        "vldrw.u32 q1, [q4, #-16*{step}]!",
        "vldrw.u32 q2, [q5, #16*{step}]!",
        powers!("q1", "q3"),
        powers!("q2", "q3"),
        "vadd.i32 q1, q1, q2",
        "vmax.s32 q0, q0, q1",
        "letp lr, 2b",
        "3:",
        "vmaxv.s32 r0, q0",
        "vpop {{d8-d11}}",
        "pop {{r4, pc}}",
        step = const STEP,
    )
}

/// The largest power of `count` points.
///
/// # Safety
/// All these points must be readable.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn strongest_of(points: *const Pair, count: usize) -> u32 {
    kernel!(
        "push {{r7, lr}}",
        "mov r2, #0",
        "vmov.i32 q0, #0",
        "wlstp.32 lr, r1, 3f",
        "2:",
        "vldrw.u32 q1, [r0], #16",
        powers!("q1", "q2"),
        "vmax.u32 q0, q0, q1",
        "letp lr, 2b",
        "3:",
        "vmaxv.u32 r2, q0",
        "mov r0, r2",
        "pop {{r7, pc}}",
    )
}

/// The number of pairs left, of `count`, when one of the next four is as strong as `best`; 0 if none is. The pairs are points from `lower`
/// downwards and from `upper` upwards.
///
/// # Safety
/// All these points must be readable and aligned.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn next_strong(
    lower: *const Pair,
    upper: *const Pair,
    count: usize,
    best: i32,
) -> usize {
    kernel!(
        "push {{r4, lr}}",
        "vpush {{d8-d9}}",
        "mov r4, #0",
        "vidup.u32 q4, r4, #4",
        "vneg.s32 q4, q4",
        "add r0, r0, #16",
        "vadd.i32 q4, q4, r0",
        "mov r0, #0",
        "wlstp.32 lr, r2, 4f",
        "2:",
        "vldrw.u32 q0, [q4, #-16]!",
        "vldrw.u32 q1, [r1], #16",
        powers!("q0", "q2"),
        powers!("q1", "q2"),
        "vadd.i32 q0, q0, q1",
        "vcmp.s32 ge, q0, r3",
        "vmrs r4, p0",
        "cbnz r4, 3f",
        "letp lr, 2b",
        "b 4f",
        "3:",
        "mov r0, lr",
        "lctp",
        "4:",
        "vpop {{d8-d9}}",
        "pop {{r4, pc}}",
    )
}

/// The number of groups left, itself included, at the first that is `least` or more, from the last of `count` groups to the first; 0 if
/// none is.
///
/// # Safety
/// The powers of all these groups must be readable below `end`.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn last_group(end: *const u32, count: usize, least: u32) -> usize {
    kernel!(
        "push {{r7, lr}}",
        "mov r12, #0",
        "vidup.u32 q0, r12, #4",
        "vneg.s32 q0, q0",
        "add r0, r0, #12",
        "vadd.i32 q0, q0, r0",
        "mov r0, #0",
        "wlstp.32 lr, r1, 4f",
        "2:",
        "vldrw.u32 q1, [q0, #-16]!",
        "vcmp.u32 cs, q1, r2",
        "vmrs r3, p0",
        "cbnz r3, 3f",
        "letp lr, 2b",
        "b 4f",
        "3:",
        "rbit r3, r3",
        "clz r3, r3",
        "sub r0, lr, r3, lsr #2",
        "lctp",
        "4:",
        "pop {{r7, pc}}",
    )
}
