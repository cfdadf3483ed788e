//! All the lines of a record that are tones, each with its phase: up to [`MOST`].
//!
//! The first tone is the pipeline's own. Each further one is sought in the second differences of the
//! bins, which are Hann's window: a tone's leakage falls by 18 dB an octave there, and models of the
//! tones found need to be subtracted only near them. A candidate exceeds the floor of its own
//! neighbourhood. Then all tones are fitted anew, each to bins less the models of the others, until
//! none moves ([`super::several`]).
//!
//! A line that is no target of its own is refused:
//!
//! - It does not exceed the noise beside it at the plan's false-alarm rate, with all models subtracted.
//! - It is the skirt of a tone that moves.
//! - It is a harmonic that the front end makes of a stronger tone: at 2 to 5 times its frequency,
//!   folded, and [`HARMONIC`] weaker.
//! - It is the image that an I/Q front end makes: at minus the frequency of a stronger tone, and
//!   [`IMAGE`] weaker. Stronger images give both tones the verdict `Image`.
//! - It is a step of the converter: weaker than half a code where no noise blurs the steps.
//! - It is what the transform leaves: [`TRANSFORM`] weaker than the strongest.

use super::detection::Less;
use super::judge::{Judgement, Line, judge};
use super::least_squares::{Course, Fit, Reach, fit_bins};
use super::measure::{Options, Seen, spread};
use super::noise::ring::{self, Beside};
use super::noise::rounding;
use super::noise::whole::{self, NOISE_BINS};
use super::phasor::{Phasor, phase};
use super::several::{Found, MOST, Rest, SWEEPS, first, remove};
use super::tone::{Tone, Verdict};
use super::uncertainty::{CLIPPED, sigma_bins, widened};
use crate::acquire::sample::{Record, Stamp};
use crate::math::series::line_shape;
use crate::spectrum::Spectrum;
use crate::spectrum::engine::Engine;
use crate::spectrum::peak::Band;
use heapless::Vec;
use num_complex::Complex;

/// A harmonic of the front end has at most this share of its tone's power: -40 dB.
pub const HARMONIC: f32 = 1e-4;

/// The same if samples clip: that of a square wave. Clipping makes so many harmonics that no line 20 dB
/// weaker can be told from them.
const CLIPPED_HARMONIC: f32 = 0.12;
const CLIPPED_LINE: f32 = 1e-2;

/// An image of the front end has at most this share of its tone's power: -20 dB.
pub const IMAGE: f32 = 1e-2;

/// What the integer transform leaves anywhere has less than this share of the strongest tone's
/// power: -75 dB.
pub const TRANSFORM: f32 = 3e-8;

/// The highest harmonic that a front end is expected to make.
const ORDERS: i32 = 5;

/// Below this noise power, in squared codes, the steps of a converter are not blurred.
const BLURRED: f32 = 0.3;

/// A tone leaks into second differences up to so many bins away: beyond by less than -100 dB.
const LEAKS: i32 = 32;

/// A tone that moves has a skirt of so many bins, in which no weak one is sought, and so many in which
/// none at all is.
const SKIRT: i32 = 16;
const NEAR: i32 = 4;

/// A line in the skirt of another is weak if it has less than this share of its power: -20 dB. In a
/// series such a line is a part of the other even if that is not known to move, because a machine's
/// line is seldom steady.
const SKIRT_POWER: f32 = 1e-2;

/// Bins beside a tone in which no other is sought.
const BESIDE: i32 = 1;

/// No further tone is sought below this bin, where a drift is.
const DRIFT: i32 = 4;

/// The most blocks of bins, and the least bins of a block.
const BLOCKS: usize = 64;
const BLOCK: i32 = 8;

/// Blocks on each side that a block's floor is taken from.
const AROUND: usize = 4;

/// The most searches of a record.
const SEARCHES: usize = 10;

/// A fit is settled if no tone moves by more than this share of its sigma.
const SETTLED: f32 = 0.1;

/// Room for the tones and for lines that a front end makes of them, which are subtracted, too.
pub(super) const ROOM: usize = 2 * MOST;

