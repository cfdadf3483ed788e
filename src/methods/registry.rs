//! The registry of methods: one line each. The pipeline, the command line, the sweep, the report and the
//! documentation all read this list; a new estimator is its file, its `mod` and a line here.

use super::samples::{Raw, Samples, as_kind};
// Every family: a new one needs no `use`.
use super::*;
use crate::acquire::sample::{Data, Iq, Real, Record};
use crate::math::scalar::Scalar;
use crate::spectrum::bins::{Bins, Rectangular};
use crate::spectrum::view::View;
use fixed::types::I2F30;

/// No method has this name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct UnknownMethod;

impl core::fmt::Display for UnknownMethod {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("there is no method of this name: see Method::ALL")
    }
}

impl core::error::Error for UnknownMethod {}

impl core::str::FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        Method::from_name(name).ok_or(UnknownMethod)
    }
}

/// The records that a method is right for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Records {
    /// Real samples only.
    Real,
    /// I/Q samples only.
    Iq,
    /// Both; on real samples there is an error from the mirror image.
    Both,
}

impl Records {
    /// Whether the method is right for records of kind `R`.
    pub const fn include<R: Record>(self) -> bool {
        match self {
            Records::Real => !R::IQ,
            Records::Iq => R::IQ,
            Records::Both => true,
        }
    }

    /// "real", "iq" or "both".
    pub const fn name(self) -> &'static str {
        match self {
            Records::Real => "real",
            Records::Iq => "iq",
            Records::Both => "both",
        }
    }
}

/// The data that a method reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Needs {
    /// The bins around the peak.
    Bins,
    /// The bins around the peak, and the samples.
    Samples,
    /// The bins around the peak, the samples and all powers of the spectrum, for its
    /// signal-to-noise ratio.
    Powers,
}

impl Needs {
    /// "bins", "samples" or "powers".
    pub const fn name(self) -> &'static str {
        match self {
            Needs::Bins => "bins",
            Needs::Samples => "samples",
            Needs::Powers => "powers",
        }
    }
}

/// The window of a method's bins. The pipeline's bins are always rectangular; bins under Hann's window are made from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Window {
    /// No window.
    Rectangular,
    /// Hann's.
    Hann,
}

impl Window {
    /// "rectangular" or "hann".
    pub const fn name(self) -> &'static str {
        match self {
            Window::Rectangular => "rectangular",
            Window::Hann => "hann",
        }
    }
}

/// The entry of a method in the registry. The host lists its own references with the same type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct About {
    /// The name that a user types.
    pub name: &'static str,
    /// The method's family, for tables.
    pub family: &'static str,
    /// The records that the method is right for.
    pub records: Records,
    /// The data that the method reads.
    pub needs: Needs,
    /// The window of its bins.
    pub window: Window,
    /// The method's RMSE over the Cramer-Rao bound, see [`Method::efficiency`].
    pub efficiency: f32,
    /// A description in one line.
    pub doc: &'static str,
}

/// The method cannot work on this kind of record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Unfit;

impl core::fmt::Display for Unfit {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the method does not work on this kind of record")
    }
}

impl core::error::Error for Unfit {}

macro_rules! methods {
    ($($id:literal $variant:ident $name:literal $family:literal $records:ident $needs:ident $window:ident
        $efficiency:literal $estimator:expr, $doc:literal;)*) => {
        /// A method that finds the offset from the peak bin. The numbers are used in telemetry and captures, and never change.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[repr(u8)]
        #[non_exhaustive]
        pub enum Method {
            $(#[doc = $doc] $variant = $id,)*
        }

        impl Method {
            /// Every method, in the order of the registry.
            pub const ALL: &'static [Method] = &[$(Method::$variant,)*];

            /// The method with this number.
            pub const fn from_u8(id: u8) -> Option<Self> {
                match id {
                    $($id => Some(Method::$variant),)*
                    _ => None,
                }
            }

            /// The name that a user types.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Method::$variant => $name,)*
                }
            }

            /// The records that the method is right for.
            pub const fn records(self) -> Records {
                match self {
                    $(Method::$variant => Records::$records,)*
                }
            }

            /// The method's RMSE over the Cramer-Rao bound at 20 dB, N = 1024, offset uniform, by the test `every_method_over_the_bound`; from
            /// about 0 dB upwards it holds within a tenth, except where stated. For Rife's method the ratio grows with the fourth root of
            /// the signal-to-noise ratio, for the parabola with the square root; on real samples every method but least squares also has an
            /// image floor.
            pub const fn efficiency(self) -> f32 {
                match self {
                    $(Method::$variant => $efficiency,)*
                }
            }

            /// The method's entry in the registry.
            pub const fn about(self) -> About {
                match self {
                    $(Method::$variant => About {
                        name: $name,
                        family: $family,
                        records: Records::$records,
                        needs: Needs::$needs,
                        window: Window::$window,
                        efficiency: $efficiency,
                        doc: $doc,
                    },)*
                }
            }

            /// The offset of the tone from the peak bin, in bins.
            ///
            /// `bins` are the plain transform around the peak; `samples` belong to the same record; `power(k)` is `|X[k]|^2` for `k` in
            /// `0..N`, in any unit. Methods use the data that they need.
            #[inline(never)]
            pub fn offset<T, R, S, P>(
                self,
                bins: &Bins<T, R, Rectangular>,
                samples: &S,
                power: P,
            ) -> Result<T, Unfit>
            where
                T: Scalar,
                R: Record,
                S: Samples<T, R> + ?Sized,
                P: Fn(i32) -> T,
            {
                match self {
                    $(Method::$variant => {
                        call!($records $needs $window $estimator, bins, samples, power)
                    })*
                }
            }
        }
    };
}

