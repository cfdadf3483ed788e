//! Spherical Bessel functions: Legendre's polynomials as the bins show them.
//!
//! Small arguments use the power series, large ones the recurrence `j_(p+1) = (2 p + 1)/x j_p - j_(p-1)` upwards, and those between the
//! recurrence downwards from a high order (Miller's algorithm; Abramowitz and Stegun 1964, 10.5).

use super::constants::{ORDERS, P};

/// Below the first limit the power series is used, up to the next limit the recurrence from high orders down, which forgets its start.
const SERIES: f32 = 1.0;
const DOWN: f32 = 9.0;

/// `j_p(x)` for p from 0 on, given sine and cosine of x.
#[inline(always)]
pub fn orders(x: f32, sine: f32, cosine: f32, values: &mut [f32; P]) {
    let size = x.abs();
    if size < SERIES {
        series(x, values);
    } else if size < DOWN {
        down(x, sine, cosine, values);
    } else {
        up(x, sine, cosine, values);
    }
}

/// `x^p / (2 p + 1)!! (1 - z/(1 (2 p + 3)) (1 - z/(2 (2 p + 5)) ...))` with `z = x^2 / 2`.
#[inline(never)]
fn series(x: f32, values: &mut [f32; P]) {
    /// The reciprocals of odd numbers from 1 on.
    const OVER: [f32; P + 4] = {
        let (mut over, mut p) = ([0.0; P + 4], 0);
        while p < P + 4 {
            // At compile time an index out of range would not compile.
            #[allow(clippy::indexing_slicing)]
            {
                over[p] = 1.0 / (2 * p + 1) as f32;
            }
            p += 1;
        }
        over
    };
    let z = 0.5 * x * x;
    let mut power = 1.0;
    for (value, [own, first, second, third, fourth]) in values.iter_mut().zip(OVER.array_windows())
    {
        power *= own;
        let rest = 1.0 - z * (1.0 / 3.0) * third * (1.0 - z * 0.25 * fourth);
        *value = power * (1.0 - z * first * (1.0 - z * 0.5 * second * rest));
        power *= x;
    }
}

/// `j_(p+1) = (2 p + 1)/x j_p - j_(p-1)`: stable where x exceeds the order.
#[inline(always)]
fn up(x: f32, sine: f32, cosine: f32, values: &mut [f32; P]) {
    let over = 1.0 / x;
    let (mut last, mut this, mut odd) = (cosine * over, sine * over, over);
    for value in values {
        *value = this;
        (this, last) = (odd * this - last, this);
        odd += 2.0 * over;
    }
}

/// The recurrence downwards (Miller), scaled by the larger of orders 0 and 1.
#[inline(never)]
fn down(x: f32, sine: f32, cosine: f32, values: &mut [f32; P]) {
    /// Orders above 9 that make the recurrence's start negligible.
    const BEGIN: i32 = 20;
    let over = 1.0 / x;
    let (mut above, mut this) = (0.0, 1e-20);
    for p in (ORDERS as i32 + 1..=BEGIN).rev() {
        (this, above) = ((2 * p + 1) as f32 * over * this - above, this);
    }
    let mut p = ORDERS as i32;
    for value in values.iter_mut().rev() {
        *value = this;
        (this, above) = ((2 * p + 1) as f32 * over * this - above, this);
        p -= 1;
    }
    let [zeroth, first, ..] = *values;
    let zero = sine * over;
    let one = (zero - cosine) * over;
    let scale = if zero.abs() > one.abs() { zero / zeroth } else { one / first };
    values.iter_mut().for_each(|value| *value *= scale);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compared with the definition's closed forms upwards in double precision, and with ten terms of the series where these lose digits.
    #[test]
    fn every_order_everywhere() {
        for i in -2000..=2000 {
            let x = f64::from(i) * 0.03 + 1e-3;
            let (sine, cosine) = (libm::sin(x), libm::cos(x));
            let mut values = [0.0; P];
            orders(x as f32, sine as f32, cosine as f32, &mut values);
            for (p, value) in values.iter().enumerate() {
                let (mut term, mut sum) = (1.0, 0.0);
                for q in 1..=p {
                    term *= x / (2 * q + 1) as f64;
                }
                for m in 1..150 {
                    sum += term;
                    term *= -0.5 * x * x / (f64::from(m) * (2 * p + 2 * m as usize + 1) as f64);
                }
                if x.abs() < 20.0 {
                    assert!((f64::from(*value) - sum).abs() < 1e-5, "{x} {p}: {value} {sum}");
                }
            }
            if x.abs() >= 20.0 {
                let (zero, one) = (sine / x, (sine / x - cosine) / x);
                let two = 3.0 / x * one - zero;
                let three = 5.0 / x * two - one;
                let four = 7.0 / x * three - two;
                for (value, exact) in values.iter().zip([zero, one, two, three, four]) {
                    assert!((f64::from(*value) - exact).abs() < 2e-6, "{x}: {value} {exact}");
                }
            }
        }
    }
}
