//! The record's magnitude and the first pass, which reads the record in sequence and writes it in digit-reversed order, four groups at a
//! time, like [`super::super::first`].

use crate::acquire::codes::Codes;
use crate::spectrum::fft::assembly::kernel;
use crate::spectrum::fft::integer::Pair;
use crate::spectrum::fft::kernel_mve::first::places;
use crate::spectrum::fft::q15::{self, DIAGONAL, first_radix};

/// The power of the strongest point about `centre`. A part further from it than 32767 counts as 32767 away. The kernel reads whole groups
/// of 32 pairs.
pub fn strongest(pairs: &[Pair], centre: i16) -> u32 {
    let groups = pairs.as_chunks::<32>().0;
    // SAFETY: these groups lie inside `pairs`.
    unsafe { power(groups.as_ptr().cast(), 2 * groups.len(), centre.into()) }
}

/// The largest distance of a part from `centre`, or 32767 or 32768 if it is more. The kernel reads whole groups of 32 pairs.
pub fn largest(pairs: &[Pair], centre: i16) -> i32 {
    let groups = pairs.as_chunks::<32>().0;
    // SAFETY: these groups lie inside `pairs`.
    unsafe { farthest(groups.as_ptr().cast(), groups.len(), centre.into()) }
}

/// The largest power of a point of `groups` groups of 16 pairs about `centre`.
///
/// # Safety
/// `groups` groups must be readable.
#[unsafe(naked)]
unsafe extern "C" fn power(from: *const Pair, groups: usize, centre: i32) -> u32 {
    // A vector's points are squared while the next one is loaded.
    macro_rules! look {
        ($less:literal) => {
            concat!(
                ".rept 4\n",
                "vldrh.u16 q1, [r0], #16\n",
                $less,
                "vmullb.s16 q2, q1, q1\n",
                "vmullt.s16 q3, q1, q1\n",
                "vadd.i32 q2, q2, q3\n",
                "vmax.u32 q0, q0, q2\n",
                ".endr",
            )
        };
    }
    kernel!(
        "push {{r7, lr}}",
        "vmov.i32 q0, #0",
        "mov r3, #0",
        "cbz r2, 4f",
        "wls lr, r1, 6f",
        "2:",
        look!("vqsub.s16 q1, q1, r2\n"),
        "le lr, 2b",
        "b 6f",
        "4:",
        "wls lr, r1, 6f",
        "5:",
        look!(""),
        "le lr, 5b",
        "6:",
        "vmaxv.u32 r3, q0",
        "mov r0, r3",
        "pop {{r7, pc}}",
    )
}

/// The largest distance of a part of `groups` groups of 32 pairs from `centre`.
///
/// # Safety
/// `groups` groups must be readable.
#[unsafe(naked)]
unsafe extern "C" fn farthest(from: *const Pair, groups: usize, centre: i32) -> i32 {
    kernel!(
        "push {{r7, lr}}",
        "vmov.i32 q0, #0",
        "mov r3, #0",
        "wls lr, r1, 6f",
        "2:",
        ".rept 8",
        "vldrh.u16 q1, [r0], #16",
        "vqsub.s16 q1, q1, r2",
        "vmaxa.s16 q0, q1",
        ".endr",
        "le lr, 2b",
        "6:",
        "vmaxv.u16 r3, q0",
        "mov r0, r3",
        "pop {{r7, pc}}",
    )
}

/// The kernels for [`q15::first_pass`], for codes within the growth bound. `points` must be aligned to words.
pub fn pass<const M: usize>(pairs: &[Pair], codes: Codes, shift: i32, points: &mut [Pair]) -> bool {
    if pairs.len() != M || points.len() != M {
        return false;
    }
    let pass = Pass {
        shift,
        centre: q15::first_centre::<M>(codes, shift).into(),
        places: const { doubled::<M>() }.as_ptr(),
    };
    // SAFETY: both slices hold M elements, `points` is aligned, and the places belong to M.
    let q = unsafe {
        match first_radix(M) {
            8 => eights(pairs.as_ptr(), points.as_mut_ptr(), M, &pass),
            _ => fours(pairs.as_ptr(), points.as_mut_ptr(), M, &pass),
        }
    };
    q != 0
}

/// The places of the first of four groups, vector by vector: in bytes for groups of eight, twice the bytes for groups of four. A group of
/// eight of these points is as long as a group of four points of 64 bits.
const fn doubled<const M: usize>() -> &'static [u16] {
    match first_radix(M) {
        8 if M > 32 => places(M / 2),
        _ => places(M),
    }
}

/// The parameters of a first pass beside the record.
#[repr(C)]
struct Pass {
    /// The number of bits by which codes are shifted up.
    shift: i32,
    /// The centre of a group's sum.
    centre: i32,
    /// The table [`doubled`].
    places: *const u16,
}

/// Begins a pass of M = r2 points in groups of 2^`$digits`. Afterwards r0 is the places, r2 the
/// shift, r3 the centre, r4 the record, r12 the bytes of its legs and lr the number of vectors. The
/// stack has the points of the first four groups, which are M bytes apart, and 32 bytes above them.
macro_rules! begin {
    ($digits:literal) => {
        lines!(
            enter!(),
            "sub sp, sp, #48",
            "mov r4, #0",
            "vmsr fpscr_nzcvqc, r4",
            "vidup.u32 q0, r4, #1",
            "vmul.i32 q0, q0, r2",
            "vadd.i32 q0, q0, r1",
            "vstrw.32 q0, [sp]",
            "mov r4, r0",
            concat!("lsr lr, r2, #2+", $digits),
            "lsl r12, r2, #2",
            concat!("lsr r12, r12, #", $digits),
            "ldr r0, [r3, #8]",
            "ldrd r2, r3, [r3]",
            "dls lr, lr"
        )
    };
}

