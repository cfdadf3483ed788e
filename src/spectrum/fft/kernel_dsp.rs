//! The transform and the search on cores with the DSP extension: whole loops in assembly, because a radix-4
//! butterfly needs all fourteen registers and the compiler gives assembly twelve. Each kernel equals its portable
//! definition in [`super::integer`] and [`crate::spectrum::sweep`] bit for bit, on every input; the tests on
//! emulated cores drive both. No kernel branches on data but the search, where the maximum rises.
//!
//! The functions are naked: what they do to registers and memory is written in them and nowhere else. All
//! save `r4` to `r11` and return by `pop`.

use super::integer::{self, Factors, Pair, Point, Scale};
use super::twiddle::{FineTriple, Packed, Triple};
use crate::spectrum::sweep::{Sweep, power};
use core::arch::naked_asm;
use core::mem::MaybeUninit;

/// As [`integer::transform`].
pub fn transform<const M: usize>(pairs: &[Pair], bits: u32, points: &mut [Point]) -> i32 {
    let scale = Scale::new(M, bits);
    if pairs.len() != M || points.len() != M {
        return scale.exponent;
    }
    first_pass::<M>(pairs, &scale, bits, points);
    let mut length = scale.first;
    while length < M {
        // SAFETY: `points` holds M points and `length` divides M; the tables hold the factors of M.
        unsafe {
            match integer::factors::<M>(length) {
                Factors::Short(table) => pass::<M>(points.as_mut_ptr(), length, table),
                Factors::Fine(table) => fine_pass::<M>(points.as_mut_ptr(), length, table),
            }
        }
        length *= 4;
    }
    scale.exponent
}

/// Codes that leave room for three additions in 16 bits go two at a time.
fn first_pass<const M: usize>(pairs: &[Pair], scale: &Scale, bits: u32, points: &mut [Point]) {
    let (from, to) = (pairs.as_ptr(), points.as_mut_ptr());
    let narrow = bits <= 13;
    // SAFETY: both slices hold M elements, and a kernel for M reads and writes as many. It is chosen by the
    // shift it has built in.
    unsafe {
        match (scale.first, scale.shift) {
            (8, 14) if narrow => eights::<M, 14>(from, to),
            (8, 13) if narrow => eights::<M, 13>(from, to),
            (8, 12) if narrow => eights::<M, 12>(from, to),
            (8, 11) if narrow => eights::<M, 11>(from, to),
            (4, 0..=14) if narrow && M <= 1024 => fours::<M>(from, to, 1 << scale.shift),
            _ => integer::first_pass::<M>(pairs, scale, bits, points),
        }
    }
}

/// A radix-4 pass over sub-transforms of `length` points.
///
/// # Safety
/// `points` must be M points and `table` the factors of M or of less, but of at least 4 `length`, which is a power of two
/// of at most M/4.
unsafe fn pass<const M: usize>(points: *mut Point, length: usize, table: &[Triple]) {
    let leg = length * size_of::<Point>();
    let blocks = M / 4 / length;
    let stride = table.len() / length * size_of::<Triple>();
    let table = table.as_ptr();
    // SAFETY: as the caller vouches; the blocks of 4 `length` points fill M points.
    unsafe {
        let end = points.add(M);
        match (length, blocks) {
            // At least four blocks: the factors stay in registers over all of them.
            (4, 2..) => short::<4>(points, end, table, stride),
            (8, 2..) => short::<8>(points, end, table, stride),
            (16, 2..) => short::<16>(points, end, table, stride),
            _ => {
                let mut block = points;
                while block < end {
                    match blocks {
                        1 if length == 128 => even::<1>(block, table),
                        1 => long::<1>(block, leg, table),
                        _ => long::<4>(block, leg, table),
                    }
                    block = block.add(4 * length);
                }
            }
        }
    }
}

/// As [`pass`], with factors of 32 bits.
///
/// # Safety
/// As [`pass`]'s, and `length` must be 16 or more.
unsafe fn fine_pass<const M: usize>(points: *mut Point, length: usize, table: &[FineTriple]) {
    let leg = length * size_of::<Point>();
    let stride = table.len() / length * size_of::<FineTriple>();
    // SAFETY: as the caller vouches; the blocks of 4 `length` points fill M points.
    unsafe {
        let end = points.add(M);
        let mut block = points;
        while block < end {
            fine(block, leg, table.as_ptr(), stride);
            block = block.add(4 * length);
        }
    }
}

