//! More than one tone in a record, by successive subtraction on the bins.
//!
//! The strongest tone is fitted to the few bins that it dominates, and its model is subtracted
//! from all bins. If the result has a peak above the detection threshold, that peak is the next
//! tone. Then each tone is fitted anew to bins from which the models of all others are subtracted,
//! in [`SWEEPS`] sweeps. The tones need no memory beyond themselves: a model is evaluated where it
//! is needed.
//!
//! Two tones were measured. At 2.5 bins or more apart, at any ratio up to 40 dB, both come out
//! within 1.15 times the bound of their joint estimation. At 2 bins three sweeps are just enough.
//! At 1.75 bins and below the tones are not separated, and the verdict is `Unresolved`. Three and
//! four tones use the same code but were not measured.

use super::judge::Line;
use super::least_squares::{Course, Fit, Model, Reach, fit_bins};
use super::measure::{Options, Seen, excess};
use super::noise::rounding;
use super::noise::whole::{self, NOISE_BINS};
use super::tone::Tone;
use super::uncertainty::{sigma_bins, widened};
use crate::acquire::sample::{Record, Stamp};
use crate::spectrum::Spectrum;
use crate::spectrum::bins::{Bins, Rectangular};
use crate::spectrum::engine::Engine;
use crate::spectrum::peak::{Band, Peak, Search};
use heapless::Vec;
use num_complex::Complex;

/// The most tones a record is searched for.
pub const MOST: usize = 4;

/// The number of sweeps after each tone that was found.
pub const SWEEPS: usize = 3;

/// No tone is looked for nearer than this to one that was found, in bins.
const APART: i32 = 2;

/// Tones that end up nearer than this cannot be separated, in bins.
const UNRESOLVED: f32 = 1.9;

/// From this distance on, in bins, the first fit of a tone may use nine bins instead of three.
const FAR: i32 = 8;

/// A tone whose fit is still refined.
#[derive(Clone, Copy)]
pub(super) struct Found {
    pub peak: i32,
    pub fit: Fit<f32>,
    pub model: Model<f32>,
}

/// A spectrum less the models of tones.
pub(super) struct Rest<'a, R: Record, const N: usize, E: Engine, const ROOM: usize = MOST> {
    pub spectrum: &'a Spectrum<R, N, E>,
    pub unit: f32,
    pub found: Vec<Found, ROOM>,
}

/// The tones of `band`, at most `wanted` (and [`MOST`]) of them, strongest first as they were found.
///
/// Sigma, amplitude and signal-to-noise ratio of each tone are those that it would have alone. The
/// noise is what all models together leave. A first tone below the threshold gets the verdict
/// `Weak`; all others exceed it. In clipped records sigma includes a coarse allowance, see
/// [`widened`]. Cost: each search for a further tone evaluates every model in every bin, about 100
/// operations a bin and tone.
pub fn several<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    band: Band,
    clipped: u32,
    stamp: &Stamp,
    options: &Options,
    wanted: usize,
) -> Vec<Tone, MOST> {
    let unit = libm::ldexpf(1.0, spectrum.exponent());
    let mut rest = Rest::<R, N, _> { spectrum, unit, found: Vec::new() };
    let mut detected = true;
    for _ in 0..wanted.min(MOST) {
        let Some(peak) = rest.search(band) else {
            break;
        };
        detected = options.threshold.detects(&peak);
        if !detected && !rest.found.is_empty() {
            detected = true;
            break;
        }
        if !rest.add(peak.bin) {
            break;
        }
        if rest.found.len() > 1 {
            for _ in 0..SWEEPS {
                rest.sweep(options.reach);
            }
        }
    }
    if let [_] = rest.found.as_slice() {
        rest.alone(options.reach);
    }
    rest.tones(clipped, stamp, detected)
}

