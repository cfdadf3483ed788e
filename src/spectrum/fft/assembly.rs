//! Functions written in assembly.

/// `naked_asm!` with an assembler that knows the DSP extension and Helium, if the core has them.
///
/// The assembler of naked functions knows the target but not `-Ctarget-cpu`. Armv7E-M implies the
/// DSP extension; Armv8-M does not.
#[cfg(not(armv8m))]
macro_rules! kernel {
    ($($line:tt)*) => { core::arch::naked_asm!($($line)*) };
}

#[cfg(all(armv8m, not(mve)))]
macro_rules! kernel {
    ($($line:tt)*) => { core::arch::naked_asm!(".cpu cortex-m33", $($line)*) };
}

#[cfg(mve)]
macro_rules! kernel {
    ($($line:tt)*) => { core::arch::naked_asm!(".cpu cortex-m55", $($line)*) };
}

/// Replaces the power in r8 and r9 by its [`worth`](crate::spectrum::scan). Changes r4 and r5.
#[cfg(dsp)]
macro_rules! worth {
    () => {
        concat!(
            "lsr r5, r9, #13\n",
            "lsr r4, r8, #13\n",
            "orr r4, r4, r9, lsl #19\n",
            "adds r4, r4, #0x200000\n",
            "adc r5, r5, #0\n",
            "subs r8, r8, r4\n",
            "sbcs r9, r9, r5\n",
            "itt lo\n",
            "movlo r8, #1\n",
            "movlo r9, #0\n",
        )
    };
}

pub(crate) use kernel;
#[cfg(dsp)]
pub(crate) use worth;
