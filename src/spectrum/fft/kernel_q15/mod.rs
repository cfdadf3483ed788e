//! The 16-bit transform and its search on cores with the DSP extension: packed points, two products
//! an instruction, and the sticky flag Q for headroom. Each kernel equals its portable definition
//! in [`super::q15`] and [`crate::spectrum::q15_bins`] bit for bit.
//!
//! The functions are naked, as in [`super::kernel_dsp`]. The passes clear Q first and return whether `SSAT16` has set it. An interrupt in
//! between does not disturb Q, because its return restores the flags.

/// Instructions, each with its own line end.
macro_rules! lines {
    ($($line:expr),* $(,)?) => { concat!($($line, "\n"),*) };
}

/// Saves the registers that a pass needs, and clears Q. The pass owns `$frame` bytes of the stack.
macro_rules! enter {
    ($frame:literal) => {
        lines!(
            "push {{r4-r11, lr}}",
            concat!("sub sp, sp, #", $frame),
            "mov r12, #0",
            "msr apsr_nzcvq, r12"
        )
    };
}

/// Returns Q.
macro_rules! leave {
    ($frame:literal) => {
        lines!(
            "mrs r0, apsr",
            "and r0, r0, #0x08000000",
            concat!("add sp, sp, #", $frame),
            "pop {{r4-r11, pc}}"
        )
    };
}

/// Sets Q if a part is large; overwrites `$free`.
macro_rules! look {
    ($free:literal: $($x:literal),*) => { concat!($("ssat16 ", $free, ", #14, ", $x, "\n",)*) };
}

#[macro_use]
mod butterfly;
mod first;
mod last;
mod passes;
mod search;
mod shift;

pub use search::scan;

use super::integer::Pair;
use super::q15;
use super::twiddle;
use crate::acquire::codes::Codes;

/// The kernels for [`q15::transform`].
pub fn transform<const M: usize>(pairs: &[Pair], codes: Codes, points: &mut [Pair]) -> i32 {
    if pairs.len() != M || points.len() != M || !points.as_ptr().cast::<u32>().is_aligned() {
        return q15::transform::<M>(pairs, codes, points);
    }
    let shift = shift::of::<M>(pairs, codes);
    let mut large = first::pass::<M>(pairs, codes, shift, points);
    let mut exponent = -shift - q15::FRACTION as i32;
    let (points, table) = (points.as_mut_ptr(), const { twiddle::passes(M) }.as_ptr());
    macro_rules! pass {
        ($($length:literal)*) => {$(
            if const { q15::has_pass(M, $length) } {
                exponent += 1 + i32::from(large);
                // SAFETY: `points` are M aligned points, the table holds the factors of M, and M has a pass of this length.
                large = unsafe { passes::pass::<M, $length>(points, table, large) };
            }
        )*};
    }
    pass!(4 8 16 32 64 128 256 512 1024);
    let _ = large;
    exponent
}
