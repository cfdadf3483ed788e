//! The fit of a complex tone.
//!
//! With `e = pi / N` (km the peak bin, i the distance from it, d the unknown offset) let
//! `u_i = tan(e i) / e` and `p = tan(e d) / e`. Every bin of a complex tone is exactly
//!
//! ```text
//! X = c h (1 + j e u)      h = p / (p - u)      h' = dh/dp = (1 - h) / (p - u)
//! ```
//!
//! c the complex unknown. With `Y = X (1 - j e u)` and `m = 1 + e^2 u^2` the normal equations (`normal`) need
//!
//! ```text
//! A = sum m h^2   B = sum m h h'   D = sum m h'^2   P = sum h Y   Q = sum h' Y
//! ```
//!
//! so no sine depends on the unknown.

use super::descent::Descent;
use super::normal::{Products, Step};
use super::rest::{self, NEAR, Rest, SCALES};
use super::{Fit, FitStart, OFFSET_LIMIT, START_LIMIT, distances, first_two, limit};
use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use crate::math::series::{circle, cosine, line_shape, sinc};
use crate::spectrum::bins::{Bins, REACH, Rectangular};
use heapless::Vec;
use num_complex::Complex;

/// A bin beside the peak.
#[derive(Clone, Copy)]
pub(super) struct Side<T> {
    /// The distance from the peak in bins.
    pub i: i32,
    pub u: T,
    pub m: T,
    pub y: Complex<T>,
}

/// The sums over the bins beside the peak.
pub(super) struct Sums<T> {
    pub aa: T,
    pub bb: T,
    pub dd: T,
    pub pp: Complex<T>,
    pub qq: Complex<T>,
}

/// The bins beside the peak, in either arithmetic.
pub(super) trait Sides<T> {
    /// The sums at p.
    fn sums(&self, p: T) -> Sums<T>;
    /// The power that the model c leaves at the offset d, and the residual's projections; `centre` is the residual of the peak's own bin.
    fn residual(&self, d: T, p: T, c: Complex<T>, centre: Complex<T>) -> (T, Rest<T>);
    /// The number of bins.
    fn count(&self) -> usize;
}

/// The bins in the form of the module's equations.
pub(super) struct Problem<T, S> {
    pub e: T,
    pub centre: Complex<T>,
    /// The peak's neighbours.
    pub near: Vec<Side<T>, 2>,
    pub sides: S,
}

struct Floats<T> {
    all: Vec<Side<T>, { 2 * REACH }>,
    /// Whether the record has fewer than [`LONG`] samples.
    short: bool,
}

/// From this many samples on m is nearly 1 in the bins within [`NEAR`]; of 8 samples it is 7 in the third one.
const LONG: i32 = 64;

pub(super) fn fit<T: Scalar, R: Record>(
    bins: &Bins<T, R, Rectangular>,
    reach: usize,
    course: FitStart<T>,
) -> Option<Fit<T>> {
    let centre = bins.at(0);
    if centre.norm_sqr() <= T::zero() {
        return None;
    }
    let e = T::new(core::f64::consts::PI) / T::from_i32(bins.n() as i32);
    // The bins are built in place: a vector made elsewhere would be copied here.
    let short = (bins.n() as i32) < LONG;
    let mut problem =
        Problem { e, centre, near: Vec::new(), sides: Floats { all: Vec::new(), short } };
    problem.read(bins, reach, matches!(course, FitStart::Further(..)));
    Some(problem.fit(course))
}

impl<T: Scalar, S: Sides<T>> Problem<T, S> {
    /// Gauss-Newton steps.
    pub fn fit(&self, course: FitStart<T>) -> Fit<T> {
        let limits = [-OFFSET_LIMIT, OFFSET_LIMIT].map(T::new);
        let (descent, enough) = Descent::new(course, || (self.start(), 2), limits);
        let end = descent.to_the_end(|d| {
            let (p, speed) = self.tangent(d);
            let step = self.step(p);
            (step.forward(speed), enough, (p, speed, step))
        });
        let ((before, speed, step), (p, _)) = (end.last, self.tangent(end.at));
        let information = step.information * speed * speed * end.sharpness;
        self.finish(end.at, p, step.line_at(p - before), information)
    }

    /// Sine and cosine of `e d`.
    fn turn(&self, d: T) -> (T, T) {
        let x = self.e * d;
        (x * sinc(x * x), cosine(x * x))
    }

    /// p of an offset d, and dp/dd.
    fn tangent(&self, d: T) -> (T, T) {
        let (sin, cos) = self.turn(d);
        let tangent = sin / cos;
        (tangent / self.e, T::one() + tangent * tangent)
    }

    /// The offset from the peak and its two neighbours, exact without noise: with `Z = X exp(-j e i)`,
    /// `sin(2 e d) = sin(2 e) Re{(Z_- - Z_+) / (2 cos(e) X_0 - Z_- - Z_+)}`.
    ///
    /// That is Candan's estimator (2013) with the half-sample rotation; his arc tangent in place of this
    /// arc sine is off by a third-order term.
    fn start(&self) -> T {
        let [left, right] = match self.near.as_slice() {
            [left, right] => [left, right],
            _ => return T::zero(),
        };
        // Y is Z / cos e. So is the peak's term, and 2 X_0 remains; and sin(2 e) = 2 tan e / m.
        let z = (left.y - right.y) / (self.centre + self.centre - left.y - right.y);
        let two = T::new(2.0);
        let sine = limit(z.re, START_LIMIT) * two * self.e * right.u / right.m;
        let z = sine * sine;
        let series = T::new(1.0 / 6.0) + z * (T::new(3.0 / 40.0) + z * T::new(15.0 / 336.0));
        sine * (T::one() + z * series) / (two * self.e)
    }

