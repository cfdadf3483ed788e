//! The real columns of a fit: a line, its mirror image, and the orders of an envelope.
//!
//! With `D(x) = sin(pi x) / sin(pi x / N)` a tone at f of amplitude c, in the middle of the record, has the bins `c D(f - k) / N`, and a
//! real tone also `conj(c) D(f + k) / N`. So c is the line's strength: nearly the root of the power in all its bins.
//!
//! A tone that changes has the envelope `sum e_p Q_p` along unit Legendre functions of time, and so the bins
//! `sum e_p j^p sqrt(2 p + 1) j_p(pi (f - k))` with spherical Bessel functions. Envelopes here are the numbers `c_p = j^p e_p`, whose columns
//! are real. The columns of order 0 and 1 are the line's own and its slope, which are exact for short records, too.

use super::bessel::orders;
use super::constants::{LENGTHS, P, REACH, WIDTH};
use super::shape::Column;
use super::window::Window;
use crate::math::scalar::Scalar as _;
use core::f32::consts::PI;
use num_complex::Complex;

/// In each bin a line of strength 1, and its change for one more bin of frequency.
pub type Line = [[f32; 2]; WIDTH];

/// In each bin an envelope's orders.
pub type Envelopes = [[f32; P]; WIDTH];

/// A line nearer to its bin than this uses a series: the quotients would lose digits.
const NEAREST: f32 = 0.02;

/// Sine and cosine of pi times an offset. A small sine keeps its relative precision.
fn sine_cosine(offset: f32) -> [f32; 2] {
    let whole = libm::roundf(offset);
    let Complex { re, im } = f32::unit(0.5 * (offset - whole));
    if whole as i32 & 1 == 0 { [im, re] } else { [-im, -re] }
}

/// Sine over angle, and cosine, of an angle up to a quarter turn by its square.
#[inline(always)]
fn circle(z: f32) -> [f32; 2] {
    let sine = 1.0 - z * (1.0 / 6.0) * (1.0 - z * (1.0 / 20.0) * (1.0 - z * (1.0 / 42.0)));
    let cosine = 1.0 - z * 0.5 * (1.0 - z * (1.0 / 12.0) * (1.0 - z * (1.0 / 30.0)));
    // A short record's window is half its spectrum.
    if z < 0.16 {
        return [sine, cosine];
    }
    let (sixth, eighth) = (z * z * z * z * (1.0 / 362_880.0), z * z * z * z * (1.0 / 40_320.0));
    [sine + sixth * (1.0 - z * (1.0 / 110.0)), cosine + eighth * (1.0 - z * (1.0 / 90.0))]
}

/// A line at `offset` bins from the window's peak.
#[inline(never)]
pub fn line(window: &Window, offset: f32, columns: &mut Line) {
    let unit = PI / window.n as f32;
    let [mut sine, mut cosine] = sine_cosine(offset);
    let mut x = offset + REACH as f32;
    for ([value, slope], used) in columns.iter_mut().zip(&window.used) {
        let angle = unit * x;
        let [sinc, turn] = circle(angle * angle);
        let over = used / (PI * x * sinc + 1e-12);
        *value = sine * over;
        *slope = PI * over * (cosine - *value * turn);
        (sine, cosine) = (-sine, -cosine);
        x -= 1.0;
    }
    let nearest = libm::roundf(offset);
    let (x, place) = (offset - nearest, nearest as i32 + REACH as i32);
    if x.abs() < NEAREST
        && let Some(cell) = columns.get_mut(place as usize)
        && window.used.get(place as usize) == Some(&1.0)
    {
        let (z, less) = (PI * PI * x * x, 1.0 - 1.0 / (window.n as f32 * window.n as f32));
        *cell = [1.0 - z * less / 6.0, -PI * PI * x / 3.0 * less * (1.0 - z / 10.0)];
    }
}

/// A drift of an I/Q record's mean, without the bin at 0 Hz, which is not used. A straight drift has `1 / k` in bin k, a bent one `1 / k^2`.
pub fn slow(window: &Window, columns: &mut Line) {
    for ((cell, i), used) in columns.iter_mut().zip(Window::places()).zip(&window.used) {
        let k = window.peak.wrapping_add(i);
        let over = if k == 0 { 0.0 } else { used / k as f32 };
        let square = over * over;
        *cell = if k & 1 == 0 { [over, square] } else { [-over, -square] };
    }
}

