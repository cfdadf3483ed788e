//! Ownership of the converter's two buffers.
