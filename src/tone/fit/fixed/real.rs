//! The fit of [`super::super::real`] for cores without an FPU.

use super::equations::{Place, Sums};
use super::near::Near;
use super::scaled::Scaled;
use super::trigonometry::{cosine, sinc};
use super::{ONE, ROOM, add, around, nearest, product, root, shape, shifted, square, times};
use crate::spectrum::bins::REACH;
use crate::spectrum::fft::integer::Point;
use crate::spectrum::layout::RealDistance;
use crate::tone::fit::descent::Descent;
use crate::tone::fit::{EDGE_LIMIT, Fit, FitStart, OFFSET_LIMIT, SETTLED, START_LIMIT};
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
use core::ops::RangeInclusive;
use heapless::Vec;
use num_complex::Complex;
use num_traits::One as _;

/// A bin beside the peak.
pub(super) struct Side {
    /// The distance from the peak in bins.
    pub i: i32,
    pub u: i32,
    pub s: i32,
    pub x: [i32; 2],
    /// s Im
    y: i32,
    /// h and h' at the last sums.
    pub h: i32,
    pub slope: i32,
}

/// The peak's place, in Q30.
pub(super) struct Peak {
    pub e: i32,
    c: i32,
    pub centre: [i32; 2],
    /// The logarithm of the record's length.
    bits: u32,
}

/// An offset, its p, dp/dd, and p/d.
pub(super) struct Offset {
    pub d: i32,
    pub p: i32,
    pub speed: i32,
    ratio: i32,
}

const fn bins(x: f64) -> i32 {
    nearest(x, 30)
}

/// Fits a tone to the bins around `peak`, which is the middle one of `bins`. Their unit is
/// `2^exponent` codes.
pub(in crate::tone::fit) fn fit(
    n: i32,
    peak: i32,
    bins: &[Point],
    table: &[RealDistance],
    exponent: i32,
    course: FitStart<f32>,
) -> Option<Fit<f32>> {
    let last = n / 2 - 1;
    let place = Peak::new(n, peak, bins)?;
    let mut sides = Vec::new();
    read(&place, bins, table, 1 - peak..=last - peak, &mut sides);
    Some(place.fit(peak, last, &mut sides, exponent + ROOM as i32, course))
}

/// Takes the bins at these distances beside the peak, the nearest first.
#[inline(always)]
pub(super) fn read(
    place: &Peak,
    bins: &[Point],
    table: &[RealDistance],
    room: RangeInclusive<i32>,
    sides: &mut Vec<Side, { 2 * REACH }>,
) {
    for (distance, i) in table.iter().zip(1..=(bins.len() / 2) as i32) {
        let bend = shifted::<29>(place.c, distance.bend);
        let lean = shifted::<27>(place.c, distance.near);
        let still = (1 << 26) - distance.versine;
        for (k, near, s) in [(-i, -distance.near, still - lean), (i, distance.near, still + lean)] {
            if let Some(x) = around(bins, k).filter(|_| room.contains(&k)) {
                // The vector holds every distance up to the reach.
                let y = shifted::<26>(s, x[1]);
                let _ = sides.push(Side { i: k, u: near + bend, s, x, y, h: 0, slope: 0 });
            }
        }
    }
}

/// c = e cot(2 pi peak / n) in Q30, which is never above 1. Near DC and Nyquist, where c matters,
/// no sine of a small angle is needed.
fn lean(peak: i32, n: i32) -> i32 {
    let mirrored = n / 2 - peak;
    let k = peak.min(mirrored);
    let low = 8 * k <= n;
    // The angle, or its complement, as a share of a right angle in Q30.
    let bits = 32u32.wrapping_sub(n.trailing_zeros()) & 31;
    let share = if low { k << bits } else { (n / 4 - k) << bits };
    let x = shifted::<29>(share, const { nearest(FRAC_PI_2, 29) });
    let z = times(x, x);
    let (cos, sinc) = (cosine(z), sinc(z));
    let c = if low {
        Scaled::new(cos, 0) / Scaled::new(sinc, 0) / Scaled::new(k, 0)
    } else {
        let e = Scaled::new(x, -30) * Scaled::new(const { bins(FRAC_PI_4) }, 3 - 30);
        e * Scaled::new(sinc, 0) / Scaled::new(cos, 0) / Scaled::new(n, 0)
    };
    let c = c.bits(30);
    if peak == k { c } else { -c }
}

