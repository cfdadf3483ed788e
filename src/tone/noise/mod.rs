//! The noise power of a record.
//!
//! - [`ring`]: beside the tone, in records that are long enough.
//! - `quietest`: of places, a quarter of which may hold other lines.
//! - [`whole`], [`whole_fixed`]: in bins all over the spectrum, for shorter records.

pub(crate) mod louder;
pub(crate) mod own;
mod power;
pub(crate) mod quietest;
pub mod ring;
pub mod whole;
pub mod whole_fixed;

pub use power::{Noise, ratio};
pub(crate) use power::{ROUNDING, rounding};
