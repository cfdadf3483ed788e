//! Least squares over FFT bins: the default methods.
//!
//! Without noise the bins around a line are an exact function of the line's offset and complex
//! amplitude. Gauss-Newton fits that function to `2 K + 1` bins and so uses nearly all the
//! information of the record, at any offset and at any SNR above the threshold: [`Reach`] has the figures. It reads nothing but bins: no second pass
//! over the samples, no window. Both fits are this project's own.
//!
//! - [`iq`]: complex tones.
//! - [`real`]: real tones, by a model that contains the mirror image; no other method of the
//!   registry is free of bias on real samples.
//! - [`fixed`]: both again, with the sums over the bins in integers, for cores without an FPU.
//!
//! Besides the offset, a [`Fit`] holds amplitude, phase and the information that gives sigma.

pub(crate) mod descent;
pub mod fixed;
pub mod iq;
mod model;
pub(crate) mod normal;
pub mod real;
mod rest;

pub(crate) use model::Model;
pub use rest::Rest;

use crate::acquire::sample::{Iq, Real, Record};
use crate::list::first;
use crate::math::scalar::Scalar;
use crate::math::series::circle;
use crate::spectrum::bins::{Bins, REACH, Rectangular};
use crate::spectrum::fft::integer::Point;
use crate::spectrum::layout::{Distance, Layout};
use crate::spectrum::neighbourhood::Neighbourhood;
use crate::tone::arithmetic::Arithmetic;
use num_complex::Complex;

/// A fit's limits in bins: the start, a step, the offset, and how near DC or Nyquist a real tone
/// may come.
const START_LIMIT: f64 = 0.75;
const STEP_LIMIT: f64 = 0.5;
const OFFSET_LIMIT: f64 = 0.9;
const EDGE_LIMIT: f64 = 0.3;

/// A further step follows only if the last one moved more than this, in bins. Gauss-Newton then
/// squares the error to less than the bound.
const SETTLED: f64 = 0.02;

/// A fit to a line that is not a steady tone nears its end by a share of the remaining way at each step. It has ended when a step moves no
/// more than this, in bins: less than the bound of a tone of 60 dB.
const ENDED: f64 = 1e-5;

/// The start of a fit, and the number of its steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FitStart<T> {
    /// From the three middle bins. Two steps, three near DC and Nyquist; another step only if the last moved more than 0.02 bin.
    Usual,
    /// From a given offset, with this many steps. With 0 steps: amplitude and information at this offset.
    From(T, u32),
    /// From a given offset, until a step hardly moves it, with at most this many steps. Such a fit ends at least squares even if the
    /// residual is more than noise, for example with a tone whose amplitude changes. The usual steps to I/Q tones end a little beside that
    /// minimum. I/Q fits leave out bin 0, which holds a constant offset.
    Further(T, u32),
}

/// The result of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit<T> {
    /// The tone's distance from the peak bin, in bins.
    pub offset: T,
    /// The tone's amplitude times half the record (real) or the record (I/Q), rotated as the line is: `amplitude * exp(j phase)` follows by
    /// [`Fit::tone`].
    pub line: Complex<T>,
    /// The information about the offset: the noise power of a bin divided by twice this is the
    /// variance of the offset in bins^2.
    pub information: T,
    /// The model's value of the peak bin.
    pub(crate) peak: Complex<T>,
    /// The distance of the peak bin from the tone as the noise estimate uses it: `p` of [`real`],
    /// or `1 - exp(j 2 pi offset / N)` for I/Q.
    pub(crate) lever: Complex<T>,
    /// The power that the model leaves in the fitted bins, in squared codes.
    pub residual: T,
    /// Degrees of freedom of the residual: the real numbers of the bins less the parameters. Noise alone leaves half this number times the
    /// noise power of a bin.
    pub dof: u32,
    /// The residual's projections near the line.
    pub rest: Rest<T>,
}

