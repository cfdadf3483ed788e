//! An answer with every test behind its verdict.

use super::Estimate;
pub use crate::explain::rows::{Fitted, Note, Notes};
use picket_dsp::model::Answer;
use picket_dsp::tone::evidence::Evidence;

/// An answer, and why its verdict is what it is.
#[derive(Clone, Debug)]
pub struct Explained {
    /// The answer.
    pub estimate: Estimate,
    /// What its verdict follows from.
    pub evidence: Evidence,
    /// The tests behind the evidence, in the order in which they were made.
    pub notes: Vec<Note>,
    /// What the joint fit says; `None` where none was made.
    pub joint: Option<Answer>,
    /// The fit; `None` where nothing was fitted.
    pub fitted: Option<Fitted>,
}

impl Explained {
    pub(super) fn of(notes: Notes, estimate: Estimate, evidence: Evidence) -> Self {
        let joint = notes.joint();
        let (notes, fitted) = notes.taken();
        Explained { estimate, evidence, notes, joint, fitted }
    }
}
