//! Lines beyond the tone's own bins: peaks of the residual, and pairs of sidebands.

use super::belief::Belief;
use super::columns::{Line, line, slow};
use super::constants::{LENGTHS, NEAR, PEAK, PEAKS, WIDTH};
use super::elimination::Taken;
use super::factor::Factor;
use super::joint::Joint;
use super::logarithm::{Product, ln};
use super::shape::{Shape, ZERO};
use super::size::{Direction, Effect, Ground, Weighed};
use super::window::Window;
use crate::chance;
use crate::math::scalar::larger;
use core::f32::consts::PI;
use num_complex::Complex;

/// A line that may be there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Its distance from the tone, bins.
    pub distance: f32,
    /// The belief in it.
    pub belief: Belief,
    /// The logarithm of the belief in its best size.
    pub best: f32,
    /// Its strength.
    pub value: Complex<f32>,
    /// Where it is.
    pub reach: Reach,
}

/// Where a line is, seen from the tone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// So close that the envelope's nine numbers describe it.
    Close,
    /// In the window.
    Inside,
    /// Outside the window, which shows only its leakage: a line far away, or a drift or slow hum at the end of the spectrum.
    Outside,
    /// At 0 Hz of an I/Q record, whose own bin is not used: a drift of the mean.
    Slow,
}

impl Place {
    /// No line.
    pub const NONE: Self = Self {
        distance: f32::INFINITY,
        belief: Belief::NEVER,
        best: f32::NEG_INFINITY,
        value: ZERO,
        reach: Reach::Inside,
    };

    /// Weighs a line by two directions of its strength, along the tone's phase and across it. `unit` is the tone's phase, `prior` the
    /// logarithm of the place's prior.
    pub fn weighed(
        ground: &Ground,
        distance: f32,
        directions: &[Direction; 2],
        unit: Complex<f32>,
        prior: f32,
        reach: Reach,
    ) -> Self {
        let Weighed { belief, best, variance } = ground.weigh(directions, 2.0 * ground.strength);
        let [re, im] = directions
            .map(|direction| direction.along * variance / (1.0 + direction.square * variance));
        let value = unit * Complex::new(re, im);
        Self { distance, belief: belief.times(prior), best: best + prior, value, reach }
    }
}

/// A line on each side of the tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sidebands {
    /// The distance of the first one from the tone; the other's is the opposite.
    pub distance: f32,
    /// The belief in both.
    pub belief: Belief,
    /// The logarithm of the belief in their best size.
    pub best: f32,
    /// Their strengths.
    pub values: [Complex<f32>; 2],
}

impl Sidebands {
    /// None.
    pub const NONE: Self = Self {
        distance: f32::INFINITY,
        belief: Belief::NEVER,
        best: f32::NEG_INFINITY,
        values: [ZERO; 2],
    };
}

/// The width in bins that each place which is tried stands for.
pub const INTERVAL: f32 = 0.25;

/// The logarithm of the prior of a line in an interval of this width at this distance: even within a bin, log-uniform beyond.
pub fn place_prior(width: f32, distance: f32) -> f32 {
    /// Both sides: the first bin, and the logarithm of the 16.5 bins beyond which the window ends.
    const ALL: f32 = 2.0 * (1.0 + 2.803_360_4);
    ln(width / (larger(distance.abs(), 1.0) * ALL))
}

/// The residual turned back by the tone's phase, with one bin more on each side.
type Padded = [Complex<f32>; WIDTH + 2];

/// The largest peaks of the residual that noise seldom has: the residual below, at and above each, and its bin.
fn peaks(left: &Shape, free: f32) -> [Option<([Complex<f32>; 3], f32)>; PEAKS] {
    let mut padded: Padded = [ZERO; WIDTH + 2];
    padded.iter_mut().skip(1).zip(left).for_each(|(cell, left)| *cell = *left);
    let limit = 2.0 * chance::ratio(PEAK, 2.0, free);
    let mut found = [None; PEAKS];
    let mut powers = [0.0; PEAKS];
    for (bins, i) in padded.array_windows::<3>().zip(Window::places()) {
        let [below, own, above] = bins;
        let power = own.norm_sqr();
        // The bins next to the tone's peak cannot hold a peak of another line.
        let outside = |i: i32, z: &Complex<f32>| if i.abs() >= 2 { z.norm_sqr() } else { 0.0 };
        if i.abs() < 2
            || power <= limit
            || power < outside(i - 1, below)
            || power < outside(i + 1, above)
        {
            continue;
        }
        let (mut this, mut height) = (Some((*bins, i as f32)), power);
        for (found, other) in found.iter_mut().zip(&mut powers) {
            if height > *other {
                core::mem::swap(found, &mut this);
                core::mem::swap(other, &mut height);
            }
        }
    }
    found
}

/// A column that may join.
struct Candidate {
    column: Line,
    taken: Taken,
    /// Its product with the residual in the tone's phase.
    along: Complex<f32>,
}

/// Whether the second of two columns explains more of a residual.
fn bends_more(columns: &Line, left: &Shape) -> bool {
    let (mut along, mut square) = ([ZERO; 2], [0.0; 2]);
    for (values, left) in columns.iter().zip(left) {
        for ((along, square), value) in along.iter_mut().zip(&mut square).zip(values) {
            *along += left * *value;
            *square += value * value;
        }
    }
    let ([a, b], [one, other]) = (along.map(|along| along.norm_sqr()), square);
    b * one > a * other
}

