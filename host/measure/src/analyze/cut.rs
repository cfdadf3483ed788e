//! The blocks of a recording, and how each is read.

use crate::length;
use crate::recording::{self, Recording};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier as Width;
use picket_dsp::tone::fit::Reach;
use std::path::Path;

/// How a recording is cut into blocks, and what is known of their samples.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// How the file is read.
    pub read: recording::Options,
    /// Samples in a block.
    pub n: usize,
    /// From one block's start to the next.
    pub hop: usize,
    /// Samples left out at the start.
    pub skip: u64,
    /// The band searched in hertz.
    pub band_hz: Option<(f64, f64)>,
    /// The width of the codes.
    pub codes: Codes,
    /// The reach of least squares.
    pub reach: Reach,
    /// The tone's own width.
    pub width: Width,
}

impl Cut {
    /// Opens a recording for blocks of a length that the library has.
    ///
    /// # Errors
    /// It cannot be opened, or there is no such length.
    pub fn open(&self, file: &Path) -> Result<Recording, String> {
        length::check(self.n)?;
        Recording::open(file, self.read).map_err(|error| error.to_string())
    }
}
