//! The first pass.

use super::super::integer::Pair;
use super::super::q15::{self, DIAGONAL, first_radix};
use crate::acquire::codes::Codes;
use crate::spectrum::fft::assembly::kernel;

/// Points are not shifted.
const NONE: u32 = 0;
/// A product shifts a point up: its lower half is not negative, and carries nothing into the upper half.
const WORDS: u32 = 1;
/// A number is added to both halves before the shift, so that the lower half is not negative.
const HALVES: u32 = 2;

/// The kernels for [`q15::first_pass`]; `points` must be aligned to words. The record must allow the shift.
pub fn pass<const M: usize>(pairs: &[Pair], codes: Codes, shift: i32, points: &mut [Pair]) -> bool {
    let (from, to) = (pairs.as_ptr(), points.as_mut_ptr());
    let Ok(up) = u32::try_from(shift) else {
        return q15::first_pass::<M>(pairs, codes, shift, points);
    };
    let twice = |part: i32| u32::from(part as u16) * 0x1_0001;
    // A shifted part is within -OFFSET..OFFSET about the centre.
    let (offset, centre) = (const { 0x8000 / first_radix(M) as i32 }, i32::from(codes.middle()));
    let added = offset.unbounded_shr(up) - centre;
    // SAFETY: both slices hold M elements, and a kernel for M reads and writes M; `points` is aligned.
    let q = unsafe {
        if up == 0 {
            let centre = twice(q15::first_centre::<M>(codes, 0).into());
            groups::<M, NONE>(from, to, centre, 0)
        } else if added <= 0 {
            let added = (added.unsigned_abs() * 0x1_0001).unbounded_shl(up).wrapping_neg();
            groups::<M, WORDS>(from, to, added, 1u32.unbounded_shl(up))
        } else {
            groups::<M, HALVES>(from, to, twice(added), up)
        }
    };
    q != 0
}

/// The pass in groups of the first radix.
///
/// # Safety
/// The conditions of [`eights`] or [`fours`].
#[inline(always)]
unsafe fn groups<const M: usize, const UP: u32>(
    from: *const Pair,
    to: *mut Pair,
    number: u32,
    shift: u32,
) -> u32 {
    // SAFETY: the caller guarantees it.
    unsafe {
        if first_radix(M) == 8 {
            eights::<M, UP>(from, to, number, shift)
        } else {
            fours::<M, UP>(from, to, number, shift)
        }
    }
}

/// Finds the start of a group of the first pass, in r0. The number of the four groups is at [sp],
/// the record at [sp, #4].
macro_rules! next_groups {
    () => {
        lines!(
            "ldrd r4, r0, [sp]",
            "rbit r5, r4",
            "and r6, r5, #0xaaaaaaaa",
            "and r5, r5, #0x55555555",
            "add r0, r0, r6, lsr #{unused}-1",
            "add r0, r0, r5, lsr #{unused}-3",
            "adds r4, #1",
            "str r4, [sp]"
        )
    };
}

/// Shifts packed pairs up by the number at [sp, #8], with the offset in lr. In the end the offset adds 2^15 over the radix to each part.
/// Uses r12.
macro_rules! up {
    ($($x:literal),*) => {
        concat!(
            ".if {up}\n ldr r12, [sp, #8]\n .endif\n",
            $(
                ".if {up} == 1\n mla ", $x, ", ", $x, ", r12, lr\n .endif\n",
                ".if {up} == 2\n sadd16 ", $x, ", ", $x, ", lr\n lsl ", $x, ", ", $x, ", r12\n .endif\n",
            )*
        )
    };
}

/// Subtracts the centre, or the offset that [`up`] added, from the sum of a group.
macro_rules! centre {
    ($to:literal, $x:literal) => {
        concat!(
            ".if {up}\n eor ",
            $to,
            ", ",
            $x,
            ", #0x80008000\n .else\n",
            "ssub16 ",
            $to,
            ", ",
            $x,
            ", lr\n .endif\n",
        )
    };
}

/// The four-point transform of $a to $d, in place but for one register: 0 in $c, 1 in $a, 2 in
/// $free, 3 in $b.
macro_rules! four_points {
    ($a:literal, $b:literal, $c:literal, $d:literal, $free:literal) => {
        concat!(
            "sadd16 ",
            $free,
            ", ",
            $a,
            ", ",
            $c,
            "\n ssub16 ",
            $c,
            ", ",
            $a,
            ", ",
            $c,
            "\n",
            "sadd16 ",
            $a,
            ", ",
            $b,
            ", ",
            $d,
            "\n ssub16 ",
            $d,
            ", ",
            $b,
            ", ",
            $d,
            "\n",
            "sadd16 ",
            $b,
            ", ",
            $free,
            ", ",
            $a,
            "\n ssub16 ",
            $free,
            ", ",
            $free,
            ", ",
            $a,
            "\n",
            "ssax ",
            $a,
            ", ",
            $c,
            ", ",
            $d,
            "\n sasx ",
            $c,
            ", ",
            $c,
            ", ",
            $d,
            "\n",
        )
    };
}

/// $x exp(-j pi/4), with sqrt(1/2) twice in r2 and its rounding in r3.
macro_rules! diagonal {
    ($x:literal, $free:literal) => {
        concat!(
            "smlsdx ",
            $free,
            ", r2, ",
            $x,
            ", r3\n smlad ",
            $x,
            ", ",
            $x,
            ", r2, r3\n",
            "lsl ",
            $free,
            ", ",
            $free,
            ", #1\n pkhtb ",
            $x,
            ", ",
            $free,
            ", ",
            $x,
            ", asr #15\n",
        )
    };
}

