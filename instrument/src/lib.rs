//! A Picket instrument as a state machine without I/O: it turns blocks into telemetry and commands into answers, identically on every
//! board, by every executor, and on a host without a board.
//!
//! ```text
//! bytes of the host -> Instrument::on_bytes --+
//! blocks of samples -> Instrument::on_block --+-> Port: frames, a watchdog to feed
//! time              -> Instrument::poll     --+
//! ```
//!
//! - [`instrument`] is the machine, [`port`] its connection to the board, [`start`] the inputs of its start.
//! - [`plan`] checks settings, [`meter`] measures a block, [`gatherer`] makes sums and bursts, [`frames`] frames of chirps, [`every`] has
//!   all of it, in memory for [`either`].
//! - [`storage`] keeps settings in two pages of flash (`nor`: of any driver by `embedded-storage`, with the feature of this name),
//!   [`words`] turns settings into words, [`checksum`] checks pages and memory.
//! - [`bounds`] bounds answers, saves and waits; [`crashes`] counts abnormal ends; [`clock`] adds the clock's part to sigma.
//! - [`slot`] is the memory of a block, [`adf4159`] the words of a ramp synthesiser.
//!
//! The crate has no panic handler and touches no register. It does not reset the chip, sleep or wait: [`instrument::End`] says when a
//! program shall restart. It allocates nothing and cannot panic.
#![no_std]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

#[cfg(test)]
extern crate std;

pub mod adf4159;
pub mod bounds;
pub mod checksum;
pub mod clock;
pub mod crashes;
pub mod either;
pub mod every;
pub mod frames;
pub mod gatherer;
pub mod instrument;
pub mod meter;
#[cfg(feature = "embedded-storage")]
pub mod nor;
pub mod plan;
pub mod port;
pub mod slot;
pub mod start;
pub mod storage;
pub mod words;

pub use instrument::{End, Instrument};
pub use port::{Clocks, Port, Slots};
pub use start::Start;
