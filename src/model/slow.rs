//! Slow terms, which leak into a real tone's bins: a drift, and hum of less than two cycles in the record.
//!
//! With `t = pi k / N`, in the record's middle, a straight line has the bins `j (-1)^k / sin t`, a parabola `(-1)^k cos t / sin^2 t`, and
//! any other slow term, far from its own bins, nearly `j (-1)^k / sin^3 t`.

use super::constants::{SLOW_TO, WIDTH};
use super::shape::{NOTHING, Shape, dot};
use super::window::Window;
use crate::math::scalar::Scalar as _;
use crate::math::series::circle;
use num_complex::Complex;

/// The number of terms.
pub const TERMS: usize = 3;

/// Whether slow terms can matter.
pub fn matter(window: &Window) -> bool {
    !window.iq && window.peak <= SLOW_TO
}

/// The terms' bins, each of length 1.
pub fn columns(window: &Window) -> [Shape; TERMS] {
    let mut columns = [NOTHING; TERMS];
    let length = (window.n as i32).saturating_mul(2);
    let near = 8.0 * core::f32::consts::PI / window.n as f32;
    for (place, i) in Window::places().enumerate().take(WIDTH) {
        if window.used.get(place) != Some(&1.0) {
            continue;
        }
        let k = window.peak.wrapping_add(i);
        let turn = circle::<f32>(k, length);
        let sign = if k & 1 == 0 { 1.0 } else { -1.0 };
        // The quotient is about 1 at bin 8.
        let over = near / turn.im;
        let line = Complex::new(0.0, sign * over);
        let values = [line, Complex::new(sign * turn.re * over * over, 0.0), line * (over * over)];
        for (column, value) in columns.iter_mut().zip(values) {
            if let Some(cell) = column.get_mut(place) {
                *cell = value;
            }
        }
    }
    columns.map(|column| {
        let over = 1.0 / dot(&column, &column).max(1e-30).root();
        column.map(|value| value * over)
    })
}
