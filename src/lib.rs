//! Picket reads a microcontroller's ADC and answers with a frequency, and from it a range and a
//! velocity, as precisely as the noise allows.
//!
//! The name comes from the *picket-fence effect*: an FFT sees the spectrum only through the gaps
//! between its bins; this library reads between the pickets.
//!
//! ```text
//! ADC codes -> block -> integer FFT -> peak + floor -> a few bins -> estimator -> tone -> solver -> target -> record
//!  acquire              spectrum                                     estimate             solve            report
//! ```
#![no_std]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

#[cfg(test)]
extern crate std;

pub mod acquire;
#[cfg(target_os = "none")]
pub mod board;
pub mod config;
pub mod estimate;
pub mod pipeline;
pub mod report;
pub mod scalar;
pub mod solve;
pub mod spectrum;
