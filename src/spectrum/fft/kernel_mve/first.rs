//! The first pass, which reads the record in sequence and writes it in digit-reversed order: four groups at a time, one in each quarter of
//! the points. Codes of at most 13 bits leave room for the sum of eight in 16 bits. Samples are loaded as halfwords, because a record may
//! begin at any halfword.

use super::{Pair, Point};
use crate::spectrum::fft::assembly::kernel;
use crate::spectrum::fft::integer::DIAGONAL;

/// Begins a pass of M = r2 points in groups of 2^`$digits`, whose places are at the fifth argument. Afterwards r0 is this address, r2 the
/// bytes of a leg of the record, r3 half of 1 shifted up, r12 the shift less 16, r4 the record, and lr a quarter of all vectors. The stack
/// has the points of the first four groups, and above them the number of the other vectors. The pass owns `$frame` bytes of the stack, from
/// the 32nd on.
macro_rules! begin {
    ($digits:literal, $frame:literal) => {
        lines!(
            "ldr r12, [sp]",
            enter!(),
            concat!("sub sp, sp, #", $frame),
            "mov r4, #0",
            "vidup.u32 q0, r4, #1",
            "lsl r4, r2, #1",
            "vmul.i32 q0, q0, r4",
            "vadd.i32 q0, q0, r1",
            "vstrw.32 q0, [sp]",
            concat!("lsr r5, r2, #2+", $digits),
            "lsr lr, r5, #2",
            "sub r5, r5, lr",
            "str r5, [sp, #16]",
            "mov r4, r0",
            "mov r0, r12",
            "sub r12, r3, #16",
            "sub r3, r3, #1",
            "mov r5, #1",
            "lsl r3, r5, r3",
            "lsl r2, r2, #2",
            concat!("lsr r2, r2, #", $digits)
        )
    };
}

/// The legs after the first, each r2 bytes from the one before.
macro_rules! legs {
    ($before:literal $leg:literal $($more:literal)*) => {
        concat!("add ", $leg, ", ", $before, ", r2\n", legs!($leg $($more)*))
    };
    ($last:literal) => { "" };
}

/// A pass over all vectors: `$halved` for the first quarter, then `$plain`.
macro_rules! vectors {
    ($halved:expr, $plain:expr) => {
        lines!(
            "wls lr, lr, 3f",
            "2:",
            $halved,
            "le lr, 2b",
            "3:",
            "ldr lr, [sp, #16]",
            "dls lr, lr",
            "4:",
            $plain,
            "le lr, 4b"
        )
    };
}

/// Sets `$to` to the places of the next four groups.
macro_rules! places {
    ($to:literal) => {
        lines!(
            "ldrh r1, [r0], #2",
            concat!("vldrw.u32 ", $to, ", [sp]"),
            concat!("vadd.i32 ", $to, ", ", $to, ", r1")
        )
    };
}

/// Ends a pass.
macro_rules! end {
    ($frame:literal) => {
        lines!(concat!("add sp, sp, #", $frame), leave!())
    };
}

/// Stores the packed points in `$x`, times twice `$by`, as point `$at` of the groups in `$places`,
/// after `$then` with each part. Uses `$free` and `$x`.
macro_rules! widen {
    ($x:literal, $by:literal, $at:literal, $free:literal, $places:literal $(, $then:literal)?) => {
        lines!(
            concat!("vqdmullb.s16 ", $free, ", ", $x, ", ", $by),
            $(concat!($then, " ", $free, ", #1"),)?
            concat!("vstrw.32 ", $free, ", [", $places, ", #8*", $at, "]"),
            concat!("vqdmullt.s16 ", $x, ", ", $x, ", ", $by),
            $(concat!($then, " ", $x, ", #1"),)?
            concat!("vstrw.32 ", $x, ", [", $places, ", #8*", $at, "+4]")
        )
    };
}

