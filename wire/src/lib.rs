//! The protocol between a Picket instrument and its host, in bytes: one for all boards.
//! `docs/protocol.md` shows a frame byte by byte.
//!
//! ```text
//! board -> host   measurement -> Telemetry -> frame -> COBS -> line
//! host  -> board  Command     -> Request   -> frame -> COBS -> line
//! ```
//!
//! - [`frame`] is the envelope: a kind, a payload and a CRC-32, stuffed by [`cobs`].
//! - [`telemetry`] is a measurement, [`lines`] all tones of a block, [`burst`] one burst, [`chirp_frame`] a frame of chirps and its targets, [`sum`] what a record adds up, [`follow`] tracks and targets, [`status`] counters, load and raw
//!   samples, [`boot`] what an instrument says at its start.
//! - [`command`] is what a host asks and how an instrument answers; [`settings`] is what a host sets,
//!   and [`settings_error`] why a board refuses it.
//! - [`capture`] is a recording with its configuration, in one file.
//!
//! - [`layout`] is how each of them is described, once, and how fields are added.
//!
//! The crate has no `std`, allocates nothing and cannot panic.
#![no_std]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

#[cfg(test)]
extern crate std;

mod answers;
pub mod boot;
pub mod burst;
pub mod capture;
pub mod chirp_frame;
pub mod cobs;
pub mod command;
mod config;
pub mod follow;
pub mod frame;
pub mod fundamental;
pub mod layout;
pub mod lines;
pub mod schema;
pub mod settings;
pub mod settings_error;
pub mod status;
pub mod sum;
pub mod telemetry;
pub mod view;
