//! What leaves the device: a measurement becomes a record, a record a frame, a frame bytes without zeros.

pub mod cobs;
pub mod frame;
pub mod record;
