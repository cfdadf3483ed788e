//! The loop of [`super::carrier`] on cores with the DSP extension, two samples at a time. It equals
//! the portable definition bit for bit, on every input; the tests on emulated cores drive both.

use super::carrier::Loop;
use crate::acquire::codes::Between;
use crate::spectrum::fft::assembly::kernel;

/// The loop's constants beside the samples.
#[repr(C)]
struct Constants {
    /// The first and the last number of both bounds, each in both halves of a word. The bounds of the samples a lag on come first.
    bounds: [u32; 4],
    cosines: *const i16,
    /// From a cosine to its sine, bytes.
    apart: usize,
    end: *const i16,
}

/// The sums of `Carrier::sums_portably`, for a block of an even number of samples; `None` for another.
pub(super) fn sums(
    [cosines, sines]: [&[i16]; 2],
    samples: &[i16],
    others: &[i16],
    [inside, far_inside]: &[Between; 2],
) -> Option<Loop> {
    let length = cosines.len();
    if length == 0 || length % 2 != 0 || samples.len() < length || others.len() < length {
        return None;
    }
    let both = |code: i16| u32::from(code as u16) * 0x1_0001;
    let [low, high] = inside.ends().map(both);
    let [far_low, far_high] = far_inside.ends().map(both);
    let range = cosines.as_ptr_range();
    let constants = Constants {
        bounds: [far_low, far_high, low, high],
        cosines: range.start,
        apart: sines.as_ptr().addr().wrapping_sub(range.start.addr()),
        end: range.end,
    };
    let mut sums = Loop::default();
    // SAFETY: all four slices hold `length` numbers, an even number above 0.
    unsafe { pairs(&mut sums, samples.as_ptr(), others.as_ptr(), &constants) };
    Some(sums)
}

/// Adds up pairs of samples to `sums`, which must be zeros.
///
/// # Safety
/// Samples, samples a lag on and sines must be readable in the number of the cosines, an even number above 0.
#[unsafe(naked)]
unsafe extern "C" fn pairs(
    sums: &mut Loop,
    samples: *const i16,
    others: *const i16,
    constants: &Constants,
) {
    kernel!(
        "push {{r4-r11, lr}}",
        "sub sp, sp, #68",
        "ldm r3, {{r4, r5, r8, r9, r10, r11, r12}}",
        "strd r4, r5, [sp]",    // bounds of the others
        "strd r12, r0, [sp, #8]", // the end, the sums
        "strd r8, r9, [sp, #16]", // bounds of the samples
        "str r11, [sp, #32]",
        "mov r3, r10",
        "mov r0, #0",
        "mov r10, #0",
        "mov r11, #0",
        "mov r12, #0",
        "mov lr, #0",
        "strd r10, r11, [sp, #40]", // of the tone of what is left out: the counts of both halves, c,
        "str r10, [sp, #48]",       // s,
        "strd r10, r11, [sp, #52]", // cc,
        "strd r10, r11, [sp, #60]", // cs
        // r0: y; r10, r11: y c; r12, lr: y s.
        ".p2align 2",
        "2:",
        "ldr r4, [r1], #4",
        "ldr r5, [r2], #4",
        "ldrd r6, r7, [sp]",
        // A set sign bit marks a half that is out of bounds.
        "qsub16 r6, r5, r6",
        "qsub16 r7, r7, r5",
        "orr r6, r6, r7",
        "qsub16 r7, r4, r8",
        "qsub16 r5, r9, r4",
        "orr r6, r6, r7",
        "orr r5, r5, r6",
        "ldr r7, [sp, #32]",
        "ldr r7, [r3, r7]",
        "ldr r6, [r3], #4",
        "tst r5, #0x80008000",
        "bne 4f",
        "3:",
        "smlald r10, r11, r4, r6",
        "smlald r12, lr, r4, r7",
        "sxtah r0, r0, r4",
        "add r0, r0, r4, asr #16",
        "ldr r5, [sp, #8]",
        "cmp r3, r5",
        "blo 2b",
        "ldr r1, [sp, #12]",
        "strd r10, r11, [r1, #{yc}]",
        "strd r12, lr, [r1, #{ys}]",
        "str r0, [r1, #{y}]",
        "ldrd r4, r5, [sp, #40]",
        "ldr r6, [sp, #48]",
        "uxth r7, r4",
        "add r4, r7, r4, lsr #16",
        "str r4, [r1, #{count}]",
        "str r5, [r1, #{c}]",
        "str r6, [r1, #{s}]",
        "ldrd r4, r5, [sp, #52]",
        "strd r4, r5, [r1, #{cc}]",
        "ldrd r4, r5, [sp, #60]",
        "strd r4, r5, [r1, #{cs}]",
        "add sp, sp, #68",
        "pop {{r4-r11, pc}}",
        // At most one half of this pair counts. The other becomes 0, and its tone is summed apart.
        "4:",
        "and r5, r5, #0x80008000",
        "lsr r8, r5, #15", // 1 in each half that is left out
        "rsb r5, r8, r8, lsl #16",
        "bic r4, r4, r5",
        "and r5, r5, r6",
        "ldr r9, [sp, #40]",
        "add r9, r9, r8",
        "str r9, [sp, #40]",
        "ldr r9, [sp, #44]",
        "smlad r9, r6, r8, r9",
        "str r9, [sp, #44]",
        "ldr r9, [sp, #48]",
        "smlad r9, r7, r8, r9",
        "str r9, [sp, #48]",
        "ldrd r8, r9, [sp, #52]",
        "smlald r8, r9, r5, r6",
        "strd r8, r9, [sp, #52]",
        "ldrd r8, r9, [sp, #60]",
        "smlald r8, r9, r5, r7",
        "strd r8, r9, [sp, #60]",
        "ldrd r8, r9, [sp, #16]",
        "b 3b",
        count = const core::mem::offset_of!(Loop, out.count),
        c = const core::mem::offset_of!(Loop, out.c),
        s = const core::mem::offset_of!(Loop, out.s),
        cc = const core::mem::offset_of!(Loop, out.cc),
        cs = const core::mem::offset_of!(Loop, out.cs),
        yc = const core::mem::offset_of!(Loop, yc),
        ys = const core::mem::offset_of!(Loop, ys),
        y = const core::mem::offset_of!(Loop, y),
    )
}
