//! The methods beside least squares, one family a file. The registry is [`super::method`].

pub mod autocorrelation;
pub mod dft;
pub mod hann;
pub mod interpolate;
pub mod quinn;
pub mod rife;
