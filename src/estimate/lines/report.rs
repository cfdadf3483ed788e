//! From a line to a tone with sigma, phase and verdict.

use super::super::judge::{Judgement, Line, judge};
use super::super::least_squares::{Course, Fit, Reach, fit_known};
use super::super::measure::Seen;
use super::super::noise::ring::{self, Beside};
use super::super::noise::rounding;
use super::super::noise::whole::{self, NOISE_BINS};
use super::super::phasor::{Phasor, phase};
use super::super::several::Found;
use super::super::uncertainty::{sigma_bins, widened};
use super::{Hunt, apart};
use crate::acquire::sample::{Record, Stamp};
use crate::spectrum::engine::Engine;
use core::mem::MaybeUninit;

impl<R: Record, const N: usize, E: Engine> Hunt<'_, R, N, E> {
    /// The noise beside a bin, less all models.
    pub(super) fn beside(&self, peak: i32) -> Beside {
        if !ring::has_room(N, R::IQ) {
            let freedom = whole::freedom::<R, N, NOISE_BINS>() as f32;
            return ring::of_power(self.rest.noise(), freedom);
        }
        // All bins of the ring in one read.
        let mut places = [MaybeUninit::uninit(); 2 * ring::OUTERMOST as usize + 1];
        let first = peak - ring::OUTERMOST;
        let points = self.rest.spectrum.fill(first, &mut places);
        let power = |k: i32| {
            let place = usize::try_from(k - 1 - first).unwrap_or(usize::MAX);
            let around = points.get(place..).and_then(|points| points.first_chunk());
            around.map_or(0.0, |around| self.difference(k, self.wide(around)).norm_sqr())
        };
        let mut beside = ring::of_rest(N, R::IQ, peak, power);
        beside.noise.power = beside.noise.power.max(rounding::<R>());
        beside.loud = beside.loud.max(rounding::<R>());
        beside
    }

    /// One tone as fitted to all its bins less the others, and what it is.
    pub(super) fn judged(&self, index: usize) -> Option<(Found, Beside, Judgement)> {
        let &Found { peak, fit: Fit { offset, .. }, model } = self.rest.found.get(index)?;
        let bins = self.bins(peak, self.options.reach.bins(), Some(index));
        let beside = self.beside(peak);
        let fitted = |reach: Reach| {
            let fit = fit_known::<R, N>(&bins, reach.bins(), Course::From(offset, 1))?;
            Some((fit, judge(&fit, N, &beside)))
        };
        let (mut fit, mut judgement) = fitted(self.options.reach)?;
        // What another line leaves far off may be in the outer bins.
        if judgement.line != Line::Steady
            && self.rest.found.len() > 1
            && let Some((narrow, inner)) = fitted(Reach::Four)
            && inner.line == Line::Steady
        {
            (fit, judgement) = (narrow, inner);
        }
        Some((Found { peak, fit, model }, beside, judgement))
    }

    pub(super) fn phasor(&self, index: usize, stamp: &Stamp) -> Option<Phasor> {
        self.own.get(index).filter(|own| **own)?;
        let (found, beside, Judgement { line, widening }) = self.judged(index)?;
        let near = beside.noise.power * widening;
        // What is only suspicious widens the frequency's sigma alone.
        let turned = if line == Line::Steady { beside.noise.power } else { near };
        // The mean of one over an estimated power is larger than one over its mean.
        let turned = turned * (1.0 + 2.0 / beside.noise.freedom);
        let sigma = sigma_bins(&found.fit, N, near) * libm::sqrtf(self.shared(index));
        let crowded = self.rest.found.len() > 1 && self.rest.crowded(&found);
        let seen = Seen {
            noise: beside.noise.power,
            line: if crowded { Line::Unresolved } else { line },
            clipped: self.clipped,
            image: R::IQ && self.has_image(index),
            gap: stamp.gap,
            weak: index == 0 && !self.stands_out(&found, &beside),
            sigma: widened(sigma, self.clipped),
        };
        let tone = seen.tone::<R, N>(found.peak, &found.fit)?;
        let [phase, sigma_phase] =
            phase::<R>(&found.fit, found.peak, N, self.options.reach, turned);
        Some(Phasor { tone, phase, sigma_phase })
    }

    /// Whether another tone is at minus this one's frequency.
    fn has_image(&self, index: usize) -> bool {
        let Some(found) = self.rest.found.get(index) else { return false };
        let mirrored = |other: &Found| apart::<R, N>(found.peak.wrapping_neg(), other.peak) <= 1;
        let mut others = self.rest.found.iter().enumerate().filter(|(other, _)| *other != index);
        others.any(|(_, other)| mirrored(other))
    }

    /// The factor by which the others widen a tone's variance. A tone D bins away shares `3/8 / D^2` of
    /// the information about the frequency.
    fn shared(&self, index: usize) -> f32 {
        let Some(one) = self.rest.found.get(index) else { return 1.0 };
        let lost = self.rest.found.iter().enumerate().filter(|(other, _)| *other != index);
        let lost = lost.fold(0.0, |sum, (_, other)| {
            let apart = apart::<R, N>(one.peak, other.peak).max(2) as f32;
            sum + 0.375 / (apart * apart)
        });
        1.0 / (1.0 - lost.min(0.5))
    }
}
