//! From tones to range and velocity.

pub mod chirp;
pub mod doppler;
pub mod track;
pub mod tracks;