    /// The sums at p, and the step that follows from them.
    fn step(&self, p: T) -> Step<T> {
        let Sums { aa, bb, dd, pp, qq } = self.sides.sums(p);
        // The peak itself: h = 1, h' = 0.
        let (aa, pp) = (aa + T::one(), pp + self.centre);
        Products::complex(aa, Complex::new(bb, T::zero()), dd, pp, qq).step()
    }

    /// The tone's amplitude `A N exp(j (phase + pi d (1 - 1/N))) = c sin(e d) / (e d) / sinc(pi d)`.
    fn finish(&self, d: T, p: T, c: Complex<T>, information: T) -> Fit<T> {
        let (sin, cos) = self.turn(d);
        let x = self.e * d;
        let two = T::new(2.0);
        let line = c * (sinc(x * x) / line_shape(d));
        let centre = self.centre - c;
        let (residual, rest) = self.sides.residual(d, p, c, centre);
        Fit {
            offset: d,
            line,
            information,
            peak: c,
            lever: Complex::new(two * sin * sin, -(two * sin * cos)),
            residual: centre.norm_sqr() + residual,
            dof: (2 * self.sides.count() as u32 + 2).saturating_sub(3),
            rest,
        }
    }
}

impl<T: Scalar> Problem<T, Floats<T>> {
    /// Takes the bins beside the peak, the nearest first.
    fn read<R: Record>(&mut self, bins: &Bins<T, R, Rectangular>, reach: usize, further: bool) {
        let (e, n) = (self.e, bins.n() as i32);
        for i in distances(reach) {
            let turn = circle::<T>(i, n.saturating_mul(2));
            let tangent = turn.im / turn.re;
            for (k, lean) in [(-i, -tangent), (i, tangent)] {
                let x = bins.at(k);
                let nearer = || bins.at(k - k.signum());
                if is_left_out(bins.peak().wrapping_add(k), n, i, further, x, nearer) {
                    continue;
                }
                let y = Complex::new(x.re + lean * x.im, x.im - lean * x.re);
                // The vector holds every distance up to the reach.
                let _ =
                    self.sides.all.push(Side { i: k, u: lean / e, m: T::one() + lean * lean, y });
            }
        }
        self.near = first_two(self.sides.all.iter().copied());
    }
}

impl<T: Scalar> Sides<T> for Floats<T> {
    fn sums(&self, p: T) -> Sums<T> {
        let (zero, none) = (T::zero(), Complex::new(T::zero(), T::zero()));
        let mut sums = Sums { aa: zero, bb: zero, dd: zero, pp: none, qq: none };
        for side in &self.all {
            let r = T::one() / (p - side.u);
            let h = p * r;
            let slope = (T::one() - h) * r;
            let (mh, ms) = (side.m * h, side.m * slope);
            sums.aa = sums.aa + mh * h;
            sums.bb = sums.bb + mh * slope;
            sums.dd = sums.dd + ms * slope;
            sums.pp = sums.pp + side.y * h;
            sums.qq = sums.qq + side.y * slope;
        }
        sums
    }

    /// `|X - c h (1 + j e u)|^2 = |Y - c h m|^2 / m`.
    fn residual(&self, d: T, p: T, c: Complex<T>, centre: Complex<T>) -> (T, Rest<T>) {
        let left = |side: &Side<T>| {
            let h = p / (p - side.u);
            side.y - c * (h * side.m)
        };
        let far = |sides: &[Side<T>], sum| {
            sides.iter().fold(sum, |sum, side| sum + left(side).norm_sqr() / side.m)
        };
        let (mut sum, mut sums, mut count) = (T::zero(), rest::Sums::new(d, centre), 0);
        let mut within = [centre.norm_sqr(); 3];
        for side in self.all.iter().take_while(|side| side.i.unsigned_abs() as usize <= NEAR) {
            let (mut left, mut m) = (left(side), side.m);
            if self.short {
                (left, m) = (left * (T::one() / m).root(), T::one());
            }
            let power = left.norm_sqr();
            sums.add(left, T::one() / sums.argument(side.i));
            let scales = within.iter_mut().zip(SCALES).filter(|(_, scale)| side.i.abs() <= *scale);
            scales.for_each(|(within, _)| *within = *within + power);
            sum = sum + power / m;
            count += 1;
        }
        let rest = self.all.get(count..).unwrap_or(&[]);
        (far(rest, sum), sums.rest(within))
    }

    fn count(&self) -> usize {
        self.all.len()
    }
}

/// Whether bin `k`, `away` from the peak, is left out because it holds a constant offset.
///
/// The bin is left out if a tone alone does not explain all bins, but not next to the tone, which needs all three bins. From four bins off
/// it is also left out if it is louder than a tone's leakage can make it: the leakage falls from the bin nearer the tone.
pub(super) fn is_left_out<T: Scalar>(
    k: i32,
    n: i32,
    away: i32,
    further: bool,
    bin: Complex<T>,
    nearer: impl Fn() -> Complex<T>,
) -> bool {
    away > 1
        && k.checked_rem(n).unwrap_or(1) == 0
        && (further || away > 3 && bin.norm_sqr() > nearer().norm_sqr() * T::new(8.0))
}
