//! The statistics behind a verdict, each beside its limit.

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