impl<T: Scalar> Fit<T> {
    /// The tone's complex amplitude in ADC codes, `A exp(j phase)`: the record's samples are
    /// `A cos(2 pi f n / N + phase)`, or `A exp(j (2 pi f n / N + phase))` for I/Q.
    pub fn tone<R: Record>(&self, n: usize) -> Complex<T> {
        self.tone_of(R::IQ, n)
    }

    /// The fit in single precision.
    pub fn single(&self) -> Fit<f32> {
        let one = |x: T| x.wide() as f32;
        let pair = |z: Complex<T>| Complex::new(one(z.re), one(z.im));
        let Rest { within, along, cosine_squared } = self.rest;
        Fit {
            offset: one(self.offset),
            line: pair(self.line),
            information: one(self.information),
            peak: pair(self.peak),
            lever: pair(self.lever),
            residual: one(self.residual),
            dof: self.dof,
            rest: Rest {
                within: within.map(one),
                along: along.map(pair),
                cosine_squared: one(cosine_squared),
            },
        }
    }

    /// The fit of a record that is `unit` times as strong.
    fn scaled(self, unit: T) -> Self {
        let Rest { within, along, cosine_squared } = self.rest;
        let power = unit * unit;
        let rest = Rest {
            within: within.map(|part| part * power),
            along: along.map(|part| part * unit),
            cosine_squared,
        };
        Fit {
            line: self.line * unit,
            information: self.information * power,
            peak: self.peak * unit,
            residual: self.residual * power,
            rest,
            ..self
        }
    }

    pub(crate) fn tone_of(&self, iq: bool, n: usize) -> Complex<T> {
        let turn = if iq { T::one() - T::one() / T::from_i32(n as i32) } else { T::one() };
        self.line * T::unit(-self.offset * turn * T::new(0.5)) * gain::<T>(iq, n)
    }

    /// The square of the amplitude in ADC codes.
    #[inline(always)] // where the size is known at compile time, nothing is divided
    pub fn amplitude_squared(&self, iq: bool, n: usize) -> T {
        let gain = gain::<T>(iq, n);
        self.line.norm_sqr() * (gain * gain)
    }
}

impl Fit<f32> {
    /// The offset in fixed point; `None` if it is not a number. A fit's offset is below 1.
    pub(crate) fn offset_in_fixed_point(&self) -> Option<::fixed::types::I2F30> {
        let bits = || fixed::quantised(self.offset, 30);
        (self.offset.abs() < 2.0).then(|| ::fixed::types::I2F30::from_bits(bits()))
    }

    /// The line in ADC codes, and the advance of the tone's phase at the first sample, in turns of 2^32: half the offset back, as in
    /// [`Fit::tone`].
    pub(crate) fn line_of(&self, iq: bool, n: usize) -> (Complex<f32>, i32) {
        let bits = n.trailing_zeros() as i32;
        let (half, gain) = (f32::two_to(31), f32::two_to(-bits));
        let (half, gain) = if iq { (half - half * gain, gain) } else { (half, gain + gain) };
        (self.line * gain, (-self.offset * half) as i32)
    }
}

#[inline(always)]
fn gain<T: Scalar>(iq: bool, n: usize) -> T {
    T::new(if iq { 1.0 } else { 2.0 }) / T::from_i32(n.max(1) as i32)
}

/// The bins that a fit reads on each side of the peak. The figures are the rms error over the Cramer-Rao bound; tests hold the error of tones
/// at any offset, from 2 dB above the threshold to 60 dB, to at most 1.035 with sixteen bins and 1.05 with eight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Reach {
    /// Four: 1.1 times the bound.
    Four,
    /// Eight: 1.02 times the bound.
    Eight,
    /// Sixteen: 1.01 times the bound.
    #[default]
    Sixteen,
}

impl Reach {
    /// The number of bins on each side: 4, 8 or 16.
    pub const fn bins(self) -> usize {
        4 << self as usize
    }
}

/// Fits a tone to `2 reach + 1` bins of either kind of record; `None` if nothing can be fitted: no
/// signal, or the peak of a real record at DC or Nyquist.
pub fn fit<T: Scalar, R: Record>(
    bins: &Bins<T, R, Rectangular>,
    reach: Reach,
    course: FitStart<T>,
) -> Option<Fit<T>> {
    fit_bins(bins, reach.bins(), course)
}

