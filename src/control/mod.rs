//! What an instrument's registers must hold, worked out from its settings: pure functions, tested on the host against the
//! reference manual. `board` only writes the words.
//!
//! The words agree with ST's machine-readable description of the registers (host-tests/tests/registers.rs). Sections named RM are of ST's reference manual RM0390 (STM32F446xx), DS of the data sheet DS10693.

pub mod adf4159;
pub mod clock;
pub mod guard;
pub mod pins;
pub mod sampling;
pub mod serial;
pub mod settings;
pub mod slots;
pub mod waveform;
