//! Both fits with the sums over the bins in integers, for cores without an FPU: only what is done once
//! a step stays in `f32`.
//!
//! Formats: frequencies u and p in Q23 (their differences stay below 256), h in Q26, h' in Q22, sines
//! and slants in Q26; bins as the FFT stores them, less two bits. A reciprocal is one 32-bit
//! division to 15 bits and one step of Newton's to 30. Whatever leaves its range near DC saturates. The
//! difference from `f32` is 0.02 of the Cramer-Rao bound at 60 dB and N = 4096, rms, and less elsewhere.

use super::series::circle;
use super::{Course, Fit, Reach, first_two, iq, real};
use crate::acquire::sample::Record;
use crate::scalar::Scalar;
use crate::spectrum::Spectrum;
use crate::spectrum::bins::REACH;
use crate::spectrum::engine::Engine;
use crate::spectrum::fft::twiddle::sin_cos;
use core::f64::consts::{PI, TAU};
use heapless::Vec;
use num_complex::Complex;

/// The bits by which the FFT's bins are shifted down.
pub(crate) const ROOM: u32 = 2;

const SINGLE: f32 = 1.0 / 67_108_864.0; // 2^-26

/// For a distance i of 1..=16 bins, `e = 2 pi/N`: `sin(e i)/e` in Q23, `(1 - cos e i)/e^2` in Q22 and
/// `1 - cos e i` in Q26; `tan(e i/2)/(e/2)` in Q23, `tan(e i/2)` in Q29 and its square in Q29.
struct Distance {
    near: i32,
    bend: i32,
    versine: i32,
    u: i32,
    tangent: i32,
    square: i32,
}

const fn distances<const N: usize>() -> [Distance; REACH] {
    const NONE: Distance = Distance { near: 0, bend: 0, versine: 0, u: 0, tangent: 0, square: 0 };
    let mut table = [NONE; REACH];
    let e = TAU / N as f64;
    let mut i = 1;
    while i <= REACH {
        let (sin, cos) = sin_cos(i, 2 * N);
        let (versine, tangent) = (2.0 * sin * sin, sin / cos);
        // The compiler runs this: an index out of range would not build.
        #[allow(clippy::indexing_slicing)]
        {
            table[i - 1] = Distance {
                near: nearest(2.0 * sin * cos / e, 23),
                bend: nearest(versine / (e * e), 22),
                versine: nearest(versine, 26),
                u: nearest(tangent / (PI / N as f64), 23),
                tangent: nearest(tangent, 29),
                square: nearest(tangent * tangent, 29),
            };
        }
        i += 1;
    }
    table
}

const fn nearest(x: f64, bits: u32) -> i32 {
    (x * (1u64 << bits) as f64 + 0.5) as i32
}

/// As [`super::fit`], from the spectrum itself.
pub fn fit<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    peak: i32,
    reach: Reach,
    course: Course<f32>,
) -> Option<Fit<f32>> {
    let last = N as i32 / 2 - 1;
    let unit = f32::two_to(spectrum.exponent());
    let x = spectrum.bin(peak);
    let centre = Complex::new(x.re as f32, x.im as f32) * unit;
    if (!R::IQ && (peak < 1 || peak > last)) || centre.norm_sqr() <= 0.0 {
        return None;
    }
    let table = const { &distances::<N>() };
    let near = table.iter().take(reach as usize).zip(1..);
    let scale = unit * (1u32 << ROOM) as f32;
    let fit = if R::IQ {
        let mut sides = Vec::new();
        for (distance, i) in near {
            for sign in [-1, 1] {
                // The vector holds every distance up to the reach.
                let _ = sides.push(IqSide::new(bin(spectrum, peak + sign * i), distance, sign));
            }
        }
        let e = (PI / N as f64) as f32;
        let near = first_two(sides.iter().map(|side: &IqSide| side.float(scale)));
        iq::Problem { e, centre, near, sides: IqSides { scale, sides } }.fit(course)
    } else {
        let e = (TAU / N as f64) as f32;
        let w = circle::<f32>(peak, N as i32);
        let c = e * (w.re / w.im);
        let mut sides = Vec::new();
        for (distance, i) in near {
            for sign in [-1, 1] {
                let k = peak + sign * i;
                if k >= 1 && k <= last {
                    let x = bin(spectrum, k);
                    let _ = sides.push(RealSide::new(x, distance, sign, quantised(c, 30), e));
                }
            }
        }
        let near = first_two(sides.iter().map(|side: &RealSide| side.float(scale)));
        let sides = RealSides { scale, sides };
        real::Problem { peak, last, e, c, centre, near, sides }.fit(course)
    };
    Some(fit)
}

