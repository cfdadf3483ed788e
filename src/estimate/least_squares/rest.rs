//! What a fit leaves near the line, at several scales and along the ways in which a tone moves.
//!
//! A tone whose amplitude or phase follows a polynomial in time over the record, Legendre's of order p, has besides its line c
//! the bins `c (-1)^i j^p j_p(x)` with spherical Bessel functions of `x = pi (d - i)`, which are orthogonal to one another. What
//! is along their real part is amplitude, along their imaginary part phase. Orders 0 and the phase of order 1, a frequency, are
//! fitted; what a tone's movement leaves is in the five directions above those, and the noise has no more in them than anywhere.
//!
//! `(-1)^i j_p` is a polynomial in `1/x` whose coefficients are the sine and the cosine of `pi d`: the four moments of the rest
//! over the bins, weighted with powers of `1/x`, hold all three orders.
//!
//! A phase that is not small has a square: of b times Legendre's second polynomial, P2, that is, as
//! `P2^2 = 1/5 + 2/7 P2 + 18/35 P4`, an amplitude of -b^2/7 of order 2, which is no change of the tone's, and -9/35 b^2 of order 4.

use crate::math::scalar::Scalar;
use crate::math::series::cosine;
use core::f64::consts::PI;
use num_complex::Complex;

/// Bins on each side that are looked at.
pub(super) const NEAR: usize = 8;

/// What a fit leaves near its line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest<T> {
    /// The power in the bins up to 2, 4 and 8 from the peak, in squared codes.
    pub within: [T; 3],
    /// The part of it along changes of the amplitude, of order 1 to 3.
    pub amplitude: [T; 3],
    /// The part of it along changes of the phase, of order 2 and 3.
    pub phase: [T; 2],
    /// The power that these changes have in the bins 9 to 16 from the peak.
    pub beyond: T,
    /// The power that a phase of order 2, where it is all, leaves in amplitudes of order 4: its square has some.
    pub fourth: T,
    /// By how many bins the frequency rises over the record.
    pub rate: T,
}

/// The sums over the bins, in the making. Bins come in the order of their distance.
#[derive(Clone, Copy)]
pub(super) struct Moments<T> {
    /// The power up to 2 bins from the peak, from there up to 4, and up to 8.
    pub within: [T; 3],
    /// Of powers 1 to 4 of `1 / (d - i)`, over the bins beside the peak.
    pub powers: [Complex<T>; 4],
}

impl<T: Scalar> Moments<T> {
    /// Of the peak's own bin alone.
    pub fn new(centre: Complex<T>) -> Self {
        let zero = Complex::new(T::zero(), T::zero());
        Self { within: [centre.norm_sqr(), T::zero(), T::zero()], powers: [zero; 4] }
    }

    /// Adds what is left i bins from the peak, within [`NEAR`]; `y = 1 / (d - i)`. Returns its power.
    #[inline(always)]
    pub fn add(&mut self, i: i32, y: T, left: Complex<T>) -> T {
        let power = left.norm_sqr();
        let [two, four, eight] = &mut self.within;
        match i.abs() {
            ..=2 => *two = *two + power,
            3..=4 => *four = *four + power,
            _ => *eight = *eight + power,
        }
        let square = y * y;
        for (sum, y) in self.powers.iter_mut().zip([y, square, square * y, square * square]) {
            *sum = *sum + left * y;
        }
        power
    }
}

impl<T: Scalar> Rest<T> {
    /// From the sums, the offset, the line, and what is left of the peak's own bin.
    #[inline(never)]
    pub(super) fn new(d: T, line: Complex<T>, centre: Complex<T>, moments: &Moments<T>) -> Self {
        let of = T::of;
        let x = d * of(PI);
        let z = x * x;
        // The angle is doubled twice.
        let cos = cosine(z * of(1.0 / 16.0));
        let cos = of(2.0) * cos * cos - T::one();
        let cos = of(2.0) * cos * cos - T::one();
        let first = series(z, [10.0, 28.0, 54.0]) * x * of(1.0 / 3.0);
        let second = series(z, [14.0, 36.0, 66.0]) * z * of(1.0 / 15.0);
        let third = series(z, [18.0, 44.0, 78.0]) * z * x * of(1.0 / 105.0);
        // sin x = x j0, and j2 = 3 j1/x - j0.
        let sin = x * (series(z, [10.0, 28.0, 54.0]) - second);
        let [m1, m2, m3, m4] = moments.powers;
        const Y: f64 = 1.0 / PI;
        let (a, b, c, e) = (Y, Y * Y, Y * Y * Y, Y * Y * Y * Y);
        let along = [
            m2 * (sin * of(b)) - m1 * (cos * of(a)) + centre * first,
            m3 * (sin * of(3.0 * c)) - m2 * (cos * of(3.0 * b)) - m1 * (sin * of(a))
                + centre * second,
            m4 * (sin * of(15.0 * e)) - m3 * (cos * of(15.0 * c)) - m2 * (sin * of(6.0 * b))
                + m1 * (cos * of(a))
                + centre * third,
        ];
        // The squares of the functions sum to 1/3, 1/5, 1/7 over all bins; beyond those that are read they are sine or cosine
        // over x.
        let (far, sin2, cos2) = (of(0.0238), sin * sin, cos * cos);
        let [n1, n2, n3] =
            [of(1.0 / 3.0) - far * cos2, of(1.0 / 5.0) - far * sin2, of(1.0 / 7.0) - far * cos2];
        // Against the line's own direction; order 1 and 3 are a quarter turn on. A component is a share of the line.
        let size = line.norm_sqr();
        let back = line.conj() * (T::one() / size);
        let [a1, a2, a3] = along;
        let [w1, w2, w3] = [(a1, n1), (a2, n2), (a3, n3)].map(|(a, n)| back * a * (T::one() / n));
        let bent = w2.im * w2.im;
        let level = bent * of(1.0 / 7.0) - w2.re;
        let [p1, p2, p3] = [n1, n2, n3].map(|n| n * size);
        let amplitude = [w1.im * w1.im * p1, level * level * p2, w3.im * w3.im * p3];
        let phase = [bent * p2, w3.re * w3.re * p3];
        // From 9 to 16 bins off there is half of what is beyond 8.
        let outside = far * of(0.485) * size;
        let odd = w1.im * w1.im + w3.im * w3.im + w3.re * w3.re;
        let [two, four, eight] = moments.within;
        let four = two + four;
        Rest {
            within: [two, four, four + eight],
            amplitude,
            phase,
            beyond: outside * (odd * cos2 + (bent + level * level) * sin2),
            fourth: bent * bent * size * of(81.0 / 1225.0 / 9.0),
            rate: -w2.im * of(6.0 / PI),
        }
    }
}

/// `1 - z/a (1 - z/b (1 - z/c))`.
fn series<T: Scalar>(z: T, [a, b, c]: [f64; 3]) -> T {
    let last = T::one() - z * T::of(1.0 / c);
    T::one() - z * T::of(1.0 / a) * (T::one() - z * T::of(1.0 / b) * last)
}