macro_rules! call {
    (Both Bins Rectangular $estimator:expr, $bins:ident, $samples:ident, $power:ident) => {
        Ok($estimator($bins))
    };
    (Both Bins Hann $estimator:expr, $bins:ident, $samples:ident, $power:ident) => {
        Ok($estimator(&$bins.hann()))
    };
    (Both Samples Rectangular $estimator:expr, $bins:ident, $samples:ident, $power:ident) => {
        Ok($estimator($bins, $samples))
    };
    ($kind:ident Bins Rectangular $estimator:expr, $bins:ident, $samples:ident, $power:ident) => {
        Ok($estimator(&$bins.as_kind::<crate::acquire::sample::$kind>().ok_or(Unfit)?))
    };
    (Iq Samples Rectangular $estimator:expr, $bins:ident, $samples:ident, $power:ident) => {
        match ($bins.as_kind::<Iq>(), as_kind::<R, Iq, S>($samples)) {
            (Some(bins), Some(samples)) => Ok($estimator(&bins, &samples)),
            _ => Err(Unfit),
        }
    };
    (Iq Powers Rectangular $estimator:expr, $bins:ident, $samples:ident, $power:ident) => {
        match ($bins.as_kind::<Iq>(), as_kind::<R, Iq, S>($samples)) {
            (Some(bins), Some(samples)) => {
                let snr = snr::parseval(bins.n(), bins.peak(), $power);
                Ok($estimator(&bins, &samples, snr))
            }
            _ => Err(Unfit),
        }
    };
}

// `call!` has an arm for these combinations, so a line may have no other:
//   records          needs    window       the estimator takes
//   Both, Real, Iq   Bins     Rectangular  the bins
//   Both             Bins     Hann         the bins under Hann's window
//   Both, Iq         Samples  Rectangular  the bins and the samples
//   Iq               Powers   Rectangular  the bins, the samples and the signal-to-noise ratio
//
// RMSE/bound is the typical ratio at 20 dB, of I/Q records, and of real ones for a method of real records alone: see `Method::efficiency`.
// `Reach` states the ceilings that tests hold least squares to.
methods! {
//  id variant  name  family  records needs window  RMSE/bound  estimator, what it does;
    0 Rife "rife" "rife" Both Bins Rectangular 6.6 rife::rife,
        "Rife: the ratio of the peak and its stronger neighbour";
    1 ZRife "z-rife" "rife" Both Bins Rectangular 1.28 rife::z_rife,
        "Z-Rife: the ratio of the peak and the neighbour its phase points to";
    2 APRife "a-p-rife" "rife" Both Bins Rectangular 1.29 rife::a_p_rife,
        "A-P-Rife (reconstructed): Rife above 1/3 bin, the phase criterion below";
    3 IRife "i-rife" "dft" Both Samples Rectangular 1.03 dft::i_rife,
        "I-Rife (reconstructed): Rife on a spectrum shifted by 1/3 bin";
    4 DualThresholdRife "dual-threshold-rife" "dft" Both Samples Rectangular 1.03 dft::dual_threshold_rife,
        "dual-threshold Rife (reconstructed): Rife, shifted Rife below 1/3, half bins below 0.15";
    5 Quinn1 "quinn1" "quinn" Both Bins Rectangular 1.28 quinn::quinn1,
        "Quinn's first estimator: one of two complex ratios";
    6 Quinn2 "quinn2" "quinn" Both Bins Rectangular 1.14 quinn::quinn2,
        "Quinn's second estimator: both complex ratios, weighted";
    7 Jacobsen "jacobsen" "interpolate" Both Bins Rectangular 1.53 interpolate::jacobsen,
        "Jacobsen: three complex bins, one division";
    8 Candan "candan" "interpolate" Both Bins Rectangular 1.53 interpolate::candan,
        "Candan: Jacobsen without its bias";
    9 Macleod "macleod" "interpolate" Both Bins Rectangular 1.15 interpolate::macleod,
        "Macleod: three phase-aligned bins";
    10 Parabolic "parabolic" "interpolate" Both Bins Rectangular 100.0 interpolate::parabolic,
        "a parabola through three log magnitudes, biased; for comparison";
    11 AboutaniosMulgrew "aboutanios-mulgrew" "dft" Both Samples Rectangular 1.0 dft::aboutanios_mulgrew,
        "Aboutanios and Mulgrew: half bins about the last answer, twice";
    12 Haqse "haqse" "dft" Both Samples Rectangular 1.0 dft::haqse,
        "HAQSE: half bins, then bins shifted by the cube root of 1/N";
    13 Autocorrelation "autocorrelation" "autocorrelation" Iq Samples Rectangular 1.07
        autocorrelation::autocorrelation,
        "the autocorrelation's phase at lag N/3";
    14 ImprovedAutocorrelation "improved-autocorrelation" "autocorrelation" Iq Powers Rectangular 1.07
        autocorrelation::improved_autocorrelation,
        "the autocorrelation's phase at the best lag for the signal-to-noise ratio";
    15 Fesa "fesa" "autocorrelation" Iq Powers Rectangular 1.06 autocorrelation::fesa,
        "FESA as printed: Quinn's second estimator or the improved autocorrelation";
    16 FesaCorrected "fesa-corrected" "autocorrelation" Iq Powers Rectangular 1.05
        autocorrelation::fesa_corrected,
        "FESA put right: lag 2N/3, the choice by comparing like with like";
    17 Grandke "grandke" "hann" Both Bins Hann 1.81 hann::grandke,
        "Grandke: the ratio of two magnitudes under Hann's window";
    18 CandanHann "candan-hann" "hann" Both Bins Hann 2.13 hann::candan_hann,
        "Candan's three complex bins under Hann's window";
    19 LeastSquares "least-squares" "least_squares" Iq Bins Rectangular 1.01
        crate::tone::fit::least_squares::<_, 16>,
        "least squares over 33 bins, I/Q";
    20 LeastSquaresReal "least-squares-real" "least_squares" Real Bins Rectangular 1.02
        crate::tone::fit::least_squares_real::<_, 16>,
        "least squares over 33 bins with the mirror image in the model, real samples";
}

