//! The ends of an emulated image.

/// The emulator's exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// All blocks were measured.
    Done = 0,
    /// The capture is missing, damaged or too short.
    Capture = 10,
    /// The configuration is not valid.
    Config = 11,
    /// An expected interrupt did not come.
    Stalled = 12,
    /// An unexpected interrupt came, or a fault.
    Unexpected = 13,
    /// The image panicked.
    Panic = 14,
}

/// Ends the emulation.
pub fn exit(code: Exit) -> ! {
    semihosting::process::exit(i32::from(code as u8))
}

/// Calls a function that does not exist. An image links only if the optimiser finds no way to a panic. Images with a logger, or with
/// third-party transforms, contain panics; they end the emulation instead.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    #[cfg(not(any(feature = "log", feature = "rivals")))]
    {
        unsafe extern "C" {
            fn picket_can_panic() -> !;
        }
        // SAFETY: the function does not exist; an image that can reach this call does not link.
        unsafe { picket_can_panic() }
    }
    #[cfg(any(feature = "log", feature = "rivals"))]
    exit(Exit::Panic)
}

/// Ends the emulation after a fault, where cortex-m-rt would loop for ever.
// SAFETY: cortex-m-rt's vector table has the handler under this name, and it does not return.
#[unsafe(no_mangle)]
extern "C" fn HardFault() -> ! {
    exit(Exit::Unexpected)
}