/// Bins in which nothing is sought, around one of them.
#[derive(Clone, Copy)]
struct Hidden {
    bin: i32,
    width: i32,
}

/// The second differences of neighbouring bins.
#[derive(Clone, Copy, Default)]
struct Block {
    /// The mean power of all but the strongest.
    mean: f32,
    /// The strongest one.
    most: f32,
    bin: i32,
}

/// The tones of a record while they are sought.
struct Hunt<'a, R: Record, const N: usize, E: Engine> {
    rest: Rest<'a, R, N, E, ROOM>,
    options: &'a Options,
    band: Band,
    clipped: f32,
    /// Whether lines that are made of others count, too.
    every: bool,
    hidden: Vec<Hidden, SEARCHES>,
    leaks: Vec<Leak, ROOM>,
}

/// A tone's leakage into second differences of bins.
struct Leak {
    peak: i32,
    offset: f32,
    /// `line sin(pi d) / pi`.
    value: Complex<f32>,
}

impl Leak {
    fn of<R: Record, const N: usize>(found: &Found) -> Self {
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

/// The tones of a record with their phases, the strongest first as they were found: `most` of them,
/// at most [`MOST`]. `tone` is the one that was measured in this spectrum.
///
/// Sigma of each tone is that of the joint fit.
pub fn lines<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    tone: &Tone,
    band: Band,
    clipped: u32,
    stamp: &Stamp,
    options: &Options,
    most: usize,
) -> Vec<Phasor, MOST> {
    let Some(mut hunt) = Hunt::start(spectrum, tone, band, clipped, options) else {
        return Vec::new();
    };
    if most > 1 {
        hunt.seek(most.min(MOST));
    }
    let mut phasors = hunt.phasors(stamp);
    // The only tone is known better by what measured it.
    if let [phasor] = phasors.as_mut_slice()
        && phasor.tone.frequency.beyond(tone.frequency).abs() * (N as f32) < 1.0
    {
        phasor.tone = *tone;
    }
    phasors
}

/// Every line of a record that stands out of the noise, also those that are made of another: up to
/// [`ROOM`].
pub(super) fn every_line<R: Record, const N: usize>(
    spectrum: &Spectrum<R, N, impl Engine>,
    tone: &Tone,
    clipped: u32,
    stamp: &Stamp,
    options: &Options,
) -> Vec<Phasor, ROOM> {
    let band = if R::IQ { Band::iq(N) } else { Band::real(N) };
    let Some(mut hunt) = Hunt::start(spectrum, tone, band, clipped, options) else {
        return Vec::new();
    };
    hunt.every = true;
    hunt.seek(ROOM);
    hunt.phasors(stamp)
}

impl<'a, R: Record, const N: usize, E: Engine> Hunt<'a, R, N, E> {
    /// Begins with the tone that was measured; `None` if there is none.
    fn start(
        spectrum: &'a Spectrum<R, N, E>,
        tone: &Tone,
        band: Band,
        clipped: u32,
        options: &'a Options,
    ) -> Option<Self> {
        let unit = libm::ldexpf(1.0, spectrum.exponent());
        let clipped = clipped as f32 / N as f32;
        let rest = Rest { spectrum, unit, found: Vec::new() };
        let (hidden, leaks) = (Vec::new(), Vec::new());
        let mut hunt = Self { rest, options, band, clipped, every: false, hidden, leaks };
        let turn = if R::IQ { N as i32 } else { i32::MAX };
        let peak = (libm::rint(tone.frequency.bins(N)) as i32).checked_rem_euclid(turn)?;
        if tone.verdict == Verdict::NoSignal {
            return None;
        }
        // A peak at DC is no tone that could be fitted, but there may be others.
        if hunt.rest.add(peak) {
            hunt.rest.alone(options.reach);
            hunt.leak();
        }
        Some(hunt)
    }

    /// The tones as they are now.
    fn phasors<const COUNT: usize>(&self, stamp: &Stamp) -> Vec<Phasor, COUNT> {
        first((0..self.rest.found.len()).filter_map(|index| self.phasor(index, stamp)))
    }

