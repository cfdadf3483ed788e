//! The normal equations of [`super::super::real`] for cores without an FPU.
//!
//! V is not summed: as `u h = p (h - 1)`, its share follows from the sums of `h Re`, `h' Re` and
//! Re.

use super::scaled::Scaled;
use crate::tone::fit::normal::{Products, Step};
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

impl Place {
    /// Evaluates the equations from the sums at p.
    pub fn step(&self, p: Scaled, sums: Sums) -> Step<Scaled> {
        let Sums { aa, s1, bb, dd, r1, r2, q1, q2 } = sums;
        let (e, c2, lean, rest) = (self.e, self.twice_c, self.e * p, s1 - bb);
        // The data along the basis (1, 0) h and (-e u, s) h; e u h is e p (h - 1), and its
        // derivative by p follows.
        let beyond = r1 - self.total;
        let (r2, q2) = (r2 - lean * beyond, q2 - e * (beyond + p * q1));
        // The peak itself: h = 1, h' = 0.
        let (aa, r1, r2) = (aa + Scaled::one(), r1 + self.centre.re, r2 + self.centre.im);
        let (ps, pr) = (p * s1, p * rest);
        let (b2, bent) = (e * pr, rest - p * dd);
        Products {
            g11: aa,
            g12: lean * ps,
            g22: aa - c2 * (p * ps),
            r: [r1, r2],
            b11: bb,
            b12: b2,
            b21: b2,
            b22: bb - c2 * pr,
            d11: dd,
            d12: e * bent,
            d22: dd - c2 * bent,
            q: [q1, q2],
        }
        .step()
    }
}
