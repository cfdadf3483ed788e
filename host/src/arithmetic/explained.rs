//! An answer with every test behind its verdict.

use super::Estimate;
use picket::tone::evidence::Evidence;
use picket::tone::fit::Fit;
use picket::tone::judge::Judgement;
use picket::tone::observer::{Observer, Step, Test};
use std::cell::{Cell, RefCell};

/// What an observer heard, in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Note {
    /// A fit begins to be judged.
    Begin(Step),
    /// A test was made.
    Test(Test),
    /// What the tests of the last fit amount to, and whether it takes the place of the fit before.
    Judged(Judgement, bool),
}

/// The last fit of a tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted {
    /// The peak bin.
    pub peak: i32,
    /// The fit about it.
    pub fit: Fit<f32>,
    /// The noise power per sample beside the tone, in squared codes.
    pub noise: f32,
}

/// An answer, and why its verdict is what it is.
#[derive(Clone, Debug)]
pub struct Explained {
    /// The answer.
    pub estimate: Estimate,
    /// What its verdict follows from.
    pub evidence: Evidence,
    /// The tests behind the evidence, in the order in which they were made.
    pub notes: Vec<Note>,
    /// The fit; `None` where nothing was fitted.
    pub fitted: Option<Fitted>,
}

/// An observer that writes all down.
#[derive(Debug, Default)]
pub(super) struct Notes {
    notes: RefCell<Vec<Note>>,
    fitted: Cell<Option<Fitted>>,
}

impl Notes {
    pub fn explained(self, estimate: Estimate, evidence: Evidence) -> Explained {
        let (notes, fitted) = (self.notes.into_inner(), self.fitted.get());
        Explained { estimate, evidence, notes, fitted }
    }

    fn push(&self, note: Note) {
        self.notes.borrow_mut().push(note);
    }
}

impl Observer for &Notes {
    fn hear(self, test: impl FnOnce() -> Test) {
        self.push(Note::Test(test()));
    }

    fn begin(self, step: Step) {
        self.push(Note::Begin(step));
    }

    fn judged(self, judgement: &Judgement, taken: bool) {
        self.push(Note::Judged(*judgement, taken));
    }

    fn fitted(self, peak: i32, fit: &Fit<f32>, noise: f32) {
        self.fitted.set(Some(Fitted { peak, fit: *fit, noise }));
    }
}
