//! A tone's own share of the second differences of bins, in floats and in integers.
//!
//! With c the tone's line, d its offset and x the distance of a bin from the tone in bins, the share is `c sin(pi d) / (pi x (x^2 - 1))`,
//! see [`super::ring`]. Near DC the mirror image of a real tone has the conjugate of this share at minus the tone's frequency, near Nyquist
//! the negative conjugate at the rate less the tone's frequency.

use crate::math::scalar::{Scalar as _, inverses};
use crate::math::series::line_shape;
use crate::spectrum::fft::integer::Point;
use crate::spectrum::neighbourhood::GROUP;
use crate::tone::fit::Fit;
use crate::tone::fit::fixed::{product, quantised, square, tail};
use num_complex::Complex;

/// Differences in a stretch, and bins from one stretch to the next.
pub(crate) const STEP: usize = GROUP;
pub(crate) const EACH: usize = STEP / 2;

/// The differences of a stretch, in stored units.
pub(crate) type Stretch = [[f32; 2]; EACH];

/// A tone's own share of the second differences.
pub(super) struct Own {
    /// `line sin(pi d) / pi` in stored units, for the tone and for its mirror image.
    value: Complex<f32>,
    image: Complex<f32>,
    /// The tone's bin and its offset.
    pub(super) peak: i32,
    offset: f32,
    /// The sum of the tone's bin and its image's: 0 or N. `None` if the image is far away.
    mirror: Option<i32>,
}

/// Tones nearer than this to an end of the spectrum have an image among their ring's bins.
const MIRRORED: i32 = 40;

/// At this distance the image's leakage is negligible.
const REACHED: i32 = 60;

impl Own {
    pub(super) fn new(iq: bool, peak: i32, n: usize, fit: &Fit<f32>, exponent: i32) -> Self {
        let (n, d) = (n as i32, fit.offset);
        // A real line and an I/Q line are turned by different angles. The difference is small
        // here.
        let angle = if iq { d * core::f32::consts::PI / n as f32 } else { 0.0 };
        let turn = Complex::new(1.0, angle);
        let value = fit.line * turn * (d * line_shape(d) * f32::two_to(-exponent));
        let near = peak.min(n / 2 - peak);
        let low = peak < n / 4;
        let mirror = (!iq && near < MIRRORED).then_some(if low { 0 } else { n });
        let image = if low { value.conj() } else { -value.conj() };
        Self { value, image, peak, offset: d, mirror }
    }

    /// The power of a stretch, whose first difference is around bin `k`, less the others' leakage into the differences around `k`, `k + 2`
    /// and so on.
    #[inline(always)]
    pub(super) fn power(
        &self,
        bins: &[Point; STEP + 1],
        k: i32,
        less_others: impl Fn(i32, &mut Stretch),
    ) -> f32 {
        let cubic = |x: f32| x * (x * x - 1.0);
        let x = (self.peak - k) as f32 + self.offset;
        let [a, b, c, d, e, f, g, h, i] = bins;
        let tails = inverses([x, x - 2.0, x - 4.0, x - 6.0].map(cubic));
        let value = self.value;
        let left =
            |[re, im]: Point, tail: f32| [re as f32 - value.re * tail, im as f32 - value.im * tail];
        let mut left = [
            left(bend(a, b, c), tails[0]),
            left(bend(c, d, e), tails[1]),
            left(bend(e, f, g), tails[2]),
            left(bend(g, h, i), tails[3]),
        ];
        if let Some(mirror) = self.mirror {
            let mut s = (self.peak + k - mirror) as f32 + self.offset;
            for [re, im] in &mut left {
                let away = s.abs();
                if away < REACHED as f32 + self.offset {
                    let tail = 1.0 / cubic(away);
                    *re -= self.image.re * tail;
                    *im -= self.image.im * tail;
                }
                s += 2.0;
            }
        }
        less_others(k, &mut left);
        left.iter().fold(0.0, |sum, [re, im]| sum + (re * re + im * im))
    }
}

/// [`Own`] in integers.
pub(super) struct OwnInIntegers {
    value: Point,
    image: Point,
    peak: i32,
    /// In Q25.
    offset: i32,
    mirror: Option<i32>,
}

impl OwnInIntegers {
    pub(super) fn from_own(own: &Own) -> Self {
        let integers = |z: Complex<f32>| [z.re as i32, z.im as i32];
        let (value, image) = (integers(own.value), integers(own.image));
        let offset = quantised(own.offset, 25);
        Self { value, image, peak: own.peak, offset, mirror: own.mirror }
    }

    /// [`Own::power`] in integers.
    #[inline(always)]
    pub(super) fn power(&self, bins: &[Point; STEP + 1], k: i32) -> f32 {
        /// One bin, in steps of the offset.
        const ONE: i32 = 1 << 25;
        let mut x = (self.peak - k).wrapping_mul(ONE).wrapping_add(self.offset);
        let mut mirrored = self.mirror.map(|mirror| self.peak + k - mirror);
        let mut sum = 0u64;
        let [a, b, c, d, e, f, g, h, i] = bins;
        for [a, b, c] in [[a, b, c], [c, d, e], [e, f, g], [g, h, i]] {
            let mut rest = bend(a, b, c);
            let mut less = |value: Point, tail: i32| {
                for (rest, part) in rest.iter_mut().zip(value) {
                    *rest = rest.wrapping_sub((product(tail, part) >> 36) as i32);
                }
            };
            less(self.value, tail(x));
            x = x.wrapping_sub(2 * ONE);
            if let Some(s) = &mut mirrored {
                if s.abs() < REACHED {
                    let away = s.wrapping_mul(ONE).wrapping_add(self.offset).wrapping_abs();
                    less(self.image, tail(away));
                }
                *s += 2;
            }
            let [re, im] = rest.map(|part| square(part) as u64);
            sum = sum.wrapping_add(re).wrapping_add(im);
        }
        sum as f32
    }
}

/// Half the second difference of three bins.
#[inline(always)]
fn bend(a: &Point, b: &Point, c: &Point) -> Point {
    let part = |a: i32, b: i32, c: i32| (a >> 1).wrapping_sub(b).wrapping_add(c >> 1);
    [part(a[0], b[0], c[0]), part(a[1], b[1], c[1])]
}
