//! The noise power of a whole record: the residual of the fitted tone in bins all over the spectrum.
//!
//! A bin of a tone is a numerator over a factor that vanishes at the tone. The numerator is a
//! constant (I/Q), or a constant and a turning term (real). Multiplied by that factor the residual
//! needs no division, and a bin near the tone, where any misfit would show, hardly counts:
//!
//! ```text
//! I/Q   w_k = 1 - exp(j 2 pi (f - k)/N)             noise N = sum |X_k w_k - G|^2 / sum |w_k|^2
//! real  w_k = cos(2 pi k/N) - cos(2 pi f/N)         noise N = sum |X_k w_k - U - V exp(j 2 pi k/N)|^2 / sum w_k^2
//! ```
//!
//! The sums run over all bins without DC. The sums of weights are known. Two simpler ways fail. The total power less the tone's power is 33 dB off at 60 dB. The residual
//! of the fit's own bins has few degrees of freedom, and is worst where the fit is.
//!
//! Measured on real tones of any frequency, at 255 bins: standard deviation 0.38 dB, no bias; at 127 bins 0.54 dB.
//!
//! Records of 256 samples and more (I/Q: 128) take the noise beside the tone instead, see [`super::ring`].

use super::power::{Noise, rounding};
use crate::math::series::circle;
use crate::spectrum::neighbourhood::Neighbourhood;
use crate::tone::arithmetic::Arithmetic;
use crate::tone::fit::Fit;
use num_complex::Complex;

/// The noise of a record that is too short for a ring, from all its bins. Not below the rounding of the converter. Cost: about 12
/// multiplications a bin.
pub fn noise(near: &Neighbourhood, fit: &Fit<f32>, arithmetic: Arithmetic) -> Noise {
    let (n, iq) = (near.n as i32, near.iq);
    let Complex { re, im } = circle::<f32>(near.peak, n);
    // The cosine of the tone's angle a sample.
    let cosine = if iq {
        re - (re * fit.lever.re - im * fit.lever.im)
    } else {
        re - im * (core::f32::consts::TAU / n as f32) * fit.lever.re
    };
    let residual = match arithmetic {
        Arithmetic::Float if iq => iq_residual(near, fit),
        Arithmetic::Float => real_residual(near, fit, cosine),
        Arithmetic::Fixed => super::whole_fixed::residual(near, fit, cosine),
    };
    // The sum of the squares of the weights.
    let bins = n as f32 * if iq { 1.0 } else { 0.5 } - 1.0;
    let weight =
        if iq { 2.0 * bins + 2.0 * cosine } else { 0.25 * n as f32 - 1.0 + bins * cosine * cosine };
    let power = residual / weight / n as f32;
    Noise { power: power.max(rounding(iq)), dof: dof(near.n, iq) }
}

/// The degrees of freedom of the estimate. A bin has two, but bins have different weights: with weights w the estimate has
/// `2 (sum w)^2 / sum w^2`, 4/3 a bin for I/Q and for a real tone at a quarter of the rate. A real tone elsewhere has 0.93 to 1.33 a bin;
/// this function returns the 4/3 for all. With them the false alarms of 64 real samples are .998 of those that are asked for, at 1e-2.
pub const fn dof(n: usize, iq: bool) -> f32 {
    let count = count(n, iq);
    (count + count / 3) as f32
}

/// The number of bins that the estimate reads: all but DC, and Nyquist of a real record.
pub const fn count(n: usize, iq: bool) -> usize {
    (if iq { n } else { n / 2 }).saturating_sub(1)
}

/// The weighted residual of an I/Q record, in squared codes.
fn iq_residual(near: &Neighbourhood, fit: &Fit<f32>) -> f32 {
    let (n, unit) = (near.n as i32, near.unit());
    let z = fit.lever;
    let constant = fit.peak * z * unit.recip();
    // exp(j 2 pi (f - k) / N) = turn.
    let one = Complex::new(1.0, 0.0);
    let start = (one - z) * circle::<f32>(near.peak, n);
    let back = circle::<f32>(-1, n);
    let mut turn = start * back;
    let mut residual = 0.0;
    let mut k = 1;
    while k < n {
        let x = near.point(k);
        let rest = Complex::new(x[0] as f32, x[1] as f32) * (one - turn) - constant;
        residual += rest.norm_sqr();
        turn *= back;
        k += 1;
    }
    residual * unit * unit
}

/// The weighted residual of a real record, in squared codes, for a tone with this cosine of its angle a sample.
fn real_residual(near: &Neighbourhood, fit: &Fit<f32>, cf: f32) -> f32 {
    let (n, unit) = (near.n as i32, near.unit());
    let p = fit.lever.re;
    let e = core::f32::consts::TAU / n as f32;
    let Complex { re: cos, im: sin } = circle::<f32>(near.peak, n);
    let tone = fit.peak * (p * e / unit);
    let (still, turning) = (sin * tone.re - cos * tone.im, tone.im);
    let forward = circle::<f32>(1, n);
    let mut turn = forward;
    let mut residual = 0.0;
    for x in near.from(1, n as usize / 2 - 1) {
        let weight = turn.re - cf;
        let re = x[0] as f32 * weight - still - turning * turn.re;
        let im = x[1] as f32 * weight - turning * turn.im;
        residual += re * re + im * im;
        turn *= forward;
    }
    residual * unit * unit
}
