//! From the converter to a block of samples that belongs to one owner.

pub mod frontend;
pub mod kind;
pub mod queue;
pub mod sample;
