//! Host tools.
pub mod scenario;
