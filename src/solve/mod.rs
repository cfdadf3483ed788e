//! From tones to range and velocity.

pub mod chirp;
pub mod doppler;
