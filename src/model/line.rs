//! A line: a steady tone in the window's bins, with the mirror image of a real tone.
//!
//! With `D(x) = sin(pi x) / sin(pi x / N)` a tone at f of amplitude c, in the middle of the record, has the bins `c D(f - k) / N`, and a
//! real tone also `conj(c) D(f + k) / N`. So c is the line's strength: nearly the root of the power in all its bins.

use super::bessel::orders;
use super::constants::{ORDERS, WIDTH};
use super::shape::{NOTHING, Shape, quarter, turned};
use super::window::Window;
use crate::math::scalar::{Scalar, cosine, sinc};
use core::f32::consts::PI;
use num_complex::Complex;

/// A line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// The line's distance from the peak, bins.
    pub offset: f32,
    /// The line's complex strength in the middle of the record.
    pub value: Complex<f32>,
}

impl Line {
    /// A line of strength 0.
    pub const NONE: Self = Self { offset: 0.0, value: Complex::new(0.0, 0.0) };
}

/// The bins of a line of strength 1, by the distance of each: the line's and its image's, and their change for one more bin of frequency.
pub struct Bins {
    own: [[f32; 2]; WIDTH],
    image: [[f32; 2]; WIDTH],
}

impl Bins {
    /// The bins of a line at `offset` bins from the window's peak.
    pub fn at(window: &Window, offset: f32) -> Self {
        let Window { n, iq, used, across, .. } = window;
        let length = *n as f32;
        let whole = libm::roundf(offset);
        let part = offset - whole;
        let Complex { re, im } = f32::unit(0.5 * part);
        let sign = if whole as i32 & 1 == 0 { 1.0 } else { -1.0 };
        let (sine, cosine) = (sign * im, sign * re);
        let turn = small(PI * offset / length);
        let (mut own, mut image) = ([[0.0; 2]; WIDTH], [[0.0; 2]; WIDTH]);
        let bins = own.iter_mut().zip(&mut image).zip(used).zip(across);
        for (i, (((own, image), &used), across)) in Window::places().zip(bins) {
            if used == 0.0 {
                continue;
            }
            let parity = if i & 1 == 0 { 1.0 } else { -1.0 };
            let (sine, cosine) = (parity * sine, parity * cosine);
            let x = offset - i as f32;
            *own = if x.abs() < NEAREST {
                nearest(x, length)
            } else {
                kernel(small(PI * x / length), sine, cosine, length)
            };
            if !iq {
                *image = kernel(turn * across, sine, cosine, length);
            }
        }
        Self { own, image }
    }

    /// The columns of the fit: of the strength along a phase, of the strength a quarter turn on, and of the frequency for a line of this
    /// strength.
    pub fn columns_along(&self, unit: Complex<f32>, value: Complex<f32>) -> [Shape; 3] {
        let [mut along, mut across, mut slope] = [NOTHING; 3];
        let columns = along.iter_mut().zip(&mut across).zip(&mut slope);
        for (((along, across), slope), (own, image)) in
            columns.zip(self.own.iter().zip(&self.image))
        {
            let (&[own, own_slope], &[image, image_slope]) = (own, image);
            let (own, image) = (unit * own, unit.conj() * image);
            *along = own + image;
            *across = quarter(own - image);
            *slope = value * own_slope + value.conj() * image_slope;
        }
        [along, across, slope]
    }

    /// The columns of the fit, for the strength's real and imaginary part.
    pub fn columns(&self, value: Complex<f32>) -> [Shape; 3] {
        self.columns_along(Complex::new(1.0, 0.0), value)
    }
}

/// Nearer to its bin than this a line's quotients have too few digits.
const NEAREST: f32 = 0.02;

/// `D(x) / N` and its slope at small x, by their series.
fn nearest(x: f32, n: f32) -> [f32; 2] {
    let (z, less) = (PI * PI * x * x, 1.0 - 1.0 / (n * n));
    [1.0 - z * less / 6.0, -PI * PI * x / 3.0 * less * (1.0 - z / 10.0)]
}