impl Candidate {
    fn new(window: &Window, joint: &Joint, at: f32, reach: Reach) -> Self {
        let mut column = [[0.0; 2]; WIDTH];
        match reach {
            Reach::Slow => {
                slow(window, &mut column);
                if bends_more(&column, &joint.left) {
                    column.iter_mut().for_each(|[straight, bent]| core::mem::swap(straight, bent));
                }
            }
            _ => line(window, at, &mut column),
        }
        let mut along = ZERO;
        for ([value, _], left) in column.iter().zip(&joint.left) {
            along += left * *value;
        }
        let taken = joint.from.taken(&column);
        Self { column, taken, along: along * joint.envelope.unit.conj() }
    }
}

/// The number of lines that are tried in a round: at peaks, and outside the window on each side.
pub const FARS: usize = PEAKS + 2;

/// Lines at the peaks of the residual and outside the window, and a pair of sidebands at the largest peak.
#[inline(never)]
pub fn lines(window: &Window, joint: &Joint, ground: &Ground) -> ([Place; FARS], Sidebands) {
    let (mut places, mut pair) = ([Place::NONE; FARS], Sidebands::NONE);
    if joint.vacant() == 0 {
        return (places, pair);
    }
    let offset = joint.offset();
    let unit = joint.envelope.unit;
    // The offset that the second whitened order makes.
    let [_, pivot, ..] = joint.from.white.over();
    let slope = pivot * LENGTHS[1] / (PI * larger(joint.envelope.size(), 1e-30));
    let weigh = |one: &Candidate, distance: f32, prior: f32, reach| {
        let Candidate { taken, along, .. } = one;
        let (first, square) = (taken.first(), larger(taken.own, 1e-3));
        let directions = [
            Direction {
                along: along.re,
                square: larger(taken.own - first * first, 1e-3),
                pull: first * slope,
            },
            Direction { along: along.im, square, pull: 0.0 },
        ];
        Place::weighed(ground, distance, &directions, unit, prior, reach)
    };
    for (number, (cell, peak)) in places.iter_mut().zip(peaks(&joint.left, joint.free)).enumerate()
    {
        let Some(([below, own, above], bin)) = peak else { continue };
        // Exact for a line alone.
        let (top, bottom) = (above - below, own * 2.0 + below + above);
        let part = (top * bottom.conj()).re / larger(bottom.norm_sqr(), 1e-30);
        let at = bin + part.clamp(-0.6, 0.6);
        let distance = at - offset;
        if distance.abs() <= NEAR || !window.has(at) {
            continue;
        }
        let one = Candidate::new(window, joint, at, Reach::Inside);
        let prior = place_prior(INTERVAL, distance);
        *cell = weigh(&one, distance, prior, Reach::Inside);
        if number == 0 && window.has(offset - distance) && joint.vacant() >= 2 {
            let other = Candidate::new(window, joint, offset - distance, Reach::Inside);
            pair = sidebands(ground, &one, &other, slope, 2.0 * ground.strength);
            pair.distance = distance;
            pair.belief = pair.belief.times(prior);
            pair.best += prior;
            pair.values = pair.values.map(|value| unit * value);
        }
    }
    for (cell, at) in places.iter_mut().skip(PEAKS).zip(window.outside()) {
        let Some((at, reach)) = at else { continue };
        let distance = at - offset;
        let one = Candidate::new(window, joint, at, reach);
        *cell = weigh(&one, distance, place_prior(distance.abs(), distance), reach);
    }
    (places, pair)
}

/// Weighs two lines whose sizes have one prior, by their strengths in the tone's phase.
fn sidebands(
    ground: &Ground,
    one: &Candidate,
    other: &Candidate,
    slope: f32,
    most: f32,
) -> Sidebands {
    let mut both = -one.taken.product(&other.taken);
    for ([a, _], [b, _]) in one.column.iter().zip(&other.column) {
        both += a * b;
    }
    let squares = [one, other].map(|candidate| {
        let first = candidate.taken.first();
        candidate.taken.own - first * first
    });
    let pulls = [one, other].map(|candidate| candidate.taken.first() * slope);
    let alongs = [one.along, other.along];
    let seen: f32 =
        alongs.iter().zip(squares).map(|(z, own)| z.norm_sqr() / larger(own, 1e-6)).sum();
    let own: f32 = squares.iter().sum();
    let mut factor = Factor::<2>::new();
    let (mut top, mut values) = (f32::NEG_INFINITY, [ZERO; 2]);
    let weighed = ground.sized(most, 4.0 * seen / larger(own, 1e-6), |variance| {
        let [square, other_square] = squares;
        factor.clear();
        factor.push(square, 1.0 / variance, []);
        factor.push(other_square, 1.0 / variance, [both]);
        let (mut re, mut im) = (alongs.map(|z| z.re), alongs.map(|z| z.im));
        let mut pull = pulls;
        let explained = factor.forward(&mut re) + factor.forward(&mut im);
        let spread = factor.forward(&mut pull);
        let offset = re.iter().zip(pull).map(|(re, pull)| re * pull).sum();
        let mut product = Product::ONE;
        factor.diagonal().for_each(|root| product.times(root * root * variance));
        // The real and the imaginary part of each strength have the same freedom.
        let cost = product.ln();
        let merit = ground.gain(explained) - cost;
        if merit > top {
            top = merit;
            factor.backward(&mut re);
            factor.backward(&mut im);
            let ([a, c], [b, d]) = (re, im);
            values = [Complex::new(a, b), Complex::new(c, d)];
        }
        Effect { explained, cost, offset, variance: spread }
    });
    Sidebands { belief: weighed.belief, best: weighed.best, values, distance: f32::INFINITY }
}
