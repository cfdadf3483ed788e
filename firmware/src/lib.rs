//! Picket's firmware: the instrument (`picket-instrument`) in a loop that all boards share, the boards, and one image a file.
//!
//! ```text
//! bin/            one image a file
//!   |
//! instrument/     the loop, and the resets by which settings take effect
//!   |
//! board.rs        what the loop needs from a board besides the instrument's `Port`
//!   ^             (fence.rs, progress.rs, sampler.rs, shared.rs: what boards have in common; self_test/: how they try themselves)
//! nucleo_f446re/  a board: its registers, and in words/ what goes into them
//! pico/           another one, with words.rs
//!
//! mps2/           emulated boards that play a capture, for images of their own
//! ```
//!
//! A new board is a type that implements [`board::Port`] and [`board::Board`], of at most 150 lines: `docs/own-board.md` shows one. The feature `instrument`
//! gives its crate the loop, without the boards of this crate. An image links only if no panic is reachable.
#![no_std]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

#[cfg(test)]
extern crate std;

pub mod board;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod fence;
pub mod instrument;
#[cfg(all(target_os = "none", feature = "cores"))]
pub mod mps2;
pub mod nucleo_f446re;
pub mod pico;
pub mod progress;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod sampler;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod self_test;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod shared;
pub use picket_instrument::slot;