/// As [`crate::spectrum::sweep::real`], for the transform of at least 32 pairs.
pub fn sweep<const M: usize>(points: &[Point], table: &[Packed]) -> Sweep {
    let middle = points.len() / 2;
    let centre = points.get(middle).map_or(0, |&x| power(x));
    let mut seen = Seen { best: centre, total: centre, at: points.as_ptr() };
    if table.len() < middle || middle < 2 {
        return Sweep { bin: middle as i32, power: centre, total: centre };
    }
    // SAFETY: pairs middle-1 and middle+1 to 1 and the last are inside `points`, their factors inside `table`.
    unsafe {
        seen.at = points.as_ptr().add(middle);
        let factors = table.as_ptr().add(middle - 1);
        pairs_outwards(&mut seen, points.as_ptr(), middle * size_of::<Point>(), factors);
    }
    let bin = (seen.at as usize).wrapping_sub(points.as_ptr() as usize) / size_of::<Point>();
    Sweep { bin: bin as i32, power: seen.best, total: seen.total }
}

/// As [`integer::window`].
#[inline]
pub fn window<'a, const K: usize>(
    points: &[Point],
    table: &[Packed],
    first: usize,
    place: &'a mut MaybeUninit<[Point; K]>,
) -> &'a [Point; K] {
    let (length, middle) = (points.len(), points.len() / 2);
    let last = first.saturating_add(K);
    if first < 1 || last > length || table.len() < middle || middle == 0 || K == 0 {
        return place.write([[0; 2]; K]);
    }
    let (from, factors, mut to) =
        (points.as_ptr(), table.as_ptr(), place.as_mut_ptr().cast::<Point>());
    let below = middle.saturating_sub(first).min(K);
    // SAFETY: bins first.. are within 1..length, and so are their mirrors; K of them are written, some below the
    // middle, perhaps that one, and the rest. The factor of each is before the middle.
    unsafe {
        if below > 0 {
            let there = from.add(length - first);
            span_below(from.add(first), there, factors.add(first), to, to.add(below));
        }
        to = to.add(below);
        let mut next = first + below;
        if next == middle && next < last {
            to.write(integer::split(points, table, middle));
            to = to.add(1);
            next += 1;
        }
        if next < last {
            let mirror = length - next;
            span_above(
                from.add(next),
                from.add(mirror),
                factors.add(mirror),
                to,
                to.add(last - next),
            );
        }
        place.assume_init_ref()
    }
}

/// As [`integer::bend`].
pub fn bend(points: &[Point], stride: usize) -> u64 {
    let count = points.len().saturating_sub(2).div_ceil(stride.max(1));
    if count == 0 {
        return 0;
    }
    let range = points.as_ptr_range();
    // SAFETY: three points start at each `stride`-th place that is two or more before the end.
    unsafe { bends(range.start, range.end.sub(2), stride.max(1) * size_of::<Point>()) }
}

/// How many parts of pairs are at or beyond a rail. Looks at whole groups of eight pairs.
pub fn touching(pairs: &[Pair], low: i16, high: i16) -> u32 {
    let both = |code: i16| u32::from(code as u16) * 0x1_0001;
    let (low, high) = (both(low.saturating_add(1)), both(high.saturating_sub(1)));
    let groups = pairs.as_chunks::<8>().0.as_ptr_range();
    if groups.is_empty() {
        return 0;
    }
    // SAFETY: the range is inside `pairs`, and not empty.
    unsafe {
        let (from, to) = (groups.start.cast(), groups.end.cast());
        if any_outside(from, to, low, high) == 0 { 0 } else { all_outside(from, to, low, high) }
    }
}

/// What the search has seen, as [`pairs_outwards`] keeps it.
#[repr(C)]
struct Seen {
    best: u64,
    total: u64,
    at: *const Point,
}

/// Reads the digit-reversed position of group h among 4^d (LSR #32 where d is 0) into r5, with r4 = h.
macro_rules! reversed {
    () => {
        "rbit r5, r4
         and r6, r5, #0x55555555
         and r5, r5, #0xaaaaaaaa
         lsr r5, r5, #1
         orr r5, r5, r6, lsl #1
         lsr r5, r5, #{unused}"
    };
}

/// Stores the packed point in `$x` at `$at`, times the factor in r3. Uses r7.
macro_rules! widen {
    ($x:literal, $at:literal) => {
        concat!(
            "smulbb r7, ",
            $x,
            ", r3\n smultb ",
            $x,
            ", ",
            $x,
            ", r3\n strd r7, ",
            $x,
            ", [r1, #",
            $at,
            "]\n"
        )
    };
}