pub(crate) fn bin<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    k: i32,
) -> [i32; 2] {
    let x = spectrum.bin(k);
    [x.re >> ROOM, x.im >> ROOM]
}

/// `x` with so many fractional bits, saturated.
pub(crate) fn quantised(x: f32, bits: u32) -> i32 {
    (x * (1u32 << bits) as f32) as i32
}

pub(crate) fn product(a: i32, b: i32) -> i64 {
    i64::from(a) * i64::from(b)
}

#[allow(clippy::manual_clamp)] // `clamp` checks its bounds
pub(crate) fn held(x: i64) -> i32 {
    x.max(i64::from(i32::MIN)).min(i64::from(i32::MAX)) as i32
}

/// h in Q26 and h' in Q22, for p and u in Q23.
fn shape(p: i32, u: i32) -> (i32, i32) {
    let difference = p.saturating_sub(u);
    let size = difference.unsigned_abs().max(1).min(i32::MAX as u32);
    // Normalised to 2^30..2^31, so that its upper half is neither zero nor above 2^16.
    let room = size.leading_zeros() - 1;
    let m = size << room;
    let rough = u64::from(u32::MAX.checked_div(m >> 15).unwrap_or(u32::MAX));
    // 1/m is about rough / 2^47; Newton: rough (2 - m rough / 2^47).
    let rest = (1u64 << 48).saturating_sub(u64::from(m) * rough) >> 17;
    let inverse = ((rough * rest) >> 16) as i64;
    // 1/m = inverse / 2^61 and 1/|p - u| = 2^(23 + room) / m: in Q26, inverse >> (12 - room).
    let inverse = if room <= 12 { inverse >> (12 - room) } else { inverse << (room - 12) };
    let inverse = held(if difference < 0 { -inverse } else { inverse });
    let h = held(product(p, inverse) >> 23);
    let slope = held(product((1i32 << 26).saturating_sub(h), inverse) >> 30);
    (h, slope)
}

/// One bin of a real record.
struct RealSide {
    u: i32,
    s: i32,
    slant: i32,
    x: [i32; 2],
    v: i32,
}

struct RealSides {
    scale: f32,
    sides: Vec<RealSide, { 2 * REACH }>,
}

impl RealSide {
    fn new(x: [i32; 2], distance: &Distance, sign: i32, c: i32, e: f32) -> Self {
        let u = held(product(c, distance.bend) >> 29).saturating_add(sign * distance.near);
        let s = (1i32 << 26)
            .saturating_sub(distance.versine)
            .saturating_add(sign.saturating_mul(held(product(c, distance.near) >> 27)));
        let slant = held(product(quantised(e, 30), u) >> 27);
        let v = held((product(s, x[1]) >> 26) - (product(slant, x[0]) >> 26));
        Self { u, s, slant, x, v }
    }

    fn float(&self, scale: f32) -> real::Side<f32> {
        real::Side {
            u: self.u as f32 * (SINGLE * 8.0),
            s: self.s as f32 * SINGLE,
            x: Complex::new(self.x[0] as f32, self.x[1] as f32) * scale,
            v: self.v as f32 * scale,
        }
    }
}

/// 2^-32, the unit of sums of weights.
const WEIGHT: f32 = SINGLE / 64.0;

