//! Floats that give equal bits on every machine, and the few elementary functions that the fits use.

pub(crate) mod fixed_point;
pub(crate) mod products;
pub mod scalar;
pub(crate) mod series;
