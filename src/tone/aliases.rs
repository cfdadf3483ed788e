//! The orders of a wave with sharp edges that fold about half the rate, and what they do to the orders that are measured.
//!
//! A wave that jumps, such as that of a comparator, a Hall sensor or a sawtooth, has orders whose amplitude falls as `1 / k`. If it is sampled
//! without a filter they fold, and some land within a bin of an order that is measured. A line of r times its amplitude, d bins away, moves its
//! frequency by at most `r g(d)` bins in a fit by least squares, with `x = pi d`
//!
//! ```text
//! g(d) = 3 (sin x / x - cos x) / (pi x)        g = d for small d,  3 / (pi^2 d) at most for large d
//! ```
//!
//! If q periods are nearly a whole number of samples, orders `q + k` and `q - k` fold beside every order k, all at the same distance and with
//! the same phase: every order moves as if the fundamental did. That phase is unknown, which halves the square.
//!
//! The strength of the orders beyond half the rate is read from bins that hold nothing else. Behind a filter these bins are empty, and
//! nothing is widened.

use super::lines::{Hunt, ROOM};
use super::phasor::ToneWithPhase;
use crate::math::scalar::Scalar as _;
use heapless::Vec;

/// Limits of effort: the orders whose strength is read, and the numbers of periods. The orders beyond pull by less than a thousandth of a bin
/// each.
const FEWEST: f32 = 64.0;
const ORDERS: f32 = 1024.0;
const PERIODS: i32 = 1024;

/// Orders are read up to this many times the order at half the rate. Those beyond have a quarter of the power of all that fold.
const TIMES: f32 = 4.0;

/// Bins from a line within which an order has no bins of its own: Hann's window is two bins wide on each side of a line between two bins.
const OWN: f32 = 3.0;

/// An order is where a line was found, or where it is expected, if it is within half a bin.
const THERE: f32 = 0.5;

/// A line farther away is a part of the noise.
const NEAR: f32 = 8.0;

/// The mean power of Hann's window in the bin nearest to a line, over all offsets.
const NEAREST: f32 = 0.87;

/// Half the second differences of white noise have this many times a bin's power.
const BENT: f32 = 1.5;

/// Noise alone exceeds its mean by this many deviations in one record of a thousand.
const SEEN: f32 = 3.1;

/// Of this many successive orders at most two vanish because two edges cancel, if the edges are a tenth of a period or more apart.
const FEW: u32 = 4;

/// `g(d) d` for large d: `3 / pi^2`.
const FAR: f32 = 0.303_963_55;

/// The edges lie between the same samples for a while, then all of them between the next: the phase steps by a q-th of a turn, and a step in
/// the middle of a record moves the frequency by 1.5 times that, in turns a record. Where edges are sharp, the distance of q periods from a
/// whole number of samples is known no better.
const HIDDEN: f32 = 1.5;

/// Lines and their orders in a series, 0 for a line that is not of the series.
pub(super) struct Orders<'a> {
    pub lines: &'a [ToneWithPhase],
    pub orders: Vec<i32, ROOM>,
}

impl<'a> Orders<'a> {
    fn all(&self) -> impl Iterator<Item = (&'a ToneWithPhase, i32)> + Clone {
        self.lines.iter().zip(self.orders.iter().copied())
    }

    /// The lines of the series.
    fn own(&self) -> impl Iterator<Item = (&'a ToneWithPhase, i32)> + Clone {
        self.all().filter(|&(line, order)| order > 0 && line.tone.amplitude > 0.0)
    }
}

/// Variances by the orders that fold, in squared bins.
#[derive(Default)]
pub(super) struct Pulls {
    /// Of each line.
    pub lines: Vec<f32, ROOM>,
    /// Of the fundamental.
    pub fundamental: f32,
}

/// The orders of a wave.
struct Wave {
    /// The fundamental, steps of 2^-32 cycles per sample.
    step: i32,
    /// One standard deviation of the fundamental, bins.
    sigma: f32,
    n: usize,
    iq: bool,
    /// From an order to the next: 2 if only odd orders are seen.
    every: i32,
    /// The square of an order's amplitude times its number, of the orders that fold, and what it is for the strongest of the lines.
    strength: f32,
    strongest: f32,
}

/// A strength by least squares, of powers that fall as `1 / k^2`.
#[derive(Clone, Copy, Default)]
struct Strength {
    more: f32,
    variance: f32,
    weight: f32,
    count: u32,
}

impl Strength {
    /// Adds the squared amplitude of order k, and what noise has there in the mean.
    fn add(&mut self, k: f32, seen: f32, noise: f32) {
        let share = 1.0 / (k * k);
        self.more += share * (seen - noise);
        self.variance += (share * noise) * (share * noise);
        self.weight += share * share * NEAREST;
        self.count += 1;
    }

    fn least(&self) -> f32 {
        SEEN * self.variance.root()
    }

    /// Whether the strength is seen, or would be if it were as large as this.
    fn tells(&self, strength: f32) -> bool {
        self.weight > 0.0
            && (self.more > self.least() || strength * self.weight >= 2.0 * self.least())
    }

    /// The strength; nothing if noise alone could have as much.
    fn value(&self) -> f32 {
        if self.more > self.least() { self.more / self.weight } else { 0.0 }
    }
}

/// The variances of lines and of their fundamental of `cycles` per sample, whose sigma is `sigma` bins, by orders that fold.
pub(super) fn pulls(hunt: &Hunt, of: &Orders, cycles: f64, sigma: f32) -> Pulls {
    let mut pulls = Pulls::default();
    pulls.lines.resize(of.lines.len(), 0.0).unwrap_or_default();
    let wave = Wave::new(hunt, of, cycles, sigma);
    if wave.strength > 0.0 {
        wave.pull(of, &mut pulls);
    }
    pulls
}

