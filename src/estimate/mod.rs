//! From a few bins to a frequency that can be trusted. One family of algorithms per file.
//!
//! An estimator answers with an *offset*: how far the tone is from the peak bin, in bins (cycles per record),
//! positive towards higher frequency, usually in -0.5..=0.5.

pub mod frequency;
pub mod method;
pub mod rife;
pub mod tone;
pub mod uncertainty;
