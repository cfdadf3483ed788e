//! The fit beside slow terms, see [`super::super::slow`], for cores without an FPU.
//!
//! Every bin has three vectors of length 1 over all bins, orthogonal to one another: one for a line, one for a parabola, one for the rest.
//! Line and rest lie along `j exp(j t)`, the parabola along `exp(j t)`, with `t = pi k / N`.

use super::equations::Place;
use super::real::{Peak, Side, limit, read, sums};
use super::scaled::Scaled;
use super::trigonometry::{cosine, sinc};
use super::{ONE, ROOM, add, held, nearest, product, shifted, times};
use crate::math::scalar::Scalar as _;
use crate::spectrum::bins::REACH;
use crate::spectrum::fft::integer::Point;
use crate::spectrum::layout::RealDistance;
use crate::tone::fit::real::{Products, STEPS};
use crate::tone::fit::slow::{self, TERMS};
use crate::tone::fit::{Fit, START_LIMIT, STEP_LIMIT};
use core::f64::consts::FRAC_PI_2;
use heapless::Vec;
use num_complex::Complex;
use num_traits::One as _;

/// The vectors' values in a bin.
struct Terms {
    /// In Q30.
    value: [[i32; 2]; TERMS],
    /// `s Im - e u Re` in Q26: next to Nyquist s is up to ten.
    across: [i32; TERMS],
}

/// The vectors in all bins of a fit, and their products with the data.
struct Slow {
    centre: Terms,
    sides: Vec<Terms, { 2 * REACH }>,
    data: [Scaled; TERMS],
}

/// The vectors' products with the model's basis and its derivative.
type Shares = [[Scaled; 4]; TERMS];

/// The fit of [`super::super::real::fit_beside_slow`], from bins in the form that [`super::real::fit`] takes.
pub(super) fn fit(
    n: i32,
    peak: i32,
    bins: &[Point],
    table: &[RealDistance],
    exponent: i32,
) -> Option<Fit<f32>> {
    let last = n / 2 - 1;
    let mut place = Peak::new(n, peak, bins)?;
    let mut sides = Vec::new();
    let first = slow::FIRST.min(peak - 2);
    read(&place, bins, table, first - peak..=last - peak, &mut sides);
    let slow = Slow::new(n, peak, &place, &sides)?;
    let equations = place.equations(&sides);
    let (low, high) = Peak::limits(peak, last);
    let mut at = place.at(limit(place.start(&sides), START_LIMIT).max(low).min(high));
    let (mut products, mut shares) = slow.products(&equations, at.p, &mut sides);
    for _ in 0..STEPS {
        let step = products.step();
        let forward = step.gradient / (step.information * Scaled::new(at.speed, -30));
        at = place.at((at.d + limit(forward.bits(30), STEP_LIMIT)).max(low).min(high));
        (products, shares) = slow.products(&equations, at.p, &mut sides);
    }
    let step = products.step();
    slow.take(step.line, &shares, &mut place, &mut sides);
    let speed = Scaled::new(at.speed, -30);
    let information = step.information * speed * speed;
    let mut fit = place.finish(&at, step.line, information, 0, &sides, exponent + ROOM as i32);
    fit.dof = fit.dof.saturating_sub(TERMS as u32).max(1);
    Some(fit)
}

/// `exp(j t)` in Q30, and `sin(t) / t`, with `t = pi k / N` within 0..=pi/2.
struct Turn {
    cos: i32,
    sin: i32,
    shape: i32,
}

impl Turn {
    fn new(k: i32, n: i32) -> Self {
        let bits = 30u32.wrapping_sub(n.trailing_zeros()) & 31;
        // Half the angle is at most pi/4.
        let x = times(k << bits, const { nearest(FRAC_PI_2, 30) });
        let z = times(x, x);
        let (cos, shape) = (cosine(z), times(sinc(z), cosine(z)));
        Self { cos: (times(cos, cos) - ONE / 2) << 1, sin: times(shape, x) << 1, shape }
    }
}

