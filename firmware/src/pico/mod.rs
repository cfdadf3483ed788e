//! The Raspberry Pi Pico: an RP2040, its converter, and two DMA channels that start each other.
//!
//! ```text
//! converter -> FIFO -> channel 0 -> slot --+
//!                   -> channel 1 -> slot --+-> interrupt -> main loop -> UART0 by channel 2, USB
//! levels -> channel 3 -> PWM -> chirp
//! sync input -> PWM -> channels -> converter on and off, in place of the chirp
//! ```
//!
//! Code that runs for every block lies in SRAM (`firmware/pico.x`): read from flash through the chip's cache of 16 KiB it would take longer
//! than a block. [`words`] and [`waveform`] compute the values of the registers, [`elapsed`] counts blocks, [`inbox`] keeps the frames of several hosts apart, and [`widths`] corrects the
//! codes: these modules have tests on the host. The other modules only write registers. Sections named DS are in the RP2040's data sheet.

pub mod elapsed;
pub mod inbox;
pub mod waveform;
pub mod widths;
pub mod words;

#[cfg(all(target_os = "none", feature = "pico"))]
mod board;
#[cfg(all(target_os = "none", feature = "pico"))]
mod chirp;
#[cfg(all(target_os = "none", feature = "pico"))]
pub mod converter;
#[cfg(all(target_os = "none", feature = "pico"))]
mod correct;
#[cfg(all(target_os = "none", feature = "pico"))]
pub mod line;
#[cfg(all(target_os = "none", feature = "pico"))]
mod multiply;
#[cfg(all(target_os = "none", feature = "pico"))]
mod pulse;
#[cfg(all(target_os = "none", feature = "pico"))]
pub mod registers;
#[cfg(all(target_os = "none", feature = "pico"))]
mod self_test;
#[cfg(all(target_os = "none", feature = "pico"))]
pub mod start;
#[cfg(all(target_os = "none", feature = "pico"))]
pub mod storage;
#[cfg(all(target_os = "none", feature = "usb"))]
pub mod usb;
#[cfg(all(target_os = "none", feature = "pico"))]
pub mod vectors;

#[cfg(all(target_os = "none", feature = "pico"))]
pub use board::Pico;
use picket_dsp::pipeline::Alternating;

/// Samples in a block of this image.
pub const N: usize = 1024;
/// The pipeline for the pairs that the converter takes in turn.
pub type Pairs = Alternating<N, { 2 * N }>;
/// Words in a slot: an I/Q block, or twice a real one.
pub const SLOT: usize = N;
/// Slots: as many as memory has room for. The settings say how many are in use.
pub const SLOTS: usize = 16;
/// Slots in use unless the settings say otherwise: two that the channels fill in turn, one that is
/// measured, and five that wait while a block takes longer than its time.
pub const USUAL_SLOTS: u16 = 8;
