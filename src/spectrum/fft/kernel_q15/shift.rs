//! The number of bits by which a record is shifted up.
//!
//! Few points decide the shift. So the kernel guesses it from every eighth part of the record, and then only checks that no point is
//! stronger than the guess allows. If one is, the record is shifted one bit less. The points checked before fit this shift, too, so no
//! point is checked twice but the points of one group.

use super::super::integer::Pair;
use super::super::q15::{self, MOST, allowed, worthwhile};
use crate::acquire::codes::Codes;
use crate::spectrum::fft::assembly::kernel;

/// The shift of the M pairs in bits: the kernel for [`q15::shift_of`].
pub fn of<const M: usize>(pairs: &[Pair], codes: Codes) -> i32 {
    let from = pairs.as_ptr().cast::<u32>();
    if !q15::is_narrow(codes) || pairs.len() != M || !from.is_aligned() {
        return q15::shift_of::<M>(pairs, codes);
    }
    let centre = u32::from(codes.middle() as u16) * 0x1_0001;
    // SAFETY: `pairs` are M aligned words, a multiple of 32.
    worthwhile::<M>(unsafe {
        if centre == 0 { checked::<M, false>(from, 0) } else { checked::<M, true>(from, centre) }
    })
}

/// The most bits, up to [`MOST`], by which all points can be shifted about `centre`, a pair of codes; 0 if none. `CENTRED` says that
/// `centre` is not 0.
///
/// # Safety
/// `from` must be M aligned words, a multiple of 32.
#[unsafe(naked)]
unsafe extern "C" fn checked<const M: usize, const CENTRED: bool>(
    from: *const u32,
    centre: u32,
) -> i32 {
    // `SMLAD` sets Q if a power added to r3 exceeds 31 bits.
    macro_rules! look {
        ($($x:literal),*) => {
            concat!(
                "ldm r0!, {{r4-r11}}\n",
                $(
                    ".if {centred}\n ssub16 ", $x, ", ", $x, ", r1\n .endif\n",
                    "smlad ", $x, ", ", $x, ", ", $x, ", r3\n",
                )*
            )
        };
    }
    kernel!(
        "push {{r4-r11, lr}}",
        "movw r12, #{low}",
        "movt r12, #{high}",
        "mov lr, #{most}",
        "mov r2, r0",
        "mov r6, #0",
        // The strongest of eight.
        ".rept 8",
        "ldr r4, [r2]",
        "add r2, r2, #{m}/2",
        ".if {centred}",
        "ssub16 r4, r4, r1",
        ".endif",
        "smuad r4, r4, r4",
        "cmp r4, r6",
        "it hi",
        "movhi r6, r4",
        ".endr",
        // A shift by lr bits allows a power of r3.
        "3:",
        "lsl r4, lr, #1",
        "lsr r3, r12, r4",
        "cmp r3, r6",
        "bhs 4f",
        "subs lr, lr, #1",
        "bne 3b",
        "b 8f",
        "4:",
        "mvn r4, #0x80000000",
        "sub r3, r4, r3",
        "mov r4, #0",
        "msr apsr_nzcvq, r4",
        ".p2align 2",
        "5:",
        ".rept 4",
        look!("r4", "r5", "r6", "r7", "r8", "r9", "r10", "r11"),
        ".endr",
        "mrs r4, apsr",
        "tst r4, #0x08000000",
        "bne 6f",
        "cmp r0, r2",
        "blo 5b",
        "b 8f",
        // These points again, shifted one bit less.
        "6:",
        "sub r0, r0, #128",
        "mov r6, #0",
        "subs lr, lr, #1",
        "bne 3b",
        "8:",
        "mov r0, lr",
        "pop {{r4-r11, pc}}",
        centred = const CENTRED as u32,
        m = const M,
        most = const MOST,
        low = const allowed(M) & 0xffff,
        high = const allowed(M) >> 16,
    )
}
