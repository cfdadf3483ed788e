//! What leaves the device: a measurement becomes a record, a record a frame, a frame bytes without zeros.

pub mod boot;
pub mod cobs;
pub mod command;
pub mod follow;
pub mod frame;
pub mod record;
pub mod status;