    /// Looks for tones until there are `most`, or no more. What does not stand out of the noise is
    /// known only when all others are subtracted.
    fn seek(&mut self, most: usize) {
        for _ in 0..SEARCHES {
            let own = self.rest.found.iter().filter(|found| found.own).count();
            let full = own >= most || self.rest.found.is_full();
            let Some(bin) = (if full { None } else { self.search() }) else {
                if self.refuse() {
                    continue;
                }
                return;
            };
            if self.is_drift(bin) || self.is_skirt(bin) {
                continue;
            }
            if !self.rest.add(bin) {
                self.hide(bin, BESIDE);
                continue;
            }
            self.settle();
            self.disown();
        }
        for _ in 0..ROOM {
            if !self.refuse() {
                break;
            }
        }
    }

    /// Marks the newest line if it is made of another.
    fn disown(&mut self) {
        let own = self.rest.found.last().is_none_or(|newest| self.every || self.is_target(newest));
        if let Some(newest) = self.rest.found.last_mut() {
            newest.own = own;
        }
    }

    /// Fits every tone anew until none moves.
    fn settle(&mut self) {
        for _ in 0..2 * SWEEPS {
            let before = self.rest.found.clone();
            self.rest.sweep(self.options.reach);
            let noise = self.rest.noise();
            let moved = |(old, new): (&Found, &Found)| {
                let moved = (new.peak - old.peak) as f32 + new.fit.offset - old.fit.offset;
                moved.abs() > SETTLED * sigma_bins(&new.fit, N, noise)
            };
            if !before.iter().zip(&self.rest.found).any(moved) {
                break;
            }
        }
        self.leak();
    }

    /// Takes out the last further tone that does not stand out of the noise, if there is one.
    fn refuse(&mut self) -> bool {
        let mut further = self.rest.found.iter().enumerate().skip(1).rev();
        let wrong = further.find(|(_, found)| !self.stands_out(found));
        let Some((index, &Found { peak, .. })) = wrong else { return false };
        remove(&mut self.rest.found, index);
        self.hide(peak, BESIDE);
        self.settle();
        true
    }

    /// Takes the leakage of the tones as they are now.
    fn leak(&mut self) {
        self.leaks = first(self.rest.found.iter().map(Leak::of::<R, N>));
    }

    fn hide(&mut self, bin: i32, width: i32) {
        // A full list ends the search soon.
        let _ = self.hidden.push(Hidden { bin, width });
    }

    fn is_hidden(&self, k: i32) -> bool {
        self.rest.nearest(k) <= BESIDE
            || self.hidden.iter().any(|hidden| apart::<R, N>(k, hidden.bin) <= hidden.width)
            || R::IQ && apart::<R, N>(k, 0) < DRIFT
    }

    /// Half the second difference of three bins around `k`, less what the tones near it leave there:
    /// `c sin(pi d) / (pi x (x^2 - 1))`, see [`super::noise::ring`].
    fn difference(&self, k: i32, [before, here, after]: [Complex<f32>; 3]) -> Complex<f32> {
        let mut rest = (before + after) * 0.5 - here;
        for leak in &self.leaks {
            rest -= leak.at::<R, N>(k);
        }
        rest
    }

    /// A bin as it is.
    fn bin(&self, k: i32) -> Complex<f32> {
        let x = self.rest.spectrum.bin(k);
        Complex::new(x.re as f32, x.im as f32) * self.rest.unit
    }

    /// The bin that exceeds its neighbourhood most, if noise does not.
    fn search(&self) -> Option<i32> {
        let blocks = self.blocks();
        let (mut highest, mut best) = (0.0, None);
        for (index, block) in blocks.iter().enumerate() {
            let floor = floor(&blocks, index);
            if block.most > highest * floor {
                (highest, best) = (block.most / floor, Some(block.bin));
            }
        }
        // The floor is that of six blocks of eight or more.
        const FREEDOM: f32 = 80.0;
        let detected = self.options.threshold.detects_beside(highest, FREEDOM, Less::Some);
        best.filter(|_| detected).map(|bin| self.summit(bin))
    }

