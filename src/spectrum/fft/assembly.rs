//! Functions written in assembly.

/// `naked_asm!` with an assembler that knows the DSP extension, if the core has it.
///
/// The assembler of naked functions knows the target but not `-Ctarget-cpu`. Armv7E-M implies the
/// extension; Armv8-M does not.
#[cfg(not(armv8m))]
macro_rules! kernel {
    ($($line:tt)*) => { core::arch::naked_asm!($($line)*) };
}

#[cfg(armv8m)]
macro_rules! kernel {
    ($($line:tt)*) => { core::arch::naked_asm!(".cpu cortex-m33", $($line)*) };
}

pub(crate) use kernel;
