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

use super::rest::{self, NEAR, Rest};
use super::slow;
use super::{
    Course, Distance, EDGE_LIMIT, Fit, OFFSET_LIMIT, SETTLED, START_LIMIT, STEP_LIMIT, distances,
    limit,
};
use crate::math::scalar::Scalar;
use crate::math::series::{circle, cosine, line_shape, sinc};
use crate::spectrum::bins::REACH;
use heapless::Vec;
use num_complex::Complex;

/// A bin beside the peak.
#[derive(Clone, Copy)]
struct Side<T> {
    /// The distance from the peak in bins.
    i: i32,
    u: T,
    s: T,
    x: Complex<T>,
    v: T,
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

/// The bins in the form of the module's equations.
struct Problem<T> {
    peak: i32,
    last: i32,
    e: T,
    c: T,
    centre: Complex<T>,
    sides: Vec<Side<T>, { 2 * REACH }>,
}

/// One evaluation of the normal equations at an offset.
struct Step<T> {
    /// The step, in units of p.
    forward: T,
    information: T,
    line: Complex<T>,
    /// The slope of `line` over p.
    slope: Complex<T>,
}

/// Fits a tone to the bins around `peak` of a record of `n` samples. `bin(k)` is the bin k bins
/// from the peak.
pub(super) fn fit<T: Scalar>(
    n: i32,
    peak: i32,
    bin: impl Fn(i32) -> Complex<T>,
    reach: usize,
    course: Course<T>,
    distance: impl Fn(i32) -> Distance<T>,
) -> Option<Fit<T>> {
    Some(Problem::new(n, peak, bin, reach, distance)?.fit(course))
}

/// Turns of fitting slow terms and the tone one after the other. Each turn leaves a tenth of the
/// error at bin 5, a third at bin 3.
const TURNS: u32 = 6;

/// The same beside the leakage of a drift and of a hum of up to one and a half cycles, whose own
/// bins lie below: see [`slow`].
pub(super) fn fit_beside_slow<T: Scalar>(
    n: i32,
    peak: i32,
    bin: impl Fn(i32) -> Complex<T>,
    reach: usize,
    distance: impl Fn(i32) -> Distance<T>,
) -> Option<Fit<T>> {
    let mut problem = Problem::new(n, peak, bin, reach, distance)?;
    let first = slow::FIRST.min(peak - 2);
    problem.sides.retain(|side| peak + side.i >= first);
    let mut fit = problem.fit(Course::Usual);
    for _ in 0..TURNS {
        problem.take_slow_terms(n, &fit);
        fit = problem.fit(Course::From(fit.offset, 1));
    }
    fit.freedom = fit.freedom.saturating_sub(slow::TERMS).max(1);
    // The information that the slow terms take.
    let far = T::of_i32(peak);
    fit.information = fit.information / (T::one() + T::of(4.5) / (far * far));
    Some(fit)
}

impl<T: Scalar> Problem<T> {
    /// `None` if nothing can be fitted.
    fn new(
        n: i32,
        peak: i32,
        bin: impl Fn(i32) -> Complex<T>,
        reach: usize,
        distance: impl Fn(i32) -> Distance<T>,
    ) -> Option<Self> {
        let (last, centre) = (n / 2 - 1, bin(0));
        if peak < 1 || peak > last || centre.norm_sqr() <= T::zero() {
            return None;
        }
        let e = T::of(core::f64::consts::TAU) / T::of_i32(n);
        let w = circle::<T>(peak, n);
        // The bins are built in place: a vector made elsewhere would be copied here.
        let mut problem =
            Problem { peak, last, e, c: e * (w.re / w.im), centre, sides: Vec::new() };
        problem.read(bin, reach, distance);
        Some(problem)
    }

    /// What the tone at p leaves of a bin.
    fn left(&self, p: T, line: Complex<T>, side: &Side<T>) -> Complex<T> {
        let h = p / (p - side.u);
        let model = Complex::new(line.re - line.im * self.e * side.u, line.im * side.s);
        side.x - model * h
    }

