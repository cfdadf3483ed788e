//! Every test behind a verdict as a row: for `picket explain`, and for the page, which has this file, too.

#[path = "words.rs"]
mod words;

use picket_dsp::model::Answer;
use picket_dsp::tone::Verdict;
use picket_dsp::tone::evidence::{EDGE_BINS, Evidence, WHOLE_SPECTRUM};
use picket_dsp::tone::fit::Fit;
use picket_dsp::tone::line_class::{FitTest, LineClass};
use picket_dsp::tone::observer::{Observer, Step, Test};
use picket_dsp::tone::sigma::CLIPPED;
use std::cell::{Cell, RefCell};

/// What an observer heard, in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Note {
    /// A fit begins to be judged.
    Begin(Step),
    /// A test was made.
    Test(Test),
    /// The verdict of the last fit's tests, and whether this fit replaces the one before.
    Judged(FitTest, bool),
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

/// An observer that writes all down.
#[derive(Debug, Default)]
pub struct Notes {
    notes: RefCell<Vec<Note>>,
    fitted: Cell<Option<Fitted>>,
    joint: Cell<Option<Answer>>,
}

impl Notes {
    /// What it heard, in order, and of the last fit, if there was one.
    pub fn taken(self) -> (Vec<Note>, Option<Fitted>) {
        (self.notes.into_inner(), self.fitted.get())
    }

    /// What the joint fit said, if there was one.
    pub fn joint(&self) -> Option<Answer> {
        self.joint.get()
    }

    fn push(&self, note: Note) {
        self.notes.borrow_mut().push(note);
    }
}

impl Observer for Notes {
    fn test(&self, test: Test) {
        self.push(Note::Test(test));
    }

    fn begin(&self, step: Step) {
        self.push(Note::Begin(step));
    }

    fn judged(&self, judgement: &FitTest, taken: bool) {
        self.push(Note::Judged(*judgement, taken));
    }

    fn fitted(&self, peak: i32, fit: &Fit<f32>, noise: f32) {
        self.fitted.set(Some(Fitted { peak, fit: *fit, noise }));
    }

    fn joint(&self, answer: &Answer) {
        self.joint.set(Some(*answer));
    }
}

/// One test, as people and programs read it.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its name.
    pub test: &'static str,
    /// What is compared, in a sentence.
    pub about: &'static str,
    /// The fit whose line is judged.
    pub fit: Option<&'static str>,
    /// The value.
    pub value: Option<f64>,
    /// Its limit.
    pub limit: Option<f64>,
    /// What both are in.
    pub unit: &'static str,
    /// Whether the test says something against the tone.
    pub fired: bool,
    /// Whether it can: another only decides which tests are made, or lists the parts of a sum.
    pub decides: bool,
    /// What followed.
    pub followed: String,
}

impl Row {
    /// What came of it, in a word; nothing of a test that cannot speak against the tone.
    pub const fn outcome(&self) -> &'static str {
        match (self.decides, self.fired) {
            (false, _) => "-",
            (true, true) => "fired",
            (true, false) => "passed",
        }
    }
}

/// The tests behind the verdict, in the order in which they were made, and then those of the verdict itself.
pub fn rows(notes: &[Note], evidence: &Evidence, n: usize) -> Vec<Row> {
    let mut rows = from_notes(notes);
    rows.extend(from_evidence(evidence, n));
    rows
}

/// The tests that were heard, in order.
pub fn from_notes(notes: &[Note]) -> Vec<Row> {
    let (mut rows, mut fit) = (Vec::new(), None);
    for note in notes {
        match note {
            Note::Begin(step) => fit = Some(of_step(*step)),
            Note::Test(test) => rows.push(words::row(test, fit)),
            Note::Judged(judgement, taken) => {
                let line = match judgement.line {
                    LineClass::Steady => "one steady tone",
                    LineClass::Moving => "one tone that changes: moving",
                    LineClass::Unresolved => {
                        "not one steady tone: unresolved, unless a joint fit explains it"
                    }
                };
                let taken = if *taken { "" } else { "; not better, so this fit is dropped" };
                rows.push(Row {
                    test: "line",
                    about: "square of sigma over that of the noise alone, 1 at best",
                    fit,
                    value: Some(judgement.variance_inflation.into()),
                    limit: None,
                    unit: "",
                    fired: judgement.line != LineClass::Steady,
                    decides: true,
                    followed: format!("{line}{taken}"),
                });
                fit = None;
            }
        }
    }
    rows
}

const fn of_step(step: Step) -> &'static str {
    match step {
        Step::Usual => "usual",
        Step::Further => "more steps",
    }
}

/// The number of rules in [`Evidence::rules`].
const RULES: usize = 12;

/// The rules of the verdict itself, with what each is about, one line for each of [`Evidence::rules`].
pub fn from_evidence(evidence: &Evidence, n: usize) -> Vec<Row> {
    let n = n as f64;
    let sigma = Some((f64::from(evidence.sigma) * n, f64::from(WHOLE_SPECTRUM) * n));
    let edge = Some((f64::from(evidence.edge_bins), f64::from(EDGE_BINS)));
    let clipped = Some((f64::from(evidence.clipped) * 100.0, f64::from(CLIPPED) * 100.0));
    let rules: [(bool, Verdict); RULES] = evidence.rules();
    let about: [_; RULES] = [
        ("found", "there is a peak in the band, and a fit to it", None, ""),
        ("detection", "the line is above the noise", None, ""),
        ("sigma", "sigma is less than the whole spectrum", sigma, "bins"),
        ("steady", "the line does not change within the block", None, ""),
        ("alone", "the line is a single tone", None, ""),
        ("image", "no strong line at minus the frequency", None, ""),
        (
            "front-end",
            "the lines are not those of codes that wrap or of exchanged samples",
            None,
            "",
        ),
        ("edge", "distance from DC or Nyquist, at least", edge, "bins"),
        ("band", "the frequency is within the band", None, ""),
        ("clipped", "share of the samples that touch a rail", clipped, "%"),
        ("codes", "samples beyond the stated rails", Some((evidence.beyond.into(), 0.0)), ""),
        ("gap", "no samples are missing before the block", None, ""),
    ];
    let finite = |x: f64| x.is_finite().then_some(x);
    let row =
        |((test, about, value, unit), (fired, verdict)): ((_, _, Option<(f64, f64)>, _), _)| {
            let verdict: Verdict = verdict;
            Row {
                test,
                about,
                fit: None,
                value: value.and_then(|(value, _)| finite(value)),
                limit: value.and_then(|(_, limit)| finite(limit)),
                unit,
                fired,
                decides: true,
                followed: if fired { verdict.name() } else { "-" }.to_owned(),
            }
        };
    about.into_iter().zip(rules).map(row).collect()
}
