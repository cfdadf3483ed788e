//! The tests behind a verdict, told to whom asks for them.
//!
//! A measurement tells each test that it makes to an [`Observer`]: the statistic, its limit and whether the test fired. A board has
//! no observer, `()`, and pays nothing: not an instruction, not a byte. `picket explain` has one that writes all down.

use super::judge::FitTest;
use crate::model::Answer;
use crate::tone::fit::Fit;

/// What a test compares. Powers are ratios to the noise of what they are measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Statistic {
    /// The line's power over the mean of the band's other bins.
    Floor,
    /// The line's power over the loudest noise near it, so much that no other test is needed.
    FarAbove,
    /// The noise near the line over that of the ring, in a short record.
    Hump,
    /// The line's power over the middle one of three residuals at 3 to 16 bins.
    MiddleResidual,
    /// The line's power over the least of these residuals.
    LeastResidual,
    /// The line's power over the mean residual.
    MeanResidual,
    /// The line's power over the noise of a ring nearly twice as wide.
    WideRing,
    /// The line's power over the noise of the louder side of the ring.
    Ring,
    /// The residual of the louder half of the bins 3 to 16 away over the floor.
    LouderHalf,
    /// The line's power over that residual.
    OverLouderHalf,
    /// The louder side's noise over the quieter one's.
    NoiseEdge,
    /// The power along the five directions in which a tone changes, in each unit of which noise leaves 1: the first look.
    Changes,
    /// The residual in the bins up to 2 from the peak: the first look.
    Within2,
    /// The residual in the bins up to 4 from the peak: the first look.
    Within4,
    /// The residual in all bins of the fit: the first look.
    WithinAll,
    /// Of the power along the directions: that of a changing level.
    Level,
    /// Of the power along the directions: that of a phase that bends, as in a sweep.
    Bend,
    /// Of the power along the directions: that of a phase of order 3, as of a jump.
    Twist,
    /// The power along the five directions, by Fisher's distribution.
    Moves,
    /// The residual up to 2 bins from the peak, by Fisher's distribution.
    Near2,
    /// The residual up to 4 bins from the peak, by Fisher's distribution.
    Near4,
    /// The residual of all bins, by Fisher's distribution.
    All,
    /// What the directions do not explain up to 8 bins from the peak, by Fisher's distribution.
    Unexplained8,
    /// What the directions do not explain in all bins, by Fisher's distribution.
    Unexplained,
    /// The unexplained power over that along the directions.
    Share,
    /// The residual over the noise, of a record in which samples clip.
    ClippedResidual,
    /// Sigma by the nearest bins over that by all bins.
    Nearest,
    /// The strongest bin at minus the frequency over the tone's power.
    ImageShare,
    /// The same over the noise.
    ImageNoise,
    /// The power of the band's other bins over the tone's.
    OtherLines,
    /// The power of the samples over the most that two tones between the rails have.
    TwoTones,
    /// The power of the samples over the most that three tones between the rails have.
    ThreeTones,
    /// The number of lines with a fiftieth of the tone's power or more.
    Lines,
    /// The line where exchanged samples put one, in deviations of the noise.
    Exchanged,
    /// What the exchange leaves of that line, in each unit of which noise leaves 1.
    ExchangedRest,
}

impl Statistic {
    /// The name that JSON shows.
    pub const fn name(self) -> &'static str {
        match self {
            Statistic::Floor => "floor",
            Statistic::FarAbove => "far-above",
            Statistic::Hump => "hump",
            Statistic::MiddleResidual => "middle-residual",
            Statistic::LeastResidual => "least-residual",
            Statistic::MeanResidual => "mean-residual",
            Statistic::WideRing => "wide-ring",
            Statistic::Ring => "ring",
            Statistic::LouderHalf => "louder-half",
            Statistic::OverLouderHalf => "over-louder-half",
            Statistic::NoiseEdge => "noise-edge",
            Statistic::Changes => "changes",
            Statistic::Within2 => "within-2",
            Statistic::Within4 => "within-4",
            Statistic::WithinAll => "within-all",
            Statistic::Level => "level",
            Statistic::Bend => "bend",
            Statistic::Twist => "twist",
            Statistic::Moves => "moves",
            Statistic::Near2 => "near-2",
            Statistic::Near4 => "near-4",
            Statistic::All => "all",
            Statistic::Unexplained8 => "unexplained-8",
            Statistic::Unexplained => "unexplained",
            Statistic::Share => "share",
            Statistic::ClippedResidual => "clipped-residual",
            Statistic::Nearest => "nearest",
            Statistic::ImageShare => "image-share",
            Statistic::ImageNoise => "image-noise",
            Statistic::OtherLines => "other-lines",
            Statistic::TwoTones => "two-tones",
            Statistic::ThreeTones => "three-tones",
            Statistic::Lines => "lines",
            Statistic::Exchanged => "exchanged",
            Statistic::ExchangedRest => "exchanged-rest",
        }
    }
}

/// A statistic beside its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Test {
    /// What is compared.
    pub statistic: Statistic,
    /// Its value.
    pub value: f32,
    /// The limit; infinite if it has none, and only tells what a sum is made of.
    pub limit: f32,
}

impl Test {
    /// Whether the value exceeds its limit.
    pub fn fires(&self) -> bool {
        self.value > self.limit
    }
}

/// A fit whose line is judged. A measurement goes on to the next where the one before shows no steady tone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// The usual fit.
    Usual,
    /// The same with more steps, to its end.
    Further,
    /// One that has a slow drift beside the tone in its model.
    BesideDrift,
}

/// Who hears of the tests behind a verdict. Every method does nothing unless it is written anew. It is copied into every function
/// that tests: an observer is a shared reference, or nothing.
pub trait Observer: Copy {
    /// Hears of a test. It is evaluated only by an observer that asks for it.
    #[inline(always)]
    fn hear(self, _test: impl FnOnce() -> Test) {}

    /// Hears that a fit begins to be judged.
    #[inline(always)]
    fn begin(self, _step: Step) {}

    /// Hears what the tests of the last fit amount to, and whether it takes the place of the fit before.
    #[inline(always)]
    fn judged(self, _judgement: &FitTest, _taken: bool) {}

    /// Hears of the last fit at a peak bin, and of the noise power per sample beside the tone.
    #[inline(always)]
    fn fitted(self, _peak: i32, _fit: &Fit<f32>, _noise: f32) {}

    /// Hears what the joint fit says of a line that is no steady tone. Its answer is taken unless it is unresolved.
    #[inline(always)]
    fn joint(self, _answer: &Answer) {}

    /// Makes a test, tells it, and says whether it fired.
    #[inline(always)]
    fn exceeds(self, statistic: Statistic, value: f32, limit: f32) -> bool {
        let test = Test { statistic, value, limit };
        self.hear(|| test);
        test.fires()
    }
}

impl Observer for () {}
