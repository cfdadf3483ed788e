//! Assembly of whole functions.

/// `naked_asm!` whose assembler knows the DSP extension, where there is one.
///
/// The symbols of such functions are read by an assembler that knows the target but not `-Ctarget-cpu`: Armv7E-M means the
/// extension, Armv8-M does not.
#[cfg(not(armv8m))]
macro_rules! kernel {
    ($($line:tt)*) => { core::arch::naked_asm!($($line)*) };
}

#[cfg(armv8m)]
macro_rules! kernel {
    ($($line:tt)*) => { core::arch::naked_asm!(".cpu cortex-m33", $($line)*) };
}

pub(in crate::spectrum) use kernel;