impl Wave {
    fn new(hunt: &Hunt, of: &Orders, cycles: f64, sigma: f32) -> Self {
        let (n, iq) = hunt.size();
        let step = libm::rint(cycles * 4_294_967_296.0) as i64 as i32;
        let size = |(line, order): (&ToneWithPhase, i32)| {
            let size = order as f32 * line.tone.amplitude;
            size * size
        };
        let strongest = of.own().map(size).fold(0.0, f32::max);
        // A fundamental alone shows no edges.
        let strength = of.own().filter(|&(_, order)| order > 1).map(size).fold(0.0, f32::max);
        let odd = of.own().count() > 1 && of.own().all(|(_, order)| order & 1 == 1);
        let mut wave =
            Self { step, sigma, n, iq, every: if odd { 2 } else { 1 }, strength, strongest };
        if strength > 0.0 {
            wave.strength = wave.seen(hunt, of).min(strongest);
        }
        wave
    }

    /// The strength of the orders that fold, from those with bins of their own; if there are none, that of the lines.
    fn seen(&self, hunt: &Hunt, of: &Orders) -> f32 {
        // A line's amplitude over its bin.
        let unit = if self.iq { 1.0 } else { 2.0 } / self.n as f32;
        let noise = |(line, _): (&ToneWithPhase, i32)| {
            let power = line.tone.amplitude * line.tone.amplitude;
            power / line.tone.snr * if self.iq { 1.0 } else { 0.5 }
        };
        let count = of.own().count() as f32;
        let noise = of.own().map(noise).sum::<f32>() / count;
        let noise = BENT * noise * self.n as f32 * (unit * unit);
        let first = self.bins(self.step);
        let beyond = 0.5 * self.n as f32 / first.abs();
        let most = (TIMES * beyond).clamp(FEWEST, ORDERS) as i32;
        // Of those below half the rate that were not found, and of those that fold.
        let mut all = [Strength::default(); 2];
        let mut order = 1;
        while order < most {
            order += self.every;
            let k = order as f32;
            let place = self.step.wrapping_mul(order);
            let place = if self.iq { place } else { place.wrapping_abs() };
            let bins = self.bins(place);
            let folds = k > beyond;
            // Lines below half the rate may be there that were not found.
            let ratio = bins / first;
            let apart = (ratio - libm::rintf(ratio)) * first;
            let near = |line: &ToneWithPhase| self.apart(place, line).abs() < OWN;
            if k * self.sigma > THERE || folds && apart.abs() < OWN || of.lines.iter().any(near) {
                continue;
            }
            let Some(power) = hunt.alone(libm::rintf(bins) as i32) else { continue };
            let [below, beyond] = &mut all;
            let strength = if folds { beyond } else { below };
            strength.add(k, power * (unit * unit), noise);
        }
        let [below, beyond] = all;
        if beyond.tells(self.strength) {
            return beyond.value();
        }
        // Orders that are missing below half the rate are missing beyond. One or two may be where two edges cancel.
        if below.count >= FEW && below.tells(self.strength) {
            return self.strength.min(below.value());
        }
        self.strength
    }

    /// A place in bins.
    fn bins(&self, place: i32) -> f32 {
        place as f32 * (self.n as f32 / 4_294_967_296.0)
    }

    /// Bins from a line to a place.
    fn apart(&self, place: i32, line: &ToneWithPhase) -> f32 {
        self.bins(place.wrapping_sub(line.tone.frequency.0.to_bits()))
    }

    /// Whether another line was found at a place: it is fitted together with this one.
    fn is_found(&self, place: i32, of: &Orders, line: &ToneWithPhase) -> bool {
        let mut others = of.lines.iter().filter(|it| it.tone.frequency != line.tone.frequency);
        others.any(|other| self.apart(place, other).abs() < THERE)
    }

    fn pull(&self, of: &Orders, pulls: &mut Pulls) {
        let weight: f32 = of.own().map(|(line, k)| (k * k) as f32 * line.tone.snr).sum();
        let strength = (0.5 * self.strength).root();
        let share = self.strength / self.strongest;
        let mut at = 0i32;
        for q in 1..=PERIODS {
            at = at.wrapping_add(self.step);
            let apart = self.bins(at);
            if q & (self.every - 1) != 0 || apart.abs() > NEAR {
                continue;
            }
            let unsure = q as f32 * self.sigma;
            let apart = (apart.abs() - HIDDEN * share).max(0.0);
            let square = (apart * apart + unsure * unsure).max(FAR * share);
            // `g`, whatever the phase at both ends.
            let turn = square / FAR;
            let pull = strength * (square / (1.0 + turn * turn)).root();
            let mut together = 0.0;
            for ((line, order), variance) in of.all().zip(&mut pulls.lines) {
                if order <= 0 || line.tone.amplitude <= 0.0 {
                    continue;
                }
                let own = line.tone.frequency.0.to_bits();
                let mut share = 0.0;
                if !self.is_found(own.wrapping_add(at), of, line) {
                    share += 1.0 / (q + order) as f32;
                }
                let below = (q - order).abs();
                if !self.iq
                    && below > 0
                    && below != order
                    && !self.is_found(own.wrapping_sub(at), of, line)
                {
                    share += 1.0 / below as f32;
                }
                let moved = pull * share / line.tone.amplitude;
                *variance += moved * moved;
                together += order as f32 * line.tone.snr * moved;
            }
            pulls.fundamental += (together / weight) * (together / weight);
        }
    }
}
