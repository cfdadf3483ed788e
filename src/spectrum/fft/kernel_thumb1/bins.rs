//! The loops that read a real record's points: the search and the noise.

use super::Point;
use crate::spectrum::fft::assembly::kernel;

/// The state of [`pairs_outwards`].
#[repr(C)]
pub(super) struct Outwards {
    /// The sum of the powers of both points, over all pairs so far.
    pub total: u64,
    /// The kernel stops after a pair that adds this much or more.
    pub least: u64,
    /// The upper point of the next pair.
    upper: *const Point,
    /// The address of a lower point plus the address just after its upper point: constant.
    sum: usize,
    /// The address after the outermost upper point.
    end: *const Point,
}

impl Outwards {
    /// A scan from the middle of these points outwards to point `outermost`, from 1 to the middle, and its mirror.
    pub fn new(points: &[Point], outermost: usize) -> Self {
        let (start, length) = (points.as_ptr(), points.len());
        let upper = start.wrapping_add(length / 2 + 1);
        let sum = (upper.addr()).wrapping_mul(2).wrapping_sub(size_of::<Point>());
        let outermost = outermost.max(1).min(length / 2);
        let end = start.wrapping_add(length + 1 - outermost);
        Self { total: 0, least: 0, upper, sum, end }
    }

    /// The indices of the last pair.
    pub fn last(&self, points: &[Point]) -> (usize, usize) {
        let bytes = self.upper.addr().wrapping_sub(points.as_ptr().addr());
        let upper = (bytes / size_of::<Point>()).wrapping_sub(1);
        (points.len().wrapping_sub(upper), upper)
    }
}

/// Adds the square of a number to r0 : `$sum`, upper word first, without twice the product of its
/// halves, `$high` and `$low`. Leaves twice that product in `$high`. Uses `$t`; overwrites `$low`.
macro_rules! square {
    ($sum:literal, $high:literal, $low:literal, $t:literal) => {
        concat!(
            "movs ",
            $t,
            ", ",
            $high,
            "\n",
            "muls ",
            $t,
            ", ",
            $t,
            ", ",
            $t,
            "\n",
            "adds r0, r0, ",
            $t,
            "\n",
            "muls ",
            $high,
            ", ",
            $low,
            ", ",
            $high,
            "\n",
            "muls ",
            $low,
            ", ",
            $low,
            ", ",
            $low,
            "\n",
            "adds ",
            $sum,
            ", ",
            $sum,
            ", ",
            $low,
            "\n",
            "movs ",
            $t,
            ", #0\n",
            "adcs r0, ",
            $t,
            "\n",
        )
    };
}

/// Adds `2^17` times `$x` to r0 : `$sum`. Uses `$t`.
macro_rules! cross {
    ($sum:literal, $x:literal, $t:literal) => {
        concat!(
            "lsls ",
            $t,
            ", ",
            $x,
            ", #17\n",
            "asrs ",
            $x,
            ", ",
            $x,
            ", #15\n",
            "adds ",
            $sum,
            ", ",
            $sum,
            ", ",
            $t,
            "\n",
            "adcs r0, ",
            $x,
            "\n",
        )
    };
}

/// Adds up the powers of pairs of points outwards from the place in `state`. Returns true if it stopped after a pair that has `least` or
/// more.
///
/// The products of a point's lower and upper halves fit in a sum of two: the parts of a point add up to at most 2^31.
///
/// # Safety
/// `state` must come from [`Outwards::new`] and this function, with at most `least` changed.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn pairs_outwards(state: &mut Outwards) -> bool {
    kernel!(
        "push {{r4-r7, lr}}",
        high_to_low!(),
        "push {{r0, r4-r7}}",
        "ldm r0!, {{r1, r2, r3, r4}}", // total, least
        "push {{r1, r2, r3, r4}}",
        "ldm r0!, {{r1, r2, r3}}",
        "movs r7, r1",
        "mov r8, r2",
        "mov r12, r3",
        "movs r0, #0",
        "cmp r7, r12",
        "beq 4f",
        "2:",
        "ldm r7!, {{r1, r2}}",
        "mov r6, r8",
        "subs r6, r6, r7",
        "ldm r6!, {{r3, r4}}",
        "mov r10, r4",
        // The power of the upper point in r0 : r1.
        "asrs r6, r1, #16",
        "uxth r1, r1",
        "movs r0, r6",
        "muls r0, r0, r0",
        "muls r6, r1, r6",
        "muls r1, r1, r1",
        "asrs r4, r2, #16",
        "uxth r2, r2",
        square!("r1", "r4", "r2", "r5"),
        "adds r6, r6, r4",
        cross!("r1", "r6", "r5"),
        // The power of the lower point.
        "asrs r4, r3, #16",
        "uxth r3, r3",
        square!("r1", "r4", "r3", "r5"),
        "mov r2, r10",
        "asrs r6, r2, #16",
        "uxth r2, r2",
        square!("r1", "r6", "r2", "r5"),
        "adds r4, r4, r6",
        cross!("r1", "r4", "r5"),
        "ldr r2, [sp]",
        "ldr r3, [sp, #4]",
        "adds r2, r2, r1",
        "adcs r3, r0",
        "str r2, [sp]",
        "str r3, [sp, #4]",
        "ldr r2, [sp, #8]",
        "ldr r3, [sp, #12]",
        "subs r1, r1, r2",
        "sbcs r0, r3",
        "bhs 3f",
        "cmp r7, r12",
        "bne 2b",
        "movs r0, #0",
        "b 4f",
        "3:",
        "movs r0, #1",
        "4:",
        "pop {{r1, r2, r3, r4, r5}}", // total, least, state
        "stm r5!, {{r1, r2}}",
        "str r7, [r5, #8]",
        "pop {{r4-r7}}",
        low_to_high!(),
        "pop {{r4-r7, pc}}",
    )
}
