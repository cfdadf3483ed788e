//! The blocks of a recording, and how each is read.

use crate::recording;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier as Width;
use picket_dsp::tone::fit::Reach;

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
