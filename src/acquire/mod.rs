//! From the converter to a block of samples that belongs to one owner.

pub mod capture;
pub mod frontend;
pub mod sample;
