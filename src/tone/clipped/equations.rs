//! The normal equations of a clipped tone, summed in integers.
//!
//! Sums of the tone alone are in Q20, sums with a sample in Q3: at most 2^30 for 1,000 samples of 16 bits.

use super::carrier::Turned;
use crate::tone::fit::fixed::scaled::Scaled;
use crate::tone::fit::fixed::{inverted, shifted, times};
use core::f32::consts::PI;
use num_traits::One as _;

/// An offset in bins and its information: the noise power of a part divided by it is the offset's variance.
#[derive(Clone, Copy)]
pub(super) struct Found {
    pub offset: f32,
    pub information: f32,
}

impl Found {
    /// The result of two parts.
    pub fn and(self, other: Self) -> Self {
        let information = self.information + other.information;
        let sum = self.offset * self.information + other.offset * other.information;
        Self { offset: sum / information, information }
    }
}

/// The normal equations for m, a, b and -pi A d: sums of products of 1, c, s, w s and the rest r of
/// a sample.
pub(super) struct Equations {
    amplitude: i32,
    count: i32,
    /// c, s, ws, r, cc, cs, wcs, rc, ss, wss, rs, wwss, wrs.
    sums: [i32; 13],
}

impl Equations {
    /// Equations without a sample. The amplitude is in codes, at least 1.
    pub fn new(amplitude: i32) -> Self {
        Self { amplitude, count: 0, sums: [0; 13] }
    }

    /// Adds a block whose middle is at `w`, in Q16.
    pub fn add(&mut self, block: &Turned, w: i32) {
        let &Turned { count, c, s, cc, cs, ss, y, yc, ys } = block;
        let rest = |y: i32, x: i32| y.wrapping_sub(shifted::<17>(x, self.amplitude));
        let weighted = |x: i32| product(w << 14, x);
        let (r, rc, rs, wss) = (rest(y, c), rest(yc, cc), rest(ys, cs), weighted(ss));
        let (ws, wcs, wwss, wrs) = (weighted(s), weighted(cs), weighted(wss), weighted(rs));
        let block = [c, s, ws, r, cc, cs, wcs, rc, ss, wss, rs, wwss, wrs];
        for (sum, x) in self.sums.iter_mut().zip(block) {
            *sum = sum.wrapping_add(x);
        }
        self.count = self.count.wrapping_add(count);
    }

    /// Solves the equations by elimination of m, a and b.
    pub fn solved(&self) -> Found {
        /// With a smaller pivot the unknown is not determined: a millionth of a sample's square, in Q30.
        const LEAST: i32 = 1074;
        /// From the rest's Q13 to Q30.
        const CODES: i32 = 17;
        // Means over the samples: in Q30, or in Q13 with the rest.
        let (inverse, up) = inverted(self.count.max(1) as u32);
        let mut means = self.sums;
        for sum in &mut means {
            *sum = product(inverse, *sum << (up & 31));
        }
        let [c, s, ws, r, cc, cs, wcs, rc, ss, wss, rs, wwss, wrs] = means;
        // With m eliminated.
        let less = |sum: i32, a: i32, b: i32| sum.wrapping_sub(product(a, b));
        let tone = |sum: i32, a: i32, b: i32| Scaled::new(less(sum, a, b), 0);
        let rest = |sum: i32, a: i32| Scaled::new(less(sum, a, r), CODES);
        let pivot = |x: i32| Scaled::new(x.max(LEAST), 0);
        let (cs, wcs, rc) = (tone(cs, c, s), tone(wcs, c, ws), rest(rc, c));
        let by_cc = Scaled::one() / pivot(less(cc, c, c));
        let (by_cs, by_wcs) = (cs * by_cc, wcs * by_cc);
        // With a eliminated.
        let by_ss = Scaled::one() / pivot((tone(ss, s, s) - by_cs * cs).bits(0));
        let (wss, rs) = (tone(wss, s, ws) - by_cs * wcs, rest(rs, s) - by_cs * rc);
        let by_wss = wss * by_ss;
        let wwss = pivot((tone(wwss, ws, ws) - by_wcs * wcs - by_wss * wss).bits(0));
        let d = (rest(wrs, ws) - by_wcs * rc - by_wss * rs) / wwss;
        let b = (rs - wss * d) * by_ss;
        let a = (rc - cs * b - wcs * d) * by_cc;
        // Without the rails the tone is stronger.
        let amplitude = Scaled::new((self.amplitude << 8).saturating_add(a.bits(8).max(0)), -8);
        let count = Scaled::new(self.count.max(1), -30);
        let information = (wwss * count * amplitude * amplitude).float(0);
        Found {
            offset: (d / amplitude).float(0) * (-1.0 / PI),
            information: information * (PI * PI),
        }
    }
}

/// The product of two numbers in Q30. Inlined everywhere it would cost more memory than it saves time.
#[inline(never)]
fn product(a: i32, b: i32) -> i32 {
    times(a, b)
}
