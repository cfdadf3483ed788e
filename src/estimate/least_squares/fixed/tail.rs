//! How a tone's leakage falls away from it.

use super::{inverse, zeros};

/// `1 / (x (x^2 - 1))` in Q36 for x in Q25, |x| within 6..64, within 1/250 of itself.
pub(crate) fn tail(x: i32) -> i32 {
    let size = x.unsigned_abs().max(1 << 27);
    let room = zeros(size).wrapping_sub(1) & 3;
    // 1/x = inverse / 2^(36 - room), in Q16.
    let y = (inverse::of(size << room) >> (20 - room)) as i32;
    // 1/(x^2 - 1) = y^2 + y^4 + y^6, in Q20.
    let square = y.wrapping_mul(y);
    let (fine, coarse) = (square >> 12, square >> 16);
    let series = (1 << 10) + (coarse >> 6) + (coarse.wrapping_mul(coarse) >> 22);
    let tail = y.wrapping_mul(fine.wrapping_mul(series) >> 10);
    if x < 0 { -tail } else { tail }
}

#[cfg(test)]
mod tests {
    #[test]
    fn tails() {
        for step in 0..5700 {
            let x = 6.1 + f64::from(step) * 0.01;
            let exact = 1.0 / (x * (x * x - 1.0));
            let found = f64::from(super::tail((x * 2f64.powi(25)) as i32)) / 2f64.powi(36);
            assert!((found / exact - 1.0).abs() < 0.004, "{x}: {found} {exact}");
            assert_eq!(
                super::tail(-(x * 2f64.powi(25)) as i32),
                -super::tail((x * 2f64.powi(25)) as i32)
            );
        }
    }
}