impl Peak {
    /// The problem of the middle one of these bins; `None` at DC and Nyquist, and without a signal.
    pub fn new(n: i32, peak: i32, bins: &[Point]) -> Option<Self> {
        let centre = around(bins, 0)?;
        if peak < 1 || peak >= n / 2 || centre == [0; 2] {
            return None;
        }
        let bits = n.trailing_zeros();
        // One turn in Q30, divided by N.
        let e = (TAU * f64::from(ONE) + 0.5) as i64 >> bits;
        Some(Self { e: e as i32, c: lean(peak, n), centre, bits })
    }

    /// The least and the largest offset: the tone stays between DC and Nyquist.
    pub fn limits(peak: i32, last: i32) -> [i32; 2] {
        let low = if peak < 2 { bins(EDGE_LIMIT) - ONE } else { -bins(OFFSET_LIMIT) };
        let high = if peak >= last { ONE - bins(EDGE_LIMIT) } else { bins(OFFSET_LIMIT) };
        [low, high]
    }

    /// The inputs of the normal equations beside their sums.
    pub fn equations(&self, sides: &[Side]) -> Place {
        Place {
            e: Scaled::new(self.e, -30),
            twice_c: Scaled::new(self.c, -29),
            centre: Complex::new(Scaled::new(self.centre[0], 0), Scaled::new(self.centre[1], 0)),
            total: Scaled::from_sum(sides.iter().map(|side| i64::from(side.x[0])).sum(), 0),
        }
    }

    /// The steps of [`super::super::real::Problem::fit`].
    fn fit(
        &self,
        peak: i32,
        last: i32,
        sides: &mut [Side],
        unit: i32,
        course: FitStart<f32>,
    ) -> Fit<f32> {
        let edge = peak < 3 || peak > last - 2;
        let usual = || (self.start(sides), if edge { 3 } else { 2 });
        let (descent, enough) = Descent::new(course, usual, Self::limits(peak, last));
        let further = descent.further;
        let place = self.equations(sides);
        let end = descent.to_the_end(|d| {
            let at = self.at(d);
            let step = place.step(Scaled::new(at.p, -30), sums(sides, at.p));
            let speed = Scaled::new(at.speed, -30);
            ((step.gradient / (step.information * speed)).bits(30), enough, (at.p, speed, step))
        });
        let ((before, speed, step), at) = (end.last, self.at(end.at));
        let onward = at.p - before;
        let far = Scaled::new(onward, -30);
        let line =
            Complex::new(step.line.re + step.slope.re * far, step.line.im + step.slope.im * far);
        let mut information = step.information * speed * speed;
        if further {
            information = information * Scaled::from_float(end.sharpness, 0);
        }
        self.finish(&at, line, information, onward, sides, unit)
    }

    /// p of an offset d.
    pub fn at(&self, d: i32) -> Offset {
        let angle = times(self.e, d);
        let y = times(angle, angle);
        let cos = ONE - (y >> 1) + times(times(y, y), const { bins(1.0 / 24.0) });
        let sinc =
            ONE - times(y, const { bins(1.0 / 6.0) } - times(y, const { bins(1.0 / 120.0) }));
        let lean = times(self.c, d);
        let ratio = sinc + times(lean, ONE / 2 - times(y, const { bins(1.0 / 24.0) }));
        Offset { d, p: times(d, ratio), speed: cos + times(lean, sinc), ratio }
    }

    /// `1 + 2 c p - e^2 p^2`, the square of the ratio of the sines of tone and peak.
    fn root(&self, p: i32) -> Scaled {
        let angle = times(self.e, p);
        // In Q28, because it may reach 4.
        root((ONE >> 2) + (times(self.c, p) >> 1) - (times(angle, angle) >> 2))
    }

    /// The offset from the peak and its two neighbours, see [`super::super::real`].
    pub fn start(&self, sides: &[Side]) -> i32 {
        let [a, b] = self.centre;
        let (mut above, mut below) = (Scaled::new(0, 0), Scaled::new(0, 0));
        for side in sides.iter().take(2) {
            let slant = shifted::<27>(self.e, side.u);
            let re = (side.x[0] - a).wrapping_add(shifted::<26>(slant, b));
            let im = side.x[1].wrapping_sub(shifted::<26>(side.s, b));
            let across = product(side.x[0], re).wrapping_add(product(side.x[1], im));
            above = above + Scaled::new(side.u, -23) * Scaled::from_sum(across, 0);
            let size = square(re).wrapping_add(square(im));
            below = below + Scaled::from_sum(size, 0);
        }
        let p = limit((above / below).bits(30), START_LIMIT);
        let half = (Scaled::new(p, -30) / (Scaled::one() + self.root(p))).bits(30);
        let tangent = times(self.e, half);
        let third = times(times(tangent, tangent), const { bins(1.0 / 3.0) });
        times(half, ONE - third) << 1
    }

