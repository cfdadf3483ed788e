//! The noise power of a record.
//!
//! - [`ring`]: beside the tone, in records that are long enough.
//! - [`whole`], [`whole_fixed`]: in bins all over the spectrum, for shorter records.

mod own;
pub mod ring;
pub mod whole;
pub mod whole_fixed;

pub use ring::{Noise, ratio};
pub(crate) use ring::{ROUNDING, rounding};