/// The first pass in groups of eight: `integer::first8` for codes of at most 13 bits.
///
/// # Safety
/// `from` and `to` must be M pairs and M points, M = 8 4^d of at most 2048.
#[unsafe(naked)]
unsafe extern "C" fn eights<const M: usize, const SHIFT: u32>(from: *const Pair, to: *mut Point) {
    naked_asm!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #4",
        "movw r2, #23170",
        "movt r2, #23170", // sqrt(1/2) twice
        "movw r3, #{one}",
        "movs r4, #0",
        "str r4, [sp]",
        "2:",
        "ldr r4, [sp]",
        reversed!(),
        "add lr, r0, r5, lsl #2",
        "adds r4, #1",
        "str r4, [sp]",
        // Four groups, whose first digit is the last of their place.
        ".rept 4",
        "ldr r4, [lr]",
        "ldr r5, [lr, #{leg}]",
        "ldr r6, [lr, #2*{leg}]",
        "ldr r7, [lr, #3*{leg}]",
        "add r11, lr, #4*{leg}",
        "ldr r8, [r11]",
        "ldr r9, [r11, #{leg}]",
        "ldr r10, [r11, #2*{leg}]",
        "ldr r11, [r11, #3*{leg}]",
        "add lr, lr, #{leg}/4",
        "sadd16 r12, r4, r8",
        "ssub16 r8, r4, r8",
        "sadd16 r4, r6, r10",
        "ssub16 r10, r6, r10",
        "sadd16 r6, r12, r4",  // e0
        "ssub16 r12, r12, r4", // e2
        "ssax r4, r8, r10",    // e1
        "sasx r8, r8, r10",    // e3
        "sadd16 r10, r5, r9",
        "ssub16 r9, r5, r9",
        "sadd16 r5, r7, r11",
        "ssub16 r11, r7, r11",
        "sadd16 r7, r10, r5",  // o0
        "ssub16 r10, r10, r5", // o2
        "ssax r5, r9, r11",    // o1
        "sasx r9, r9, r11",    // o3
        "sadd16 r11, r6, r7",
        "ssub16 r6, r6, r7",
        widen!("r11", "0"),
        widen!("r6", "32"),
        "ssax r11, r12, r10",
        "sasx r10, r12, r10",
        widen!("r11", "16"),
        widen!("r10", "48"),
        // Points 1 and 5.
        "smuad r6, r5, r2",
        "smusdx r5, r2, r5",
        "smulbb r7, r4, r3",
        "smultb r4, r4, r3",
        "add r10, r7, r6, asr #{fraction}",
        "add r11, r4, r5, asr #{fraction}",
        "strd r10, r11, [r1, #8]",
        "sub r7, r7, r6, asr #{fraction}",
        "sub r4, r4, r5, asr #{fraction}",
        "strd r7, r4, [r1, #40]",
        // Points 3 and 7.
        "smusdx r6, r2, r9",
        "smuad r9, r9, r2",
        "smulbb r7, r8, r3",
        "smultb r8, r8, r3",
        "add r10, r7, r6, asr #{fraction}",
        "sub r11, r8, r9, asr #{fraction}",
        "strd r10, r11, [r1, #24]",
        "sub r7, r7, r6, asr #{fraction}",
        "add r8, r8, r9, asr #{fraction}",
        "strd r7, r8, [r1, #56]",
        "add r1, r1, #64",
        ".endr",
        "ldr r4, [sp]",
        "cmp r4, #{outer}",
        "blo 2b",
        "add sp, sp, #4",
        "pop {{r4-r11, pc}}",
        one = const 1 << SHIFT,
        fraction = const 15 - SHIFT,
        // No length beyond 2048 is asked for, but the assembler sees it.
        leg = const if M <= 2048 { M / 8 * 4 } else { 4 },
        outer = const M / 32,
        unused = const 32 - (M / 32).trailing_zeros(),
    )
}

/// The first pass in groups of four: `integer::first4` for codes of at most 13 bits. `one` is one shifted up.
///
/// # Safety
/// `from` and `to` must be M pairs and M points, M = 4^d of at most 1024.
#[unsafe(naked)]
unsafe extern "C" fn fours<const M: usize>(from: *const Pair, to: *mut Point, one: u32) {
    naked_asm!(
        "push {{r4-r11, lr}}",
        "mov r3, r2",
        "movs r4, #0",
        "2:",
        reversed!(),
        "add lr, r0, r5, lsl #2",
        "adds r4, #1",
        ".rept 4",
        "ldr r8, [lr]",
        "ldr r9, [lr, #{leg}]",
        "ldr r10, [lr, #2*{leg}]",
        "ldr r11, [lr, #3*{leg}]",
        "add lr, lr, #{leg}/4",
        "sadd16 r12, r8, r10",
        "ssub16 r10, r8, r10",
        "sadd16 r8, r9, r11",
        "ssub16 r11, r9, r11",
        "sadd16 r9, r12, r8",
        "ssub16 r12, r12, r8",
        "ssax r8, r10, r11",
        "sasx r10, r10, r11",
        widen!("r9", "0"),
        widen!("r8", "8"),
        widen!("r12", "16"),
        widen!("r10", "24"),
        "add r1, r1, #32",
        ".endr",
        "cmp r4, #{outer}",
        "blo 2b",
        "pop {{r4-r11, pc}}",
        leg = const if M <= 1024 { M / 4 * 4 } else { 4 },
        outer = const M / 16,
        unused = const 32 - (M / 16).trailing_zeros(),
    )
}