/// The first pass in groups of eight: `q15::first8`. `UP` is the way parts are shifted up: [`NONE`] leaves them, [`WORDS`] multiplies by
/// the factor `shift`, [`HALVES`] shifts by `shift` bits. `number` is the centre of a group's sum, the number added to a product, or the
/// number added to parts before the shift.
///
/// # Safety
/// `from` and `to` must be M pairs and M aligned points, M = 8 4^d of at most 2048.
#[unsafe(naked)]
unsafe extern "C" fn eights<const M: usize, const UP: u32>(
    from: *const Pair,
    to: *mut Pair,
    number: u32,
    shift: u32,
) -> u32 {
    kernel!(
        enter!(16),
        "str r12, [sp]",
        "str r0, [sp, #4]",
        "mov lr, r2",
        "sub r1, r1, #8",
        "str r3, [sp, #8]",
        "movw r2, #{diagonal}",
        "movt r2, #{diagonal}",
        "movw r3, #0x4000",
        ".p2align 2",
        "2:",
        next_groups!(),
        // Four groups, whose first digit is the last of their place.
        ".rept 4",
        "ldr r4, [r0]",
        "ldr r5, [r0, #{leg}]",
        "ldr r6, [r0, #2*{leg}]",
        "ldr r7, [r0, #3*{leg}]",
        ".if {leg} == 1024",
        "add r11, r0, #4*{leg}",
        "ldr r8, [r11]",
        "ldr r9, [r11, #{leg}]",
        "ldr r10, [r11, #2*{leg}]",
        "ldr r11, [r11, #3*{leg}]",
        ".else",
        "ldr r8, [r0, #4*{leg_}]",
        "ldr r9, [r0, #5*{leg_}]",
        "ldr r10, [r0, #6*{leg_}]",
        "ldr r11, [r0, #7*{leg_}]",
        ".endif",
        "add r0, r0, #{leg}/4",
        up!("r4", "r5", "r6", "r7", "r8", "r9", "r10", "r11"),
        four_points!("r4", "r6", "r8", "r10", "r12"), // 0 r6, 1 r4, 2 r12, 3 r8
        four_points!("r5", "r7", "r9", "r11", "r10"), // 0 r7, 1 r5, 2 r10, 3 r9
        "sadd16 r11, r6, r7",
        "ssub16 r6, r6, r7",
        centre!("r11", "r11"),
        "ssax r7, r12, r10",
        "sasx r10, r12, r10",
        look!("r12": "r11", "r6", "r7", "r10"),
        diagonal!("r5", "r12"),
        "sadd16 r12, r4, r5",
        "ssub16 r5, r4, r5",
        look!("r4": "r12", "r5"),
        "strd r11, r12, [r1, #8]",
        "strd r6, r5, [r1, #24]",
        diagonal!("r9", "r12"),
        "ssax r11, r8, r9",
        "sasx r8, r8, r9",
        look!("r12": "r11", "r8"),
        "strd r7, r11, [r1, #16]",
        "strd r10, r8, [r1, #32]!",
        ".endr",
        "ldr r4, [sp]",
        "cmp r4, #{outer}",
        "blo 2b",
        leave!(16),
        diagonal = const DIAGONAL,
        up = const UP,
        // No caller needs more than 2048 points, but the assembler sees such lengths.
        leg = const if M <= 2048 { M / 8 * 4 } else { 4 },
        leg_ = const if M <= 512 { M / 8 * 4 } else { 4 },
        outer = const M / 32,
        unused = const 32 - (M / 32).trailing_zeros(),
    )
}

/// The first pass in groups of four: `q15::first4`. The parameters are those of [`eights`].
///
/// # Safety
/// `from` and `to` must be M pairs and M aligned points, M = 4^d of at most 4096.
#[unsafe(naked)]
unsafe extern "C" fn fours<const M: usize, const UP: u32>(
    from: *const Pair,
    to: *mut Pair,
    number: u32,
    shift: u32,
) -> u32 {
    kernel!(
        enter!(16),
        "str r12, [sp]",
        "str r0, [sp, #4]",
        "mov lr, r2",
        "sub r1, r1, #8",
        "str r3, [sp, #8]",
        ".p2align 2",
        "2:",
        next_groups!(),
        ".rept 4",
        "ldr r4, [r0]",
        ".if {leg} <= 1024",
        "ldr r5, [r0, #{leg_}]",
        "ldr r6, [r0, #2*{leg_}]",
        "ldr r7, [r0, #3*{leg_}]",
        ".else",
        "add r7, r0, #{leg}",
        "ldr r5, [r7]",
        "add r7, r7, #{leg}",
        "ldr r6, [r7]",
        "add r7, r7, #{leg}",
        "ldr r7, [r7]",
        ".endif",
        "add r0, r0, #{leg}/4",
        up!("r4", "r5", "r6", "r7"),
        four_points!("r4", "r5", "r6", "r7", "r8"), // 0 r5, 1 r4, 2 r8, 3 r6
        centre!("r10", "r5"),
        "mov r11, r4",
        "mov r9, r6",
        look!("r12": "r10", "r11", "r8", "r9"),
        "strd r10, r11, [r1, #8]",
        "strd r8, r9, [r1, #16]!",
        ".endr",
        "ldr r4, [sp]",
        "cmp r4, #{outer}",
        "blo 2b",
        leave!(16),
        up = const UP,
        leg = const M,
        leg_ = const if M <= 1024 { M } else { 4 },
        outer = const M / 16,
        unused = const 32 - (M / 16).trailing_zeros(),
    )
}
