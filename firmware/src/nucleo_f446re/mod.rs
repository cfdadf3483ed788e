//! The NUCLEO-F446RE. This module writes to its registers what [`words`] decides.
//!
//! With the feature `played` the image runs on QEMU's STM32F405, which has neither converters nor DMA. Their registers are then a piece of
//! memory ([`PLAYED`]), in which the host plays them. The played samples are exact, so sigma does not cover QEMU's fallback clock. Nothing
//! else differs.

pub mod words;

#[cfg(all(target_os = "none", feature = "nucleo"))]
mod board;
#[cfg(all(target_os = "none", feature = "brown-out"))]
mod brown_out;
#[cfg(all(target_os = "none", feature = "nucleo"))]
pub mod chirp;
#[cfg(all(target_os = "none", feature = "nucleo"))]
pub mod converter;
#[cfg(all(target_os = "none", feature = "nucleo"))]
pub mod gauge;
#[cfg(all(target_os = "none", feature = "nucleo"))]
pub mod registers;
#[cfg(all(target_os = "none", feature = "nucleo"))]
mod self_test;
#[cfg(all(target_os = "none", feature = "nucleo"))]
pub mod serial;
#[cfg(all(target_os = "none", feature = "nucleo"))]
pub mod start;
#[cfg(all(target_os = "none", feature = "nucleo"))]
pub mod storage;
#[cfg(all(target_os = "none", feature = "nucleo"))]
mod tone;
#[cfg(all(target_os = "none", feature = "nucleo"))]
pub mod vectors;

#[cfg(all(target_os = "none", feature = "nucleo"))]
pub use board::Nucleo;

use picket_wire::settings::GUARD;

/// Samples in a block of this image.
pub const N: usize = 1024;
/// Words in a slot: an I/Q block with the guard before it.
pub const SLOT: usize = N + GUARD as usize;
/// Slots: as many as memory has room for beside sums and bursts. The settings say how many are in use.
pub const SLOTS: usize = 12;
/// Slots in use unless the settings say otherwise: two that the stream fills in turn, one that is
/// measured, and one that waits.
pub const USUAL_SLOTS: u16 = 4;

/// Cells of a frame of chirps: 64 chirps of 120 bins, as many as leave a block its stack on the emulated board, whose memory is 4 KB smaller. The
/// settings' error names them.
pub const CELLS: usize = 64 * 120;

/// Address at which the host plays DMA2, and from 0x400 on the converters.
pub const PLAYED: usize = 0x2001_F000;