impl real::Sides<f32> for RealSides {
    fn sums(&self, p: f32) -> real::Sums<f32> {
        let p = quantised(p, 23);
        let (mut aa, mut s1, mut bb, mut dd) = (0i64, 0i64, 0i64, 0i64);
        let (mut r1, mut r2, mut q1, mut q2) = (0i64, 0i64, 0i64, 0i64);
        for side in &self.sides {
            let (h, slope) = shape(p, side.u);
            aa = aa.saturating_add(product(h, h) >> 20);
            s1 = s1.saturating_add(i64::from(slope));
            bb = bb.saturating_add(product(h, slope) >> 16);
            dd = dd.saturating_add(product(slope, slope) >> 12);
            r1 = r1.saturating_add(product(h, side.x[0]) >> 10);
            r2 = r2.saturating_add(product(h, side.v) >> 10);
            q1 = q1.saturating_add(product(slope, side.x[0]) >> 6);
            q2 = q2.saturating_add(product(slope, side.v) >> 6);
        }
        // Products with bins have 16 fractional bits.
        let bins = self.scale * (SINGLE * 1024.0);
        real::Sums {
            aa: aa as f32 * WEIGHT,
            s1: s1 as f32 * (SINGLE * 16.0),
            bb: bb as f32 * WEIGHT,
            dd: dd as f32 * WEIGHT,
            r1: r1 as f32 * bins,
            r2: r2 as f32 * bins,
            q1: q1 as f32 * bins,
            q2: q2 as f32 * bins,
        }
    }

    fn residual(&self, p: f32, line: Complex<f32>) -> f32 {
        let p = quantised(p, 23);
        let (a, b) = ((line.re / self.scale) as i32, (line.im / self.scale) as i32);
        let mut sum = 0i64;
        for side in &self.sides {
            let (h, _) = shape(p, side.u);
            let re = held(i64::from(a) - (product(b, side.slant) >> 26));
            let im = held(product(b, side.s) >> 26);
            let left = [re, im].map(|model| product(model, h) >> 26);
            for (x, model) in side.x.into_iter().zip(left) {
                let left = held(i64::from(x) - model);
                sum = sum.saturating_add(product(left, left));
            }
        }
        sum as f32 * self.scale * self.scale
    }

    fn count(&self) -> usize {
        self.sides.len()
    }
}

/// One bin of an I/Q record.
struct IqSide {
    u: i32,
    m: i32,
    inverse_m: i32,
    y: [i32; 2],
}

struct IqSides {
    scale: f32,
    sides: Vec<IqSide, { 2 * REACH }>,
}

impl IqSide {
    fn new(x: [i32; 2], distance: &Distance, sign: i32) -> Self {
        let lean = sign * distance.tangent;
        let y = [
            held(i64::from(x[0]) + (product(lean, x[1]) >> 29)),
            held(i64::from(x[1]) - (product(lean, x[0]) >> 29)),
        ];
        // 1/(1 + tan^2) = cos^2 = 1 - versine/2.
        let inverse_m = (1i32 << 26) - distance.versine / 2;
        Self { u: sign * distance.u, m: (1i32 << 29) + distance.square, inverse_m, y }
    }

    fn float(&self, scale: f32) -> iq::Side<f32> {
        iq::Side {
            u: self.u as f32 * (SINGLE * 8.0),
            m: self.m as f32 * (SINGLE / 8.0),
            y: Complex::new(self.y[0] as f32, self.y[1] as f32) * scale,
        }
    }
}

impl iq::Sides<f32> for IqSides {
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

    fn residual(&self, p: f32, c: Complex<f32>) -> f32 {
        let p = quantised(p, 23);
        let c = [(c.re / self.scale) as i32, (c.im / self.scale) as i32];
        let mut sum = 0i64;
        for side in &self.sides {
            let (h, _) = shape(p, side.u);
            let mh = held(product(side.m, h) >> 29);
            for (y, c) in side.y.into_iter().zip(c) {
                let left = held(i64::from(y) - (product(c, mh) >> 26));
                let share = held(product(left, side.inverse_m) >> 26);
                sum = sum.saturating_add(product(left, share));
            }
        }
        sum as f32 * self.scale * self.scale
    }

    fn count(&self) -> usize {
        self.sides.len()
    }
}
