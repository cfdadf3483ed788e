//! The decay of a tone's leakage with the distance from the tone.

use super::{inverse, shifted, square, zeros};

/// `1 / (x (x^2 - 1))` in Q36 for x in Q25, |x| within 6..64.
pub(crate) fn tail(x: i32) -> i32 {
    let size = x.unsigned_abs().max(6 << 25).min(i32::MAX as u32);
    let room = zeros(size).wrapping_sub(1) & 3;
    // x = m / 2^(25 + room) with m within 2^30..2^31.
    let m = (size << room) as i32;
    // x^2 - 1, times 2^(18 + 2 room): below 2^30.
    let less = ((square(m) >> 32) as i32).wrapping_sub(1 << (18 + 2 * room));
    // x (x^2 - 1), times 2^(13 + 3 room): below 2^31.
    let cube = shifted::<30>(less, m) as u32;
    let up = zeros(cube | 1).wrapping_sub(1) & 31;
    // 2^61 / (cube 2^up).
    let inverse = inverse::of(cube << up);
    let down = 12u32.wrapping_sub(up).wrapping_sub(3 * room) & 31;
    let tail = (inverse >> down) as i32;
    if x < 0 { -tail } else { tail }
}

#[cfg(test)]
mod tests {
    #[test]
    fn tails() {
        for step in 0..5780 {
            let x = 6.1 + f64::from(step) * 0.01;
            let exact = 1.0 / (x * (x * x - 1.0));
            let fixed = (x * 2f64.powi(25)) as i32;
            let found = f64::from(super::tail(fixed)) / 2f64.powi(36);
            assert!((found / exact - 1.0).abs() < 1e-5, "{x}: {found} {exact}");
            assert_eq!(super::tail(-fixed), -super::tail(fixed));
        }
    }
}