/// Ends a pass with the flag QC.
macro_rules! end {
    () => {
        lines!("add sp, sp, #48", "vmrs r0, fpscr_nzcvqc", "and r0, r0, #0x08000000", leave!())
    };
}

/// The legs after the first, each r12 bytes from the one before.
macro_rules! legs {
    ($before:literal $leg:literal $($more:literal)*) => {
        concat!("add ", $leg, ", ", $before, ", r12\n", legs!($leg $($more)*))
    };
    ($last:literal) => { "" };
}

/// Loads four pairs from each of two legs, shifted, and computes their sum and difference.
macro_rules! two {
    ($x:literal $xs:literal, $y:literal $ys:literal, $sum:literal) => {
        lines!(
            concat!("vldrh.u16 ", $x, ", [", $xs, "], #16"),
            concat!("vldrh.u16 ", $y, ", [", $ys, "], #16"),
            concat!("vrshl.s16 ", $x, ", r2"),
            concat!("vrshl.s16 ", $y, ", r2"),
            concat!("vadd.i16 ", $sum, ", ", $x, ", ", $y),
            concat!("vsub.i16 ", $x, ", ", $x, ", ", $y)
        )
    };
}

/// Sets q7 to the places of the next four groups, after `$then` with the place of the first.
macro_rules! next {
    ($($then:literal)?) => {
        lines!("ldrh r1, [r0], #2", "vldrw.u32 q7, [sp]", $($then,)? "vadd.i32 q7, q7, r1")
    };
}

/// Stores points `$at` of four groups, and sets QC if a part is large.
macro_rules! store {
    ($($x:literal $at:literal),*) => {
        concat!(
            $("vstrw.32 ", $x, ", [q7, #4*", $at, "]\n",)*
            $("vqshl.s16 ", $x, ", ", $x, ", #2\n",)*
        )
    };
}

/// The first pass in groups of eight: `q15::first8`. Returns nonzero if a part is large.
///
/// # Safety
/// `from` and `to` must be `m` pairs and `m` aligned points, m = 8 4^d of 32 or more, and the places must belong to `m`.
#[unsafe(naked)]
unsafe extern "C" fn eights(from: *const Pair, to: *mut Pair, m: usize, pass: &Pass) -> u32 {
    kernel!(
        begin!("3"),
        legs!("r4" "r5" "r6" "r7" "r8" "r9" "r10" "r11"),
        "movw r12, #{diagonal}",
        "2:",
        // The odd part: points 0 and 2 in q3, q2; 1 and 3, turned, in memory.
        two!("q0" "r5", "q1" "r9", "q2"),
        two!("q1" "r7", "q3" "r11", "q4"),
        "vadd.i16 q3, q2, q4",
        "vsub.i16 q2, q2, q4",
        "vcadd.i16 q4, q0, q1, #270",
        "vcadd.i16 q0, q0, q1, #90",
        "vcadd.i16 q4, q4, q4, #270",
        "vcadd.i16 q0, q0, q0, #270",
        "vqrdmulh.s16 q4, q4, r12",
        "vqrdmulh.s16 q0, q0, r12",
        "vstrw.32 q4, [sp, #16]",
        "vstrw.32 q0, [sp, #32]",
        // The even part: points 0 and 2 in q5, q4; the terms of the others in q0, q1.
        two!("q0" "r4", "q1" "r8", "q4"),
        two!("q1" "r6", "q5" "r10", "q6"),
        "vadd.i16 q5, q4, q6",
        "vsub.i16 q4, q4, q6",
        next!(),
        "vadd.i16 q6, q5, q3",
        "vsub.i16 q5, q5, q3",
        "vsub.i16 q6, q6, r3",
        "vcadd.i16 q3, q4, q2, #270",
        "vcadd.i16 q4, q4, q2, #90",
        store!("q6" "0", "q5" "4", "q3" "2", "q4" "6"),
        "vcadd.i16 q2, q0, q1, #270",
        "vcadd.i16 q0, q0, q1, #90",
        "vldrw.u32 q1, [sp, #16]",
        "vldrw.u32 q4, [sp, #32]",
        "vadd.i16 q3, q2, q1",
        "vsub.i16 q2, q2, q1",
        "vcadd.i16 q5, q0, q4, #270",
        "vcadd.i16 q0, q0, q4, #90",
        store!("q3" "1", "q2" "5", "q5" "3", "q0" "7"),
        "le lr, 2b",
        end!(),
        diagonal = const DIAGONAL,
    )
}

/// The first pass in groups of four: `q15::first4` with the parameters of [`eights`].
///
/// # Safety
/// The conditions of [`eights`], m = 4^d of 64 or more.
#[unsafe(naked)]
unsafe extern "C" fn fours(from: *const Pair, to: *mut Pair, m: usize, pass: &Pass) -> u32 {
    kernel!(
        begin!("2"),
        legs!("r4" "r5" "r6" "r7"),
        "2:",
        two!("q0" "r4", "q1" "r6", "q2"),
        two!("q1" "r5", "q3" "r7", "q4"),
        next!("lsr r1, r1, #1"),
        "vadd.i16 q3, q2, q4",
        "vsub.i16 q2, q2, q4",
        "vsub.i16 q3, q3, r3",
        "vcadd.i16 q4, q0, q1, #270",
        "vcadd.i16 q0, q0, q1, #90",
        store!("q3" "0", "q4" "1", "q2" "2", "q0" "3"),
        "le lr, 2b",
        end!(),
    )
}
