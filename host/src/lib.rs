//! Host tools.
pub mod cli;
pub mod reference;
pub mod scenario;
pub mod telemetry;
