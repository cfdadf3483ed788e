//! Leakage of lines beyond the window.

use super::constants::{LEAKS, REACH};
use super::shape::{NOTHING, Shape};
use super::window::Window;

/// The number of real numbers that it has.
pub const TERMS: usize = 2 * LEAKS.len();

/// The bins of a principal component, of which there is a real and an imaginary one of each order.
pub fn column(window: &Window, term: usize) -> Shape {
    let (order, imaginary) = (term / 2, term % 2 == 1);
    let mut column = NOTHING;
    let Some(component) = LEAKS.get(order) else { return column };
    for (cell, (i, used)) in column.iter_mut().zip(Window::places().zip(&window.used)) {
        let distance = (i.unsigned_abs() as usize).min(REACH);
        let size = component.get(distance).copied().unwrap_or(0.0) * used;
        let size = if order % 2 == 1 && i < 0 { -size } else { size };
        if imaginary { cell.im = size } else { cell.re = size }
    }
    column
}