/// The sum r5, r8 and the difference r12, r6 of leg 1 in r12, r6 and leg 3 in `$re`, `$im`.
macro_rules! sum_outer_legs {
    ($re:literal, $im:literal) => {
        concat!(
            "add r5, r12, ",
            $re,
            "\n sub r12, r12, ",
            $re,
            "\n add r8, r6, ",
            $im,
            "\n sub r6, r6, ",
            $im,
            "\n"
        )
    };
}

/// The four sums of those, of leg 2 in r10, r9 and leg 0, not halved, in r7, lr: points 0 (lr, r5), 1 (r8, r6),
/// 2 (r11, r7), 3 (r10, r9).
macro_rules! sum_all_legs {
    () => {
        "add r11, r10, r7, asr #1
         rsb r10, r10, r7, asr #1
         add r7, r9, lr, asr #1
         rsb r9, r9, lr, asr #1
         add lr, r11, r5
         sub r11, r11, r5
         add r5, r7, r8
         sub r7, r7, r8
         add r8, r10, r6
         sub r10, r10, r6
         sub r6, r9, r12
         add r9, r9, r12\n"
    };
}

/// `integer::turn` of r5, r6 and of r5, r7: legs 1 and 3, and their sum r5, r8 and difference r12, r6.
/// The factors are in `$one` and `$three`, the loads given, between which a factor may be loaded.
macro_rules! outer_legs {
    ($load1:expr, $one:literal, $load3:expr, $three:literal) => {
        concat!(
            $load1, // r5, r6
            "smulwb r12, r5, ",
            $one,
            "\n smulwt r8, r6, ",
            $one,
            "\n sub r12, r12, r8\n",
            "smulwb r6, r6, ",
            $one,
            "\n smlawt r6, r5, ",
            $one,
            ", r6\n",
            $load3, // r5, r7
            "smulwb r8, r5, ",
            $three,
            "\n smulwt r9, r7, ",
            $three,
            "\n sub r8, r8, r9\n",
            "smulwb r7, r7, ",
            $three,
            "\n smlawt r7, r5, ",
            $three,
            ", r7\n",
            sum_outer_legs!("r8", "r7"),
        )
    };
}

/// Leg 2 turned, leg 0 halved, and the four sums: points 0 (lr, r5), 1 (r8, r6), 2 (r11, r7), 3 (r10, r9).
macro_rules! inner_legs {
    ($load2:expr, $two:literal, $load0:expr) => {
        concat!(
            $load2, // r7, r9
            "smulwb r10, r7, ",
            $two,
            "\n smulwt r11, r9, ",
            $two,
            "\n sub r10, r10, r11\n",
            "smulwb r9, r9, ",
            $two,
            "\n smlawt r9, r7, ",
            $two,
            ", r9\n",
            $load0, // r7, lr
            sum_all_legs!(),
        )
    };
}

/// The butterfly whose factors are 1: points 0 (r11, r12), 1 (r7, r6), 2 (lr, r10), 3 (r8, r9).
macro_rules! plain {
    ($load1:expr, $load3:expr, $load2:expr, $load0:expr) => {
        concat!(
            $load1, // r5, r6
            $load3, // r7, r8
            "asr r5, r5, #1\n asr r6, r6, #1\n",
            "add r12, r5, r7, asr #1\n sub r5, r5, r7, asr #1\n",
            "add r7, r6, r8, asr #1\n sub r6, r6, r8, asr #1\n",
            $load2, // r8, r9
            $load0, // r10, r11
            "asr r8, r8, #1\n asr r9, r9, #1\n",
            "add lr, r8, r10, asr #1\n rsb r8, r8, r10, asr #1\n",
            "add r10, r9, r11, asr #1\n rsb r9, r9, r11, asr #1\n",
            "add r11, lr, r12\n sub lr, lr, r12\n add r12, r10, r7\n sub r10, r10, r7\n",
            "add r7, r8, r6\n sub r8, r8, r6\n sub r6, r9, r5\n add r9, r9, r5\n",
        )
    };
}

