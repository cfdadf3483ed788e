//! Transforms. [`integer`] is the default engine and the definition of the target's arithmetic;
//! cores with the DSP extension run the same arithmetic in the loops of `kernel_dsp`. [`q15`] is the 16-bit one, and
//! `kernel_q15` its loops. `float`, with the feature `microfft`, is somebody else's.

#[cfg(dsp)]
pub(super) mod assembly;
#[cfg(feature = "microfft")]
pub mod float;
pub mod integer;
#[cfg(dsp)]
pub mod kernel_dsp;
#[cfg(dsp)]
pub mod kernel_q15;
pub mod q15;
pub mod twiddle;

#[cfg(not(dsp))]
pub(super) use super::sweep::real as sweep;
#[cfg(not(dsp))]
use integer as engine;
#[cfg(dsp)]
use kernel_dsp as engine;
#[cfg(dsp)]
pub(super) use kernel_dsp::sweep;

pub(crate) use engine::bend;
pub(super) use engine::{transform, window};
