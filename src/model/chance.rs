//! The frequency of chance events in noise alone.

use crate::math::scalar::{Scalar as _, larger};

/// The ratio of two mean squares, with these degrees of freedom, that noise exceeds as often as a normal number exceeds `deviations`. The
/// ratio follows Fisher's distribution, whose cube root is nearly normal (Wilson and Hilferty 1931).
pub fn ratio(deviations: f32, free: f32, noise: f32) -> f32 {
    let (a, b) = (2.0 / (9.0 * free), 2.0 / (9.0 * noise));
    let (mean, other, square) = (1.0 - a, 1.0 - b, deviations * deviations);
    let below = other * other - square * b;
    let inside = a * other * other + b * mean * mean - a * b * square;
    let root = (mean * other + deviations * larger(inside, 0.0).root()) / below;
    if below > 0.0 { root * root * root } else { f32::INFINITY }
}

#[cfg(test)]
mod tests {
    #[test]
    fn quantiles_of_fishers() {
        for (deviations, free, noise, exact) in [
            (5.026, 5.0, 52.0, 11.145),
            (5.026, 63.0, 52.0, 4.138),
            (3.291, 31.0, 52.0, 2.803),
            (1.534, 5.0, 52.0, 2.260),
        ] {
            let limit = super::ratio(deviations, free, noise);
            assert!((0.98 * exact..1.06 * exact).contains(&limit), "{free} {noise}: {limit}");
        }
    }
}
