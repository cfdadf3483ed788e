//! Angles and line shapes of the fits, from `+` and `*` alone: equal bits on every machine, and far cheaper on the target than a library's
//! functions.

use super::scalar::Scalar;
pub use super::scalar::{cosine, sinc};

/// Cosine (real part) and sine (imaginary part) of `2 pi k / n`, for any integers with `n > 0`.
///
/// The angle is folded in integers into an eighth of a turn, where eight terms are exact to 1e-16.
/// So a sine near 0 keeps the full relative precision of the type, which matters at low bins.
pub fn circle<T: Scalar>(k: i32, n: i32) -> num_complex::Complex<T> {
    let n = n.max(1);
    let k = k.checked_rem_euclid(n).unwrap_or(0);
    // Eight times k fits in 32 bits for every length in use; 64-bit numbers are slow on the target.
    let (quadrant, rest) = if n <= 1 << 27 {
        let quadrant = ((8 * k).checked_div(n).unwrap_or(0) + 1) / 2;
        // 4 k - quadrant n is four times the remaining angle, within -n/2..=n/2.
        (quadrant, 4 * k - quadrant * n)
    } else {
        let eighths = i64::from(k) * 8 / i64::from(n);
        let quadrant = (eighths + 1) / 2;
        (quadrant as i32, (4 * i64::from(k) - quadrant * i64::from(n)) as i32)
    };
    let x = T::from_i32(rest) * (T::new(core::f64::consts::FRAC_PI_2) / T::from_i32(n));
    let z = x * x;
    let (cos, sin) = (cosine(z), x * sinc(z));
    match quadrant {
        0 | 4 => num_complex::Complex::new(cos, sin),
        1 => num_complex::Complex::new(-sin, cos),
        2 => num_complex::Complex::new(-cos, -sin),
        _ => num_complex::Complex::new(sin, -cos),
    }
}

/// `sin(pi d) / (pi d)` for |d| < 1, by doubling the angle twice.
pub fn line_shape<T: Scalar>(d: T) -> T {
    let x = d * T::new(core::f64::consts::FRAC_PI_4);
    let cos = cosine(x * x);
    sinc(x * x) * cos * (T::new(2.0) * cos * cos - T::one())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_equal_the_library() {
        for n in [64, 100, 8192] {
            for k in -n..n {
                let turns = f64::from(k) / f64::from(n);
                let exact = f64::unit(turns);
                assert!((circle::<f64>(k, n) - exact).norm_sqr() < 1e-28, "{k}/{n}");
                let single = circle::<f32>(k, n);
                assert!((f64::from(single.re) - exact.re).abs() < 1.5e-7, "{k}/{n}");
                assert!((f64::from(single.im) - exact.im).abs() < 1.5e-7, "{k}/{n}");
            }
            let relative = f64::from(circle::<f32>(1, n).im) / f64::unit(1.0 / f64::from(n)).im;
            assert!((relative - 1.0).abs() < 2e-7);
        }
        for d in [-0.99, -0.5, 0.01, 0.3, 0.9] {
            let x = core::f64::consts::PI * d;
            assert!((line_shape(d) - libm::sin(x) / x).abs() < 1e-14);
        }
        assert_eq!(line_shape(0.0f32), 1.0);
    }
}