impl Default for Method {
    /// The default is least squares, in the form for the kind of record (see [`Method::from_kind`]).
    fn default() -> Self {
        Method::LeastSquares
    }
}

impl Method {
    /// The method's number, as [`Method::from_u8`] reads it.
    pub const fn id(self) -> u8 {
        self as u8
    }

    /// The method with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|method| method.name() == name)
    }

    /// The method in the form for records of kind `R`: least squares has one for each kind.
    pub const fn from_kind<R: Record>(self) -> Self {
        match self {
            Method::LeastSquares | Method::LeastSquaresReal if R::IQ => Method::LeastSquares,
            Method::LeastSquares | Method::LeastSquaresReal => Method::LeastSquaresReal,
            other => other,
        }
    }

    /// Whether the method is right for records of kind `R`, and part of the program. Without the feature `methods` a program has least
    /// squares alone, and no plan with another method.
    pub const fn fits<R: Record>(self) -> bool {
        self.records().include::<R>() && (cfg!(feature = "methods") || self.is_least_squares())
    }

    /// Whether the method is least squares, in either form.
    pub const fn is_least_squares(self) -> bool {
        matches!(self, Method::LeastSquares | Method::LeastSquaresReal)
    }

    /// The offset as the target computes it: Rife's and Z-Rife's in integers throughout, the others' in `f32` on the bins of the integer
    /// FFT.
    ///
    /// # Errors
    /// The method does not work on this kind of record, or the program is without the feature `methods`.
    pub fn offset_target(self, view: &View, data: Data, peak: i32) -> Result<I2F30, Unfit> {
        if !cfg!(feature = "methods") {
            return Err(Unfit);
        }
        let three = [-1, 0, 1].map(|offset| view.bin(peak.wrapping_add(offset)));
        match self {
            Method::Rife => Ok(rife::rife_integer(three)),
            Method::ZRife => Ok(rife::z_rife_integer(three)),
            _ => {
                let power: &dyn Fn(i32) -> f32 = &|k| view.power(k) as f32;
                let offset = if data.iq {
                    let bins = Bins::<f32, Iq, Rectangular>::from_view(view, peak);
                    self.offset(&bins, &Raw::<Iq>(data.pairs), power)?
                } else {
                    let bins = Bins::<f32, Real, Rectangular>::from_view(view, peak);
                    self.offset(&bins, &Raw::<Real>(data.parts()), power)?
                };
                // A cast saturates and turns NaN into 0.
                Ok(I2F30::from_bits((offset * 1_073_741_824.0) as i32))
            }
        }
    }
}

impl core::fmt::Display for Method {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.name())
    }
}