    /// The strongest bin up the slope from this one: the slope of a strong tone may stand out of its
    /// block more than the tone of the next.
    fn summit(&self, bin: i32) -> i32 {
        let mut summit = bin;
        for _ in 0..BLOCK {
            let here = self.power(summit);
            let stronger = |k: &i32| !self.is_hidden(*k) && self.power(*k) > here;
            match [summit - 1, summit + 1].into_iter().find(stronger) {
                Some(next) => summit = next,
                None => break,
            }
        }
        summit
    }

    /// The power of the difference around bin `k`.
    fn power(&self, k: i32) -> f32 {
        self.difference(k, [-1, 0, 1].map(|i| self.bin(k + i))).norm_sqr()
    }

    fn blocks(&self) -> Vec<Block, BLOCKS> {
        let (low, high) = if R::IQ {
            (self.band.low, self.band.high)
        } else {
            (self.band.low.max(DRIFT), self.band.high.min(N as i32 / 2 - 2))
        };
        let width = ((high - low) / BLOCKS as i32 + 1).max(BLOCK);
        let least = rounding::<R>() * 1.5 * N as f32;
        let mut blocks = Vec::new();
        let (mut first, mut before, mut here) = (low, self.bin(low - 1), self.bin(low));
        while first <= high {
            let (mut block, mut sum, mut count) =
                (Block { bin: first, ..Block::default() }, 0.0, 0);
            let next = first.saturating_add(width);
            for k in first..next.min(high + 1) {
                let after = self.bin(k + 1);
                let power = self.difference(k, [before, here, after]).norm_sqr();
                (before, here) = (here, after);
                if self.is_hidden(k) {
                    continue;
                }
                (sum, count) = (sum + power, count + 1);
                if power > block.most {
                    (block.most, block.bin) = (power, k);
                }
            }
            let mean = ((sum - block.most) / (count - 1).max(1) as f32).max(least);
            block.mean = if count < BLOCK / 2 { f32::INFINITY } else { mean };
            if blocks.push(block).is_err() {
                break;
            }
            first = next;
        }
        blocks
    }

    /// Whether a candidate lies on the slope of a drift, which falls from DC on. The slope is hidden
    /// then.
    fn is_drift(&mut self, bin: i32) -> bool {
        let from_dc = apart::<R, N>(bin, 0);
        let inward = if R::IQ && bin > N as i32 / 2 { 1 } else { -1 };
        let here = self.power(bin);
        let falls =
            from_dc < SKIRT && [1, 2].into_iter().any(|i| self.power(bin + i * inward) > here);
        if falls {
            self.hide(0, from_dc);
        }
        falls
    }

    /// Whether a candidate lies in the skirt of a tone that moves. The skirt is hidden then.
    fn is_skirt(&mut self, bin: i32) -> bool {
        let near = |found: &&Found| apart::<R, N>(bin, found.peak) <= SKIRT;
        let Some(index) = self.rest.found.iter().position(|found| near(&found)) else {
            return false;
        };
        let Some((found, _, judgement)) = self.judged(index) else { return false };
        let near = apart::<R, N>(bin, found.peak) < NEAR;
        let weak = self.power(bin) < SKIRT_POWER * found.fit.line.norm_sqr();
        let moves = judgement.line == Line::Moving;
        if moves && near {
            self.hide(found.peak, NEAR);
        } else if weak && (moves || self.every) {
            self.hide(found.peak, SKIRT);
        } else {
            return false;
        }
        true
    }

    /// Whether a line is a target of its own, if it is no noise.
    fn is_target(&self, found: &Found) -> bool {
        let power = found.fit.line.norm_sqr();
        let others = || self.rest.found.iter().filter(|other| other.peak != found.peak);
        let strongest = others().map(|other| other.fit.line.norm_sqr()).fold(0.0, f32::max);
        let steps = found.fit.amplitude_squared::<R>(N) < 0.25;
        power > TRANSFORM * strongest
            && !(steps && self.beside(found.peak).noise.power < BLURRED)
            && !others().any(|stronger| stronger.own && self.is_made_of(found, stronger))
    }

    /// Whether a line exceeds the noise of the louder side.
    fn stands_out(&self, found: &Found) -> bool {
        let beside = self.beside(found.peak);
        // A hump of noise is wider than a line.
        let wide = spread(&found.fit).max(beside.loud * N as f32);
        let ratio = found.fit.line.norm_sqr() / wide;
        self.options.threshold.detects_beside(ratio, beside.noise.freedom, Less::Nothing)
    }

