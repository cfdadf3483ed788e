//! The fit of [`super::super::iq`] with the sums in integers.

use super::near::Near;
use super::{ROOM, around, held, product, quantised, shape};
use crate::math::scalar::Scalar as _;
use crate::spectrum::bins::REACH;
use crate::spectrum::fft::integer::Point;
use crate::spectrum::layout::IqDistance;
use crate::tone::fit::rest::Rest;
use crate::tone::fit::{Fit, FitStart, first_two, iq};
use heapless::Vec;
use num_complex::Complex;

/// 2^-26, the unit of sums.
const SINGLE: f32 = 1.0 / 67_108_864.0;

/// 2^-32, the unit of sums of weights.
const WEIGHT: f32 = SINGLE / 64.0;

/// Fits a tone to `bins`, of which the middle one is the peak. Their unit is `2^exponent` codes.
pub(in crate::tone::fit) fn fit(
    n: i32,
    peak: i32,
    bins: &[Point],
    table: &[IqDistance],
    exponent: i32,
    course: FitStart<f32>,
) -> Option<Fit<f32>> {
    let unit = f32::two_to(exponent);
    let &[re, im] = bins.get(bins.len() / 2)?;
    let centre = Complex::new(re as f32, im as f32) * unit;
    if centre.norm_sqr() <= 0.0 {
        return None;
    }
    let scale = f32::two_to(exponent + ROOM as i32);
    let e = core::f32::consts::PI / n as f32;
    let unit = exponent + ROOM as i32;
    let (near, sides) = (Vec::new(), Sides { scale, unit, sides: Vec::new() });
    let mut problem = iq::Problem { e, centre, near, sides };
    let further = matches!(course, FitStart::Further(..));
    let float = |[re, im]: Point| Complex::new(re as f32, im as f32);
    for (distance, i) in table.iter().zip(1..=(bins.len() / 2) as i32) {
        for sign in [-1, 1] {
            let k = peak.wrapping_add(sign * i);
            let nearer = || float(around(bins, sign * (i - 1)).unwrap_or_default());
            let stays = |&x: &Point| !iq::is_left_out(k, n, i, further, float(x), nearer);
            if let Some(x) = around(bins, sign * i).filter(stays) {
                // The vector holds every distance up to the reach.
                let _ = problem.sides.sides.push(Side::new(x, distance, sign, i));
            }
        }
    }
    problem.near = first_two(problem.sides.sides.iter().map(|side| side.float(scale)));
    Some(problem.fit(course))
}

/// One bin of an I/Q record.
struct Side {
    /// The distance from the peak in bins.
    i: i32,
    u: i32,
    m: i32,
    inverse_m: i32,
    y: [i32; 2],
}

struct Sides {
    scale: f32,
    /// `scale` as a power of two.
    unit: i32,
    sides: Vec<Side, { 2 * REACH }>,
}

impl Side {
    fn new(x: [i32; 2], distance: &IqDistance, sign: i32, i: i32) -> Self {
        let lean = sign * distance.tangent;
        let y = [
            held(i64::from(x[0]) + (product(lean, x[1]) >> 29)),
            held(i64::from(x[1]) - (product(lean, x[0]) >> 29)),
        ];
        // 1/m = 1/(1 + tan^2) = cos^2.
        let m = (1i32 << 29) + distance.square;
        Self { i: sign * i, u: sign * distance.u, m, inverse_m: distance.inverse_m, y }
    }

    fn float(&self, scale: f32) -> iq::Side<f32> {
        iq::Side {
            i: self.i,
            u: self.u as f32 * (SINGLE * 8.0),
            m: self.m as f32 * (SINGLE / 8.0),
            y: Complex::new(self.y[0] as f32, self.y[1] as f32) * scale,
        }
    }
}

impl iq::Sides<f32> for Sides {
    fn sums(&self, p: f32) -> iq::Sums<f32> {
        let p = quantised(p, 23);
        let (mut aa, mut bb, mut dd) = (0i64, 0i64, 0i64);
        let (mut pp, mut qq) = ([0i64; 2], [0i64; 2]);
        for side in &self.sides {
            let (h, slope) = shape(p, side.u);
            let mh = held(product(side.m, h) >> 29);
            let ms = held(product(side.m, slope) >> 29);
            aa = aa.saturating_add(product(mh, h) >> 20);
            bb = bb.saturating_add(product(mh, slope) >> 16);
            dd = dd.saturating_add(product(ms, slope) >> 12);
            for (sum, y) in pp.iter_mut().zip(side.y) {
                *sum = sum.saturating_add(product(h, y) >> 10);
            }
            for (sum, y) in qq.iter_mut().zip(side.y) {
                *sum = sum.saturating_add(product(slope, y) >> 6);
            }
        }
        let bins = self.scale * (SINGLE * 1024.0);
        iq::Sums {
            aa: aa as f32 * WEIGHT,
            bb: bb as f32 * WEIGHT,
            dd: dd as f32 * WEIGHT,
            pp: Complex::new(pp[0] as f32, pp[1] as f32) * bins,
            qq: Complex::new(qq[0] as f32, qq[1] as f32) * bins,
        }
    }

    fn residual(&self, d: f32, p: f32, c: Complex<f32>, centre: Complex<f32>) -> (f32, Rest<f32>) {
        let (p, d) = (quantised(p, 23), quantised(d, 30));
        let c = [(c.re / self.scale) as i32, (c.im / self.scale) as i32];
        let left = |side: &Side| {
            let (h, _) = shape(p, side.u);
            let mh = held(product(side.m, h) >> 29);
            let [re, im] = [0, 1].map(|part: usize| {
                let [y, c] = if part == 0 { [side.y[0], c[0]] } else { [side.y[1], c[1]] };
                held(i64::from(y) - (product(c, mh) >> 26))
            });
            [re, im]
        };
        let centre = [(centre.re / self.scale) as i32, (centre.im / self.scale) as i32];
        let mut near = Near::new(centre);
        let mut sum = 0i64;
        for side in &self.sides {
            let left = left(side);
            near.take(side.i, left);
            for part in left {
                let share = held(product(part, side.inverse_m) >> 26);
                sum = sum.saturating_add(product(part, share));
            }
        }
        (sum as f32 * self.scale * self.scale, near.rest(d, self.unit, None))
    }

    fn count(&self) -> usize {
        self.sides.len()
    }
}
