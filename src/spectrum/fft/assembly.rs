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

pub(crate) use kernel;
