//! The fit of a real tone, image included.
//!
//! With `e = 2 pi / N`, `C = cos e km`, `S = sin e km` (km the peak bin, i the distance from it, d the
//! unknown offset) let
//!
//! ```text
//! c = e C / S              u_i = sin(e i) / e + c (1 - cos e i) / e^2        (about i)
//!                          p   = sin(e d) / e + c (1 - cos e d) / e^2        (about d)
//! ```
//!
//! that is, `u` and `p` are the differences of the cosines of frequencies, divided by `-e S`. Then
//! every bin of a real tone, its image included, is exactly
//!
//! ```text
//! Re X = (a - b e u) h      Im X = b s h      h = p / (p - u)      s = sin(e (km + i)) / S
//! ```
//!
//! with two real unknowns a, b, and h' = dh/dp = (1 - h) / (p - u). No sine depends on the
//! unknown, all numbers are near 1, and because `u h = p (h - 1)` every weighted sum the normal
//! equations need follows from eight:
//!
//! ```text
//! A = sum h^2    s1 = sum h'    B = sum h h'    D = sum h'^2
//! r1 = sum h Re  r2 = sum h V   q1 = sum h' Re  q2 = sum h' V      V = s Im - e u Re
//! ```
//!
//! Only bins 1..=N/2-1 enter, so a DC offset has no effect.
//!
//! A Gauss-Newton step sums over the bins (`Sums`), makes inner products of the sums (`Products`), and solves the normal equations for a
//! and b and for the way in p (`Step`). The fields of the [`Fit`] are
//!
//! - `offset`: d where the last step ends;
//! - `line`: the complex amplitude there, from a and b;
//! - `information`: the curvature of the squared residual over d with a and b free, from which sigma follows;
//! - `residual` and `dof`: the power that the model leaves in the bins, and its degrees of freedom;
//! - `rest`: the part of the residual near the line, for the judgement;
//! - `peak` and `lever`: the peak bin of the model and p, from which the other bins of the tone follow.

use super::descent::Descent;
use super::normal::{Products, Step};
use super::rest::{self, Rest, SCALES};
use super::{EDGE_LIMIT, Fit, FitStart, OFFSET_LIMIT, START_LIMIT, limit};
use crate::math::scalar::{Scalar, inverses};
use crate::math::series::{circle, cosine, line_shape, sinc};
use crate::spectrum::bins::REACH;
use crate::spectrum::layout::Distance;
use heapless::Vec;
use num_complex::Complex;

/// The bins in the form of the module's equations.
struct Problem<T> {
    peak: i32,
    last: i32,
    e: T,
    /// C / S
    cotangent: T,
    c: T,
    centre: Complex<T>,
    /// The bins beside the peak, the nearest first.
    sides: Vec<Side<T>, { 2 * REACH }>,
    /// The bins below the peak and above it that a fit may read.
    room: [i32; 2],
}

/// The bins below and above the peak, and the constants of their distance.
pub(super) type Both<T> = ([Complex<T>; 2], Distance<T>);

/// Fits a tone to the bins around `peak` of a record of `n` samples: the peak's own bin and the bins beside it, the nearest
/// first, at most [`REACH`] on each side.
#[inline(always)]
pub(super) fn fit<T: Scalar>(
    n: i32,
    peak: i32,
    centre: Complex<T>,
    beside: impl Iterator<Item = Both<T>>,
    course: FitStart<T>,
) -> Option<Fit<T>> {
    if !Problem::has_tone(n, peak, centre) {
        return None;
    }
    let mut problem = Problem::new(n, peak, centre);
    problem.read(beside);
    Some(problem.fit(course))
}

impl<T: Scalar> Problem<T> {
    /// Whether there is a tone to fit.
    fn has_tone(n: i32, peak: i32, centre: Complex<T>) -> bool {
        peak >= 1 && peak < n / 2 && centre.norm_sqr() > T::zero()
    }

    /// A problem without sides: they are read in place, because a problem with all of them would be copied.
    #[inline(always)]
    fn new(n: i32, peak: i32, centre: Complex<T>) -> Self {
        let last = n / 2 - 1;
        let e = T::new(core::f64::consts::TAU) / T::from_i32(n);
        let w = circle::<T>(peak, n);
        let (cotangent, room) = (w.re / w.im, [peak - 1, last - peak]);
        Problem { peak, last, e, cotangent, c: e * cotangent, centre, sides: Vec::new(), room }
    }

    /// The least and the largest offset: the tone stays between DC and Nyquist.
    fn limits(&self) -> [T; 2] {
        let low = (T::new(EDGE_LIMIT) - T::from_i32(self.peak)).max(T::new(-OFFSET_LIMIT));
        let high =
            (T::from_i32(self.last - self.peak + 1) - T::new(EDGE_LIMIT)).min(T::new(OFFSET_LIMIT));
        [low, high]
    }

