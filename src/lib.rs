//! Picket reads a microcontroller's ADC and answers with a frequency, and from it a range and a
//! velocity, as precisely as the noise allows.
//!
//! The name comes from the *picket-fence effect*: an FFT sees the spectrum only through the gaps
//! between its bins; this library reads between the pickets.
//!
//! ```text
//! ADC codes -> block -> integer FFT -> peak + floor -> a few bins -> estimator -> tone -> solver -> target
//!  acquire              spectrum                                     estimate             solve
//! ```
//! [`pipeline`] is this way for one block, [`tracker`] the same with a memory: tones followed from block to block.
//!
//! # Example
//!
//! ```
//! use picket::acquire::sample::{Real, Stamp};
//! use picket::config::Config;
//! use picket::estimate::tone::Verdict;
//! use picket::pipeline::Pipeline;
//!
//! let config = Config { rate_hz: 48_000.0, ..Config::default() };
//! let mut pipeline = Pipeline::<Real, 1024>::new(config.validate::<Real>(1024)?);
//! let turn = std::f64::consts::TAU * 1000.2 / 48_000.0;
//! let samples = std::array::from_fn(|n| (1500.0 * (turn * n as f64).sin()).round() as i16);
//! let tone = pipeline.block(Stamp::default(), &samples).tone;
//! assert_eq!(tone.verdict, Verdict::Good);
//! let error = tone.frequency.hertz(48_000.0) - 1000.2;
//! assert!(error.abs() < 5.0 * f64::from(tone.sigma) * 48_000.0);
//! # Ok::<(), picket::config::ConfigError>(())
//! ```
#![no_std]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

#[cfg(test)]
extern crate std;

pub mod acquire;
pub mod config;
pub mod estimate;
pub mod math;
pub mod pipeline;
pub mod solve;
pub mod spectrum;
pub mod tracker;
