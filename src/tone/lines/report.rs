//! From a line to a tone with sigma, phase and verdict.

use super::super::evidence::Evidence;
use super::super::judge::{first_look, from_end, judge};
use super::super::line_class::{FitTest, LineClass};
use super::super::measure;
use super::super::noise::ring::{self, LocalNoise};
use super::super::options::Options;
use super::super::phasor::{ToneWithPhase, phase};
use super::fit::Window;
use super::rest::Found;
use super::{Hunt, IMAGE};
use crate::acquire::sample::Stamp;
use crate::math::scalar::Scalar as _;
use crate::spectrum::neighbourhood::{Neighbourhood, Places, has_ring};
use crate::spectrum::{layout::Layout, view::View};
use crate::tone::Tone;
use crate::tone::fit::{FitStart, Model, Reach, fit_around, fit_in_floats};
use crate::tone::residual::expected;
use crate::tone::sigma::{sigma_bins, widened};
use heapless::Vec;

/// The peak bin of a tone and its distance from there, in bins.
pub(super) fn place(layout: &'static Layout, tone: &Tone) -> Option<(i32, f32)> {
    let bins = tone.frequency.bins(layout.n);
    let nearest = libm::rint(bins);
    let turn = if layout.iq { layout.n as i32 } else { i32::MAX };
    Some(((nearest as i32).checked_rem_euclid(turn)?, (bins - nearest) as f32))
}

/// The noise power per sample in which a tone was measured.
pub(super) fn noise_power(layout: &'static Layout, tone: &Tone) -> f32 {
    let power = tone.amplitude * tone.amplitude;
    // The ratio lacks the noise within the amplitude.
    let (power, own) = if layout.iq { (power, 1.0) } else { (0.5 * power, 2.0) };
    power / (tone.snr + own / layout.n as f32)
}

/// A good tone with its phase as a steady tone alone has it, and whether the fit leaves no more than such a tone does.
pub(super) fn phase_of(
    view: &View,
    tone: &Tone,
    options: &Options,
    bends: bool,
) -> Option<(ToneWithPhase, bool)> {
    let layout = view.layout;
    let (peak, offset) = place(layout, tone)?;
    // The frequency hardly turns the phase in the middle. An offset, which does, is left out of the bins.
    let steps = u32::from(!options.method.is_least_squares());
    let mut places = Places::new();
    let near = Neighbourhood::read(view, peak, &mut places);
    let fit = fit_in_floats(&near, options.reach, FitStart::Further(offset, steps))?;
    let beside = ring::beside_in_floats(&near, &fit);
    let from_end = from_end(peak, layout.n, layout.iq);
    // A motion bends the phase of a ramp's tone, but not in the middle.
    let judgement = match bends {
        true => judge(&fit, layout.n, from_end, &beside, true, ()),
        false => first_look(&fit, layout.n, &beside, ()),
    };
    let steady = judgement.line == LineClass::Steady;
    let mut noise = noise_power(layout, tone) * (1.0 + 2.0 / ring::dof(layout.n, layout.iq));
    if !steady {
        // What is beside the tone turns its phase by as much as it leaves.
        noise = noise.max(fit.residual / expected::<f32>(&fit, layout.n));
    }
    let [phase, sigma_phase] = phase(layout.iq, &fit, peak, layout.n, options.reach, noise);
    Some((ToneWithPhase { tone: *tone, phase, sigma_phase }, steady))
}

/// A tone with no other within this many bins has eight bins on each side for itself.
const ALONE: i32 = 8;

