//! How probable it is that noise looks like a target.
//!
//! The power of the target that fits best at a place of the map, over the noise's power, is exponential in noise. Over all places it is a
//! smooth field, and it exceeds a level x as often as the mean Euler characteristic of the places above x says (Adler and Taylor 2007,
//! *Random Fields and Geometry*, chapter 15): for each cell
//!
//! ```text
//! (pi / 3) (x - 1/2) exp(-x)
//! ```
//!
//! because the variance of the time within a record, and within a frame, is a twelfth of its square. The map is a cylinder, closed over the
//! rows, so its two ends add `sqrt(pi x / 3) exp(-x)` for each row. The noise is a mean of `F` cells, over which `exp(-x)` becomes
//! `(1 + x / F)^-F`.

use core::f32::consts::FRAC_PI_3;

/// The natural logarithm of the probability that noise exceeds this power, in units of the noise, somewhere among these cells.
#[inline(never)] // once in an image
pub(super) fn ln_chance(power: f32, cells: f32, rows: f32, noise_cells: f32) -> f32 {
    if power <= 1.0 {
        return 0.0;
    }
    let held = power / (1.0 + power / noise_cells);
    let places = cells * FRAC_PI_3 * (held - 0.5).max(0.5) + rows * libm::sqrtf(FRAC_PI_3 * held);
    (libm::logf(places) - noise_cells * libm::log1pf(power / noise_cells)).min(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_far_above_the_noise_is_no_chance() {
        let chance = |power| ln_chance(power, 8192.0, 64.0, 240.0);
        assert_eq!(chance(0.5), 0.0);
        // One in a million frames of 8192 cells.
        assert!((chance(26.6 + 26.6 * 26.6 / 480.0) + 13.8).abs() < 0.6, "{}", chance(28.0));
        assert!(chance(100.0) < -60.0 && chance(1e6) < -1000.0);
    }
}
