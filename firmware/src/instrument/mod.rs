//! The instrument: it turns blocks into telemetry and commands into answers, the same on every
//! board.

pub mod adf4159;
pub mod bounds;
pub mod checksum;
pub mod clock;
pub mod crashes;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod fault;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod legacy;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod measurer;
pub mod plan;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod retained;
#[cfg(all(target_os = "none", feature = "instrument"))]
mod run;
#[cfg(all(target_os = "none", feature = "instrument", image = "signals"))]
mod signals;
#[cfg(all(target_os = "none", feature = "instrument"))]
pub mod stack;
pub mod storage;

#[cfg(all(target_os = "none", feature = "instrument"))]
pub use run::Instrument;
