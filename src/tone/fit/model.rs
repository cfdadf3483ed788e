//! A fitted tone's value in any bin, so that the tone can be subtracted.

use super::Fit;
use crate::math::scalar::Scalar;
use crate::math::series::{circle, cosine, sinc};
use crate::spectrum::bins::REACH;
use crate::spectrum::layout::Distance;
use num_complex::Complex;

/// A fitted tone, ready to be evaluated in bins of an `n`-point record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Model<T> {
    n: i32,
    peak: i32,
    value: Complex<T>,
    lever: T,
    /// Cosine and sine of `pi offset / n`.
    turn: Complex<T>,
    /// Sine of `2 pi peak / n`.
    sine: T,
}

impl<T: Scalar> Model<T> {
    /// The tone that `fit` found at bin `peak`.
    pub(crate) fn new(fit: &Fit<T>, peak: i32, n: i32) -> Self {
        let x = fit.offset * T::new(core::f64::consts::PI) / T::from_i32(n);
        let turn = Complex::new(cosine(x * x), x * sinc(x * x));
        let sine = circle::<T>(peak, n).im;
        Self { n, peak, value: fit.peak, lever: fit.lever.re, turn, sine }
    }

    /// The tone's value in bin `k`: with `s(x) = sin(pi x / n)` and the offset d, `c s(d) / s(d - i) exp(j pi i / n)` for I/Q, and for real
    /// records `e p (a S - 2 b s(k+km) s(k-km) + j b sin(e k)) / (2 s(f+k) s(f-k))`, see [`super::real`].
    pub(crate) fn bin(&self, iq: bool, k: i32) -> Complex<T> {
        let (n, i) = (self.n, k.wrapping_sub(self.peak));
        if i.checked_rem(n).unwrap_or(0) == 0 {
            return self.value;
        }
        let apart = circle::<T>(i, 2 * n);
        let minus = self.turn.im * apart.re - self.turn.re * apart.im;
        if iq {
            return self.value * apart * (self.turn.im / minus);
        }
        let across = circle::<T>(k.wrapping_add(self.peak), 2 * n);
        let plus = self.turn.im * across.re + self.turn.re * across.im;
        let Complex { re: a, im: b } = self.value;
        let two = T::new(2.0);
        let e = T::new(core::f64::consts::TAU) / T::from_i32(n);
        let re = a * self.sine - two * b * across.im * apart.im;
        let im = b * circle::<T>(k, n).im;
        Complex::new(re, im) * (e * self.lever / (two * plus * minus))
    }

    /// The tone's value in its peak bin.
    pub(crate) fn value(&self) -> Complex<T> {
        self.value
    }

    /// The tone's value in a distant bin, times the distance in bins.
    pub(crate) fn leakage(&self) -> Complex<T> {
        self.value * (self.turn.im * T::from_i32(self.n) / T::new(core::f64::consts::PI))
    }

    /// Subtracts a real tone from an odd number of bins around `peak`. `table` has the constants of each distance from the peak. With `w`
    /// and `s` of [`super::real`] for these bins, and `e p` and `e q` the distances of the tone and of its own peak in the same measure, a
    /// bin is
    ///
    /// ```text
    /// e lever (a S' / S - b (w - e q) + j b s) / (e p - w)
    /// ```
    ///
    /// so that it costs a division and seven operations.
    pub(crate) fn take_around(
        &self,
        peak: i32,
        table: &[Distance<T>; REACH + 1],
        bins: &mut [Complex<T>],
    ) {
        let (n, two) = (self.n, T::new(2.0));
        let centre = circle::<T>(peak, n);
        let inverse = T::one() / centre.im;
        let cotangent = centre.re * inverse;
        let apart = circle::<T>(self.peak.wrapping_sub(peak), 2 * n);
        let across = circle::<T>(self.peak.wrapping_add(peak), 2 * n);
        let turned = |z: Complex<T>| z.im * self.turn.re + z.re * self.turn.im;
        let ep = two * turned(apart) * turned(across) * inverse;
        let eq = two * apart.im * across.im * inverse;
        let scale = T::new(core::f64::consts::TAU) / T::from_i32(n) * self.lever;
        let (still, turning) = (
            scale * (self.value.re * self.sine * inverse + self.value.im * eq),
            scale * self.value.im,
        );
        let take = |bin: &mut Complex<T>, w: T, s: T| {
            let inverse = T::one() / (ep - w);
            bin.re = bin.re - (still - turning * w) * inverse;
            bin.im = bin.im - turning * s * inverse;
        };
        // At the tone's own peak the quotient has no value.
        let reach = (bins.len() / 2) as i32;
        let own =
            usize::try_from(self.peak.wrapping_sub(peak).wrapping_add(reach)).unwrap_or(usize::MAX);
        let own = bins.get(own).map(|&bin| (own, bin - self.value));
        let Some((below, above)) = bins.split_at_mut_checked(reach as usize) else { return };
        let Some((middle, above)) = above.split_first_mut() else { return };
        take(middle, T::zero(), T::one());
        let sides = below.iter_mut().rev().zip(above).zip(table.iter().skip(1));
        for ((low, high), &Distance { sine, versine }) in sides {
            let (bend, straight, lean) =
                (cotangent * versine, T::one() - versine, cotangent * sine);
            take(low, bend - sine, straight - lean);
            take(high, bend + sine, straight + lean);
        }
        if let Some((place, left)) = own
            && let Some(bin) = bins.get_mut(place)
        {
            *bin = left;
        }
    }

    /// Subtracts a complex tone from the bins from `first` on: [`Model::bin`] of each, whose angle is turned on from bin to bin.
    pub(crate) fn take_from(&self, first: i32, bins: &mut [Complex<T>]) {
        let n = self.n;
        let forward = circle::<T>(1, 2 * n);
        let mut apart = circle::<T>(first.wrapping_sub(self.peak), 2 * n);
        // At the tone's own peak the quotient has no value.
        let own = self.peak.wrapping_sub(first).checked_rem_euclid(n).unwrap_or(0) as usize;
        let scale = self.value * self.turn.im;
        for (place, bin) in bins.iter_mut().enumerate() {
            let minus = self.turn.im * apart.re - self.turn.re * apart.im;
            let model = if place == own { self.value } else { scale * apart / minus };
            *bin = *bin - model;
            apart = apart * forward;
        }
    }
}
