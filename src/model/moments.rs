//! The residual of a fit along the directions in which a tone changes: Legendre's functions of time.
//!
//! The bins of `sqrt(2 p + 1) P_p(t)` times the tone are `sqrt(2 p + 1) j^p j_p(pi (f - k))`. Over all bins they are orthogonal; over the
//! window the Gram-Schmidt process makes them so, from order 0 up. The fit has taken order 0 and the phase of order 1.

use super::bessel::orders;
use super::constants::{LENGTHS, ORDERS};
use super::factor::{Factor, Rows};
use super::line::Line;
use super::shape::{Shape, turned};
use super::window::Window;
use crate::math::scalar::Scalar as _;
use core::f32::consts::PI;
use num_complex::Complex;

/// The moments, of order 1 and up, in deviations of the noise.
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    /// Moments of the amplitude.
    pub amplitude: [f32; ORDERS],
    /// Moments of the phase; 0 at order 1, which is the frequency.
    pub phase: [f32; ORDERS],
}

impl Moments {
    /// The moments of the residual of a fit with this tone.
    pub fn from_residual(window: &Window, tone: &Line, left: &Shape) -> Self {
        /// The number of orders, with order 0.
        const COUNT: usize = ORDERS + 1;
        let Complex { re, im } = f32::unit(0.5 * tone.offset);
        let back = tone.value.conj() * (1.0 / tone.value.norm_sqr().root().max(1e-30));
        let mut gram: Rows<COUNT> = [[0.0; COUNT]; COUNT];
        let (mut real, mut imaginary) = ([0.0; COUNT], [0.0; COUNT]);
        for ((i, left), &used) in Window::places().zip(left).zip(&window.used) {
            if used == 0.0 {
                continue;
            }
            let parity = if i & 1 == 0 { 1.0 } else { -1.0 };
            let mut values = orders(PI * (tone.offset - i as f32), parity * im, parity * re);
            values.iter_mut().zip(LENGTHS).for_each(|(value, length)| *value *= length);
            let left = left * back;
            for (p, (row, value)) in gram.iter_mut().zip(values).enumerate() {
                row.iter_mut()
                    .zip(values)
                    .take(p + 1)
                    .for_each(|(sum, other)| *sum += value * other);
            }
            let sums = real.iter_mut().zip(&mut imaginary).zip(values);
            sums.for_each(|((re, im), value)| {
                *re += left.re * value;
                *im += left.im * value;
            });
        }
        // The directions are `j^p` times these functions: the fit's own two are the first, and the real part of the second.
        let ([zeroth, first, ..], [other, ..]) = (&mut real, &mut imaginary);
        (*zeroth, *first, *other) = (0.0, 0.0, 0.0);
        let factor = Factor::from_rows(&gram, COUNT);
        // The matrix has ones on its diagonal, nearly.
        let (real, imaginary) = (factor.forward(&real), factor.forward(&imaginary));
        let (mut amplitude, mut phase) = ([0.0; ORDERS], [0.0; ORDERS]);
        let sums = real.into_iter().zip(imaginary).zip(0..).skip(1);
        for ((amplitude, phase), ((re, im), p)) in amplitude.iter_mut().zip(&mut phase).zip(sums) {
            // A turn back by `j^p` equals a turn on by `j^(3 p)`.
            let along = turned(Complex::new(re, im), 3 * p);
            (*amplitude, *phase) = (along.re, along.im);
        }
        let [first, ..] = &mut phase;
        *first = 0.0;
        Self { amplitude, phase }
    }
}
