//! Host tools.
pub mod reference;
pub mod scenario;
pub mod telemetry;