/// A radix-4 pass over sub-transforms of L points: one factor after the other, each for all blocks, of
/// which there are at least four.
///
/// # Safety
/// `points..end` must be whole pairs of blocks of 4 L points, `table` the factors, `stride` bytes apart.
#[unsafe(naked)]
unsafe extern "C" fn short<const L: usize>(
    points: *mut Point,
    end: *mut Point,
    table: *const Triple,
    stride: usize,
) {
    macro_rules! leg {
        ($do:literal, $x:literal, $y:literal, $leg:literal, $block:literal) => {
            concat!($do, " ", $x, ", ", $y, ", [r0, #", $leg, "*8*{l}+", $block, "*32*{l}]\n")
        };
    }
    macro_rules! first {
        ($b:literal) => {
            concat!(
                plain!(
                    leg!("ldrd", "r5", "r6", 1, $b),
                    leg!("ldrd", "r7", "r8", 3, $b),
                    leg!("ldrd", "r8", "r9", 2, $b),
                    leg!("ldrd", "r10", "r11", 0, $b)
                ),
                leg!("strd", "r11", "r12", 0, $b),
                leg!("strd", "r7", "r6", 1, $b),
                leg!("strd", "lr", "r10", 2, $b),
                leg!("strd", "r8", "r9", 3, $b),
            )
        };
    }
    macro_rules! turned {
        ($b:literal) => {
            concat!(
                outer_legs!(
                    leg!("ldrd", "r5", "r6", 1, $b),
                    "r2",
                    leg!("ldrd", "r5", "r7", 3, $b),
                    "r4"
                ),
                inner_legs!(leg!("ldrd", "r7", "r9", 2, $b), "r3", leg!("ldrd", "r7", "lr", 0, $b)),
                leg!("strd", "lr", "r5", 0, $b),
                leg!("strd", "r8", "r6", 1, $b),
                leg!("strd", "r11", "r7", 2, $b),
                leg!("strd", "r10", "r9", 3, $b),
            )
        };
    }
    naked_asm!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #16",
        "add r4, r0, #8",
        "add r5, r0, #8*{l}",
        "add r2, r2, r3",
        "strd r4, r5, [sp]",    // the next point of a leg, and the leg's end
        "strd r2, r3, [sp, #8]", // its factors, and the stride
        "2:",
        first!(0),
        first!(1),
        "add r0, r0, #64*{l}",
        "cmp r0, r1",
        "blo 2b",
        "3:",
        "ldr r0, [sp]",
        "ldrd r5, r6, [sp, #8]",
        "ldm r5, {{r2, r3, r4}}",
        "add r5, r5, r6",
        "str r5, [sp, #8]",
        "add r5, r0, #8",
        "str r5, [sp]",
        "4:",
        turned!(0),
        turned!(1),
        "add r0, r0, #64*{l}",
        "cmp r0, r1",
        "blo 4b",
        "ldrd r4, r5, [sp]",
        "cmp r4, r5",
        "blo 3b",
        "add sp, sp, #16",
        "pop {{r4-r11, pc}}",
        l = const L,
    )
}

/// A radix-4 pass over one block whose legs are `leg` bytes, 256 or more, with every `STRIDE`-th factor.
///
/// # Safety
/// `block` must be the four legs, `table` the factors of that many points.
#[unsafe(naked)]
unsafe extern "C" fn long<const STRIDE: usize>(
    block: *mut Point,
    leg: usize,
    table: *const Triple,
) {
    macro_rules! turned {
        () => {
            concat!(
                outer_legs!(
                    "ldr lr, [r4, #-4]\n ldrd r5, r6, [r1]\n",
                    "lr",
                    "ldr lr, [r4, #4]\n ldrd r5, r7, [r3]\n",
                    "lr"
                ),
                inner_legs!(
                    "ldr lr, [r4], #12*{stride}\n ldrd r7, r9, [r2]\n",
                    "lr",
                    "ldrd r7, lr, [r0]\n"
                ),
                "strd lr, r5, [r0], #8\n strd r8, r6, [r1], #8\n",
                "strd r11, r7, [r2], #8\n strd r10, r9, [r3], #8\n",
            )
        };
    }
    naked_asm!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #4",
        "add r4, r2, #12*{stride}+4",
        "add r3, r0, r1",
        "str r3, [sp]",
        "add r2, r3, r1",
        "add r1, r2, r1",
        // r3, r2, r1 are legs 1, 2, 3: put them in order.
        "mov r5, r1",
        "mov r1, r3",
        "mov r3, r5",
        plain!(
            "ldrd r5, r6, [r1]\n",
            "ldrd r7, r8, [r3]\n",
            "ldrd r8, r9, [r2]\n",
            "ldrd r10, r11, [r0]\n"
        ),
        "strd r11, r12, [r0], #8",
        "strd r7, r6, [r1], #8",
        "strd lr, r10, [r2], #8",
        "strd r8, r9, [r3], #8",
        turned!(),
        "2:",
        turned!(),
        turned!(),
        "ldr r5, [sp]",
        "cmp r0, r5",
        "blo 2b",
        "add sp, sp, #4",
        "pop {{r4-r11, pc}}",
        stride = const STRIDE,
    )
}

