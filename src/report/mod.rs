//! What leaves the device.
