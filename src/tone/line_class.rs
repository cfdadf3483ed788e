//! The classes of a line.

/// A line's class, by its residual.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LineClass {
    /// One tone, as far as the bins show.
    Steady,
    /// One tone whose frequency or level changes.
    Moving,
    /// More than one tone.
    Unresolved,
}

/// The result of the tests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitTest {
    /// The line's class.
    pub line: LineClass,
    /// The factor by which the variance exceeds what the noise beside the tone causes.
    pub variance_inflation: f32,
}

impl FitTest {
    /// The result where nothing is suspicious.
    pub const STEADY: Self = Self { line: LineClass::Steady, variance_inflation: 1.0 };
}

/// Above this power along the five directions sigma grows. Noise alone exceeds it in 4 % of blocks (if its power were known, in 3 %: chi-square).
pub(super) const SUSPICIOUS: f32 = 12.37;
