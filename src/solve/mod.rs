//! From tones to range and velocity, in one block and over many.

pub(crate) mod beats;
pub mod bounds;
pub mod candidates;
pub mod chirp;
pub mod displacement;
pub mod doppler;
pub mod equations;
pub(crate) mod hypotheses;
pub(crate) mod hypothesis;
pub(crate) mod motion;
pub mod pairing;
pub mod phase_range;
pub(crate) mod segments;
pub mod sequence;
mod target;
pub mod track;
pub(crate) mod tracks;
pub mod uncertainty;
pub mod waveform;
