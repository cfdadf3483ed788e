//! Host tools.
pub mod cli;
pub mod recording;
pub mod reference;
pub mod scenario;
pub mod simulate;
pub mod telemetry;