impl Hunt<'_> {
    /// The noise beside a line, less the leakage of the others.
    pub(super) fn beside(&self, found: &Found) -> LocalNoise {
        if !has_ring(self.layout.n, self.layout.iq) {
            return LocalNoise::from_noise(self.rest.noise());
        }
        let &Found { peak, ref fit, .. } = found;
        let mut places = Places::new();
        let near = Neighbourhood::read(self.rest.view, peak, &mut places);
        let alone = self.rest.found.len() == 1;
        let others = if alone { Vec::new() } else { self.others_near(peak, ring::OUTERMOST) };
        if others.is_empty() {
            return ring::beside_in_floats(&near, fit);
        }
        ring::beside_others(&near, fit, |k, stretch| {
            others.iter().for_each(|other| other.take(k - peak, stretch));
        })
    }

    /// The bins of a tone's final fit. With several tones each fit reads fewer bins: 1.02 times the bound instead of 1.01, for half the
    /// cost. A tone that shares these bins with another reads more bins farther off instead.
    fn reach(&self, peak: i32) -> Reach {
        let within = |found: &&Found| self.layout.apart(found.peak, peak) <= ALONE;
        let found = &self.rest.found;
        match self.options.reach {
            // The one tone that is near is this tone itself.
            Reach::Sixteen if found.len() > 1 && found.iter().filter(within).count() == 1 => {
                Reach::Eight
            }
            reach => reach,
        }
    }

    /// Fits every tone to all its bins and judges it.
    pub(super) fn judge_all(&mut self) {
        self.judged.clear();
        for index in 0..self.rest.found.len() {
            let Some((found, beside, judgement)) = self.judged(index) else { return };
            self.take(index, found);
            // There is room for all lines that were found.
            let _ = self.judged.push((beside, judgement));
        }
    }

    /// One tone as fitted to all its bins less the others, with its noise and its class.
    pub(super) fn judged(&self, index: usize) -> Option<(Found, LocalNoise, FitTest)> {
        let &Found { peak, fit: old, .. } = self.rest.found.get(index)?;
        let mut window = Window::new();
        let reach = self.reach(peak);
        let bins = self.bins(peak, reach, Some(index), &mut window);
        let fitted = |reach: Reach| {
            let outer = (bins.len() / 2).checked_sub(reach.bins())?;
            let bins = bins.get(outer..bins.len() - outer)?;
            let fit = fit_around(self.layout, bins, peak, FitStart::From(old.offset, 1))?;
            Some(Found { peak, fit, model: Model::new(&fit, peak, self.layout.n as i32) })
        };
        let mut found = fitted(reach)?;
        let beside = self.beside(&found);
        let from_end = from_end(peak, self.layout.n, self.layout.iq);
        let mut judgement = judge(&found.fit, self.layout.n, from_end, &beside, self.bends, ());
        // The residual of another line far off may be in the outer bins.
        if judgement.line != LineClass::Steady
            && self.rest.found.len() > 1
            && let Some(narrow) = fitted(Reach::Four)
        {
            let inner = judge(&narrow.fit, self.layout.n, from_end, &beside, self.bends, ());
            if inner.line == LineClass::Steady {
                (found, judgement) = (narrow, inner);
            }
        }
        Some((found, beside, judgement))
    }

    pub(super) fn phasor(&self, index: usize, stamp: &Stamp) -> Option<ToneWithPhase> {
        self.marks.get(index).filter(|mark| mark.own)?;
        let found = *self.rest.found.get(index)?;
        let &(beside, FitTest { line, variance_inflation }) = self.judged.get(index)?;
        let near = beside.noise.power * variance_inflation;
        // A residual that is only suspicious widens the frequency's sigma alone.
        let turned = if line == LineClass::Steady { beside.noise.power } else { near };
        // The mean of the reciprocal of an estimated power is larger than the reciprocal of its mean.
        let turned = turned * (1.0 + 2.0 / beside.noise.dof);
        let sigma = sigma_bins(&found.fit, self.layout.n, near) * self.shared(index).root();
        let crowded = self.rest.found.len() > 1 && self.rest.crowded(&found);
        let engine = self.rest.view.error();
        let unseen = engine * engine + self.options.width.of_block();
        // The record's own tone reports a fault of the front end.
        let evidence = Evidence {
            detected: index != 0 || self.stands_out(&found, &beside),
            line: if crowded { LineClass::Unresolved } else { line },
            image: self.layout.iq && self.has_image(index),
            gap: stamp.gap,
            clipped: self.clipped,
            ..Evidence::CLEAN
        };
        let (sigma, noise) = (widened(sigma, self.clipped), beside.noise.power);
        let (mut tone, evidence) =
            measure::tone(self.layout, found.peak, &found.fit, noise, [sigma, unseen], evidence)?;
        tone.conclude(&evidence);
        let [phase, sigma_phase] = phase(
            self.layout.iq,
            &found.fit,
            found.peak,
            self.layout.n,
            self.reach(found.peak),
            turned,
        );
        Some(ToneWithPhase { tone, phase, sigma_phase })
    }

    /// Whether another tone is at minus this tone's frequency, and stronger than a front end should make it.
    fn has_image(&self, index: usize) -> bool {
        let Some(found) = self.rest.found.get(index) else { return false };
        let least = IMAGE * found.fit.line.norm_sqr();
        let mirrored = |other: &Found| {
            self.layout.apart(found.peak.wrapping_neg(), other.peak) <= 1
                && other.fit.line.norm_sqr() > least
        };
        let mut others = self.rest.found.iter().enumerate().filter(|(other, _)| *other != index);
        others.any(|(_, other)| mirrored(other))
    }

    /// The factor by which the others widen a tone's variance. A tone D bins away shares `3/8 / D^2` of
    /// the information about the frequency.
    fn shared(&self, index: usize) -> f32 {
        let Some(one) = self.rest.found.get(index) else { return 1.0 };
        let lost = self.rest.found.iter().enumerate().filter(|(other, _)| *other != index);
        let lost = lost.fold(0.0, |sum, (_, other)| {
            let apart = self.layout.apart(one.peak, other.peak).max(2) as f32;
            sum + 0.375 / (apart * apart)
        });
        1.0 / (1.0 - lost.min(0.5))
    }
}
