//! The blocks of a recording, and how each is read.

use crate::recording::{self, Clock, Recording};
use crate::{cli, length};
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
        let recording = Recording::open(file, self.read).map_err(|error| error.to_string())?;
        if let Some(clock) = recording.clock().filter(|clock| clock.walk_s > 0.0) {
            return Err(format!("{}: {}", cli::name(file), uneven(&clock, self.n)));
        }
        assumed(file, &recording);
        Ok(recording)
    }
}

/// Says on stderr what was assumed of a recording, in one line.
pub fn assumed(file: &Path, recording: &Recording) {
    if let Some(assumed) = recording.assumed() {
        eprintln!("{}: {assumed}", cli::name(file));
    }
}

/// Why blocks of samples that are not even in time are not measured.
pub fn uneven(clock: &Clock, n: usize) -> String {
    format!(
        "the samples are not even in time: over {n} of them the rate is off by {:.2} % and unknown, more than sigma covers; sample by a timer, or \
         add --rate HZ to take them as even",
        100.0 * clock.share(n)
    )
}