/// Stores points `$at` and `$at` + 4 of the groups in q3 by `$add` and `$sub`: sum and difference of the even part in `$e` and the odd part
/// at `$odd`. The odd part has the product of its lower halves in q5 and of its upper halves in q4: `$re` is the real part and `$im` the
/// imaginary part, or with `$plus` and `$minus` exchanged its negative. Uses q2, q6 and `$e`.
macro_rules! diagonal {
    (
        $e:literal, $odd:literal, $at:literal, $re:literal, $im:literal,
        $add:literal, $sub:literal, $plus:literal, $minus:literal
    ) => {
        lines!(
            concat!("vqdmullb.s16 q2, ", $e, ", r3"),
            concat!("vqdmullt.s16 ", $e, ", ", $e, ", r3"),
            concat!("vldrw.u32 q4, [sp, #", $odd, "]"),
            "vqdmullb.s16 q5, q4, r3",
            "vqdmullt.s16 q4, q4, r3",
            "vqdmulh.s32 q5, q5, r2",
            "vqdmulh.s32 q4, q4, r2",
            concat!($add, " q6, q2, ", $re),
            concat!("vstrw.32 q6, [q3, #8*", $at, "]"),
            concat!($plus, " q6, ", $e, ", ", $im),
            concat!("vstrw.32 q6, [q3, #8*", $at, "+4]"),
            concat!($sub, " q6, q2, ", $re),
            concat!("vstrw.32 q6, [q3, #8*", $at, "+32]"),
            concat!($minus, " q6, ", $e, ", ", $im),
            concat!("vstrw.32 q6, [q3, #8*", $at, "+36]")
        )
    };
}

/// Four groups of eight, with points 0, 2, 4 and 6 times twice `$by`, and the others by `$add` and
/// `$sub`.
macro_rules! eight {
    ($by:literal, $add:literal, $sub:literal, $scale:expr $(, $odd:literal)?) => {
        lines!(
            // The odd part: q3, q2, and points 1 and 3 times 1 - j in memory.
            "vldrh.u16 q0, [r5], #16",
            "vldrh.u16 q1, [r9], #16",
            "vadd.i16 q2, q0, q1",
            "vsub.i16 q0, q0, q1",
            "vldrh.u16 q1, [r7], #16",
            "vldrh.u16 q3, [r11], #16",
            "vadd.i16 q4, q1, q3",
            "vsub.i16 q1, q1, q3",
            "vadd.i16 q3, q2, q4",
            "vsub.i16 q2, q2, q4",
            "vcadd.i16 q4, q0, q1, #270",
            "vcadd.i16 q0, q0, q1, #90",
            "vcadd.i16 q4, q4, q4, #270",
            "vcadd.i16 q0, q0, q0, #270",
            "vstrw.32 q4, [sp, #32]",
            "vstrw.32 q0, [sp, #48]",
            // The even part: points 0 and 2 in q7, q6; the terms of the others in q1, q5.
            "vldrh.u16 q1, [r4], #16",
            "vldrh.u16 q5, [r8], #16",
            "vadd.i16 q6, q1, q5",
            "vsub.i16 q1, q1, q5",
            "vldrh.u16 q5, [r6], #16",
            "vldrh.u16 q7, [r10], #16",
            "vadd.i16 q4, q5, q7",
            "vsub.i16 q5, q5, q7",
            "vadd.i16 q7, q6, q4",
            "vsub.i16 q6, q6, q4",
            "vadd.i16 q4, q7, q3",
            "vsub.i16 q7, q7, q3",
            places!("q3"),
            $scale,
            widen!("q4", $by, "0", "q0", "q3" $(, $odd)?),
            widen!("q7", $by, "4", "q0", "q3"),
            "vcadd.i16 q4, q6, q2, #270",
            "vcadd.i16 q6, q6, q2, #90",
            widen!("q4", $by, "2", "q0", "q3"),
            widen!("q6", $by, "6", "q0", "q3"),
            "vcadd.i16 q0, q1, q5, #270",
            "vcadd.i16 q1, q1, q5, #90",
            diagonal!("q0", "32", "1", "q5", "q4", $add, $sub, $add, $sub),
            diagonal!("q1", "48", "3", "q4", "q5", $add, $sub, $sub, $add)
        )
    };
}