/// [`long`] with factors of 32 bits, which lie `stride` bytes apart; legs of 128 bytes or more.
///
/// # Safety
/// `block` must be the four legs, `table` the factors of that many points.
#[unsafe(naked)]
unsafe extern "C" fn fine(block: *mut Point, leg: usize, table: *const FineTriple, stride: usize) {
    // `integer::turn_finely` of $x, $y by the factor in $cos, $sin, to $re, $im.
    macro_rules! turn {
        ($re:literal, $im:literal, $x:literal, $y:literal, $cos:literal, $sin:literal) => {
            concat!(
                "smmul ",
                $re,
                ", ",
                $x,
                ", ",
                $cos,
                "\n smmla ",
                $re,
                ", ",
                $y,
                ", ",
                $sin,
                ", ",
                $re,
                "\n",
                "smmul ",
                $im,
                ", ",
                $y,
                ", ",
                $cos,
                "\n smmls ",
                $im,
                ", ",
                $x,
                ", ",
                $sin,
                ", ",
                $im,
                "\n",
            )
        };
    }
    macro_rules! turned {
        () => {
            concat!(
                "ldrd r5, r7, [r1]\n ldrd r8, r9, [r4]\n",
                turn!("r12", "r6", "r5", "r7", "r8", "r9"),
                "ldrd r5, r7, [r3]\n ldrd r8, r9, [r4, #16]\n",
                turn!("r10", "r11", "r5", "r7", "r8", "r9"),
                sum_outer_legs!("r10", "r11"),
                "ldrd r7, r11, [r2]\n ldr lr, [r4, #8]\n",
                "smmul r10, r7, lr\n smmul r9, r11, lr\n",
                "ldr lr, [r4, #12]\n",
                "smmla r10, r11, lr, r10\n smmls r9, r7, lr, r9\n",
                "ldrd r7, lr, [r0]\n",
                sum_all_legs!(),
                "strd lr, r5, [r0], #8\n strd r8, r6, [r1], #8\n",
                "strd r11, r7, [r2], #8\n strd r10, r9, [r3], #8\n",
                "ldr r5, [sp, #4]\n add r4, r4, r5\n",
            )
        };
    }
    naked_asm!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #12",
        "add r4, r2, r3",
        "str r3, [sp, #4]",
        "add r5, r0, r1",
        "str r5, [sp]",
        "add r2, r5, r1",
        "add r3, r2, r1",
        "mov r1, r5",
        plain!(
            "ldrd r5, r6, [r1]\n",
            "ldrd r7, r8, [r3]\n",
            "ldrd r8, r9, [r2]\n",
            "ldrd r10, r11, [r0]\n"
        ),
        "strd r11, r12, [r0], #8",
        "strd r7, r6, [r1], #8",
        "strd lr, r10, [r2], #8",
        "strd r8, r9, [r3], #8",
        turned!(),
        "2:",
        turned!(),
        turned!(),
        "ldr r5, [sp]",
        "cmp r0, r5",
        "blo 2b",
        "add sp, sp, #12",
        "pop {{r4-r11, pc}}",
    )
}

/// [`long`] for legs of 128 points, which two pointers reach: that leaves registers to load a triple at once.
///
/// # Safety
/// `block` must be 512 points, `table` the factors of that many times `STRIDE`.
#[unsafe(naked)]
unsafe extern "C" fn even<const STRIDE: usize>(block: *mut Point, table: *const Triple) {
    macro_rules! store {
        ($y0:literal, $y1:literal, $y2:literal, $y3:literal) => {
            concat!(
                "strd ",
                $y0,
                ", [r0, #-1016]\n strd ",
                $y1,
                ", [r0, #8]!\n",
                "strd ",
                $y2,
                ", [r1, #-1016]\n strd ",
                $y3,
                ", [r1, #8]!\n",
            )
        };
    }
    macro_rules! turned {
        () => {
            concat!(
                ".if {stride} == 1
                 ldm r2!, {{r3, r4, lr}}
                 .else
                 ldm r2, {{r3, r4, lr}}
                 add r2, r2, #12*{stride}
                 .endif\n",
                outer_legs!("ldrd r5, r6, [r0, #8]\n", "r3", "ldrd r5, r7, [r1, #8]\n", "lr"),
                inner_legs!("ldrd r7, r9, [r1, #-1016]\n", "r4", "ldrd r7, lr, [r0, #-1016]\n"),
                store!("lr, r5", "r8, r6", "r11, r7", "r10, r9")
            )
        };
    }
    naked_asm!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #4",
        "add r2, r1, #12*{stride}",
        // Eight bytes before legs 1 and 3; the others are 1024 bytes before them.
        "add r1, r0, #3072-8",
        "add r0, r0, #1024-8",
        "add r3, r0, #1024",
        "str r3, [sp]",
        plain!(
            "ldrd r5, r6, [r0, #8]\n",
            "ldrd r7, r8, [r1, #8]\n",
            "ldrd r8, r9, [r1, #-1016]\n",
            "ldrd r10, r11, [r0, #-1016]\n"
        ),
        store!("r11, r12", "r7, r6", "lr, r10", "r8, r9"),
        turned!(),
        "2:",
        turned!(),
        turned!(),
        "ldr r5, [sp]",
        "cmp r0, r5",
        "blo 2b",
        "add sp, sp, #4",
        "pop {{r4-r11, pc}}",
        stride = const STRIDE,
    )
}

