//! Transforms. [`integer`] is the default engine and the definition of the target's arithmetic.

pub mod integer;
pub mod twiddle;
