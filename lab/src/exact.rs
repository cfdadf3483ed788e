//! Methods in floats on an exact transform of any length: the reference for integers.

use crate::arithmetic::{Arithmetic, Frequencies, engine, within};
use crate::estimator::Estimator;
use crate::simulate::Kind;
use picket_dsp::math::scalar::Scalar;
use picket_dsp::plan::Terms;
use picket_dsp::spectrum::bins::{Bins, Rectangular};
use picket_dsp::spectrum::peak::{Band, Search};
use picket_dsp::spectrum::view::STANDS_OUT;
use picket_transform::num_complex::Complex;
use picket_transform::{Fft, Transform};
use std::fmt::Debug;
use std::marker::PhantomData;
use std::sync::Arc;

/// The numbers in which frequencies are estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numbers {
    /// 64-bit floats throughout.
    F64,
    /// 32-bit floats throughout.
    F32,
    /// The library's.
    Library(Arithmetic),
}

impl Numbers {
    /// Every one.
    pub const ALL: [Self; 4] = [
        Self::F64,
        Self::F32,
        Self::Library(Arithmetic::Target),
        Self::Library(Arithmetic::TargetFixed),
    ];

    /// What the user types.
    pub const fn name(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
            Self::Library(arithmetic) => arithmetic.name(),
        }
    }

    /// The numbers of this name.
    ///
    /// # Errors
    /// There are none.
    pub fn from_name(name: &str) -> Result<Self, String> {
        let names = Self::ALL.map(Self::name);
        let found = Self::ALL.into_iter().find(|numbers| numbers.name() == name);
        found.ok_or_else(|| format!("choose one of {}", names.join(", ")))
    }

    /// # Errors
    /// `estimator` has no form in these numbers.
    pub fn check(self, estimator: Estimator) -> Result<(), String> {
        match (self, estimator) {
            (Self::F32, Estimator::Host(reference)) => {
                Err(format!("{} needs --arith f64", reference.about().name))
            }
            (Self::F64 | Self::F32, _) => Ok(()),
            (Self::Library(arithmetic), _) => arithmetic.check(estimator),
        }
    }
}

/// The longest record.
const LONGEST: usize = 1 << 22;

/// What estimates frequencies in records of kind `R` and `n` samples. Every estimator must be right for the kind and the numbers.
///
/// # Errors
/// There is no such length.
pub fn frequencies<R: Kind>(
    numbers: Numbers,
    n: usize,
    plan: Terms,
) -> Result<Box<dyn Frequencies>, String> {
    // The shortest that has bins beside a peak on both sides.
    if !(16..=LONGEST).contains(&n) {
        return Err(format!("N = {n}: choose 16 to {LONGEST} samples"));
    }
    Ok(match numbers {
        Numbers::F64 => Box::new(Exact::<f64, R>::new(n, plan)),
        Numbers::F32 => Box::new(Exact::<f32, R>::new(n, plan)),
        Numbers::Library(arithmetic) => engine::<R>(arithmetic, n, plan)?,
    })
}

/// Floats of one width.
struct Exact<T: Transform, R> {
    n: usize,
    band: Band,
    fft: Arc<dyn Fft<T>>,
    scratch: Vec<Complex<T>>,
    kind: PhantomData<R>,
}

impl<T: Transform, R> Debug for Exact<T, R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Exact({}, {:?})", self.n, self.band)
    }
}

impl<T: Scalar + Transform, R: Kind> Exact<T, R> {
    fn new(n: usize, plan: Terms) -> Self {
        let fft = T::forward(n);
        let scratch = vec![Complex::new(T::zero(), T::zero()); fft.get_inplace_scratch_len()];
        Self { n, band: plan.band, fft, scratch, kind: PhantomData }
    }

    /// The strongest bin by the library's search, which takes integers.
    fn peak(&self, powers: &[T]) -> Option<i32> {
        let Band { low, high, .. } = self.band;
        let power = |k: i32| powers[k.rem_euclid(self.n as i32) as usize].wide();
        let most = (low..=high).map(power).fold(0.0, f64::max);
        // So many steps that none of the digits counts.
        let unit = most / (1u64 << 40) as f64;
        if !(unit > 0.0 && unit.is_finite()) {
            return None;
        }
        let mut search = Search::new(self.band);
        (low..=high).for_each(|k| search.push((power(k) / unit) as u64));
        search.finish().map(|peak| peak.bin)
    }
}

/// Takes an I/Q converter's offset out of bin 0, as the library does beside a tone.
fn take_offset<T: Scalar>(spectrum: &mut [Complex<T>]) {
    if let [offset, above, .., below] = spectrum
        && offset.norm_sqr() > (above.norm_sqr() + below.norm_sqr()) * T::new(STANDS_OUT as f64)
    {
        *offset = (*above + *below) * T::new(0.5);
    }
}

impl<T: Scalar + Transform, R: Kind> Frequencies for Exact<T, R> {
    fn frequencies(&mut self, record: &[Complex<f64>], estimators: &[Estimator]) -> Vec<f64> {
        let samples: Vec<Complex<T>> =
            record.iter().map(|x| Complex::new(T::new(x.re), T::new(x.im))).collect();
        let mut spectrum = samples.clone();
        self.fft.process_with_scratch(&mut spectrum, &mut self.scratch);
        if R::IQ {
            take_offset(&mut spectrum);
        }
        let powers: Vec<T> = spectrum.iter().map(|x| x.norm_sqr()).collect();
        let Some(peak) = self.peak(&powers) else { return vec![f64::NAN; estimators.len()] };
        let bins = Bins::<T, R, Rectangular>::gather(self.n, peak, |k| spectrum[k]);
        let frequency = |&estimator: &Estimator| {
            let found = match estimator {
                Estimator::Core { method, reach } => {
                    Estimator::offset(method, reach, &bins, &samples, &powers)
                        .map(|offset| f64::from(peak) + offset.wide())
                }
                Estimator::Host(reference) if R::IQ => reference.iq(record),
                Estimator::Host(reference) => {
                    reference.real(&record.iter().map(|x| x.re).collect::<Vec<_>>())
                }
            };
            found.map_or(f64::NAN, |bins| within::<R>(bins, self.n))
        };
        estimators.iter().map(frequency).collect()
    }
}