/// Fits a tone to the bins within `reach` of a peak, in either arithmetic; `None` if nothing can be fitted: no signal, or the
/// peak of a real record at DC or Nyquist.
pub type FitNear = fn(&Neighbourhood, Arithmetic, Reach, FitStart<f32>) -> Option<Fit<f32>>;

/// The fit for records of kind `R`: a program with records of one kind links one of the two.
pub const fn fit_near<R: Record>() -> FitNear {
    if R::IQ { fit_near_iq } else { fit_near_real }
}

#[inline(never)]
fn fit_near_real(
    near: &Neighbourhood,
    arithmetic: Arithmetic,
    reach: Reach,
    course: FitStart<f32>,
) -> Option<Fit<f32>> {
    let Neighbourhood { layout, peak, exponent, .. } = *near;
    let bins = near.within(reach.bins());
    match arithmetic.available() {
        Arithmetic::Fixed => {
            fixed::fit_real(layout.n as i32, peak, bins, layout.real, exponent, course)
        }
        Arithmetic::Float => fit_points(layout, bins, peak, exponent, course),
    }
}

#[inline(never)]
fn fit_near_iq(
    near: &Neighbourhood,
    arithmetic: Arithmetic,
    reach: Reach,
    course: FitStart<f32>,
) -> Option<Fit<f32>> {
    let Neighbourhood { layout, peak, exponent, .. } = *near;
    let bins = near.within(reach.bins());
    match arithmetic.available() {
        Arithmetic::Fixed => {
            fixed::fit_iq(layout.n as i32, peak, bins, layout.quadrature, exponent, course)
        }
        Arithmetic::Float => {
            let bins = Bins::<f32, Iq, _>::from_points(layout.n, peak, bins, exponent);
            iq::fit(&bins, reach.bins(), course)
        }
    }
}

/// Fits a real tone to an odd number of bins around `peak`, in units of `2^exponent` codes.
#[inline(never)] // so that all who fit share one
fn fit_points(
    layout: &Layout,
    points: &[Point],
    peak: i32,
    exponent: i32,
    course: FitStart<f32>,
) -> Option<Fit<f32>> {
    let (centre, beside) = bins(points, layout.distances)?;
    let fit = real::fit(layout.n as i32, peak, centre, beside, course)?;
    Some(fit.scaled(f32::two_to(exponent)))
}

/// [`fit_near`] in floats, for a record of any kind and length.
pub(crate) fn fit_in_floats(
    near: &Neighbourhood,
    reach: Reach,
    course: FitStart<f32>,
) -> Option<Fit<f32>> {
    let &Neighbourhood { layout, peak, .. } = near;
    let unit = near.unit();
    let bins = near.within(reach.bins()).iter();
    let bins = bins.map(|&[re, im]| Complex::new(re as f32 * unit, im as f32 * unit));
    let bins: heapless::Vec<_, { 2 * REACH + 1 }> = first(bins);
    fit_around(layout, &bins, peak, course)
}

/// The middle one of a fit's bins, and the bins beside it.
#[inline(always)]
fn bins<'a>(
    points: &'a [Point],
    table: &'a [Distance<f32>; REACH + 1],
) -> Option<(Complex<f32>, impl Iterator<Item = real::Both<f32>> + 'a)> {
    let bin = |&[re, im]: &Point| Complex::new(re as f32, im as f32);
    let (below, rest) = points.split_at_checked(points.len() / 2)?;
    let (centre, above) = rest.split_first()?;
    let beside = table.get(1..)?.iter().zip(above).zip(below.iter().rev());
    let beside = beside.map(move |((&distance, high), low)| ([bin(low), bin(high)], distance));
    Some((bin(centre), beside))
}

