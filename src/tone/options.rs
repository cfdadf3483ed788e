//! The parameters of a tone's measurement.

use super::arithmetic::Arithmetic;
use super::effort::Effort;
use super::fit::Reach;
use super::threshold::Threshold;
use crate::carrier::Width;
use crate::methods::registry::Method;

/// The parameters of a tone's measurement beside the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The method of estimation.
    pub method: Method,
    /// The number of bins on each side that least squares reads.
    pub reach: Reach,
    /// The arithmetic of least squares.
    pub arithmetic: Arithmetic,
    /// The detection threshold.
    pub threshold: Threshold,
    /// The effort spent on a line that is not a steady tone.
    pub effort: Effort,
    /// The effect of the carrier's own width.
    pub width: Width,
}
