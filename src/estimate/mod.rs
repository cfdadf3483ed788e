//! From a few bins to a frequency that can be trusted. One family of algorithms per file.
//!
//! An estimator answers with an *offset*: how far the tone is from the peak bin, in bins (cycles per record),
//! positive towards higher frequency, usually in -0.5..=0.5.

mod carrier;
#[cfg(dsp)]
mod carrier_dsp;
pub mod detection;
mod detector;
mod equations;
pub mod evidence;
pub mod frequency;
pub mod harmonic;
pub mod image;
pub mod judge;
pub mod lag;
pub mod least_squares;
pub mod lines;
pub mod lock;
pub mod measure;
pub mod method;
pub mod methods;
pub mod noise;
pub mod observer;
mod part;
pub mod phasor;
pub mod samples;
pub mod snr;
pub mod tone;
mod turn;
pub mod uncertainty;
pub mod unclipped;
pub mod verdict;
pub mod zoomed;

/// `x` held to `-limit..=limit`; 0 where it is not a number, as for a record without a signal.
pub(crate) fn within<T: crate::math::scalar::Scalar>(x: T, limit: T) -> T {
    if x.is_nan() { T::zero() } else { x.min(limit).max(-limit) }
}
