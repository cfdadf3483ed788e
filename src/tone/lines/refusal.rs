//! The rules by which a line is not a target of its own.

use super::super::detector::Spread;
use super::super::line_class::LineClass;
use super::super::noise::ring::LocalNoise;
use super::super::threshold::Relaxation;
use super::Hunt;
use super::rest::Found;
use crate::tone::sigma::CLIPPED;

/// A harmonic of the front end has at most this share of its tone's power: -40 dB.
pub const HARMONIC: f32 = 1e-4;

/// The largest share of a harmonic if samples clip, which is a square wave's. Clipping makes so many harmonics that no line 20 dB weaker
/// than the tone can be separated from them.
const CLIPPED_HARMONIC: f32 = 0.12;
const CLIPPED_LINE: f32 = 1e-2;

/// An image of the front end has at most this share of its tone's power: -20 dB.
pub const IMAGE: f32 = 1e-2;

/// Artefacts of the integer transform have less than this share of the strongest tone's power: -75 dB.
pub const ARTEFACT: f32 = 3e-8;

/// The highest harmonic that a front end is expected to make.
const ORDERS: i32 = 5;

/// Below this noise power, in squared codes, the steps of a converter are not blurred.
const BLURRED: f32 = 0.3;

/// Bins of the skirt of a tone that moves: within the first number no weak line is sought, within the second no line at all.
const SKIRT: i32 = 16;
const NEAR: i32 = 4;

/// A line in the skirt of another is weak if it has less than this share of the other's power: -20 dB. In a harmonic series such a line is
/// a part of the other even if that is not known to move, because a machine's line is seldom steady.
const SKIRT_POWER: f32 = 1e-2;

impl Hunt<'_> {
    /// Whether a candidate lies on the slope of a drift, which falls from DC on. If so, the slope is hidden.
    pub(super) fn is_drift(&mut self, bin: i32) -> bool {
        let from_dc = self.layout.apart(bin, 0);
        if from_dc >= SKIRT {
            return false;
        }
        let inward = if self.layout.iq && bin > self.layout.n as i32 / 2 { 1 } else { -1 };
        let here = self.power(bin);
        let falls = [1, 2].into_iter().any(|i| self.power(bin + i * inward) > here);
        if falls {
            self.hide(0, from_dc);
        }
        falls
    }

    /// Whether a candidate lies in the skirt of a tone that moves. If so, the skirt is hidden.
    pub(super) fn is_skirt(&mut self, bin: i32) -> bool {
        (0..self.rest.found.len()).any(|index| self.is_in_skirt_of(index, bin))
    }

    /// Whether the newest line is the remainder of a much stronger one, too near to be separated from it.
    pub(super) fn is_remainder(&self) -> bool {
        let Some((newest, others)) = self.rest.found.split_last() else { return false };
        let power = newest.fit.line.norm_sqr();
        let stronger = others.iter().any(|other| power < SKIRT_POWER * other.fit.line.norm_sqr());
        stronger && self.rest.crowded(newest)
    }

    fn is_in_skirt_of(&mut self, index: usize, bin: i32) -> bool {
        let near = |found: &&Found| self.layout.apart(bin, found.peak) <= SKIRT;
        if self.rest.found.get(index).filter(near).is_none() {
            return false;
        }
        let Some((found, _, judgement)) = self.judged(index) else { return false };
        let near = self.layout.apart(bin, found.peak) < NEAR;
        let weak = self.power(bin) < SKIRT_POWER * found.fit.line.norm_sqr();
        let moves = judgement.line == LineClass::Moving;
        if moves && near {
            self.hide(found.peak, NEAR);
        } else if weak && (moves || self.every) {
            self.hide(found.peak, SKIRT);
        } else {
            return false;
        }
        true
    }

    /// Whether a line is a target of its own, given that it exceeds the noise.
    pub(super) fn is_target(&self, found: &Found) -> bool {
        let power = found.fit.line.norm_sqr();
        let tones = || self.rest.found.iter().zip(&self.marks).filter(|(_, mark)| mark.own);
        let others = || tones().map(|(other, _)| other).filter(|other| other.peak != found.peak);
        let strongest = others().map(|other| other.fit.line.norm_sqr()).fold(0.0, f32::max);
        let steps = found.fit.amplitude_squared(self.layout.iq, self.layout.n) < 0.25;
        power > ARTEFACT * strongest
            && !(steps && self.beside(found).noise.power < BLURRED)
            && !others().any(|stronger| self.is_made_of(found, stronger))
    }

    /// Whether a line exceeds the noise of the louder side beside it.
    pub(super) fn stands_out(&self, found: &Found, beside: &LocalNoise) -> bool {
        // A hump of noise is wider than a line.
        let least = Spread::from_fit(&found.fit, found.peak, self.layout.n, self.layout.iq).least;
        let wide = least.max(beside.loud * self.layout.n as f32);
        let ratio = found.fit.line.norm_sqr() / wide;
        self.options.threshold.detects_beside(ratio, beside.noise.dof, Relaxation::NOTHING)
    }

    /// Whether a front end makes the weak line of the strong one.
    fn is_made_of(&self, weak: &Found, strong: &Found) -> bool {
        let share = weak.fit.line.norm_sqr() / strong.fit.line.norm_sqr();
        let place = |found: &Found| found.peak as f32 + found.fit.offset;
        let n = self.layout.n as f32;
        let at = |order: i32| {
            let apart = |x: f32| {
                let turns = x / n;
                n * (turns - libm::rintf(turns)).abs()
            };
            let (x, y) = (order as f32 * place(strong), place(weak));
            let apart = if self.layout.iq { apart(x - y) } else { apart(x - y).min(apart(x + y)) };
            // A weak line's frequency is off by more where other artefacts are near.
            apart < 2.0
        };
        let clips = self.clipped > CLIPPED;
        let most = if clips { CLIPPED_HARMONIC } else { HARMONIC };
        clips && share < CLIPPED_LINE
            || self.layout.iq && share < IMAGE && at(-1)
            || share < most && (2..=ORDERS).any(|order| at(order) || self.layout.iq && at(-order))
    }
}
