//! The noise estimate of [`super::whole`] with the sum over the bins in integers.
//!
//! Angles turn in Q30, weights are in Q29, bins as in [`crate::tone::fit::fixed`].

use crate::math::scalar::Scalar;
use crate::math::series::circle;
use crate::spectrum::neighbourhood::Neighbourhood;
use crate::tone::fit::Fit;
use crate::tone::fit::fixed::{ROOM, held, product, quantised};

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

/// The weighted residual of [`super::whole`] in integers, in squared codes; `cosine` is that of the tone's angle a sample.
pub(super) fn residual(near: &Neighbourhood, fit: &Fit<f32>, cosine: f32) -> f32 {
    let scale = f32::two_to(near.exponent + ROOM as i32);
    let residual = if near.iq { iq(near, fit, scale) } else { real(near, fit, scale, cosine) };
    residual * scale * scale
}

/// Bin `k`, less the bits of [`ROOM`].
fn bin(near: &Neighbourhood, k: i32) -> [i32; 2] {
    near.point(k).map(|part| part >> ROOM)
}

fn real(near: &Neighbourhood, fit: &Fit<f32>, scale: f32, cf: f32) -> f32 {
    let n = near.n as i32;
    let p = fit.lever.re;
    let e = core::f32::consts::TAU / n as f32;
    let w = circle::<f32>(near.peak, n);
    let tone = fit.peak * (p * e / scale);
    let (still, turning) = ((w.im * tone.re - w.re * tone.im) as i32, tone.im as i32);
    let forward = turn(1, n);
    let (mut angle, threshold) = (forward, quantised(cf, 29));
    let (mut residual, mut k) = (0i64, 1);
    while k < n / 2 {
        let [re, im] = bin(near, k);
        let weight = (angle[0] >> 1).saturating_sub(threshold);
        let re =
            (product(re, weight) >> 29) - i64::from(still) - (product(turning, angle[0]) >> 30);
        let im = (product(im, weight) >> 29) - (product(turning, angle[1]) >> 30);
        let (re, im) = (held(re), held(im));
        residual = residual.saturating_add(product(re, re)).saturating_add(product(im, im));
        angle = turned(angle, forward);
        k += 1;
    }
    residual as f32
}

fn iq(near: &Neighbourhood, fit: &Fit<f32>, scale: f32) -> f32 {
    let n = near.n as i32;
    let constant = fit.peak * fit.lever / scale;
    let constant = [constant.re as i32, constant.im as i32];
    let w = circle::<f32>(near.peak, n);
    let start = w - w * fit.lever;
    let back = turn(-1, n);
    let mut angle = turned([quantised(start.re, 30), quantised(start.im, 30)], back);
    let (mut residual, mut k) = (0i64, 1);
    while k < n {
        let [re, im] = bin(near, k);
        let weight = [(1i32 << 29).saturating_sub(angle[0] >> 1), -(angle[1] >> 1)];
        let left = [
            ((product(re, weight[0]) - product(im, weight[1])) >> 29) - i64::from(constant[0]),
            ((product(re, weight[1]) + product(im, weight[0])) >> 29) - i64::from(constant[1]),
        ];
        for left in left.map(held) {
            residual = residual.saturating_add(product(left, left));
        }
        angle = turned(angle, back);
        k += 1;
    }
    residual as f32
}
