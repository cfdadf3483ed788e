//! The tests behind a verdict, reported to an observer.
//!
//! A measurement reports each test to an [`Observer`]: the statistic, its limit and whether the test fired. A block without an observer
//! pays nothing. The observer of `picket explain` writes every test down.

use super::judge::FitTest;
use crate::model::Answer;
use crate::tone::fit::Fit;

macro_rules! statistics {
    ($($(#[$about:meta])* $variant:ident $name:literal;)*) => {
        /// The quantity that a test compares with its limit. Powers are ratios to the noise in which they are measured.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Statistic {
            $($(#[$about])* $variant,)*
        }

        impl Statistic {
            /// Every statistic.
            pub const ALL: &'static [Statistic] = &[$(Statistic::$variant),*];

            /// The name that JSON shows.
            pub const fn name(self) -> &'static str {
                match self { $(Statistic::$variant => $name,)* }
            }
        }
    };
}

// One line for each statistic; its words for people are those of `picket explain`.
statistics! {
    /// The line's power over the mean of the band's other bins.
    Floor "floor";
    /// The line's power over the loudest noise near it, where the ratio is so large that no other test is needed.
    FarAbove "far-above";
    /// The noise near the line over the noise of the ring, in a short record.
    Hump "hump";
    /// The line's power over the median of three residuals at 3 to 16 bins.
    MiddleResidual "middle-residual";
    /// The line's power over the least of three residuals at 3 to 16 bins.
    LeastResidual "least-residual";
    /// The line's power over the mean residual.
    MeanResidual "mean-residual";
    /// The line's power over the noise of a ring nearly twice as wide.
    WideRing "wide-ring";
    /// The line's power over the noise of the louder side of the ring.
    Ring "ring";
    /// The residual of the louder half of the bins 3 to 16 away over the floor.
    LouderHalf "louder-half";
    /// The line's power over the residual of the louder half.
    OverLouderHalf "over-louder-half";
    /// The louder side's noise over the quieter one's.
    NoiseEdge "noise-edge";
    /// The power along the five directions in which a tone changes, in each unit of which noise leaves 1: the first look.
    Changes "changes";
    /// The residual in the bins up to 2 from the peak: the first look.
    Within2 "within-2";
    /// The residual in the bins up to 4 from the peak: the first look.
    Within4 "within-4";
    /// The residual in all bins of the fit: the first look.
    WithinAll "within-all";
    /// The part of the power along the directions that is a changing level.
    Level "level";
    /// The part of the power along the directions that is a bending phase, as in a sweep.
    Bend "bend";
    /// The part of the power along the directions that is a phase of order 3, as in a jump.
    Twist "twist";
    /// The power along the five directions, by Fisher's distribution.
    Moves "moves";
    /// The residual up to 2 bins from the peak, by Fisher's distribution.
    Near2 "near-2";
    /// The residual up to 4 bins from the peak, by Fisher's distribution.
    Near4 "near-4";
    /// The residual of all bins, by Fisher's distribution.
    All "all";
    /// The residual up to 8 bins from the peak beyond the directions, by Fisher's distribution.
    Unexplained8 "unexplained-8";
    /// The residual of all bins beyond the directions, by Fisher's distribution.
    Unexplained "unexplained";
    /// The unexplained power over the power along the directions.
    Share "share";
    /// The residual over the noise, of a record in which samples clip.
    ClippedResidual "clipped-residual";
    /// Sigma by the nearest bins over sigma by all bins.
    Nearest "nearest";
    /// The strongest bin at minus the frequency over the tone's power.
    ImageShare "image-share";
    /// The strongest bin at minus the frequency over the noise.
    ImageNoise "image-noise";
    /// The power of the band's other bins over the tone's.
    OtherLines "other-lines";
    /// The power of the samples over the most that two tones between the rails have.
    TwoTones "two-tones";
    /// The power of the samples over the most that three tones between the rails have.
    ThreeTones "three-tones";
    /// The number of lines with a fiftieth of the tone's power or more.
    Lines "lines";
    /// The line where exchanged samples put one, in deviations of the noise.
    Exchanged "exchanged";
    /// The residual of the exchange in its line, in each unit of which noise leaves 1.
    ExchangedRest "exchanged-rest";
}

/// A statistic beside its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Test {
    /// The statistic that is compared.
    pub statistic: Statistic,
    /// The statistic's value.
    pub value: f32,
    /// The limit; infinite for a statistic without a limit, which only shows the parts of a sum.
    pub limit: f32,
}

impl Test {
    /// A statistic with its value and its limit.
    pub const fn new(statistic: Statistic, value: f32, limit: f32) -> Self {
        Self { statistic, value, limit }
    }

    /// Whether the value exceeds its limit.
    pub fn fires(&self) -> bool {
        self.value > self.limit
    }
}

/// A fit whose line is judged. A measurement goes on to the next fit where the one before shows no steady tone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// The usual fit.
    Usual,
    /// The usual fit with more steps, to its end.
    Further,
    /// A fit with a slow drift beside the tone in its model.
    BesideDrift,
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
pub trait Tap: Copy {
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