    /// Whether a front end makes one line of a stronger one.
    fn is_made_of(&self, weak: &Found, strong: &Found) -> bool {
        let share = weak.fit.line.norm_sqr() / strong.fit.line.norm_sqr();
        let place = |found: &Found| found.peak as f32 + found.fit.offset;
        let n = N as f32;
        let at = |order: i32| {
            let apart = |x: f32| {
                let turns = x / n;
                n * (turns - libm::rintf(turns)).abs()
            };
            let (x, y) = (order as f32 * place(strong), place(weak));
            let apart = if R::IQ { apart(x - y) } else { apart(x - y).min(apart(x + y)) };
            // A weak line is off by more where other artefacts are near.
            apart < 2.0
        };
        let clips = self.clipped > CLIPPED;
        let most = if clips { CLIPPED_HARMONIC } else { HARMONIC };
        clips && share < CLIPPED_LINE
            || R::IQ && share < IMAGE && at(-1)
            || share < most && (2..=ORDERS).any(|order| at(order) || R::IQ && at(-order))
    }

    /// The noise beside a bin, less all models.
    fn beside(&self, peak: i32) -> Beside {
        if !ring::has_room::<R, N>() {
            let freedom = whole::freedom::<R, N, NOISE_BINS>() as f32;
            return ring::of_power(self.rest.noise(), freedom);
        }
        let mut beside = ring::of_rest(N, R::IQ, peak, |k| self.power(k));
        beside.noise.power = beside.noise.power.max(rounding::<R>());
        beside.loud = beside.loud.max(rounding::<R>());
        beside
    }

    /// One tone as fitted to all its bins less the others, and what it is.
    fn judged(&self, index: usize) -> Option<(Found, Beside, Judgement)> {
        let &Found { peak, fit: Fit { offset, .. }, model, own } = self.rest.found.get(index)?;
        let bins = self.rest.bins(peak, Some(index));
        let beside = self.beside(peak);
        let fitted = |reach: Reach| {
            let fit = fit_bins(&bins, reach.bins(), Course::From(offset, 1))?;
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
        Some((Found { peak, fit, model, own }, beside, judgement))
    }

    fn phasor(&self, index: usize, stamp: &Stamp) -> Option<Phasor> {
        let (found, beside, Judgement { line, widening }) = self.judged(index)?;
        if !found.own {
            return None;
        }
        let near = beside.noise.power * widening;
        // What is only suspicious widens the frequency's sigma alone.
        let turned = if line == Line::Steady { beside.noise.power } else { near };
        let sigma = sigma_bins(&found.fit, N, near) * libm::sqrtf(self.shared(index));
        let crowded = self.rest.found.len() > 1 && self.rest.crowded(&found);
        let seen = Seen {
            noise: beside.noise.power,
            line: if crowded { Line::Unresolved } else { line },
            clipped: self.clipped,
            image: R::IQ && self.has_image(index),
            gap: stamp.gap,
            weak: index == 0 && !self.stands_out(&found),
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

/// Bins from one to another, round the circle for I/Q.
fn apart<R: Record, const N: usize>(a: i32, b: i32) -> i32 {
    let (apart, n) = (a.wrapping_sub(b), N as i32);
    if !R::IQ {
        return apart.abs();
    }
    let apart = apart.checked_rem_euclid(n).unwrap_or(0);
    apart.min(n - apart)
}

/// The floor of a block: the mean of the quieter two thirds of its neighbours.
fn floor(blocks: &[Block], index: usize) -> f32 {
    let around = blocks.get(index.saturating_sub(AROUND)..).unwrap_or_default();
    let mut means: Vec<f32, { 2 * AROUND + 1 }> = first(around.iter().map(|block| block.mean));
    means.retain(|mean| mean.is_finite());
    means.sort_unstable_by(f32::total_cmp);
    let kept = (2 * means.len() / 3).max(1);
    let sum: f32 = means.iter().take(kept).sum();
    if means.is_empty() { f32::INFINITY } else { sum / kept as f32 }
}