/// The first pass in groups of eight: `integer::first8` for codes of at most 13 bits, shifted up by `shift`, with points in the form that
/// the next pass takes.
///
/// # Safety
/// `from` and `to` must be `m` pairs and `m` points, m = 8 4^d of 32 or more; `shift` 2 to 15; `places` the table [`places`] for an
/// `m`-point transform.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn eights(
    from: *const Pair,
    to: *mut Point,
    m: usize,
    shift: u32,
    places: *const u16,
) {
    kernel!(
        begin!("3", "64"),
        legs!("r4" "r5" "r6" "r7" "r8" "r9" "r10" "r11"),
        "movw r2, #({root}<<15)&0xffff",
        "movt r2, #{root}>>1",
        vectors!(
            eight!("r1", "vhadd.s32", "vhsub.s32", "lsr r1, r3, #1"),
            eight!("r3", "vadd.i32", "vsub.i32", "", "vorr.i32")
        ),
        end!("64"),
        root = const DIAGONAL,
    )
}

/// Four groups of four times twice `$by`.
macro_rules! four {
    ($by:literal, $scale:expr $(, $odd:literal)?) => {
        lines!(
            "vldrh.u16 q0, [r4], #16",
            "vldrh.u16 q1, [r6], #16",
            "vadd.i16 q2, q0, q1",
            "vsub.i16 q0, q0, q1",
            "vldrh.u16 q1, [r5], #16",
            "vldrh.u16 q3, [r7], #16",
            "vadd.i16 q4, q1, q3",
            "vsub.i16 q1, q1, q3",
            places!("q7"),
            $scale,
            "vadd.i16 q3, q2, q4",
            "vsub.i16 q2, q2, q4",
            "vcadd.i16 q4, q0, q1, #270",
            "vcadd.i16 q0, q0, q1, #90",
            widen!("q3", $by, "0", "q5", "q7" $(, $odd)?),
            widen!("q4", $by, "1", "q5", "q7"),
            widen!("q2", $by, "2", "q5", "q7"),
            widen!("q0", $by, "3", "q5", "q7")
        )
    };
}

/// The first pass in groups of four: `integer::first4` with the parameters of [`eights`].
///
/// # Safety
/// The conditions of [`eights`], m = 4^d of 64 or more.
#[unsafe(naked)]
pub(super) unsafe extern "C" fn fours(
    from: *const Pair,
    to: *mut Point,
    m: usize,
    shift: u32,
    places: *const u16,
) {
    kernel!(
        begin!("2", "64"),
        legs!("r4" "r5" "r6" "r7"),
        vectors!(four!("r1", "lsr r1, r3, #1"), four!("r3", "", "vorr.i32")),
        end!("64"),
    )
}

/// The places of the first of four groups for an M-point transform, vector by vector, in bytes.
pub(super) const fn places(m: usize) -> &'static [u16] {
    match m {
        32 => &PLACES_32,
        64 => &PLACES_64,
        128 => &PLACES_128,
        256 => &PLACES_256,
        512 => &PLACES_512,
        1024 => &PLACES_1024,
        2048 => &PLACES_2048,
        4096 => &PLACES_4096,
        _ => &[],
    }
}

static PLACES_32: [u16; 1] = reversed(64);
static PLACES_64: [u16; 4] = reversed(32);
static PLACES_128: [u16; 4] = reversed(64);
static PLACES_256: [u16; 16] = reversed(32);
static PLACES_512: [u16; 16] = reversed(64);
static PLACES_1024: [u16; 64] = reversed(32);
static PLACES_2048: [u16; 64] = reversed(64);
static PLACES_4096: [u16; 256] = reversed(32);

/// The numbers below V = 4^d with their digits in base 4 reversed, times `bytes`.
// Const functions cannot use `get_mut`. An index out of range would be a compile error.
#[allow(clippy::indexing_slicing)]
const fn reversed<const V: usize>(bytes: usize) -> [u16; V] {
    let mut table = [0; V];
    let mut index = 0;
    while index < V {
        let (mut rest, mut place, mut count) = (index, 0, V);
        while count > 1 {
            place = 4 * place + rest % 4;
            rest /= 4;
            count /= 4;
        }
        table[index] = (place * bytes) as u16;
        index += 1;
    }
    table
}
