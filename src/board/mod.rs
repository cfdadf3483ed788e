//! Registers, one board a file. Nothing of the core refers to this.

#[cfg(all(feature = "mps2", an505))]
pub mod converter;
#[cfg(feature = "mps2")]
pub mod count;
#[cfg(feature = "mps2")]
pub mod halt;
#[cfg(feature = "mps2")]
pub mod mps2;
#[cfg(feature = "nucleo")]
pub mod nucleo_f446re;
#[cfg(feature = "mps2")]
pub mod playback;