/// The turn of a bin, and the sizes of line, parabola and rest there, in Q30.
type Shape = (Turn, [i32; TERMS]);

/// The reciprocal square root of a positive number.
fn inverse_root(square: Scaled) -> Scaled {
    Scaled::one() / Scaled::from_float(square.float(0).root(), 0)
}

impl Slow {
    fn new(n: i32, peak: i32, place: &Peak, sides: &[Side]) -> Option<Self> {
        // A drift's leakage falls with the sine: relative to the lowest bin no value is above 1.
        let lowest = sides.iter().map(|side| side.i).fold(0, i32::min) + peak;
        let from = Scaled::new(Turn::new(lowest, n).shape, 0) * Scaled::new(lowest, 0);
        let mut shapes = Vec::<_, { 2 * REACH + 1 }>::new();
        let [mut lines, mut parabolas, mut both, mut rests] = [0i64; 4];
        for i in core::iter::once(0).chain(sides.iter().map(|side| side.i)) {
            let turn = Turn::new(peak + i, n);
            let near = from / (Scaled::new(turn.shape, 0) * Scaled::new(peak + i, 0));
            let line = near.bits(30);
            let square = times(line, line);
            let (parabola, rest) = (times(square, turn.cos), times(square, line));
            // The vector has room for the peak and all sides.
            let _ = shapes.push((turn, [line, parabola, rest]));
            lines += i64::from(times(line, line));
            parabolas += i64::from(times(parabola, parabola));
            both += i64::from(times(line, rest));
            rests += i64::from(times(rest, rest));
        }
        let [lines, parabolas, both, rests] =
            [lines, parabolas, both, rests].map(|sum| Scaled::from_sum(sum, -30));
        let share = both / lines;
        let left = Scaled::from_sum(i64::from((rests - share * both).bits(28).max(1)), -28);
        let scales = [lines, parabolas, left].map(inverse_root);
        let share = share.bits(30);
        let terms =
            |&(Turn { cos, sin, .. }, [line, parabola, rest]): &Shape, s: i32, lean: i32| {
                let mut sizes = [line, parabola, rest - times(share, line)];
                for (size, &scale) in sizes.iter_mut().zip(&scales) {
                    *size = (Scaled::new(*size, -30) * scale).bits(30);
                }
                let [line, parabola, rest] = sizes;
                let value = [
                    [-times(line, sin), times(line, cos)],
                    [times(parabola, cos), times(parabola, sin)],
                    [-times(rest, sin), times(rest, cos)],
                ];
                let across = value.map(|[re, im]| times(im, s) - times(re, lean));
                Terms { value, across }
            };
        let (centre, rest) = shapes.split_first()?;
        let (centre, data) = (terms(centre, 1 << 26, 0), [Scaled::ZERO; TERMS]);
        let mut slow = Self { centre, sides: Vec::new(), data };
        let mut data = [0i64; TERMS];
        let mut seen = |terms: &Terms, x: [i32; 2]| {
            for (sum, [re, im]) in data.iter_mut().zip(terms.value) {
                add(sum, re, x[0]);
                add(sum, im, x[1]);
            }
        };
        seen(&slow.centre, place.centre);
        for (side, shape) in sides.iter().zip(rest) {
            let terms = terms(shape, side.s, shifted::<27>(place.e, side.u));
            seen(&terms, side.x);
            // The vector has room for all sides.
            let _ = slow.sides.push(terms);
        }
        slow.data = data.map(|sum| Scaled::from_sum(sum, -30));
        Some(slow)
    }

