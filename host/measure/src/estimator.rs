//! Every method a user can name: the core's registry and the host's references.

use crate::reference::Reference;
use picket_dsp::acquire::sample::Record;
use picket_dsp::math::scalar::Scalar;
use picket_dsp::methods::registry::{About, Method, Records, Unfit};
use picket_dsp::methods::samples::Samples;
use picket_dsp::spectrum::bins::{Bins, Rectangular};
use picket_dsp::tone::fit::{FitStart, Reach, fit};
use picket_transform::num_complex::Complex;

/// A method of the core, with the reach of least squares, or one of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// One of the core's.
    Core {
        /// Which.
        method: Method,
        /// For least squares: how many bins it reads.
        reach: Reach,
    },
    /// One of the host's.
    Host(Reference),
}

/// The reach that `--k` names: bins on each side of the peak.
pub fn reach(k: usize) -> Result<Reach, String> {
    [Reach::Four, Reach::Eight, Reach::Sixteen]
        .into_iter()
        .find(|&reach| reach.bins() == k)
        .ok_or_else(|| format!("--k {k}: choose 4, 8 or 16"))
}

/// The methods of a list of names separated by commas.
pub fn parse(names: &str, reach: Reach) -> Result<Vec<Estimator>, String> {
    names.split(',').map(|name| Estimator::from_name(name.trim(), reach)).collect()
}

/// Every method of the library, as a list for `--help`.
pub fn help() -> String {
    "Methods:\n".to_owned() + &list(Method::ALL.iter().map(|method| method.about()))
}

/// Every method, as a list for `--help`.
pub fn help_with_references() -> String {
    help() + &list(Reference::ALL.iter().map(|reference| reference.about()))
}

fn list(methods: impl Iterator<Item = About>) -> String {
    let lines = methods.map(|about| {
        let records = match about.records {
            Records::Real => " (real samples only)",
            Records::Iq => " (I/Q only)",
            Records::Both => "",
        };
        format!("  {:<25}{}{records}\n", about.name, about.doc)
    });
    lines.collect()
}

impl Estimator {
    /// The method with this name.
    pub fn from_name(name: &str, reach: Reach) -> Result<Self, String> {
        Method::from_name(name)
            .map(|method| Estimator::Core { method, reach })
            .or_else(|| Reference::from_name(name).map(Estimator::Host))
            .ok_or_else(|| format!("no method \"{name}\": --help lists them"))
    }

    /// The best for a kind of record: least squares.
    pub fn best(iq: bool, reach: Reach) -> Self {
        let method = if iq { Method::LeastSquares } else { Method::LeastSquaresReal };
        Estimator::Core { method, reach }
    }

    /// True for the two forms of least squares, which return sigma themselves.
    pub const fn least_squares(self) -> bool {
        matches!(
            self,
            Estimator::Core { method: Method::LeastSquares | Method::LeastSquaresReal, .. }
        )
    }

    /// What there is to know of it.
    pub const fn about(self) -> About {
        match self {
            Estimator::Core { method, .. } => method.about(),
            Estimator::Host(reference) => reference.about(),
        }
    }

    /// Its name.
    pub const fn name(self) -> &'static str {
        self.about().name
    }

    /// An error, in one line, if it is not right for records of kind `R`.
    pub fn check<R: Record>(self) -> Result<(), String> {
        if self.about().records.include::<R>() {
            return Ok(());
        }
        let name = self.name();
        Err(match (R::IQ, self) {
            (true, _) => format!("{name} works on real records only: use least-squares"),
            (false, Estimator::Core { method: Method::LeastSquares, .. }) => {
                format!("{name} works on I/Q records only: use least-squares-real")
            }
            (false, _) => {
                format!("{name} works on I/Q records only: use least-squares-real or z-rife")
            }
        })
    }

    /// The offset from the peak bin by a method of the core. `powers` of all N bins.
    pub fn offset<T: Scalar, R: Record>(
        method: Method,
        reach: Reach,
        bins: &Bins<T, R, Rectangular>,
        samples: &[Complex<T>],
        powers: &[T],
    ) -> Result<T, Unfit> {
        if let Some(offset) = reached(method, reach, bins) {
            return offset;
        }
        method.offset(bins, &Values(samples), |k| {
            powers.get(k as usize).copied().unwrap_or(T::zero())
        })
    }
}

/// Least squares with this reach in place of the registry's; `None` for every other method.
pub fn reached<T: Scalar, R: Record>(
    method: Method,
    reach: Reach,
    bins: &Bins<T, R, Rectangular>,
) -> Option<Result<T, Unfit>> {
    let own = matches!(method, Method::LeastSquares | Method::LeastSquaresReal);
    (own && reach != Reach::default()).then(|| {
        let found = fit(bins, reach, FitStart::Usual).map_or(T::zero(), |fit| fit.offset);
        if method.fits::<R>() { Ok(found) } else { Err(Unfit) }
    })
}

/// Samples of either kind as complex numbers.
struct Values<'a, T>(&'a [Complex<T>]);

impl<T: Scalar, R: Record> Samples<T, R> for Values<'_, T> {
    fn from(&self, start: usize) -> impl Iterator<Item = Complex<T>> {
        self.0.get(start..).unwrap_or_default().iter().copied()
    }
}
