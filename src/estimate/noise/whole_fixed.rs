//! The noise estimate of [`super::whole`] with the sum over the bins in integers.
//!
//! Angles turn in Q30, weights are in Q29, bins as in [`crate::estimate::least_squares::fixed`].

use super::{ROUNDING, whole};
use crate::acquire::sample::Record;
use crate::estimate::least_squares::Fit;
use crate::estimate::least_squares::fixed::{ROOM, bin, held, product, quantised};
use crate::math::scalar::Scalar;
use crate::math::series::circle;
use crate::spectrum::Spectrum;
use crate::spectrum::engine::Engine;

/// An angle as cosine and sine in Q30.
pub(crate) type Turn = [i32; 2];

fn turn(k: i32, n: i32) -> Turn {
    let w = circle::<f32>(k, n);
    [quantised(w.re, 30), quantised(w.im, 30)]
}

pub(crate) fn turned([a, b]: Turn, [c, d]: Turn) -> Turn {
    let half = 1i64 << 29;
    [
        held((product(a, c) - product(b, d) + half) >> 30),
        held((product(a, d) + product(b, c) + half) >> 30),
    ]
}

/// As [`whole::power`].
pub fn power<R: Record, const N: usize, const BINS: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: i32,
    fit: &Fit<f32>,
) -> f32 {
    let stride = whole::stride::<R, N, BINS>() as i32;
    let scale = f32::two_to(spectrum.exponent() + ROOM as i32);
    let (residual, weight) = if R::IQ {
        iq(spectrum, peak, fit, stride, scale)
    } else {
        real(spectrum, peak, fit, stride, scale)
    };
    let parts = if R::IQ { 2.0 } else { 1.0 };
    (residual / weight / N as f32 * scale * scale).max(ROUNDING as f32 * parts)
}

fn real<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: i32,
    fit: &Fit<f32>,
    stride: i32,
    scale: f32,
) -> (f32, f32) {
    let n = N as i32;
    let p = fit.lever.re;
    let e = (core::f64::consts::TAU / N as f64) as f32;
    let w = circle::<f32>(peak, n);
    let cf = w.re - w.im * e * p;
    let tone = fit.peak * (p * e / scale);
    let (still, turning) = ((w.im * tone.re - w.re * tone.im) as i32, tone.im as i32);
    let forward = turn(stride, n);
    let (mut angle, threshold) = (forward, quantised(cf, 29));
    let (mut residual, mut k) = (0i64, stride);
    while k < n / 2 {
        let [re, im] = bin(spectrum, k);
        let weight = (angle[0] >> 1).saturating_sub(threshold);
        let re =
            (product(re, weight) >> 29) - i64::from(still) - (product(turning, angle[0]) >> 30);
        let im = (product(im, weight) >> 29) - (product(turning, angle[1]) >> 30);
        let (re, im) = (held(re), held(im));
        residual = residual.saturating_add(product(re, re)).saturating_add(product(im, im));
        angle = turned(angle, forward);
        k += stride;
    }
    let half = (n / 2 / stride) as f32;
    (residual as f32, half * 0.5 - 1.0 + (half - 1.0) * cf * cf)
}

fn iq<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: i32,
    fit: &Fit<f32>,
    stride: i32,
    scale: f32,
) -> (f32, f32) {
    let n = N as i32;
    let constant = fit.peak * fit.lever / scale;
    let constant = [constant.re as i32, constant.im as i32];
    let w = circle::<f32>(peak, n);
    let start = w - w * fit.lever;
    let back = turn(-stride, n);
    let mut angle = turned([quantised(start.re, 30), quantised(start.im, 30)], back);
    let (mut residual, mut k) = (0i64, stride);
    while k < n {
        let [re, im] = bin(spectrum, k);
        let weight = [(1i32 << 29).saturating_sub(angle[0] >> 1), -(angle[1] >> 1)];
        let left = [
            ((product(re, weight[0]) - product(im, weight[1])) >> 29) - i64::from(constant[0]),
            ((product(re, weight[1]) + product(im, weight[0])) >> 29) - i64::from(constant[1]),
        ];
        for left in left.map(held) {
            residual = residual.saturating_add(product(left, left));
        }
        angle = turned(angle, back);
        k += stride;
    }
    (residual as f32, (2 * n / stride - 2) as f32 + 2.0 * start.re)
}
