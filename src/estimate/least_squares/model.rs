//! A fitted tone's value in any bin, so that it can be taken away.

use super::Fit;
use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use crate::math::series::{circle, cosine, sinc};
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
        let x = fit.offset * T::of(core::f64::consts::PI) / T::of_i32(n);
        let turn = Complex::new(cosine(x * x), x * sinc(x * x));
        let sine = circle::<T>(peak, n).im;
        Self { n, peak, value: fit.peak, lever: fit.lever.re, turn, sine }
    }

    /// The tone's value in bin `k`: with `s(x) = sin(pi x / n)` and the offset d, `c s(d) / s(d - i)
    /// exp(j pi i / n)` for I/Q, and for real records
    /// `e p (a S - 2 b s(k+km) s(k-km) + j b sin(e k)) / (2 s(f+k) s(f-k))`, see [`super::real`].
    pub(crate) fn bin<R: Record>(&self, k: i32) -> Complex<T> {
        let (n, i) = (self.n, k.wrapping_sub(self.peak));
        if i.checked_rem(n).unwrap_or(0) == 0 {
            return self.value;
        }
        let apart = circle::<T>(i, 2 * n);
        let minus = self.turn.im * apart.re - self.turn.re * apart.im;
        if R::IQ {
            return self.value * apart * (self.turn.im / minus);
        }
        let across = circle::<T>(k.wrapping_add(self.peak), 2 * n);
        let plus = self.turn.im * across.re + self.turn.re * across.im;
        let Complex { re: a, im: b } = self.value;
        let two = T::of(2.0);
        let e = T::of(core::f64::consts::TAU) / T::of_i32(n);
        let re = a * self.sine - two * b * across.im * apart.im;
        let im = b * circle::<T>(k, n).im;
        Complex::new(re, im) * (e * self.lever / (two * plus * minus))
    }

    /// Takes the tone from the bins from `first` on: [`Model::bin`] of each, with its angles turned on
    /// from bin to bin.
    pub(crate) fn take_from<R: Record>(&self, first: i32, bins: &mut [Complex<T>]) {
        let (n, two) = (self.n, T::of(2.0));
        let forward = circle::<T>(1, 2 * n);
        let mut apart = circle::<T>(first.wrapping_sub(self.peak), 2 * n);
        // At the tone's own peak the quotient has no value.
        let own = self.peak.wrapping_sub(first).checked_rem_euclid(n).unwrap_or(0) as usize;
        if R::IQ {
            let scale = self.value * self.turn.im;
            for (place, bin) in bins.iter_mut().enumerate() {
                let minus = self.turn.im * apart.re - self.turn.re * apart.im;
                let model = if place == own { self.value } else { scale * apart / minus };
                *bin = *bin - model;
                apart = apart * forward;
            }
            return;
        }
        let mut across = circle::<T>(first.wrapping_add(self.peak), 2 * n);
        let (mut turn, twice) = (circle::<T>(first, n), circle::<T>(1, n));
        let Complex { re: a, im: b } = self.value;
        let e = T::of(core::f64::consts::TAU) / T::of_i32(n);
        let scale = e * self.lever / two;
        let (still, turning) = (a * self.sine * scale, b * scale);
        for (place, bin) in bins.iter_mut().enumerate() {
            let minus = self.turn.im * apart.re - self.turn.re * apart.im;
            let plus = self.turn.im * across.re + self.turn.re * across.im;
            let re = still - two * turning * across.im * apart.im;
            let inverse = T::one() / (plus * minus);
            let model = Complex::new(re, turning * turn.im) * inverse;
            *bin = *bin - if place == own { self.value } else { model };
            (apart, across, turn) = (apart * forward, across * forward, turn * twice);
        }
    }
}
