//! The normal equations of [`super::super::real`] for cores without an FPU.
//!
//! V is not summed: as `u h = p (h - 1)`, its share follows from the sums of `h Re`, `h' Re` and
//! Re.

use super::scaled::Scaled;
use num_complex::Complex;
use num_traits::One as _;

/// The sums over the bins beside the peak that change with p. They are the sums of the float fit, except `r2 = sum h s Im` and
/// `q2 = sum h' s Im`.
pub(super) struct Sums {
    pub aa: Scaled,
    pub s1: Scaled,
    pub bb: Scaled,
    pub dd: Scaled,
    pub r1: Scaled,
    pub r2: Scaled,
    pub q1: Scaled,
    pub q2: Scaled,
}

/// The inputs of the equations beside the sums.
pub(super) struct Place {
    pub e: Scaled,
    pub twice_c: Scaled,
    /// The peak's bin.
    pub centre: Complex<Scaled>,
    /// The sum of the real parts of the bins beside it.
    pub total: Scaled,
}

/// One evaluation of the normal equations at an offset.
pub(super) struct Step {
    /// The step, in units of p.
    pub forward: Scaled,
    pub information: Scaled,
    pub line: Complex<Scaled>,
    /// The slope of `line` over p.
    pub slope: Complex<Scaled>,
}

impl Place {
    /// Evaluates the equations from the sums at p.
    pub fn step(&self, p: Scaled, sums: Sums) -> Step {
        let Sums { aa, s1, bb, dd, r1, r2, q1, q2 } = sums;
        let (e, c2, lean, rest) = (self.e, self.twice_c, self.e * p, s1 - bb);
        // The data along the basis (1, 0) h and (-e u, s) h; e u h is e p (h - 1), and its
        // derivative by p follows.
        let beyond = r1 - self.total;
        let (r2, q2) = (r2 - lean * beyond, q2 - e * (beyond + p * q1));
        // The peak itself: h = 1, h' = 0.
        let (aa, r1, r2) = (aa + Scaled::one(), r1 + self.centre.re, r2 + self.centre.im);
        // Inner products of the basis, and the line by elimination.
        let ps = p * s1;
        let g12 = lean * ps;
        let inverse = Scaled::one() / aa;
        let share = g12 * inverse;
        let second = Scaled::one() / (aa - c2 * (p * ps) - share * g12);
        let b = (r2 - share * r1) * second;
        let a = (r1 - g12 * b) * inverse;
        // Products of the model's derivative with the basis, with itself and with the data.
        let (cb, pr) = (c2 * b, p * rest);
        let b2 = e * pr;
        let x1 = a * bb + b * b2;
        let x2 = a * b2 + b * bb - cb * pr;
        let own = (a * a + b * b) * dd + b * (rest - p * dd) * ((e + e) * a - cb);
        let slope2 = (x2 - share * x1) * second;
        let slope1 = (x1 - g12 * slope2) * inverse;
        let information = own - (x1 * slope1 + x2 * slope2);
        Step {
            forward: (a * (q1 - x1) + b * (q2 - x2)) / information,
            information,
            line: Complex::new(a, b),
            slope: Complex::new(-slope1, -slope2),
        }
    }
}