    /// Gauss-Newton steps.
    #[inline(always)]
    fn fit(&self, course: FitStart<T>) -> Fit<T> {
        let edge = self.peak < 3 || self.peak > self.last - 2;
        let usual = || (self.start(), if edge { 3 } else { 2 });
        let (descent, enough) = Descent::new(course, usual, self.limits());
        let end = descent.to_the_end(|d| {
            let (p, speed) = self.p_of(d);
            let step = self.step(p);
            (step.forward(speed), enough, (p, speed, step))
        });
        let ((before, speed, step), (p, _)) = (end.last, self.p_of(end.at));
        let information = step.information * speed * speed * end.sharpness;
        self.finish(end.at, p, step.line_at(p - before), information)
    }

    /// The p of the module's equations for an offset d, and its slope dp/dd.
    fn p_of(&self, d: T) -> (T, T) {
        let half = self.e * d * T::new(0.5);
        let z = half * half;
        let (cos, sinc) = (cosine(z), sinc(z));
        let bend = d * d * sinc * sinc * T::new(0.5);
        let p = d * sinc * cos + self.c * bend;
        (p, T::one() - T::new(2.0) * z * sinc * sinc + self.c * d * sinc * cos)
    }

    /// The offset from the peak and its two neighbours: `X (p - u) = p (a - b e u + j b s)` with
    /// `a + j b` the peak itself, by linear least squares for p. Exact without noise.
    fn start(&self) -> T {
        let Complex { re: a, im: b } = self.centre;
        let (mut above, mut below) = (T::zero(), T::zero());
        for side in self.sides.iter().take(2) {
            let x = side.x;
            let (re, im) = (x.re - a + side.w * b, x.im - side.s * b);
            above = above + side.w * (x.re * re + x.im * im);
            below = below + re * re + im * im;
        }
        let p = above / (below * self.e);
        // d of p: tan(e d / 2) = e p / (1 + sqrt(1 + 2 c p - e^2 p^2)), an angle below 0.05.
        let p = limit(p, START_LIMIT);
        let root = (T::one() + T::new(2.0) * self.c * p - self.e * self.e * p * p).max(T::zero());
        let half = p / (T::one() + root.root());
        let tangent = self.e * half;
        (half + half) * (T::one() - tangent * tangent * T::new(1.0 / 3.0))
    }

    fn step(&self, p: T) -> Step<T> {
        self.products(p).step()
    }

    /// The inner products at p, from the sums.
    #[inline(always)]
    fn products(&self, p: T) -> Products<T> {
        let Sums { aa, s1, bb, dd, r1, r2, q1, q2 } = self.sums(p);
        // The peak itself: h = 1, h' = 0.
        let (aa, r1, r2) = (aa + T::one(), r1 + self.centre.re, r2 + self.centre.im);
        let (e, c2) = (self.e, self.c + self.c);
        let (lean, rest) = (e * p, s1 - bb);
        // Inner products of the basis (1, 0) h and (-e u, s) h.
        let g12 = lean * p * s1;
        let g22 = aa - c2 * p * p * s1;
        // Products of the model's derivative with the basis, with itself and with the data.
        let b2 = lean * rest;
        Products {
            g11: aa,
            g12,
            g22,
            r: [r1, r2],
            b11: bb,
            b12: b2,
            b21: b2,
            b22: bb - c2 * p * rest,
            d11: dd,
            d12: e * (rest - p * dd),
            d22: dd - c2 * (rest - p * dd),
            q: [q1, q2],
        }
    }

    /// The tone's amplitude `A N/2 exp(j (phase + pi d)) = p/d / sinc(pi d) ((a - e p b) / s + j b)`,
    /// `s = sin(e f) / S`.
    fn finish(&self, d: T, p: T, at_peak: Complex<T>, information: T) -> Fit<T> {
        let Complex { re: a, im: b } = at_peak;
        let bent = self.e * p;
        let s = (T::one() + (self.c + self.c) * p - bent * bent).max(T::epsilon()).root();
        let (p_over, d_under) = if d == T::zero() { (T::one(), T::one()) } else { (p, d) };
        let scale = p_over / (d_under * line_shape(d) * s);
        let line = Complex::new((a - bent * b) * scale, b * (scale * s));
        let centre = self.centre - at_peak;
        let (residual, rest) = self.residual(d, p, at_peak, centre);
        Fit {
            offset: d,
            line,
            information,
            peak: at_peak,
            lever: Complex::new(p, T::zero()),
            residual,
            dof: (2 * self.sides.len() as u32 + 2).saturating_sub(3),
            rest,
        }
    }

    /// Takes the bins beside the peak, the nearest first.
    #[inline(always)]
    fn read(&mut self, beside: impl Iterator<Item = Both<T>>) {
        let (cotangent, [below, above]) = (self.cotangent, self.room);
        for (index, ([low, high], distance)) in beside.enumerate() {
            let i = index as i32 + 1;
            let Distance { sine, versine } = distance;
            let (bend, straight, lean) =
                (cotangent * versine, T::one() - versine, cotangent * sine);
            // The vector holds every distance up to the reach.
            if i <= below {
                let _ = self.sides.push(Side::new(-i, bend - sine, straight - lean, low));
            }
            if i <= above {
                let _ = self.sides.push(Side::new(i, bend + sine, straight + lean, high));
            }
        }
    }

