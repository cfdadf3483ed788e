//! A spectrum less the models of the tones that were found. A model is evaluated where needed.

use super::super::noise::rounding;
use super::super::noise::whole;
use super::{ROOM, apart};
use crate::acquire::sample::Record;
use crate::spectrum::Spectrum;
use crate::spectrum::bins::{Bins, Rectangular};
use crate::spectrum::engine::Engine;
use crate::tone::fit::{Fit, Model};
use heapless::Vec;
use num_complex::Complex;

/// Tones that end up nearer than this cannot be separated, in bins.
const UNRESOLVED: f32 = 1.9;

/// A tone whose fit is still refined.
#[derive(Clone, Copy)]
pub(super) struct Found {
    pub peak: i32,
    pub fit: Fit<f32>,
    pub model: Model<f32>,
}

/// A spectrum less the models of tones.
pub(super) struct Rest<'a, R: Record, const N: usize, E: Engine> {
    pub spectrum: &'a Spectrum<R, N, E>,
    pub unit: f32,
    pub found: Vec<Found, ROOM>,
}

impl<R: Record, const N: usize, E: Engine> Rest<'_, R, N, E> {
    /// Bin `k` less every model but the one at `except`.
    pub fn bin(&self, k: i32, except: Option<usize>) -> Complex<f32> {
        let x = self.spectrum.bin(k);
        let mut rest = Complex::new(x.re as f32, x.im as f32) * self.unit;
        for (index, found) in self.found.iter().enumerate() {
            if Some(index) != except {
                rest -= found.model.bin::<R>(k);
            }
        }
        rest
    }

    pub fn bins(&self, peak: i32, except: Option<usize>) -> Bins<f32, R, Rectangular> {
        Bins::gather(N, peak, |k| self.bin(k as i32, except))
    }

    /// Bins from `k` to the nearest tone.
    pub fn nearest(&self, k: i32) -> i32 {
        self.found.iter().map(|found| apart::<R, N>(k, found.peak)).min().unwrap_or(N as i32)
    }

    /// Whether another tone ended up too near to this one.
    pub fn crowded(&self, one: &Found) -> bool {
        let apart = |other: &Found| {
            let apart = (other.peak - one.peak) as f32 + other.fit.offset - one.fit.offset;
            let n = N as f32;
            if R::IQ { apart.abs().min(n - apart.abs()) } else { apart.abs() }
        };
        self.found.iter().filter(|other| apart(other) < UNRESOLVED).count() > 1
    }

    /// The noise power per sample: the residual of all models in all bins, of a record without a ring.
    pub fn noise(&self) -> f32 {
        let count = whole::count(N, R::IQ) as i32;
        let sum = (1..=count).fold(0.0, |sum, k| sum + self.bin(k, None).norm_sqr());
        (sum / (count as f32 * N as f32)).max(rounding(R::IQ))
    }
}
