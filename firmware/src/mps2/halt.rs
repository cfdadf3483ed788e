//! How an emulated image ends.

/// The emulator's exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Everything was measured.
    Done = 0,
    /// The capture is missing, damaged or too short.
    Capture = 10,
    /// The configuration is not valid.
    Config = 11,
    /// An interrupt that was expected did not come.
    Stalled = 12,
    /// An interrupt came that nobody expects, or a fault.
    Unexpected = 13,
    /// The image panicked.
    Panic = 14,
}

/// Ends the emulation.
pub fn exit(code: Exit) -> ! {
    semihosting::process::exit(i32::from(code as u8))
}

/// Calls a function that does not exist: an image links only if the optimiser finds no way to a panic. A logger holds
/// panics of its own, and so do other people's transforms, so images with either end the emulation instead.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    #[cfg(not(any(feature = "log", feature = "rivals")))]
    {
        unsafe extern "C" {
            fn picket_can_panic() -> !;
        }
        // SAFETY: there is no such function: an image in which this call can be reached does not link.
        unsafe { picket_can_panic() }
    }
    #[cfg(any(feature = "log", feature = "rivals"))]
    exit(Exit::Panic)
}

/// A fault ends the emulation at once, where cortex-m-rt would stay in a loop.
// SAFETY: this is the name by which cortex-m-rt's vector table knows the handler, and it does not return.
#[unsafe(no_mangle)]
extern "C" fn HardFault() -> ! {
    exit(Exit::Unexpected)
}
