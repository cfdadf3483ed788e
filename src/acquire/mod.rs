//! From the converter's words to blocks of samples, each with one owner.

pub mod burst;
pub mod codes;
pub mod format;
pub mod framer;
pub mod frontend;
pub mod kind;
pub mod queue;
pub mod rate_check;
pub mod sample;
