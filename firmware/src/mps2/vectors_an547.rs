//! The place of AN547's handlers. The core starts from the first two vectors at the bottom of its ITCM, and the others lie with the
//! program.

use core::arch::naked_asm;

/// Sets SCB.VTOR to this place before anything else runs.
///
/// # Safety
/// cortex-m-rt calls the function at the start, before variables have their values.
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
