//! From the converter to a block of samples that belongs to one owner.

pub mod assembler;
pub mod codes;
pub mod format;
pub mod frontend;
pub mod kind;
pub mod queue;
pub mod sample;
