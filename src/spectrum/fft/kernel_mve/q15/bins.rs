//! Bins of a real record in a row, four at a time.

use super::is_aligned;
use crate::spectrum::fft::assembly::kernel;
use crate::spectrum::fft::integer::{Pair, Point, filled};
use crate::spectrum::fft::twiddle::Packed;
use crate::spectrum::q15_bins;
use core::mem::MaybeUninit;

/// The bins from `first` on, all within 1..M, equal to [`q15_bins::split`] of each. No bins if they are not within this range.
pub fn window<'a>(
    points: &[Pair],
    table: &[Packed],
    first: usize,
    places: &'a mut [MaybeUninit<Point>],
) -> &'a [Point] {
    if !is_aligned(points) {
        return filled(places, (first..).map(|k| q15_bins::split(points, table, k)));
    }
    let (length, middle) = (points.len(), points.len() / 2);
    let end = first.saturating_add(places.len());
    if first < 1 || end > length || table.len() < middle {
        return &[];
    }
    let (from, factors) = (points.as_ptr(), table.as_ptr());
    let (below, above) = (end.min(middle), first.max(middle + 1));
    let place = |bin: usize| bin.wrapping_sub(first);
    // SAFETY: the bins lie within 1..length, and so do their mirrors. Every place is written: the bins below the middle, the middle, and
    // the bins above. The factor of each lies before the middle.
    unsafe {
        let to = places.as_mut_ptr().cast::<Point>();
        if first < below {
            let (here, there) = (from.add(first), from.add(length - first));
            ascending(here, there, factors.add(first), to, below - first);
        }
        if first <= middle && middle < end {
            to.add(place(middle)).write(q15_bins::split(points, table, middle));
        }
        if above < end {
            let mirror = length - above;
            let (here, there) = (from.add(mirror), from.add(above));
            descending(here, there, factors.add(mirror), to.add(place(above)), end - above);
        }
        places.assume_init_ref()
    }
}

/// Defines bins of pairs of points in a row: the loads of the next points and factors, and the operations by which the sum and the turned
/// difference become the bin.
macro_rules! bins {
    (
        $(#[$doc:meta])*
        $name:ident, $here:expr, $there:expr, $factors:expr, $re:literal, $im:literal
    ) => {
        $(#[$doc])*
        ///
        /// # Safety
        /// All these points and factors must be readable and aligned, and as many places writable.
        #[unsafe(naked)]
        unsafe extern "C" fn $name(
            here: *const Pair,
            there: *const Pair,
            factors: *const Packed,
            to: *mut Point,
            count: usize,
        ) {
            kernel!(
                "ldr r12, [sp]",
                enter!(),
                "sub sp, sp, #16",
                "mov r4, #0",
                "vidup.u32 q0, r4, #8",
                "vstrw.32 q0, [sp]",
                "mov r4, #0",
                "vidup.u32 q7, r4, #4",
                "vneg.s32 q7, q7",
                "add r4, r3, #4",
                "wlstp.32 lr, r12, 3f",
                "2:",
                $here,
                $there,
                // Real and imaginary parts in units of bins.
                "vshllb.s16 q2, q0, #{fraction}",
                "vshllt.s16 q0, q0, #{fraction}",
                "vshllb.s16 q3, q1, #{fraction}",
                "vshllt.s16 q1, q1, #{fraction}",
                "vadd.i32 q4, q2, q3",
                "vsub.i32 q2, q2, q3",
                "vsub.i32 q3, q0, q1",
                "vadd.i32 q0, q0, q1",
                $factors,
                "vshllt.s16 q5, q1, #16",
                "vshllb.s16 q1, q1, #16",
                "vmulh.s32 q6, q2, q5",
                "vmulh.s32 q5, q0, q5",
                "vmulh.s32 q0, q0, q1",
                "vmulh.s32 q1, q2, q1",
                "vsub.i32 q6, q6, q0",
                "vadd.i32 q5, q5, q1",
                "vshr.s32 q4, q4, #1",
                "vshr.s32 q3, q3, #1",
                $re,
                $im,
                "vldrw.u32 q0, [sp]",
                "vstrw.32 q4, [r3, q0]",
                "vstrw.32 q5, [r4, q0]",
                "add r3, r3, #32",
                "add r4, r4, #32",
                "letp lr, 2b",
                "3:",
                "add sp, sp, #16",
                leave!(),
                fraction = const crate::spectrum::fft::q15::FRACTION,
            )
        }
    };
}

bins! {
    /// `count` bins from points from `here` upwards and their mirrors from `there` downwards.
    ascending,
    "vldrw.u32 q0, [r0], #16",
    lines!("vldrw.u32 q1, [r1, q7]", "sub r1, r1, #16"),
    "vldrw.u32 q1, [r2], #16",
    "vadd.i32 q4, q4, q6", "vadd.i32 q5, q5, q3"
}

bins! {
    /// The mirrored bins of pairs with points from `here` downwards and from `there` upwards.
    descending,
    lines!("vldrw.u32 q0, [r0, q7]", "sub r0, r0, #16"),
    "vldrw.u32 q1, [r1], #16",
    lines!("vldrw.u32 q1, [r2, q7]", "sub r2, r2, #16"),
    "vsub.i32 q4, q4, q6", "vsub.i32 q5, q5, q3"
}
