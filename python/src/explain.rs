//! Why a block has its verdict.

use crate::native::{Native, Work};
use crate::tables::{self, ToneRow};
use picket_dsp::model::{Answer, Cause};
use picket_dsp::spectrum::engine::Engine;
use picket_dsp::tone::line_class::{FitTest, LineClass};
use picket_dsp::tone::observer::{Observer, Step, Test};
use picket_dsp::{Pipeline, Plan, Record};
use std::cell::RefCell;

/// One thing that was heard of a measurement: the fit that is judged, the test, its value, its limit, and what is said.
pub type Heard = (&'static str, &'static str, f64, f64, String);

/// Every test behind the verdict on one block.
pub struct Explain<'a> {
    pub words: &'a [i16],
}

/// Writes down what it hears.
#[derive(Default)]
struct Notes {
    fit: RefCell<&'static str>,
    heard: RefCell<Vec<Heard>>,
}

impl Observer for Notes {
    fn test(&self, test: Test) {
        let said = if test.fires() { "above" } else { "below" };
        let (value, limit) = (test.value.into(), test.limit.into());
        let heard = (*self.fit.borrow(), test.statistic.name(), value, limit, said.to_owned());
        self.heard.borrow_mut().push(heard);
    }

    fn begin(&self, step: Step) {
        *self.fit.borrow_mut() = match step {
            Step::Usual => "usual",
            Step::Further => "more steps",
        };
    }

    fn judged(&self, judgement: &FitTest, taken: bool) {
        let line = match judgement.line {
            LineClass::Steady => "steady",
            LineClass::Moving => "moving",
            LineClass::Unresolved => "unresolved",
        };
        let said = format!("{line}{}", if taken { "" } else { ", dropped" });
        let heard = (self.fit.take(), "line", judgement.variance_inflation.into(), f64::NAN, said);
        self.heard.borrow_mut().push(heard);
    }

    fn joint(&self, answer: &Answer) {
        let [nothing, weights @ ..] = &answer.weights;
        let causes = Cause::ALL.into_iter().zip(weights).zip(answer.kept);
        let causes = causes.map(|((cause, weight), kept)| (cause.name(), *weight, kept));
        let mut heard = self.heard.borrow_mut();
        for (name, weight, kept) in [("nothing more", *nothing, 0)].into_iter().chain(causes) {
            let said = if kept > 0 { "joined the fit" } else { "-" };
            heard.push(("joint", name, weight.into(), f64::NAN, said.to_owned()));
        }
        let said = match (answer.unresolved, answer.moves) {
            (true, _) => "unresolved, dropped",
            (false, true) => "moving",
            (false, false) => "steady",
        };
        heard.push(("joint", "line", f64::NAN, f64::NAN, said.to_owned()));
    }
}

impl Work for Explain<'_> {
    type Output = (ToneRow, Vec<Heard>);

    fn run<R: Record, const N: usize, E: Engine>(
        self,
        native: &Native,
        plan: Plan<R, N>,
    ) -> Self::Output {
        let (mut tone, notes) = ([f64::NAN; tables::TONE], Notes::default());
        let mut pipeline = Box::new(Pipeline::<R, N, E>::new(plan));
        let mut rules = Vec::new();
        native.records::<R, N>(self.words, N, 0..1, |stamp, samples| {
            let (_, seen, evidence) = pipeline.explain(&stamp, samples, &notes);
            tone = tables::tone(&seen);
            for (applies, verdict) in evidence.rules() {
                let said = if applies { "applies" } else { "does not apply" };
                rules.push(("verdict", verdict.name(), f64::NAN, f64::NAN, said.to_owned()));
            }
        });
        let mut heard = notes.heard.into_inner();
        heard.extend(rules);
        (tone, heard)
    }
}
