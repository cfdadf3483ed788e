//! Picket's instrument: a loop that is the same on every board, the boards, and what each writes into its registers.
//!
//! ```text
//! bin/  one image a file
//!   |
//! instrument/  blocks to records, commands to answers          mps2/  emulated boards that play a capture
//!   |
//! board.rs  what the instrument asks of a board     <-  nucleo_f446re/  registers, and words/ for them
//! ```
//!
//! A new board is a type that implements [`board::Board`]: `docs/porting.md` has one of some hundred lines.
#![no_std]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

#[cfg(test)]
extern crate std;

pub mod board;
pub mod instrument;
#[cfg(all(target_os = "none", feature = "mps2"))]
pub mod mps2;
pub mod nucleo_f446re;
pub mod slot;