/// Splits the pairs of points beside the middle, outwards to the first and the last, adds their powers to `seen`
/// and keeps the strongest, of equal ones the lowest (see [`crate::spectrum::sweep::real`]).
///
/// # Safety
/// `points` must be `2 middle` bytes of points, `factors` the one of the pair nearest the middle, those of the
/// others before it.
#[unsafe(naked)]
unsafe extern "C" fn pairs_outwards(
    seen: &mut Seen,
    points: *const Point,
    middle: usize,
    factors: *const Packed,
) {
    // Where the maximum rises the code leaves its line, and comes back.
    macro_rules! pair {
        ($lower:literal, $next:literal, $upper:literal, $end:literal) => {
            concat!(
                "ldrd r4, r5, [r0], #-8
                 ldrd r6, r7, [r2], #8
                 ldr lr, [r3], #-4
                 add r12, r4, r6
                 sub r4, r4, r6
                 sub r6, r5, r7
                 add r5, r5, r7
                 smulwt r7, r4, lr
                 smulwb r4, r4, lr
                 smlawt r4, r5, lr, r4
                 smulwb r5, r5, lr
                 sub r7, r7, r5
                 add r5, r7, r12, asr #1
                 rsb r7, r7, r12, asr #1
                 add r12, r4, r6, asr #1
                 sub r4, r4, r6, asr #1
                 smull r6, lr, r5, r5
                 smlal r6, lr, r12, r12
                 adds r10, r10, r6
                 adc r11, r11, lr
                 cmp r6, r8
                 sbcs r5, lr, r9
                 bhs ",
                $lower,
                "f\n",
                $next,
                ":
                 smull r5, r6, r7, r7
                 smlal r5, r6, r4, r4
                 adds r10, r10, r5
                 adc r11, r11, r6
                 cmp r8, r5
                 sbcs r7, r9, r6
                 blo ",
                $upper,
                "f\n",
                $end,
                ":\n"
            )
        };
    }
    // The lower bin (r6, lr) wins if it is as strong as any above it, the upper one (r5, r6) if it is stronger than
    // all below it.
    macro_rules! risen {
        ($lower:literal, $next:literal, $upper:literal, $end:literal) => {
            concat!(
                $lower,
                ": mov r8, r6\n mov r9, lr\n add r5, r0, #8\n str r5, [sp, #4]\n b ",
                $next,
                "b\n",
                $upper,
                ": mov r8, r5\n mov r9, r6\n sub r5, r2, #8\n str r5, [sp, #4]\n b ",
                $end,
                "b\n",
            )
        };
    }
    naked_asm!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #8",
        "str r0, [sp]",
        "ldm r0, {{r8, r9, r10, r11, r12}}", // best, total, at
        "str r12, [sp, #4]",
        // r1: the end; r0: towards it; r2: away.
        "add r2, r1, r2",
        "sub r0, r2, #8",
        "add r2, r2, #8",
        pair!("10", "11", "12", "13"),
        "2:",
        "cmp r0, r1",
        "bls 6f",
        pair!("20", "21", "22", "23"),
        pair!("30", "31", "32", "33"),
        "b 2b",
        "6:",
        "ldrd r0, r12, [sp]",
        "stm r0, {{r8, r9, r10, r11, r12}}",
        "add sp, sp, #8",
        "pop {{r4-r11, pc}}",
        risen!("10", "11", "12", "13"),
        risen!("20", "21", "22", "23"),
        risen!("30", "31", "32", "33"),
    )
}

/// Sums the powers of half the second difference at every `stride`-th byte from `from` to before `to`.
///
/// # Safety
/// There must be three points at each, and at least one.
#[unsafe(naked)]
unsafe extern "C" fn bends(from: *const Point, to: *const Point, stride: usize) -> u64 {
    naked_asm!(
        "push {{r4-r10, lr}}",
        "mov r3, #0",
        "mov r12, #0",
        "2:",
        "ldm r0, {{r4-r9}}",
        "add r0, r0, r2",
        "rsb r4, r6, r4, asr #1",
        "add r4, r4, r8, asr #1",
        "rsb r5, r7, r5, asr #1",
        "add r5, r5, r9, asr #1",
        "smlal r3, r12, r4, r4",
        "smlal r3, r12, r5, r5",
        "cmp r0, r1",
        "blo 2b",
        "mov r0, r3",
        "mov r1, r12",
        "pop {{r4-r10, pc}}",
    )
}