/// `D(x) / N` and its slope from cosine and sine of `pi x / N`, and from sine and cosine of `pi x`.
fn kernel(angle: Complex<f32>, sine: f32, cosine: f32, n: f32) -> [f32; 2] {
    let over = 1.0 / (n * angle.im);
    let value = sine * over;
    [value, PI * over * (cosine - value * angle.re)]
}

/// Cosine and sine of an angle up to a quarter turn, with all digits of a small sine.
pub fn small(angle: f32) -> Complex<f32> {
    let half = 0.5 * angle;
    let z = half * half;
    let (sine, cosine) = (half * sinc(z), cosine(z));
    Complex::new(1.0 - 2.0 * sine * sine, 2.0 * sine * cosine)
}

/// The columns of a tone's changes of order p, in amplitude and in phase: Legendre's polynomials of time, which have spherical Bessel
/// functions as bins. `c j^p j_p(pi (f - k))` and the image's `conj(c) j^p j_p(-pi (f + k))`. A change that has a place among the columns
/// is put there.
///
/// The function also adds the changes' parts to the tone's own columns: to its strength and its turn the part that turns with the tone, to
/// its frequency the change for one more bin: `j_p' = (p j_(p-1) - (p + 1) j_(p+1)) / (2 p + 1)`. `values` are the changes' sizes.
pub fn changes<const P: usize>(
    window: &Window,
    tone: &Line,
    [levels, angles]: &[[f32; P]; 2],
    columns: &mut [Shape],
    places: &[[Option<usize>; P]; 2],
    [turn, slope]: [&mut Shape; 2],
) {
    let (length, half) = (window.n as f32, 0.5 * window.n as f32);
    let Complex { re, im } = f32::unit(0.5 * tone.offset);
    let Line { offset, value } = *tone;
    let over = 1.0 / value.norm_sqr().root().max(1e-30);
    let [level_places, angle_places] = places;
    for ((bin, i), (turn, slope)) in Window::places().enumerate().zip(turn.iter_mut().zip(slope)) {
        if window.used.get(bin) != Some(&1.0) {
            continue;
        }
        let parity = if i & 1 == 0 { 1.0 } else { -1.0 };
        let (sine, cosine) = (parity * im, parity * re);
        let own = orders(PI * (offset - i as f32), sine, cosine);
        let across = offset + (window.peak.wrapping_mul(2).wrapping_add(i)) as f32;
        let (across, wrap) = if across > half { (across - length, -1.0) } else { (across, 1.0) };
        let image = if window.iq { [0.0; ORDERS + 1] } else { orders(-PI * across, -sine, cosine) };
        let sizes = levels.iter().zip(angles).zip(level_places.iter().zip(angle_places));
        let orders = own.array_windows().zip(image.array_windows()).zip(1..);
        for (((level, angle), (level_place, angle_place)), ((own, image), p)) in sizes.zip(orders) {
            let (&[own_below, own, own_above], &[below, image, above]) = (own, image);
            let (line, mirror) = (turned(value, p), turned(value.conj(), p) * wrap);
            let derivative = |below: f32, above: f32| {
                let p = p as f32;
                PI * (p * below - (p + 1.0) * above) / (2.0 * p + 1.0)
            };
            let (own_slope, slope_back) =
                (line * derivative(own_below, own_above), mirror * -derivative(below, above));
            let (own, image) = (line * own, mirror * image);
            let (amplitude, phase) = (own + image, quarter(own - image));
            *turn += (phase * *level - amplitude * *angle) * over;
            *slope += (own_slope + slope_back) * *level + quarter(own_slope - slope_back) * *angle;
            for (place, value) in [(level_place, amplitude), (angle_place, phase)] {
                let column = place.and_then(|place| columns.get_mut(place));
                if let Some(cell) = column.and_then(|column| column.get_mut(bin)) {
                    *cell = value;
                }
            }
        }
    }
}