    /// Subtracts slow terms, as the residual shows them, from the bins.
    fn take_slow_terms(&mut self, n: i32, fit: &Fit<T>) {
        let (p, line) = (fit.lever.re, fit.peak);
        let mut sums = slow::Sums::new();
        sums.add(slow::Bin::new(self.peak, n), self.centre - line);
        for side in &self.sides {
            sums.add(slow::Bin::new(self.peak + side.i, n), self.left(p, line, side));
        }
        let terms = sums.solve();
        self.centre = self.centre - slow::Bin::new(self.peak, n).value(&terms);
        for side in &mut self.sides {
            side.x = side.x - slow::Bin::new(self.peak + side.i, n).value(&terms);
            side.v = side.s * side.x.im - self.e * side.u * side.x.re;
        }
    }

    /// Gauss-Newton steps.
    fn fit(&self, course: Course<T>) -> Fit<T> {
        let (problem, peak, last) = (self, self.peak, self.last);
        let edge = peak < 3 || peak > last - 2;
        let (start, steps, settled) = match course {
            Course::Usual => (problem.start(), if edge { 3 } else { 2 }, T::of(SETTLED)),
            Course::From(start, steps) | Course::Further(start, steps) => (start, steps, T::zero()),
        };
        // The tone stays between DC and Nyquist.
        let low = (T::of(EDGE_LIMIT) - T::of_i32(peak)).max(T::of(-OFFSET_LIMIT));
        let high = (T::of_i32(last - peak + 1) - T::of(EDGE_LIMIT)).min(T::of(OFFSET_LIMIT));
        let mut d = limit(start, START_LIMIT).max(low).min(high);
        let (mut p, mut speed) = problem.cosine_offset(d);
        let mut step = problem.step(p);
        for taken in 0..steps {
            if taken > 0 {
                step = problem.step(p);
            }
            let next = (d + limit(step.forward / speed, STEP_LIMIT)).max(low).min(high);
            let moved = next - d;
            d = next;
            let information = step.information * speed * speed;
            let before = p;
            (p, speed) = problem.cosine_offset(d);
            step.line = step.line + step.slope * (p - before);
            step.information = information;
            if moved.abs() <= settled {
                break;
            }
        }
        if steps == 0 {
            step.information = step.information * speed * speed;
        }
        problem.finish(d, p, &step)
    }

    /// p of an offset d, and dp/dd.
    fn cosine_offset(&self, d: T) -> (T, T) {
        let half = self.e * d * T::of(0.5);
        let z = half * half;
        let (cos, sinc) = (cosine(z), sinc(z));
        let bend = d * d * sinc * sinc * T::of(0.5);
        let p = d * sinc * cos + self.c * bend;
        (p, T::one() - T::of(2.0) * z * sinc * sinc + self.c * d * sinc * cos)
    }

    /// The offset from the peak and its two neighbours: `X (p - u) = p (a - b e u + j b s)` with
    /// `a + j b` the peak itself, by linear least squares for p. Exact without noise.
    fn start(&self) -> T {
        let Complex { re: a, im: b } = self.centre;
        let (mut above, mut below) = (T::zero(), T::zero());
        for side in self.sides.iter().take(2) {
            let x = side.x;
            let (re, im) = (x.re - a + self.e * side.u * b, x.im - side.s * b);
            above = above + side.u * (x.re * re + x.im * im);
            below = below + re * re + im * im;
        }
        let p = above / below;
        // d of p: tan(e d / 2) = e p / (1 + sqrt(1 + 2 c p - e^2 p^2)), an angle below 0.05.
        let p = limit(p, START_LIMIT);
        let root = (T::one() + T::of(2.0) * self.c * p - self.e * self.e * p * p).max(T::zero());
        let half = p / (T::one() + root.root());
        let tangent = self.e * half;
        (half + half) * (T::one() - tangent * tangent * T::of(1.0 / 3.0))
    }

    /// The sums at p, and what follows from them.
    fn step(&self, p: T) -> Step<T> {
        let Sums { aa, s1, bb, dd, r1, r2, q1, q2 } = self.sums(p);
        // The peak itself: h = 1, h' = 0.
        let (aa, r1, r2) = (aa + T::one(), r1 + self.centre.re, r2 + self.centre.im);
        let (e, c2) = (self.e, self.c + self.c);
        let (lean, rest) = (e * p, s1 - bb);
        // Inner products of the basis (1, 0) h and (-e u, s) h.
        let g12 = lean * p * s1;
        let g22 = aa - c2 * p * p * s1;
        let inverse = T::one() / (aa * g22 - g12 * g12);
        let a = (g22 * r1 - g12 * r2) * inverse;
        let b = (aa * r2 - g12 * r1) * inverse;
        // Those of the model's derivative with the basis, with itself and with the data.
        let b2 = lean * rest;
        let d2 = e * (rest - p * dd);
        let x1 = a * bb + b * b2;
        let x2 = a * b2 + b * (bb - c2 * p * rest);
        let own = a * a * dd + (a + a) * b * d2 + b * b * (dd - c2 * (rest - p * dd));
        let slope = Complex::new((g22 * x1 - g12 * x2) * inverse, (aa * x2 - g12 * x1) * inverse);
        let information = own - (x1 * slope.re + x2 * slope.im);
        Step {
            forward: (a * (q1 - x1) + b * (q2 - x2)) / information,
            information,
            line: Complex::new(a, b),
            slope: -slope,
        }
    }