    fn sums(&self, p: T) -> Sums<T> {
        let zero = T::zero();
        let mut sums =
            Sums { aa: zero, s1: zero, bb: zero, dd: zero, r1: zero, r2: zero, q1: zero, q2: zero };
        let ep = self.e * p;
        each(&self.sides, ep, |side, r| sums.add(side, ep, r));
        // A slope over p is e times one over e p.
        let Sums { aa, s1, bb, dd, r1, r2, q1, q2 } = sums;
        let e = self.e;
        Sums { aa, s1: e * s1, bb: e * bb, dd: e * e * dd, r1, r2, q1: e * q1, q2: e * q2 }
    }

    /// The power that the model leaves, and its projections; `centre` is the residual of the peak's own bin.
    fn residual(&self, d: T, p: T, line: Complex<T>, centre: Complex<T>) -> (T, Rest<T>) {
        let (ep, own) = (self.e * p, centre.norm_sqr());
        let mut sums = rest::Sums::new(d, centre);
        let (mut from, mut sum, mut within) = (0, own, [own; 3]);
        for (reach, within) in SCALES.into_iter().zip(&mut within) {
            let [below, above] = self.room.map(|room| room.min(reach));
            let to = self.sides.len().min((below + above) as usize);
            sum =
                Self::near(self.sides.get(from..to).unwrap_or_default(), ep, line, sum, &mut sums);
            (from, *within) = (to, sum);
        }
        let far = self.sides.get(from..).unwrap_or_default();
        let rest = sums.turned_back(2 * self.last + 2).rest(within);
        (Self::far(far, ep, line, sum), rest)
    }

    /// Adds the residual power in bins near the line to `sum`, and to `sums` as well.
    #[inline(always)]
    fn near(sides: &[Side<T>], ep: T, line: Complex<T>, sum: T, sums: &mut rest::Sums<T>) -> T {
        let (pairs, rest) = sides.as_chunks::<2>();
        let mut sum = sum;
        let mut add = |sums: &mut rest::Sums<T>, side: &Side<T>, r: T, y: T| {
            let left = side.left(line, ep * r);
            sums.add(left, y);
            sum = sum + left.norm_sqr();
        };
        for [a, b] in pairs {
            let [x, y] = [a, b].map(|side| sums.argument(side.i));
            let [r, s, x, y] = inverses([ep - a.w, ep - b.w, x, y]);
            add(sums, a, r, x);
            add(sums, b, s, y);
        }
        if let [side] = rest {
            let [r, y, ..] = inverses([ep - side.w, sums.argument(side.i), T::one(), T::one()]);
            add(sums, side, r, y);
        }
        sum
    }

    /// Adds the residual power in bins farther off to `sum`.
    #[inline(always)]
    fn far(sides: &[Side<T>], ep: T, line: Complex<T>, sum: T) -> T {
        let mut sum = sum;
        each(sides, ep, |side, r| sum = sum + side.left(line, ep * r).norm_sqr());
        sum
    }
}

/// A bin beside the peak.
#[derive(Clone, Copy)]
struct Side<T> {
    /// The distance from the peak in bins.
    i: i32,
    /// e u
    w: T,
    s: T,
    x: Complex<T>,
    v: T,
}

/// The sides that share a division.
const GROUP: usize = 4;

impl<T: Scalar> Side<T> {
    #[inline(always)]
    fn new(i: i32, w: T, s: T, x: Complex<T>) -> Self {
        Side { i, w, s, x, v: s * x.im - w * x.re }
    }

    /// The residual of a bin in which the model is h times the basis.
    #[inline(always)]
    fn left(&self, line: Complex<T>, h: T) -> Complex<T> {
        let model = Complex::new(line.re - line.im * self.w, line.im * self.s);
        self.x - model * h
    }
}

/// Each side with one over its distance from e p.
#[inline(always)]
fn each<T: Scalar>(sides: &[Side<T>], ep: T, mut take: impl FnMut(&Side<T>, T)) {
    let (groups, rest) = sides.as_chunks::<GROUP>();
    for group in groups {
        let inverses = inverses(group.each_ref().map(|side| ep - side.w));
        group.iter().zip(inverses).for_each(|(side, r)| take(side, r));
    }
    for side in rest {
        take(side, T::one() / (ep - side.w));
    }
}

/// The eight sums over the bins beside the peak.
struct Sums<T> {
    aa: T,
    s1: T,
    bb: T,
    dd: T,
    r1: T,
    r2: T,
    q1: T,
    q2: T,
}

impl<T: Scalar> Sums<T> {
    /// Adds a side, with `r` one over its distance from e p.
    #[inline(always)]
    fn add(&mut self, side: &Side<T>, ep: T, r: T) {
        let h = ep * r;
        let slope = (T::one() - h) * r;
        self.aa = self.aa + h * h;
        self.s1 = self.s1 + slope;
        self.bb = self.bb + h * slope;
        self.dd = self.dd + slope * slope;
        self.r1 = self.r1 + h * side.x.re;
        self.r2 = self.r2 + h * side.v;
        self.q1 = self.q1 + slope * side.x.re;
        self.q2 = self.q2 + slope * side.v;
    }
}
