//! What tones leave in the second differences of bins, which are Hann's window.

use super::super::least_squares::Fit;
use super::super::several::Found;
use super::Hunt;
use crate::acquire::sample::Record;
use crate::math::series::line_shape;
use crate::spectrum::engine::Engine;
use crate::spectrum::fft::integer::Point;
use num_complex::Complex;

/// A tone leaks into second differences up to so many bins away: beyond by less than -100 dB.
pub(super) const LEAKS: i32 = 32;

/// A tone's leakage into second differences of bins.
pub(super) struct Leak {
    peak: i32,
    offset: f32,
    /// `line sin(pi d) / pi`.
    value: Complex<f32>,
}

impl Leak {
    pub(super) fn of<R: Record, const N: usize>(found: &Found) -> Self {
        let Fit { offset, line, .. } = found.fit;
        // A real line and an I/Q line are turned by different angles.
        let angle = if R::IQ { offset * core::f32::consts::PI / N as f32 } else { 0.0 };
        let value = line * Complex::new(1.0, angle) * (offset * line_shape(offset));
        Self { peak: found.peak, offset, value }
    }

    /// The tone's own share of the difference around `k`, with that of a real tone's image.
    fn at<R: Record, const N: usize>(&self, k: i32) -> Complex<f32> {
        let tail = |x: f32| 1.0 / (x * (x * x - 1.0));
        let (n, zero) = (N as i32, Complex::new(0.0, 0.0));
        let mut apart = self.peak.wrapping_sub(k);
        if R::IQ {
            apart = (apart + n / 2).checked_rem_euclid(n).unwrap_or(0) - n / 2;
        }
        let own =
            if apart.abs() <= LEAKS { self.value * tail(apart as f32 + self.offset) } else { zero };
        let low = self.peak < n / 4;
        let across = self.peak + k - if low { 0 } else { n };
        if R::IQ || across.abs() > LEAKS {
            return own;
        }
        let image = if low { self.value.conj() } else { -self.value.conj() };
        own + image * tail((across as f32 + self.offset).abs())
    }
}

impl<R: Record, const N: usize, E: Engine> Hunt<'_, R, N, E> {
    /// Half the second difference of three bins around `k`, less what the tones near it leave there:
    /// `c sin(pi d) / (pi x (x^2 - 1))`, see [`super::noise::ring`].
    pub(super) fn difference(
        &self,
        k: i32,
        [before, here, after]: [Complex<f32>; 3],
    ) -> Complex<f32> {
        let mut rest = (before + after) * 0.5 - here;
        for leak in &self.leaks {
            rest -= leak.at::<R, N>(k);
        }
        rest
    }

    /// Points as bins in codes.
    pub(super) fn wide(&self, points: &[Point; 3]) -> [Complex<f32>; 3] {
        points.map(|[re, im]| Complex::new(re as f32, im as f32) * self.rest.unit)
    }

    /// A bin as it is.
    pub(super) fn bin(&self, k: i32) -> Complex<f32> {
        let x = self.rest.spectrum.bin(k);
        Complex::new(x.re as f32, x.im as f32) * self.rest.unit
    }

    /// The power of the difference around bin `k`.
    pub(super) fn power(&self, k: i32) -> f32 {
        self.difference(k, [-1, 0, 1].map(|i| self.bin(k + i))).norm_sqr()
    }
}
