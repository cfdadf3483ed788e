//! The samples of a record, for the estimators that need more than bins.

use crate::acquire::sample::{Iq, Real, Record};
use crate::math::scalar::Scalar;
use core::marker::PhantomData;
use num_complex::Complex;

/// The samples of one record of kind `R`, read as complex floats in ADC codes (a real sample has
/// the imaginary part 0).
///
/// Implemented by [`Raw`] for the converter's codes, and by slices of floats: `[T]` is a real record, `[Complex<T>]` an I/Q record.
pub trait Samples<T: Scalar, R: Record> {
    /// The samples from number `start` on; none if the record is shorter.
    fn from(&self, start: usize) -> impl Iterator<Item = Complex<T>>;
}

/// The converter's own codes as [`Samples`].
#[derive(Clone, Copy, Debug)]
pub struct Raw<'a, R: Record>(pub &'a [R::Sample]);

impl<T: Scalar, R: Record> Samples<T, R> for Raw<'_, R> {
    fn from(&self, start: usize) -> impl Iterator<Item = Complex<T>> {
        self.0.get(start..).unwrap_or_default().iter().map(|&sample| {
            let [re, im] = R::parts(sample);
            Complex::new(T::from_i32(re.into()), T::from_i32(im.into()))
        })
    }
}

impl<T: Scalar> Samples<T, Real> for [T] {
    fn from(&self, start: usize) -> impl Iterator<Item = Complex<T>> {
        self.get(start..).unwrap_or_default().iter().map(|&x| Complex::new(x, T::zero()))
    }
}

impl<T: Scalar> Samples<T, Iq> for [Complex<T>] {
    fn from(&self, start: usize) -> impl Iterator<Item = Complex<T>> {
        self.get(start..).unwrap_or_default().iter().copied()
    }
}

/// Samples of a kind `R` that was found to be `K`; made only by [`as_kind`].
pub(crate) struct As<'a, S: ?Sized, R, K> {
    samples: &'a S,
    kind: PhantomData<(R, K)>,
}

impl<T: Scalar, R: Record, K: Record, S: Samples<T, R> + ?Sized> Samples<T, K> for As<'_, S, R, K> {
    fn from(&self, start: usize) -> impl Iterator<Item = Complex<T>> {
        self.samples.from(start)
    }
}

/// `samples` as samples of a record of kind `K`; `None` where `R` is another kind.
pub(crate) fn as_kind<R: Record, K: Record, S: ?Sized>(samples: &S) -> Option<As<'_, S, R, K>> {
    (R::IQ == K::IQ).then_some(As { samples, kind: PhantomData })
}