impl<R: Record, const N: usize, E: Engine, const ROOM: usize> Rest<'_, R, N, E, ROOM> {
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
        let n = N as i32;
        let apart = |found: &Found| {
            let apart = (k - found.peak).abs();
            if R::IQ { apart.min(n - apart) } else { apart }
        };
        self.found.iter().map(apart).min().unwrap_or(n)
    }

    /// The strongest bin after subtraction, away from the tones that were found.
    fn search(&self, band: Band) -> Option<Peak> {
        let mut search = Search::new(band);
        let mut hidden = 0;
        for k in band.low..=band.high {
            if self.nearest(k) < APART {
                hidden += 1;
                search.push(0);
            } else {
                // In stored units the power of a weak bin stays above 1.
                let x = self.bin(k, None) / self.unit;
                search.push(x.norm_sqr() as u64);
            }
        }
        let mut peak = search.finish()?;
        peak.floor_bins = peak.floor_bins.saturating_sub(hidden);
        Some(peak)
    }

    /// Adds a new tone; false if no bins can be fitted.
    pub fn add(&mut self, peak: i32) -> bool {
        let reach = if self.nearest(peak) >= FAR && !self.found.is_empty() { 4 } else { 1 };
        match fit_bins(&self.bins(peak, None), reach, Course::Usual) {
            Some(fit) => {
                let model = Model::new(&fit, peak, N as i32);
                self.found.push(Found { peak, fit, model }).is_ok()
            }
            None => false,
        }
    }

    /// Fits every tone once to the bins less the other models.
    pub fn sweep(&mut self, reach: Reach) {
        for index in 0..self.found.len() {
            let Some(&old) = self.found.get(index) else {
                return;
            };
            // A tone that moved to another bin is centred there.
            let moved = if old.fit.offset.abs() > 0.6 { old.fit.offset.signum() as i32 } else { 0 };
            let peak = old.peak + moved;
            let start = old.fit.offset - moved as f32;
            let bins = self.bins(peak, Some(index));
            if let Some(fit) = fit_bins(&bins, reach.bins(), Course::From(start, 1)) {
                let model = Model::new(&fit, peak, N as i32);
                if let Some(found) = self.found.get_mut(index) {
                    *found = Found { peak, fit, model };
                }
            }
        }
    }

    /// A single tone, fitted to all its bins.
    pub fn alone(&mut self, reach: Reach) {
        let Some(&Found { peak, .. }) = self.found.first() else {
            return;
        };
        if let Some(fit) = fit_bins(&self.bins(peak, Some(0)), reach.bins(), Course::Usual) {
            let model = Model::new(&fit, peak, N as i32);
            self.found.clear();
            // There is room for four.
            let _ = self.found.push(Found { peak, fit, model });
        }
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

    /// The noise power per sample: what all models leave in bins all over the spectrum.
    pub fn noise(&self) -> f32 {
        let count = whole::count::<R, N, NOISE_BINS>() as i32;
        let stride = (if R::IQ { N } else { N / 2 }) as i32 / (count + 1);
        let sum = (1..=count).fold(0.0, |sum, k| sum + self.bin(k * stride, None).norm_sqr());
        (sum / (count as f32 * N as f32)).max(rounding::<R>())
    }

    fn tones(&self, clipped: u32, stamp: &Stamp, detected: bool) -> Vec<Tone, MOST> {
        let noise = self.noise();
        let tone = |found: &Found| {
            let excess = excess::<R, N>(&found.fit, noise);
            let clipped = clipped as f32 / N as f32;
            let seen = Seen {
                noise,
                line: if excess > 1.0 || self.crowded(found) {
                    Line::Unresolved
                } else {
                    Line::Steady
                },
                clipped,
                image: false,
                gap: stamp.gap,
                weak: !detected,
                sigma: widened(sigma_bins(&found.fit, N, noise * excess), clipped),
                engine: self.spectrum.error(),
            };
            seen.tone::<R, N>(found.peak, &found.fit)
        };
        first(self.found.iter().filter_map(tone))
    }
}

/// Takes out the item at `index`, if there is one. The list's own `remove` panics otherwise.
pub(crate) fn remove<T, const ROOM: usize>(items: &mut Vec<T, ROOM>, index: usize) {
    let mut at = 0;
    items.retain(|_| {
        at += 1;
        at != index + 1
    });
}

/// Collects as many items as there is room for. `collect` panics at one more.
pub(crate) fn first<T, const ROOM: usize>(items: impl Iterator<Item = T>) -> Vec<T, ROOM> {
    let mut vec = Vec::new();
    for item in items {
        if vec.push(item).is_err() {
            break;
        }
    }
    vec
}
