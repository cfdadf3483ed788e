//! Where AN547's handlers are. The core starts from the first two vectors at the bottom of its ITCM,
//! and the others lie with the program.

use core::arch::naked_asm;

/// Tells the core, in SCB.VTOR, before anything else runs.
///
/// # Safety
/// cortex-m-rt calls it at the start, before variables have their values.
// SAFETY: cortex-m-rt knows the function by this name.
#[unsafe(no_mangle)]
#[unsafe(naked)]
unsafe extern "C" fn __pre_init() {
    naked_asm!(
        "movw r0, #:lower16:__vector_table",
        "movt r0, #:upper16:__vector_table",
        "movw r1, #0xed08",
        "movt r1, #0xe000",
        "str r0, [r1]",
        "dsb",
        "bx lr",
    )
}
