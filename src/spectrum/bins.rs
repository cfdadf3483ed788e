//! The few bins around a peak that an estimator reads. The kind of record and the window are part
//! of the type, so an estimator for one cannot be given the other.

use super::fft::integer::Point;
pub use super::layout::REACH;
use super::view::View;
use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use core::marker::PhantomData;
use core::mem::MaybeUninit;
use num_complex::Complex;

const WIDTH: usize = 2 * REACH + 1;

/// No window: the bins of the plain transform.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Rectangular;

/// Hann's window (periodic form, `sin^2(pi n / N)`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Hann;

/// Bins `peak - REACH ..= peak + REACH` of a record of `n` samples, in ADC codes.
///
/// Every bin has a value: an I/Q spectrum wraps round, a real one is mirrored at DC and Nyquist.
/// The values are unscaled: a tone of amplitude A has a line of A n (I/Q) or A n / 2 (real).
#[derive(Clone, Debug)]
pub struct Bins<T, R, W> {
    n: usize,
    peak: i32,
    cells: [Complex<T>; WIDTH],
    kind: PhantomData<(R, W)>,
}

impl<T: Scalar, R: Record, W> Bins<T, R, W> {
    /// The number of samples in the record.
    pub fn n(&self) -> usize {
        self.n
    }

    /// The number of samples as a float.
    pub fn length(&self) -> T {
        T::from_i32(self.n as i32)
    }

    /// The index of the peak bin.
    pub fn peak(&self) -> i32 {
        self.peak
    }

    /// The bin `offset` away from the peak; zero beyond [`REACH`].
    pub fn at(&self, offset: i32) -> Complex<T> {
        usize::try_from(offset + REACH as i32)
            .ok()
            .and_then(|index| self.cells.get(index))
            .copied()
            .unwrap_or(Complex::new(T::zero(), T::zero()))
    }

    /// The peak's left neighbour, the peak and its right neighbour.
    pub fn three(&self) -> [Complex<T>; 3] {
        [self.at(-1), self.at(0), self.at(1)]
    }

    /// These bins as bins of a record of kind `K`; `None` if `R` is another kind. The conversion serves code that is generic over the kind
    /// and selects an estimator at run time.
    pub fn as_kind<K: Record>(&self) -> Option<Bins<T, K, W>> {
        let Self { n, peak, cells, .. } = *self;
        (R::IQ == K::IQ).then_some(Bins { n, peak, cells, kind: PhantomData })
    }
}

impl<T: Scalar, R: Record> Bins<T, R, Rectangular> {
    /// Bins around `peak` from any source. `bin(k)` is called for `peak - REACH ..= peak + REACH`,
    /// with k folded into the record's range: `0..n` for I/Q, `0..=n/2` for real records. A folded
    /// bin of a real record is conjugated.
    pub fn gather(n: usize, peak: i32, bin: impl Fn(usize) -> Complex<T>) -> Self {
        let n = n.max(1);
        let mut cells = [Complex::new(T::zero(), T::zero()); WIDTH];
        for (cell, k) in cells.iter_mut().zip(peak - REACH as i32..) {
            let k = k.checked_rem_euclid(n as i32).unwrap_or(0) as usize;
            *cell = if !R::IQ && k > n / 2 { bin(n - k).conj() } else { bin(k) };
        }
        Self { n, peak, cells, kind: PhantomData }
    }

    /// Bins from an odd number of values around `peak`, in ascending order. The bins beyond are zero.
    pub(crate) fn from_middle(n: usize, peak: i32, bins: &[Complex<T>]) -> Self {
        let mut cells = [Complex::new(T::zero(), T::zero()); WIDTH];
        let first = REACH.saturating_sub(bins.len() / 2);
        let places = cells.iter_mut().skip(first);
        places.zip(bins).for_each(|(cell, bin)| *cell = *bin);
        Self { n, peak, cells, kind: PhantomData }
    }

    /// An odd number of bins around `peak`, in units of `2^exponent` codes. The bins beyond are zero.
    pub(crate) fn from_points(n: usize, peak: i32, points: &[Point], exponent: i32) -> Self {
        let unit = T::two_to(exponent);
        let mut cells = [Complex::new(T::zero(), T::zero()); WIDTH];
        let first = REACH.saturating_sub(points.len() / 2);
        for (cell, &[re, im]) in cells.iter_mut().skip(first).zip(points) {
            *cell = Complex::new(T::from_i32(re) * unit, T::from_i32(im) * unit);
        }
        Self { n, peak, cells, kind: PhantomData }
    }

    /// Bins around `peak` of an integer spectrum. The conversion rounds each part once to `T`.
    pub fn from_view(view: &View, peak: i32) -> Self {
        let mut place = MaybeUninit::<[Point; WIDTH]>::uninit();
        let points = view.window(peak - REACH as i32, &mut place);
        Self::from_points(view.layout.n, peak, points, view.exponent)
    }

    /// The bins under Hann's window: `X/2 - (left + right)/4`, which is exact. The outermost bin on each side has no outer neighbour and is
    /// zero.
    pub fn hann(&self) -> Bins<T, R, Hann> {
        let (half, quarter) = (T::new(0.5), T::new(0.25));
        let mut cells = [Complex::new(T::zero(), T::zero()); WIDTH];
        let inner = cells.iter_mut().skip(1);
        for (cell, around) in inner.zip(self.cells.array_windows()) {
            let &[left, centre, right] = around;
            *cell = centre * half - (left + right) * quarter;
        }
        Bins { n: self.n, peak: self.peak, cells, kind: PhantomData }
    }
}