/// The two halves of `integer::split_pair` up to its last sums: the point $p in r5, r6 and its mirror $q in r7, r8
/// give re in r8, im in r5, twice the even part in r9, r7.
macro_rules! split_pair {
    () => {
        "add r9, r5, r7
         sub r5, r5, r7
         sub r7, r6, r8
         add r6, r6, r8
         smulwt r8, r5, r10
         smulwb r5, r5, r10
         smlawt r5, r6, r10, r5
         smulwb r6, r6, r10
         sub r8, r8, r6"
    };
}

/// Bins below the middle, in ascending order.
///
/// # Safety
/// For each bin in `to..end` there must be a point at `here` and after, one at `there` and before, and a factor
/// at `factors` and after. There must be at least one.
#[unsafe(naked)]
unsafe extern "C" fn span_below(
    here: *const Point,
    there: *const Point,
    factors: *const Packed,
    to: *mut Point,
    end: *mut Point,
) {
    naked_asm!(
        "ldr r12, [sp]",
        "push {{r4-r10, lr}}",
        "2:",
        "ldrd r5, r6, [r0], #8",
        "ldrd r7, r8, [r1], #-8",
        "ldr r10, [r2], #4",
        split_pair!(),
        "add r8, r8, r9, asr #1",
        "add r5, r5, r7, asr #1",
        "strd r8, r5, [r3], #8",
        "cmp r3, r12",
        "blo 2b",
        "pop {{r4-r10, pc}}",
    )
}

/// Bins above the middle, in ascending order.
///
/// # Safety
/// As [`span_below`], but with the factors at `factors` and before.
#[unsafe(naked)]
unsafe extern "C" fn span_above(
    here: *const Point,
    there: *const Point,
    factors: *const Packed,
    to: *mut Point,
    end: *mut Point,
) {
    naked_asm!(
        "ldr r12, [sp]",
        "push {{r4-r10, lr}}",
        "2:",
        "ldrd r7, r8, [r0], #8",
        "ldrd r5, r6, [r1], #-8",
        "ldr r10, [r2], #-4",
        split_pair!(),
        "rsb r8, r8, r9, asr #1",
        "sub r5, r5, r7, asr #1",
        "strd r8, r5, [r3], #8",
        "cmp r3, r12",
        "blo 2b",
        "pop {{r4-r10, pc}}",
    )
}

/// Other than 0 where a half of a word is outside `low..=high`, each given in both halves.
///
/// # Safety
/// `from..to` must be groups of eight words, at least one.
#[unsafe(naked)]
unsafe extern "C" fn any_outside(from: *const u32, to: *const u32, low: u32, high: u32) -> u32 {
    macro_rules! look {
        ($($x:literal, $y:literal);*) => {
            concat!($(
                // The larger of each half to lr, the smaller to the other.
                "ssub16 lr, ", $x, ", ", $y, "\n sel lr, ", $x, ", ", $y, "\n sel ", $x, ", ", $y, ", ", $x, "\n",
                // A sign bit tells.
                "qsub16 lr, r3, lr\n orr r12, r12, lr\n qsub16 lr, ", $x, ", r2\n orr r12, r12, lr\n",
            )*)
        };
    }
    naked_asm!(
        "push {{r4-r11, lr}}",
        "mov r12, #0",
        "2:",
        "ldm r0!, {{r4-r11}}",
        look!("r4", "r5"; "r6", "r7"; "r8", "r9"; "r10", "r11"),
        "cmp r0, r1",
        "blo 2b",
        "and r0, r12, #0x80008000",
        "pop {{r4-r11, pc}}",
    )
}

/// How many halves of words are outside `low..=high`, each given in both halves.
///
/// # Safety
/// `from..to` must be groups of eight words, at least one, and at most 2^16 words.
#[unsafe(naked)]
unsafe extern "C" fn all_outside(from: *const u32, to: *const u32, low: u32, high: u32) -> u32 {
    macro_rules! look {
        ($($x:literal),*) => {
            concat!($(
                "qsub16 lr, ", $x, ", r2\n qsub16 ", $x, ", r3, ", $x, "\n orr lr, lr, ", $x, "\n",
                "and lr, lr, #0x80008000\n add r12, r12, lr, lsr #15\n",
            )*)
        };
    }
    naked_asm!(
        "push {{r4-r11, lr}}",
        "mov r12, #0",
        "2:",
        "ldm r0!, {{r4-r11}}",
        look!("r4", "r5", "r6", "r7", "r8", "r9", "r10", "r11"),
        "cmp r0, r1",
        "blo 2b",
        // Each half has counted its own.
        "uxth r0, r12",
        "add r0, r0, r12, lsr #16",
        "pop {{r4-r11, pc}}",
    )
}
