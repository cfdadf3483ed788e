//! Two lines so near each other, and so strong, that they look like one that changes.
//!
//! The moments describe a line beside the tone only if it is small. Two equally strong lines leave the fit between them. In the middle of a
//! record of which x goes from -1 to 1 they are `z = a exp(j k x) + b exp(j l x)`, of which `z'' = j s z' + q z` with `s = k + l` and
//! `q = k l` (Prony 1795). Multiplied by polynomials w that vanish at both ends, with their slopes, and integrated by parts, the equation
//! has no derivative of z: `integral z w'' = -j s integral z w' + q integral z w`. The moments give the integrals, three polynomials six
//! real equations, least squares s and q, and these both offsets.

use super::changes::Moments;
use super::constants::LENGTHS;
use crate::math::scalar::Scalar as _;
use core::f32::consts::PI;
use num_complex::Complex;

/// The highest order that counts.
const SMOOTH: usize = 6;

/// The integrals of Legendre's polynomials of order 0 to 6 times w, w' and w'', for w of `(1 - x^2)^2` times 1, x and `x^2 - 1/7`.
const INTEGRALS: [[[f32; SMOOTH + 1]; 3]; 3] = [
    [
        [1.066_666_7, 0.0, -0.304_761_9, 0.0, 0.050_793_65, 0.0, 0.0],
        [0.0, -1.066_666_7, 0.0, 0.457_142_86, 0.0, 0.0, 0.0],
        [0.0, 0.0, 3.2, 0.0, 0.0, 0.0, 0.0],
    ],
    [
        [0.0, 0.152_380_95, 0.0, -0.101_587_3, 0.0, 0.023_088_023, 0.0],
        [0.0, 0.0, -0.457_142_86, 0.0, 0.253_968_25, 0.0, 0.0],
        [0.0, 0.0, 0.0, 2.285_714_4, 0.0, 0.0, 0.0],
    ],
    [
        [0.0, 0.0, 0.043_537_416, 0.0, -0.039_579_466, 0.0, 0.010_656_01],
        [0.0, 0.0, 0.0, -0.217_687_07, 0.0, 0.138_528_14, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.523_809_6, 0.0, 0.0],
    ],
];

/// Lines nearer to each other have no distances of their own; lines farther apart are not a pair.
const APART: core::ops::Range<f32> = 0.05..2.0;

/// Both lines' distances from a tone of this strength whose fit leaves these moments, bins, the nearer line first; `None` if the residual
/// does not come from two lines.
pub fn places(strength: f32, moments: &Moments) -> Option<[f32; 2]> {
    let mut series = [Complex::new(strength, 0.0); SMOOTH + 1];
    let seen = moments.amplitude.iter().zip(&moments.phase).zip(LENGTHS.iter().skip(1));
    for (term, ((amplitude, phase), length)) in series.iter_mut().skip(1).zip(seen) {
        *term = Complex::new(amplitude * length, phase * length);
    }
    // The normal equations of s and q.
    let [mut ss, mut sq, mut qq, mut sy, mut qy] = [0.0; 5];
    for integrals in &INTEGRALS {
        let [plain, first, second] = integrals.map(|weights| {
            weights.iter().zip(&series).map(|(weight, term)| term * *weight).sum::<Complex<f32>>()
        });
        // `-j s first`.
        let turned = Complex::new(first.im, -first.re);
        let real = |a: Complex<f32>, b: Complex<f32>| a.re * b.re + a.im * b.im;
        ss += real(turned, turned);
        sq += real(turned, plain);
        qq += real(plain, plain);
        sy += real(turned, second);
        qy += real(plain, second);
    }
    let determinant = ss * qq - sq * sq;
    if determinant.is_nan() || determinant <= 1e-6 * ss * qq {
        return None;
    }
    let (sum, product) = ((sy * qq - qy * sq) / determinant, (qy * ss - sy * sq) / determinant);
    let square = 0.25 * sum * sum - product;
    let half = square.max(0.0).root();
    let places = [0.5 * sum - half, 0.5 * sum + half].map(|place| place / PI);
    let [low, high] = places;
    let nearer = if low.abs() < high.abs() { places } else { [high, low] };
    (square > 0.0 && APART.contains(&(high - low))).then_some(nearer)
}
