//! What a Picket instrument and its host say to each other, the same for every board: telemetry,
//! tracks, commands, settings and captures as bytes. `docs/protocol.md` shows a frame byte by byte.
//!
//! ```text
//! board -> host   measurement -> record -> frame -> COBS -> line
//! host  -> board  command     -> frame  -> COBS -> line
//! ```
#![no_std]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

#[cfg(test)]
extern crate std;

pub mod boot;
mod bytes;
pub mod capture;
pub mod cobs;
pub mod command;
mod config;
pub mod follow;
pub mod frame;
pub mod settings;
pub mod settings_error;
pub mod status;
pub mod telemetry;
