//! Leakage of lines beyond the window.

use super::constants::{LEAKS, REACH};
use super::shape::{NOTHING, Shape};
use super::window::Window;

/// The number of real parameters of the leakage.
pub const TERMS: usize = 2 * LEAKS.len();

/// The bins of the principal components: a real and an imaginary column of each order.
pub fn columns(window: &Window) -> [Shape; TERMS] {
    let mut columns = [NOTHING; TERMS];
    let pairs = columns.as_chunks_mut::<2>().0;
    for (order, ([real, imaginary], component)) in pairs.iter_mut().zip(&LEAKS).enumerate() {
        let cells = real.iter_mut().zip(imaginary).zip(&window.used);
        for (((real, imaginary), used), i) in cells.zip(Window::places()) {
            let distance = (i.unsigned_abs() as usize).min(REACH);
            let size = component.get(distance).copied().unwrap_or(0.0) * used;
            let size = if order % 2 == 1 && i < 0 { -size } else { size };
            (real.re, imaginary.im) = (size, size);
        }
    }
    columns
}
