//! The instrument on a chip: `picket-instrument` between a board and the resets by which settings take effect.

pub mod checksum;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod fault;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod handover;
#[cfg(all(target_os = "none", feature = "defmt"))]
mod log;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod meter;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod retained;
#[cfg(all(target_os = "none", feature = "instrument"))]
mod run;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod stack;

pub use picket_instrument::{adf4159, bounds, clock, crashes, plan, storage, words};
#[cfg(all(target_os = "none", feature = "instrument"))]
pub use run::Instrument;
