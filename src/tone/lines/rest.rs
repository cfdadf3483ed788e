//! A spectrum less the models of the tones that were found. A model is evaluated where needed.

use super::super::noise::{Noise, rounding, whole};
use super::ROOM;
use crate::acquire::sample::Real;
use crate::spectrum::bins::{Bins, Rectangular};
use crate::spectrum::{layout::Layout, view::View};
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
pub(super) struct Rest<'a> {
    pub view: &'a View<'a>,
    pub layout: &'static Layout,
    pub unit: f32,
    pub found: Vec<Found, ROOM>,
}

impl Rest<'_> {
    /// Bin `k` less every model but the one at `except`.
    pub fn bin(&self, k: i32, except: Option<usize>) -> Complex<f32> {
        let x = self.view.bin(k);
        let mut rest = Complex::new(x.re as f32, x.im as f32) * self.unit;
        for (index, found) in self.found.iter().enumerate() {
            if Some(index) != except {
                rest -= found.model.bin(self.layout.iq, k);
            }
        }
        rest
    }

    pub fn bins(&self, peak: i32, except: Option<usize>) -> Bins<f32, Real, Rectangular> {
        Bins::gather(self.layout.n, peak, |k| self.bin(k as i32, except))
    }

    /// Bins from `k` to the nearest tone.
    pub fn nearest(&self, k: i32) -> i32 {
        self.found
            .iter()
            .map(|found| self.layout.apart(k, found.peak))
            .min()
            .unwrap_or(self.layout.n as i32)
    }

    /// Whether another tone ended up too near to this one.
    pub fn crowded(&self, one: &Found) -> bool {
        let apart = |other: &Found| {
            let apart = (other.peak - one.peak) as f32 + other.fit.offset - one.fit.offset;
            let n = self.layout.n as f32;
            if self.layout.iq { apart.abs().min(n - apart.abs()) } else { apart.abs() }
        };
        self.found.iter().filter(|other| apart(other) < UNRESOLVED).count() > 1
    }

    /// The noise of a record without a ring: the residual of all models in all bins.
    pub fn noise(&self) -> Noise {
        let Layout { n, iq, .. } = *self.layout;
        let count = whole::count(n, iq) as i32;
        let sum = (1..=count).fold(0.0, |sum, k| sum + self.bin(k, None).norm_sqr());
        let power = sum / (count as f32 * n as f32);
        Noise { power: power.max(rounding(iq)), dof: whole::dof(n, iq) }
    }
}
