//! The close look at a line that is not far above the noise next to it. Noise is seldom white, so the floor of a band says little
//! about the noise at one place in it.
//!
//! So a line must pass several tests at once. Each compares the ratio of the line's power to one noise power with the threshold for the
//! degrees of freedom of this noise (see [`detection`](super::detection)): the floor of the band, the louder side of the ring, a ring twice
//! as wide, the fit's mean residual, and in short records the louder half of the residual. Because all must pass, each threshold is relaxed
//! a little.

use super::detector::{Detector, Spread};
use super::fit::{Fit, Model, take_around};
use super::noise::louder::{WIDTH, louder};
use super::noise::ring::LocalNoise;
use super::observer::Tap;
use super::statistic::{Statistic, Test};
use super::threshold::Relaxation;
use crate::math::scalar::Scalar;
use crate::spectrum::bins::REACH;
use crate::spectrum::neighbourhood::Neighbourhood;
use num_complex::Complex;

/// The residual of the louder half of the bins 3 to 16 away, which form four groups, two on each side.
///
/// A band of noise may end within the bins of the fit. The bins beyond its end have no noise, so the mean of all bins is too low.
#[inline(never)]
pub(super) fn louder_half(near: &Neighbourhood, fit: &Fit<f32>) -> f32 {
    let (layout, peak, unit) = (near.layout, near.peak, near.unit());
    let mut bins = [Complex::new(0.0, 0.0); WIDTH];
    for (bin, &[re, im]) in bins.iter_mut().zip(near.within(REACH)) {
        *bin = Complex::new(re as f32 * unit, im as f32 * unit);
    }
    take_around(layout, &Model::new(fit, peak, near.n as i32), peak, &mut bins);
    louder(&bins, near.iq, near.n, peak)
}

impl Detector {
    /// Whether the floor of the line's band, if it separates noise from tones, is a test of its own: where the floor is as loud as the wide
    /// ring and the residual.
    #[inline(never)]
    pub(super) fn tested(&self, wide: &LocalNoise, floor: Option<f32>) -> bool {
        let (mean, dof) = self.spread.mean();
        let residual = dof > 0.0 && wide.has_sides();
        floor.is_some_and(|floor| {
            let likely = 1.0 + RESIDUAL * (2.0 / dof).root();
            wide.loud * self.n as f32 <= LOUDER * floor && !(residual && mean > likely * floor)
        })
    }

    /// Whether the line exceeds this noise, the noise of a wider ring, and the mean residual.
    #[inline(never)]
    pub(super) fn exceeds(
        &self,
        beside: &LocalNoise,
        wide: &LocalNoise,
        tested: bool,
        observer: impl Tap,
    ) -> bool {
        let Self { n, ref spread, .. } = *self;
        let (least, (mean, dof)) = (spread.least, spread.mean());
        // A short record without a ring has nothing else beside its tone.
        let residual = beside.has_sides() && dof > if self.short { 0.0 } else { WHOLE };
        // In a short record the wide ring is most of the spectrum, and the floor once more.
        let less = match (tested, self.short) {
            (true, true) => Relaxation::MOST,
            (true, false) => Relaxation::SOME.in_record(n),
            (false, _) => Relaxation::NOTHING,
        };
        let less_residual = if self.short && !tested {
            Relaxation::NOTHING
        } else {
            Relaxation::for_residual(n, self.short)
        };
        let detects = |statistic, beside: &LocalNoise, less| {
            let noise = least.max(beside.loud * n as f32);
            self.detects(statistic, noise, beside.noise.dof, less, observer)
        };
        let over_mean =
            || self.detects(Statistic::MeanResidual, mean, dof, less_residual, observer);
        (!residual || over_mean())
            && detects(Statistic::WideRing, wide, less)
            && detects(Statistic::Ring, beside, Relaxation::MOST.in_record(n))
    }

    /// Whether the line exceeds this mean of the louder half of the residual, or a floor that is a test of its own is as loud as the floor
    /// of white noise.
    #[inline(never)]
    pub(super) fn exceeds_half(&self, louder: f32, floor: Option<f32>, observer: impl Tap) -> bool {
        /// Effective degrees of freedom of this mean, as if it were not a maximum.
        const DOF: f32 = 72.0;
        /// In white noise the louder half has 1.25 times the floor's power, and exceeds this factor four times in a thousand.
        const LIKELY: f32 = 2.0;
        floor.is_some_and(|floor| {
            observer.hear(|| Test::new(Statistic::LouderHalf, louder / floor, LIKELY));
            louder <= LIKELY * floor
        }) || self.detects(Statistic::OverLouderHalf, louder, DOF, Relaxation::NOTHING, observer)
    }

    /// The factor on sigma of a line that is found in noise of this power per sample.
    ///
    /// Lines near the threshold are found where noise has raised them, and so look more precise than they are. Measured: the excess of the
    /// factor over 1 falls with the fourth power of the line's power.
    #[inline(never)]
    pub(super) fn selection(&self, noise: f32) -> f32 {
        /// The excess of a line at the threshold.
        const MOST: f32 = 0.5;
        let least = self.threshold.least_power() * noise * self.n as f32;
        let share = least / self.power;
        1.0 + MOST * (share * share) * (share * share)
    }
}

/// Degrees of freedom per bin of the mean residual.
const EACH: f32 = 1.8;
/// Minimum degrees of freedom for the residual to be tested beside a ring that is narrow in the spectrum: most of the degrees of freedom of
/// 28 bins.
const WHOLE: f32 = 45.0;
/// The ring's noise over the floor, above which the floor belongs to another part of the spectrum.
const LOUDER: f32 = 1.4;
/// The limit of the mean residual, in its standard deviations above the floor, from which the floor belongs to another part of the
/// spectrum.
const RESIDUAL: f32 = 2.6;

impl Spread {
    /// The mean residual of a bin over all groups, with its degrees of freedom.
    fn mean(&self) -> (f32, f32) {
        let ([inside, all], [nearest, next, last]) = (self.sums, self.bins);
        let bins = nearest + next + last;
        ((all - inside) / bins, EACH * bins)
    }
}