    /// The result as in [`super::super::real::Problem::finish`], `onward` in p from the last sums.
    pub fn finish(
        &self,
        at: &Offset,
        line: Complex<Scaled>,
        information: Scaled,
        onward: i32,
        sides: &[Side],
        unit: i32,
    ) -> Fit<f32> {
        let (peak, Complex { re: a, im: b }) = (line, line);
        // sin(pi d) / (pi d), by doubling the angle twice.
        let x = times(at.d, const { bins(FRAC_PI_4) });
        let z = times(x, x);
        let cos = cosine(z);
        let shape = times(times(sinc(z), cos), (times(cos, cos) - ONE / 2) << 1);
        let scale = Scaled::new(at.ratio, 0) / Scaled::new(shape, 0);
        let bent = Scaled::new(times(self.e, at.p), -30) * b;
        let turned = Complex::new((a - bent) * scale / self.root(at.p), b * scale);
        let float = |z: Complex<Scaled>| Complex::new(z.re.float(unit), z.im.float(unit));
        let line = [(a - bent).bits(0), bent.bits(0), b.bits(0)];
        let (left, near) = self.residual(at, onward, line, sides);
        Fit {
            offset: Scaled::new(at.d, -30).float(0),
            line: float(turned),
            information: information.float(2 * unit),
            peak: float(peak),
            lever: Complex::new(Scaled::new(at.p, -30).float(0), 0.0),
            residual: left.float(2 * unit),
            dof: (2 * sides.len() as u32 + 2).saturating_sub(3),
            rest: near.rest(at.d, unit, Some(self.bits)),
        }
    }

    /// The power that the model leaves. As `u h = p (h - 1)`, its real part is `(a - e p b) h + e p b`, and its imaginary part `b s h`. A
    /// last step that has settled changes h as h' says, with an error below a hundredth of the residual.
    fn residual(
        &self,
        at: &Offset,
        onward: i32,
        [turning, still, b]: [i32; 3],
        sides: &[Side],
    ) -> (Scaled, Near) {
        let ([re, im], p) = (self.centre, narrow(at.p));
        let settled = onward.abs() <= bins(SETTLED);
        let centre = [re.wrapping_sub(turning.wrapping_add(still)), im.wrapping_sub(b)];
        let mut near = Near::new(centre);
        let mut sum = squares(centre[0], centre[1]);
        for side in sides {
            let h = if settled {
                side.h.wrapping_add(shifted::<26>(onward, side.slope))
            } else {
                shape(p, side.u).0
            };
            let re = shifted::<26>(h, turning);
            let im = shifted::<26>(side.s, shifted::<26>(h, b));
            let left = [side.x[0].wrapping_sub(re.wrapping_add(still)), side.x[1].wrapping_sub(im)];
            near.take(side.i, left);
            sum = sum.wrapping_add(squares(left[0], left[1]));
        }
        (Scaled::from_sum((sum >> 1) as i64, 1), near)
    }
}

/// Squared size of a bin. Powers of bins sum to less than 2^60, and so do the residuals of a fitted model.
fn squares(re: i32, im: i32) -> u64 {
    (square(re) as u64).wrapping_add(square(im) as u64)
}

/// The sums at p.
pub(super) fn sums(sides: &mut [Side], p: i32) -> Sums {
    let p = narrow(p);
    let (mut aa, mut s1, mut bb, mut dd) = (0, 0i64, 0, 0);
    let (mut r1, mut r2, mut q1, mut q2) = (0, 0, 0, 0);
    for side in sides {
        let (h, slope) = shape(p, side.u);
        (side.h, side.slope) = (h, slope);
        add(&mut aa, h, h);
        s1 += i64::from(slope);
        add(&mut bb, h, slope);
        add(&mut dd, slope, slope);
        add(&mut r1, h, side.x[0]);
        add(&mut r2, h, side.y);
        add(&mut q1, slope, side.x[0]);
        add(&mut q2, slope, side.y);
    }
    Sums {
        aa: Scaled::from_sum(aa, -52),
        s1: Scaled::from_sum(s1, -22),
        bb: Scaled::from_sum(bb, -48),
        dd: Scaled::from_sum(dd, -44),
        r1: Scaled::from_sum(r1, -26),
        r2: Scaled::from_sum(r2, -26),
        q1: Scaled::from_sum(q1, -22),
        q2: Scaled::from_sum(q2, -22),
    }
}

/// From Q30 to Q23.
fn narrow(p: i32) -> i32 {
    (p + (1 << 6)) >> 7
}

pub(super) fn limit(x: i32, bound: f64) -> i32 {
    x.max(-bins(bound)).min(bins(bound))
}
