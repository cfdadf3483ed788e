//! The estimators of the papers and of others, one family a file, and the registry of all methods.
//!
//! An estimator returns an *offset*: the distance of the tone from the peak bin, in bins (cycles per record), positive towards higher
//! frequency, usually in -0.5..=0.5.

pub mod autocorrelation;
pub mod dft;
pub mod hann;
pub mod interpolate;
pub mod quinn;
pub mod registry;
pub mod rife;
pub mod samples;
pub mod snr;