    /// The tone's amplitude `A N/2 exp(j (phase + pi d)) = p/d / sinc(pi d) ((a - e p b) / s + j b)`,
    /// `s = sin(e f) / S`.
    fn finish(&self, d: T, p: T, step: &Step<T>) -> Fit<T> {
        let Complex { re: a, im: b } = step.line;
        let bent = self.e * p;
        let s = (T::one() + (self.c + self.c) * p - bent * bent).max(T::epsilon()).root();
        let ratio = if d == T::zero() { T::one() } else { p / d };
        let line = Complex::new((a - bent * b) / s, b) * (ratio / line_shape(d));
        let centre = self.centre - step.line;
        let (residual, rest) = self.residual(d, p, step.line, centre);
        Fit {
            offset: d,
            line,
            information: step.information,
            peak: step.line,
            lever: Complex::new(p, T::zero()),
            residual,
            freedom: (2 * self.sides.len() as u32 + 2).saturating_sub(3),
            rest,
        }
    }

    /// Takes the bins beside the peak, the nearest first.
    fn read(
        &mut self,
        bin: impl Fn(i32) -> Complex<T>,
        reach: usize,
        distance: impl Fn(i32) -> Distance<T>,
    ) {
        let (e, c) = (self.e, self.c);
        for i in distances(reach) {
            let Distance { near, bend, versine } = distance(i);
            let bend = c * bend;
            for (k, sign) in [(-i, -T::one()), (i, T::one())] {
                if self.peak + k < 1 || self.peak + k > self.last {
                    continue;
                }
                let u = sign * near + bend;
                let s = T::one() - versine + sign * c * near;
                let x = bin(k);
                // The vector holds every distance up to the reach.
                let _ = self.sides.push(Side { i: k, u, s, x, v: s * x.im - e * u * x.re });
            }
        }
    }

    fn sums(&self, p: T) -> Sums<T> {
        let zero = T::zero();
        let mut sums =
            Sums { aa: zero, s1: zero, bb: zero, dd: zero, r1: zero, r2: zero, q1: zero, q2: zero };
        for side in &self.sides {
            let r = T::one() / (p - side.u);
            let h = p * r;
            let slope = (T::one() - h) * r;
            sums.aa = sums.aa + h * h;
            sums.s1 = sums.s1 + slope;
            sums.bb = sums.bb + h * slope;
            sums.dd = sums.dd + slope * slope;
            sums.r1 = sums.r1 + h * side.x.re;
            sums.r2 = sums.r2 + h * side.v;
            sums.q1 = sums.q1 + slope * side.x.re;
            sums.q2 = sums.q2 + slope * side.v;
        }
        sums
    }

    /// The power that the model leaves and its places; the peak's own bin leaves `centre`.
    fn residual(&self, d: T, p: T, line: Complex<T>, centre: Complex<T>) -> (T, Rest<T>) {
        let left = |side: &Side<T>| self.left(p, line, side);
        let far = |sides: &[Side<T>], sum| {
            sides.iter().fold(sum, |sum, side| sum + left(side).norm_sqr())
        };
        let own = centre.norm_sqr();
        if !cfg!(feature = "methods") {
            return (far(&self.sides, own), Rest::none());
        }
        let (mut sum, mut sums, mut count) = (own, rest::Sums::new(d, centre), 0);
        for side in self.sides.iter().take_while(|side| side.i.unsigned_abs() as usize <= NEAR) {
            sum = sum + sums.add(side.i, left(side));
            count += 1;
        }
        (far(self.sides.get(count..).unwrap_or(&[]), sum), sums.rest())
    }
}
