//! Transforms. [`integer`] is the default and defines the target's arithmetic. Cores with the DSP extension run this arithmetic in the
//! loops of `kernel_dsp`, cores with Helium in the loops of `kernel_mve`, Armv6-M in the loops of `kernel_thumb1`. `float`, with the
//! feature `microfft`, calls another crate.

#[cfg(any(dsp, short_products))]
pub(crate) mod assembly;
#[cfg(feature = "microfft")]
pub mod float;
pub mod integer;
#[cfg(dsp)]
pub mod kernel_dsp;
#[cfg(mve)]
pub mod kernel_mve;
#[cfg(short_products)]
pub mod kernel_thumb1;
pub mod twiddle;

#[cfg(not(any(dsp, short_products)))]
pub(super) use super::scan::real as scan;
#[cfg(not(any(dsp, short_products)))]
use integer as engine;
#[cfg(dsp)]
use kernel_dsp as engine;
#[cfg(short_products)]
use kernel_thumb1 as engine;

#[cfg(all(any(dsp, short_products), not(mve)))]
pub(super) use engine::scan;
#[cfg(not(mve))]
pub(super) use engine::transform;
pub(super) use engine::{window, window_finely};
#[cfg(mve)]
pub(super) use kernel_mve::{scan, transform};
