//! A checked configuration in the units of the pipeline. Nothing that follows a plan can fail.

use crate::acquire::codes::Codes;
use crate::acquire::sample::{Iq, Real, Record};
use crate::carrier::Width;
use crate::error::ConfigError;
use crate::methods::registry::Method;
use crate::solve::chirp::Scale;
use crate::solve::equations::Equations;
use crate::solve::track::Tracking;
use crate::spectrum::fft::twiddle::supported;
use crate::spectrum::neighbourhood::has_ring;
use crate::spectrum::peak::Band;
use crate::tone::arithmetic::Arithmetic;
use crate::tone::effort::Effort;
use crate::tone::fit::Reach;
use crate::tone::options::Options;
use crate::tone::threshold::{FALSE_ALARM, Threshold};
use core::marker::PhantomData;
use core::ops::Deref;

/// The way from tones to targets.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(u8)]
pub enum Solver {
    /// Tones stay tones.
    None,
    /// A Doppler shift gives a velocity; the scale is the velocity of one cycle per sample, with its sign.
    Doppler(Scale),
    /// The beats of a chirp give range and velocity.
    Chirp(Equations),
}

/// The terms of a plan, for records whose kind and length are known only at run time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms {
    /// Samples in a record.
    pub n: u32,
    /// Whether the records are I/Q.
    pub iq: bool,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// The converter's codes.
    pub codes: Codes,
    /// The bins to search.
    pub band: Band,
    /// The options of a tone's measurement.
    pub options: Options,
    /// The way from tones to targets.
    pub solver: Solver,
    /// The options of following tones.
    pub tracking: Tracking,
}

impl Terms {
    /// Whether a target is found from the lines of several segments.
    pub(crate) const fn pairs(&self) -> bool {
        self.segments() > 1
    }

    /// Blocks in a chirp; 1 if there is no chirp.
    pub const fn segments(&self) -> u32 {
        match self.solver {
            Solver::None | Solver::Doppler(_) => 1,
            Solver::Chirp(Equations { shape, .. }) => shape.segments().len() as u32,
        }
    }
}

/// A plan for records of kind `R` and `N` samples. A plan for other records has another type.
///
/// ```
/// use picket_dsp::{Codes, Config, Pipeline, Plan, Real};
///
/// // By the compiler, for a pipeline in static memory; or by `Config::plan`, which checks it.
/// const PLAN: Plan<Real, 1024> = Plan::tone(48_000.0, Codes::signed::<12>());
/// static PIPELINE: Pipeline<Real, 1024> = Pipeline::new(PLAN);
/// let plan: Plan<Real, 1024> = Config::new(48_000.0, Codes::signed::<12>()).plan()?;
/// assert_eq!((plan.n, plan.rate_hz, plan.band), (1024, 48_000.0, PIPELINE.plan().band));
/// # Ok::<(), picket_dsp::ConfigError>(())
/// ```
///
/// A length that the transform does not support is a compile error:
///
/// ```compile_fail
/// use picket_dsp::{Codes, Plan, Real};
/// let plan = Plan::<Real, 1000>::tone(48_000.0, Codes::signed::<12>());
/// ```
///
/// A plan for records of another length or kind is a compile error, too:
///
/// ```compile_fail
/// use picket_dsp::{Codes, Config, Pipeline, Plan, Real};
/// let plan: Plan<Real, 4096> = Config::new(48_000.0, Codes::signed::<12>()).plan()?;
/// let mut pipeline = Pipeline::<Real, 1024>::new(plan);
/// # Ok::<(), picket_dsp::ConfigError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan<R: Record, const N: usize> {
    terms: Terms,
    kind: PhantomData<R>,
}

impl<R: Record, const N: usize> Deref for Plan<R, N> {
    type Target = Terms;

    fn deref(&self) -> &Terms {
        &self.terms
    }
}

impl<R: Record, const N: usize> Plan<R, N> {
    /// The plan of [`Config::new`](crate::config::Config::new), but with eight bins on each side and not sixteen, made
    /// by the compiler. A program that sets nothing else needs no code to check it. The rate, Hz,
    /// must be positive.
    pub const fn tone(rate_hz: f64, codes: Codes) -> Self {
        Self::supported();
        let band = if R::IQ { Band::iq(N) } else { Band::real(N) };
        let threshold = Threshold::new(band.width(), FALSE_ALARM);
        let options = Options {
            method: Method::LeastSquares.from_kind::<R>(),
            reach: Reach::Eight,
            arithmetic: Arithmetic::from_core(),
            threshold: if has_ring(N, R::IQ) { threshold.with_another() } else { threshold },
            effort: Effort::from_core(),
            width: Width::NONE,
        };
        let Self { terms: idle, kind } = Self::IDLE;
        Self {
            terms: Terms { n: N as u32, iq: R::IQ, rate_hz, codes, band, options, ..idle },
            kind,
        }
    }

    /// A plan with these terms.
    ///
    /// # Errors
    /// The terms are for records of another kind or length.
    pub const fn from_terms(terms: Terms) -> Result<Self, ConfigError> {
        Self::supported();
        if terms.n as usize == N && terms.iq == R::IQ {
            Ok(Self { terms, kind: PhantomData })
        } else {
            Err(ConfigError::Records)
        }
    }

    /// The plan with another way to measure a tone.
    pub const fn with_options(mut self, options: Options) -> Self {
        self.terms.options = options;
        self
    }

    /// A placeholder of zeros, for a pipeline in static memory that gets its plan later. Zeros take
    /// no place in the program.
    pub const IDLE: Self = Self {
        terms: Terms {
            n: 0,
            iq: false,
            rate_hz: 0.0,
            codes: Codes::IDLE,
            band: Band::new(0, 0),
            options: Options {
                method: Method::Rife,
                reach: Reach::Four,
                arithmetic: Arithmetic::Float,
                threshold: Threshold::ZERO,
                effort: Effort::LOOK,
                width: Width::NONE,
            },
            solver: Solver::None,
            tracking: Tracking {
                rate: 0.0,
                signed: false,
                evident: 0.0,
                apart: 0.0,
                envelope: 0.0,
                stated: 0.0,
                most: 0,
                refresh: 0,
            },
        },
        kind: PhantomData,
    };

    /// Takes another plan, one field after the other: where the compiler knows the fields, a small program stores them at once and needs no
    /// routine that copies memory.
    #[inline(always)]
    pub(crate) fn take(&mut self, plan: Self) {
        let Terms { n, iq, rate_hz, codes, band, options, solver, tracking } = plan.terms;
        let terms = &mut self.terms;
        (terms.n, terms.iq, terms.rate_hz, terms.codes) = (n, iq, rate_hz, codes);
        (terms.band, terms.options, terms.tracking) = (band, options, tracking);
        // Without a solver the solver's scales need not be copied.
        match solver {
            Solver::None => terms.solver = Solver::None,
            solver => terms.solver = solver,
        }
    }

    const fn supported() {
        const { assert!(supported(N), "a record has 64, 128, ... 4096 samples") };
    }
}

/// A plan for either kind of record, for programs in which a setting decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EitherPlan<const N: usize> {
    /// For records of one converter.
    Real(Plan<Real, N>),
    /// For records of two converters.
    Iq(Plan<Iq, N>),
}

impl<const N: usize> Deref for EitherPlan<N> {
    type Target = Terms;

    fn deref(&self) -> &Terms {
        match self {
            EitherPlan::Real(plan) => plan,
            EitherPlan::Iq(plan) => plan,
        }
    }
}
