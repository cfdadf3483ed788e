//! The tests behind a verdict, reported to an observer.
//!
//! A measurement reports each test to an [`Observer`]: the statistic, its limit and whether the test fired. A block without an observer
//! pays nothing. The observer of `picket explain` writes every test down.

use super::line_class::FitTest;
pub use super::statistic::{Statistic, Test};
use crate::model::Answer;
use crate::tone::fit::Fit;

/// A fit whose line is judged. A measurement goes on to the next fit where the one before shows no steady tone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// The usual fit.
    Usual,
    /// The usual fit with more steps, to its end.
    Further,
}

/// The receiver of the tests behind a verdict. Every method does nothing unless overridden.
pub trait Observer {
    /// Receives a test.
    fn test(&self, _test: Test) {}

    /// A fit begins to be judged.
    fn begin(&self, _step: Step) {}

    /// Receives the conclusion of the last fit's tests, and whether the fit replaces the one before.
    fn judged(&self, _judgement: &FitTest, _taken: bool) {}

    /// Receives the last fit at a peak bin, and the noise power per sample beside the tone.
    fn fitted(&self, _peak: i32, _fit: &Fit<f32>, _noise: f32) {}

    /// Receives the joint fit's answer on a line that is not a steady tone. The answer is taken unless it is unresolved.
    fn joint(&self, _answer: &Answer) {}
}

/// An observer or none: `()` costs a measurement nothing, since nothing of it is compiled.
pub(crate) trait Tap: Copy {
    /// [`Observer::test`]. The closure is evaluated only for an observer.
    fn hear(self, test: impl FnOnce() -> Test);
    /// [`Observer::begin`].
    fn begin(self, step: Step);
    /// [`Observer::judged`].
    fn judged(self, judgement: &FitTest, taken: bool);
    /// [`Observer::fitted`].
    fn fitted(self, peak: i32, fit: &Fit<f32>, noise: f32);
    /// [`Observer::joint`].
    fn joint(self, answer: &Answer);

    /// Makes a test, reports it, and returns whether it fired.
    #[inline(always)]
    fn exceeds(self, statistic: Statistic, value: f32, limit: f32) -> bool {
        let test = Test { statistic, value, limit };
        self.hear(|| test);
        test.fires()
    }
}

impl Tap for () {
    #[inline(always)]
    fn hear(self, _: impl FnOnce() -> Test) {}
    #[inline(always)]
    fn begin(self, _: Step) {}
    #[inline(always)]
    fn judged(self, _: &FitTest, _: bool) {}
    #[inline(always)]
    fn fitted(self, _: i32, _: &Fit<f32>, _: f32) {}
    #[inline(always)]
    fn joint(self, _: &Answer) {}
}

impl Tap for &dyn Observer {
    fn hear(self, test: impl FnOnce() -> Test) {
        self.test(test());
    }
    fn begin(self, step: Step) {
        Observer::begin(self, step);
    }
    fn judged(self, judgement: &FitTest, taken: bool) {
        Observer::judged(self, judgement, taken);
    }
    fn fitted(self, peak: i32, fit: &Fit<f32>, noise: f32) {
        Observer::fitted(self, peak, fit, noise);
    }
    fn joint(self, answer: &Answer) {
        Observer::joint(self, answer);
    }
}