    /// The inner products at p, without the parts along the vectors, and the vectors' shares of them.
    #[inline(never)]
    fn products(
        &self,
        equations: &Place,
        p: i32,
        sides: &mut [Side],
    ) -> (Products<Scaled>, Shares) {
        let mut products = equations.products(Scaled::new(p, -30), sums(sides, p));
        // The peak itself: h = 1, h' = 0.
        let Terms { value, across } = &self.centre;
        let mut shares = [[0i64; 4]; TERMS];
        for ((share, [re, _]), across) in shares.iter_mut().zip(value).zip(across) {
            *share = [i64::from(*re) << 26, i64::from(*across) << 26, 0, 0];
        }
        for (side, Terms { value, across }) in sides.iter().zip(&self.sides) {
            for ((share, &[re, _]), &across) in shares.iter_mut().zip(value).zip(across) {
                let [f1, f2, g1, g2] = share;
                add(f1, re, side.h);
                add(f2, across, side.h);
                add(g1, re, side.slope);
                add(g2, across, side.slope);
            }
        }
        let shares = shares.map(|[f1, f2, g1, g2]| {
            [
                Scaled::from_sum(f1, -56),
                Scaled::from_sum(f2, -52),
                Scaled::from_sum(g1, -52),
                Scaled::from_sum(g2, -48),
            ]
        });
        for (&[f1, f2, g1, g2], data) in shares.iter().zip(self.data) {
            products.less(f1, f2, g1, g2, data);
        }
        (products, shares)
    }

    /// Subtracts the slow terms from the bins, given the line and the terms' shares.
    fn take(&self, line: Complex<Scaled>, shares: &Shares, place: &mut Peak, sides: &mut [Side]) {
        let mut heights = [0; TERMS];
        for ((height, data), &[f1, f2, ..]) in heights.iter_mut().zip(self.data).zip(shares) {
            let rest = data - line.re * f1 - line.im * f2;
            // A height may be larger than any bin, by the root of their number.
            *height = (rest * Scaled::new(1, -3)).bits(0);
        }
        let less = |x: [i32; 2], terms: &Terms| {
            let mut left = x.map(i64::from);
            for (value, height) in terms.value.iter().zip(heights) {
                for (left, value) in left.iter_mut().zip(value) {
                    *left = left.wrapping_sub(product(*value, height) >> 27);
                }
            }
            left.map(held)
        };
        place.centre = less(place.centre, &self.centre);
        for (side, terms) in sides.iter_mut().zip(&self.sides) {
            side.x = less(side.x, terms);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Arithmetic, Codes, Config, Pipeline, Real, Stamp};
    use std::f64::consts::TAU;

    /// Tones at every bin up to Nyquist, beside drifts: the answers agree with the fit in floats, and no number is too large for its
    /// format.
    fn compare<const N: usize>() {
        let [mut fixed, mut float] = [Arithmetic::Fixed, Arithmetic::Float].map(|arithmetic| {
            let config = Config { arithmetic, ..Config::new(1.0, Codes::signed::<12>()) };
            Pipeline::<Real, N>::new(config.plan().unwrap())
        });
        let (mut both, mut differ) = (0, 0);
        for quarter in 12..4 * (N / 2).min(48) as i32 - 2 {
            for (drift, rise) in [(40.0, 0.0), (400.0, 0.0), (1500.0, 0.0), (150.0, 1.5)] {
                let samples = core::array::from_fn(|n| {
                    let time = n as f64 / N as f64;
                    let turns = (f64::from(quarter) / 4.0 + rise * (time - 1.0)) * time + 0.1;
                    let dither = f64::from((n as i32 * 7919 + quarter * 31) % 61 - 30) / 20.0;
                    (400.0 * (TAU * turns).cos() + drift * (time - 0.5) + dither).round() as i16
                });
                let [one, other] =
                    [&mut fixed, &mut float].map(|way| way.block(&Stamp::default(), &samples).tone);
                let apart = one.frequency.cycles() - other.frequency.cycles();
                let sigma = f64::from(one.sigma.max(other.sigma));
                both += 1;
                differ += u32::from(one.verdict != other.verdict || apart.abs() > sigma);
            }
        }
        assert!(20 * differ <= both, "{N}: {differ} of {both} differ");
    }

    #[test]
    fn the_fit_beside_a_drift_is_that_in_floats() {
        compare::<64>();
        compare::<128>();
        compare::<1024>();
        compare::<4096>();
    }
}
