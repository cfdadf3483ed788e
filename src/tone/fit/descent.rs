//! The one descent to a line's place: Gauss-Newton steps, each from the normal equations at the place before.
//!
//! All fits of one line take it: those of a block in floats and in integers, of a zoom, of a sum of products and of a burst. What they differ
//! in, the columns, makes their [`Products`](super::normal::Products).

use super::{ENDED, FitStart, SETTLED, START_LIMIT, STEP_LIMIT};
use crate::math::scalar::Scalar;
use crate::spectrum::layout::nearest;
use core::ops::{Add, Sub};

/// The least curvature of a line over a steady tone's curvature: a tone which is on for a tenth of a record has this ratio.
const FLATTEST: f64 = 0.01;

/// A place in bins: a float, or an integer in Q30.
pub(crate) trait Place: Copy + PartialOrd + Add<Output = Self> + Sub<Output = Self> {
    /// The float that stands for a place in ratios of steps.
    type Float: Scalar;
    /// The place at this number of bins.
    fn at(bins: f64) -> Self;
    /// The place as a float.
    fn float(self) -> Self::Float;
    /// The place of a float.
    fn from_float(bins: Self::Float) -> Self;
    /// The place within these limits; 0 if it is not a number.
    fn within(self, limits: [Self; 2]) -> Self;
}

impl<T: Scalar> Place for T {
    type Float = T;

    #[inline(always)]
    fn at(bins: f64) -> T {
        T::new(bins)
    }

    #[inline(always)]
    fn float(self) -> T {
        self
    }

    #[inline(always)]
    fn from_float(bins: T) -> T {
        bins
    }

    #[inline(always)]
    fn within(self, [low, high]: [T; 2]) -> T {
        // `max` and `min` return the number if the other is NaN.
        if self.is_nan() { T::zero() } else { self.max(low).min(high) }
    }
}

impl Place for i32 {
    type Float = f32;

    #[inline(always)]
    fn at(bins: f64) -> i32 {
        nearest(bins, 30)
    }

    #[inline(always)]
    fn float(self) -> f32 {
        super::fixed::scaled::Scaled::new(self, -30).float(0)
    }

    #[inline(always)]
    fn from_float(bins: f32) -> i32 {
        super::fixed::quantised(bins, 30)
    }

    #[inline(always)]
    fn within(self, [low, high]: [i32; 2]) -> i32 {
        self.max(low).min(high)
    }
}

/// The way of a descent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Descent<P> {
    /// Where it starts.
    pub start: P,
    /// The most steps; with none the equations are evaluated once, at the start.
    pub steps: u32,
    /// The longest step.
    pub longest: P,
    /// The least and the largest place.
    pub limits: [P; 2],
    /// Whether steps follow the line's own curvature, see [`FitStart::Further`].
    pub further: bool,
}

/// The end of a descent.
pub(crate) struct Ended<P: Place, S> {
    /// The place.
    pub at: P,
    /// What the last evaluation gave beside the step.
    pub last: S,
    /// The information about the place over a steady tone's.
    pub sharpness: P::Float,
}

impl<P: Place> Descent<P> {
    /// The descent of a [`FitStart`], between these limits; `usual` has the start and the number of the usual steps. Returns also the move
    /// after which it ends.
    #[inline(always)]
    pub fn new(
        course: FitStart<P::Float>,
        usual: impl FnOnce() -> (P, u32),
        limits: [P; 2],
    ) -> (Self, P) {
        let (start, steps, enough) = match course {
            FitStart::Usual => {
                let (start, steps) = usual();
                (start, steps, SETTLED)
            }
            FitStart::From(start, steps) => (P::from_float(start), steps, 0.0),
            FitStart::Further(start, steps) => (P::from_float(start), steps, ENDED),
        };
        let start = start.within([P::at(-START_LIMIT), P::at(START_LIMIT)]).within(limits);
        let further = matches!(course, FitStart::Further(..));
        (Self { start, steps, longest: P::at(STEP_LIMIT), limits, further }, P::at(enough))
    }

    /// Takes the steps. `step` evaluates the equations at a place: it returns the step that follows, the largest move after which no other
    /// is needed, and what the caller keeps of the last evaluation.
    #[inline(always)]
    pub fn to_the_end<S>(self, mut step: impl FnMut(P) -> (P, P, S)) -> Ended<P, S> {
        let Self { start, steps, longest, limits, further } = self;
        let mut pace = Pace::new();
        let (zero, mut at) = (P::at(0.0), start);
        let (mut own, mut enough, mut last) = step(start);
        for taken in 0..steps {
            if taken > 0 {
                (own, enough, last) = step(at);
            }
            let own_step = own.within([zero - longest, longest]);
            let onward = if further {
                P::from_float(pace.step(own_step.float(), longest.float()))
            } else {
                own_step
            };
            let next = (at + onward).within(limits);
            let moved = next - at;
            if further {
                pace.took(own_step.float(), moved.float());
            }
            at = next;
            if moved <= enough && zero - moved <= enough {
                break;
            }
        }
        Ended { at, last, sharpness: pace.sharpness() }
    }
}

/// The steps along a line whose curvature is not that of a steady tone, which a Gauss-Newton step assumes. A tone that is on for a share p of
/// the record has a wider line, of `p^2` times the curvature, so each step covers only `p^2` of the remaining way. Two steps give the
/// curvature, and so the remaining distance, by a secant.
struct Pace<T> {
    /// The last Gauss-Newton step, and the step that was taken instead.
    last: Option<[T; 2]>,
    /// The line's curvature over a steady tone's curvature.
    curvature: T,
}

impl<T: Scalar> Pace<T> {
    fn new() -> Self {
        Self { last: None, curvature: T::one() }
    }

    /// The step to take instead of this Gauss-Newton step.
    fn step(&mut self, own: T, longest: T) -> T {
        let Some([before, moved]) = self.last else { return own };
        let curvature = (before - own) / moved;
        if curvature < T::new(FLATTEST) {
            return own;
        }
        self.curvature = curvature;
        (own / curvature).within([-longest, longest])
    }

    fn took(&mut self, own: T, moved: T) {
        self.last = Some([own, moved]);
    }

    /// The information about the line's offset over a steady tone's. Noise moves the gradient by an equal amount in both, and a given
    /// gradient is a longer way where the curvature is less.
    fn sharpness(&self) -> T {
        let curvature = self.curvature.min(T::one());
        curvature * curvature
    }
}
