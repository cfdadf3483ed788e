//! Bins of a real record in a row, four at a time.

use super::{Packed, Point};
use crate::spectrum::fft::assembly::kernel;
use crate::spectrum::fft::kernel_dsp::bins;

/// The bins of [`bins::span_below`] by vectors.
///
/// # Safety
/// The conditions of [`bins::span_below`].
pub unsafe fn span_below(
    here: *const Point,
    there: *const Point,
    factors: *const Packed,
    to: *mut Point,
    end: *mut Point,
) {
    // SAFETY: the caller guarantees the points, the factors and the places of all these bins. The
    // last four overlap with those before them.
    unsafe {
        let count = end.offset_from_unsigned(to);
        if count < 4 {
            return bins::span_below(here, there, factors, to, end);
        }
        fours_below(here, there, factors, to, count / 4);
        let rest = count - 4;
        if !count.is_multiple_of(4) {
            fours_below(here.add(rest), there.sub(rest), factors.add(rest), to.add(rest), 1);
        }
    }
}

/// The bins of [`bins::span_above`] by vectors.
///
/// # Safety
/// The conditions of [`bins::span_above`].
pub unsafe fn span_above(
    here: *const Point,
    there: *const Point,
    factors: *const Packed,
    to: *mut Point,
    end: *mut Point,
) {
    // SAFETY: as in `span_below`. The mirrors ascend as the bins descend.
    unsafe {
        let count = end.offset_from_unsigned(to);
        if count < 4 {
            return bins::span_above(here, there, factors, to, end);
        }
        let rest = count - 1;
        let (low, high) = (there.sub(rest), here.add(rest));
        fours_above(low, high, factors.sub(rest), end.sub(1), count / 4);
        if !count.is_multiple_of(4) {
            fours_above(there.sub(3), here.add(3), factors.sub(3), to.add(3), 1);
        }
    }
}

/// `integer::split_pair` of four points from r0 on and four mirrors at the places q7: real parts q4
/// and q5, imaginary parts q1 and q2, whose sum is the lower bin. Advances all of them.
macro_rules! split {
    () => {
        lines!(
            "vld20.32 {{q0, q1}}, [r0]",
            "vld21.32 {{q0, q1}}, [r0]!",
            "vldrw.u32 q4, [r2], #16",
            "vldrw.u32 q2, [q7, #-32]!",
            "vldrw.u32 q3, [q7, #4]",
            "vadd.i32 q5, q0, q2",
            "vsub.i32 q0, q0, q2",
            "vsub.i32 q2, q1, q3",
            "vadd.i32 q1, q1, q3",
            // Low and high half of the factor, in the upper half of a lane.
            "vshllb.s16 q6, q4, #16",
            "vshllt.s16 q3, q4, #16",
            "vmulh.s32 q4, q0, q3",
            "vmulh.s32 q0, q0, q6",
            "vmulh.s32 q6, q1, q6",
            "vmulh.s32 q1, q1, q3",
            "vsub.i32 q4, q4, q6",
            "vadd.i32 q1, q1, q0",
            "vshr.s32 q5, q5, #1",
            "vshr.s32 q2, q2, #1"
        )
    };
}

/// Sets q7 to the places of four points from r1 downwards, 32 bytes behind them, and lr to the count.
macro_rules! begin {
    () => {
        lines!(
            "ldr r12, [sp]",
            enter!(),
            "mov r4, #0",
            "vidup.u32 q7, r4, #8",
            "vneg.s32 q7, q7",
            "add r1, r1, #32",
            "vadd.i32 q7, q7, r1",
            "dls lr, r12"
        )
    };
}

/// Fours of bins below the middle, `count` of them, in ascending order.
///
/// # Safety
/// For each bin there must be a point from `here` upwards, one from `there` downwards, a factor from `factors` upwards and a place from
/// `to` upwards. `count` must be 1 or more.
#[unsafe(naked)]
unsafe extern "C" fn fours_below(
    here: *const Point,
    there: *const Point,
    factors: *const Packed,
    to: *mut Point,
    count: usize,
) {
    kernel!(
        begin!(),
        "2:",
        split!(),
        "vadd.i32 q0, q5, q4",
        "vadd.i32 q1, q2, q1",
        "vst20.32 {{q0, q1}}, [r3]",
        "vst21.32 {{q0, q1}}, [r3]!",
        "le lr, 2b",
        leave!(),
    )
}

/// Fours of bins above the middle, `count` of them, in descending order.
///
/// # Safety
/// The conditions of [`fours_below`], for the mirrors of the bins, but with the places from `to` downwards.
#[unsafe(naked)]
unsafe extern "C" fn fours_above(
    here: *const Point,
    there: *const Point,
    factors: *const Packed,
    to: *mut Point,
    count: usize,
) {
    kernel!(
        begin!(),
        // From a mirror to its bin's place.
        "sub r3, r3, r1",
        "add r3, r3, #32",
        "2:",
        split!(),
        "vsub.i32 q0, q5, q4",
        "vsub.i32 q1, q1, q2",
        "vadd.i32 q2, q7, r3",
        "vstrw.32 q0, [q2]",
        "vstrw.32 q1, [q2, #4]",
        "le lr, 2b",
        leave!(),
    )
}