impl<T: Scalar> Distance<T> {
    fn new(i: i32, n: i32) -> Self {
        let half = circle::<T>(i, n.saturating_mul(2));
        let two = T::new(2.0);
        Distance { sine: two * half.im * half.re, versine: two * half.im * half.im }
    }
}

/// [`fit`] to an odd number of bins around `peak` of a record of N samples, at most `2 REACH + 1`. What
/// depends on N alone is computed at compile time.
#[inline(never)]
pub(crate) fn fit_around(
    layout: &Layout,
    bins: &[Complex<f32>],
    peak: i32,
    course: FitStart<f32>,
) -> Option<Fit<f32>> {
    let reach = bins.len() / 2;
    let n = layout.n;
    if layout.iq {
        return iq::fit(&Bins::<f32, Iq, _>::from_middle(n, peak, bins), reach, course);
    }
    let (below, rest) = bins.split_at_checked(reach)?;
    let (&centre, above) = rest.split_first()?;
    let beside = layout.distances.get(1..)?.iter().zip(above).zip(below.iter().rev());
    let beside = beside.map(|((&distance, &high), &low)| ([low, high], distance));
    real::fit(n as i32, peak, centre, beside, course)
}

/// Takes a tone's model from an odd number of bins around `peak` of a record of N samples.
pub(crate) fn take_around(
    layout: &Layout,
    model: &Model<f32>,
    peak: i32,
    bins: &mut [Complex<f32>],
) {
    if layout.iq {
        model.take_from(peak.wrapping_sub((bins.len() / 2) as i32), bins);
    } else {
        model.take_around(peak, layout.distances, bins);
    }
}

/// [`fit`] with any reach up to 16.
pub(crate) fn fit_bins<T: Scalar, R: Record>(
    bins: &Bins<T, R, Rectangular>,
    reach: usize,
    course: FitStart<T>,
) -> Option<Fit<T>> {
    if R::IQ {
        return iq::fit(bins, reach, course);
    }
    let n = bins.n() as i32;
    let beside = distances(reach).map(|i| ([bins.at(-i), bins.at(i)], Distance::new(i, n)));
    real::fit(n, bins.peak(), bins.at(0), beside, course)
}

/// `least-squares`: the offset of a complex tone, in bins, within -0.9..=0.9; 0 if there is no
/// signal.
///
/// 1.00 to 1.03 times the Cramer-Rao bound (K = 16). Cost for K = 16, counted at 20 dB: about
/// 1000 multiplications and 180 divisions beyond the FFT.
pub fn least_squares<T: Scalar, const K: usize>(bins: &Bins<T, Iq, Rectangular>) -> T {
    fit_bins(bins, K, FitStart::Usual).map_or(T::zero(), |fit| fit.offset)
}

/// `least-squares-real`: the offset of a real tone, in bins, within -0.9..=0.9; 0 if there is no
/// signal. Valid for 1.5 < f < N/2 - 1.5 bins. A DC offset has no effect.
///
/// Accuracy: see [`Reach`]. Cost for K = 16, counted at 20 dB:
/// about 1250 multiplications and 120 divisions beyond the FFT.
pub fn least_squares_real<T: Scalar, const K: usize>(bins: &Bins<T, Real, Rectangular>) -> T {
    fit_bins(bins, K, FitStart::Usual).map_or(T::zero(), |fit| fit.offset)
}

/// The distances 1..=reach from the peak, at most [`REACH`].
fn distances(reach: usize) -> core::ops::RangeInclusive<i32> {
    1..=reach.min(REACH) as i32
}

fn limit<T: Scalar>(x: T, bound: f64) -> T {
    let bound = T::new(bound);
    // `max` and `min` return the number if the other is NaN.
    if x.is_nan() { T::zero() } else { x.max(-bound).min(bound) }
}

/// The first two items, the peak's neighbours. Collecting into a full vector panics, and a compiler that optimises for size does not see
/// that the vector never is full.
fn first_two<T>(sides: impl Iterator<Item = T>) -> heapless::Vec<T, 2> {
    let mut near = heapless::Vec::new();
    for side in sides.take(2) {
        let _ = near.push(side);
    }
    near
}