/// The mirror image of a real line at `offset` bins from the window's peak.
#[inline(never)]
pub fn image(window: &Window, offset: f32, column: &mut Column) {
    let n = window.n as f32;
    let [mut sine, _] = sine_cosine(offset);
    let turn = small(PI * offset / n);
    for ((value, used), across) in column.iter_mut().zip(&window.used).zip(&window.across) {
        let height = turn.re * across.im + turn.im * across.re;
        *value = sine * used / (n * height + (1.0 - used));
        sine = -sine;
    }
}

/// Cosine and sine of an angle up to a quarter turn. A small sine keeps its relative precision.
fn small(angle: f32) -> Complex<f32> {
    let half = 0.5 * angle;
    let [sinc, cosine] = circle(half * half);
    let sine = half * sinc;
    Complex::new(1.0 - 2.0 * sine * sine, 2.0 * sine * cosine)
}

/// The orders of an envelope at `offset` bins from the window's peak.
#[inline(never)]
pub fn envelopes(window: &Window, offset: f32, rows: &mut Envelopes) {
    let mut own = [[0.0; 2]; WIDTH];
    line(window, offset, &mut own);
    let [mut sine, mut cosine] = sine_cosine(offset);
    let mut x = PI * (offset + REACH as f32);
    for (row, [value, slope]) in rows.iter_mut().zip(own) {
        orders(x, sine, cosine, row);
        row.iter_mut().zip(LENGTHS).for_each(|(cell, length)| *cell *= length);
        let [zeroth, first, ..] = row;
        (*zeroth, *first) = (value, -slope * (LENGTHS[1] / PI));
        (sine, cosine) = (-sine, -cosine);
        x -= PI;
    }
    blank(window, rows);
}

/// The mirror image of these orders: an envelope c has `conj(c)` times them.
#[inline(never)]
pub fn images(window: &Window, offset: f32, rows: &mut Envelopes) {
    let (length, half) = (window.n as f32, 0.5 * window.n as f32);
    let [mut sine, mut cosine] = sine_cosine(offset);
    let mut own = [0.0; WIDTH];
    image(window, offset, &mut own);
    for ((i, row), value) in Window::places().zip(rows.iter_mut()).zip(own) {
        let across = offset + (window.peak.wrapping_mul(2).wrapping_add(i)) as f32;
        let (across, wrap) = if across > half { (across - length, -1.0) } else { (across, 1.0) };
        orders(PI * across, sine, cosine, row);
        row.iter_mut().zip(LENGTHS).for_each(|(cell, length)| *cell *= length * wrap);
        let [zeroth, ..] = row;
        *zeroth = value;
        (sine, cosine) = (-sine, -cosine);
    }
    blank(window, rows);
}

/// Clears the bins that are not used.
fn blank(window: &Window, rows: &mut Envelopes) {
    for (row, used) in rows.iter_mut().zip(&window.used) {
        if *used == 0.0 {
            *row = [0.0; P];
        }
    }
}

/// The envelope of a line of strength 1 at `x` bins from the reference: `(-1)^p sqrt(2 p + 1) j_p(pi x)`.
pub fn line_envelope(x: f32) -> [f32; P] {
    let [sine, cosine] = sine_cosine(x);
    let mut values = [0.0; P];
    orders(PI * x, sine, cosine, &mut values);
    let mut sign = 1.0;
    for (value, length) in values.iter_mut().zip(LENGTHS) {
        *value *= length * sign;
        sign = -sign;
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    /// Against the quotient that defines it, and its difference quotient.
    #[test]
    fn a_lines_column_is_the_kernel_and_its_slope() {
        for (n, peak) in [(64, 20), (256, 100), (1024, 300)] {
            let window = Window::new(n, true, peak, |_| Complex::new(0.0, 0.0));
            let kernel = |x: f64| {
                let n = n as f64;
                if x.abs() < 1e-9 { 1.0 } else { (PI * x).sin() / (PI * x / n).sin() / n }
            };
            for offset in [-7.3, -0.5, -0.01, 0.0, 0.019, 0.021, 0.4, 5.5, 12.25] {
                let mut columns = [[0.0; 2]; WIDTH];
                line(&window, offset as f32, &mut columns);
                for ([value, slope], i) in columns.into_iter().zip(Window::places()) {
                    let x = offset - f64::from(i);
                    let step = 1e-5;
                    let rise = (kernel(x + step) - kernel(x - step)) / (2.0 * step);
                    let off = [f64::from(value) - kernel(x), f64::from(slope) - rise];
                    // The slope is a difference of floats near 1, over an offset of .02 and more.
                    let [of_value, of_slope] = off.map(f64::abs);
                    assert!(of_value < 2e-5 && of_slope < 3e-4, "{n} {offset} {i}: {off:?}");
                }
            }
        }
    }
}
