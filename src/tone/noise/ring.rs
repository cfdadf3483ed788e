//! The noise beside a tone, from the bins of a ring around it. There the noise is as strong as
//! under the tone itself.
//!
//! Noise is seldom white. A filter, a converter's own noise and hum can make it a hundred times stronger in one part of a spectrum than in
//! another. So only the noise near the tone determines the tone's error. But the tone leaks into the bins near it, and so does any signal
//! that moves along with the tone. Second differences of the bins, which are Hann's window, lessen leakage by 18 dB an octave. The tone's
//! own leakage is known and subtracted. With c the tone's line, d its offset and x the distance of a bin from the tone in bins,
//!
//! ```text
//! (X[k-1] + X[k+1]) / 2 - X[k]  =  noise + c sin(pi d) / (pi x (x^2 - 1))          white noise of power P: 3/2 P
//! ```
//!
//! The error of this equation is of the order of `(pi x / N)^4`: a tone's bins are cotangents less
//! a constant, and the difference of a cotangent from `1/x` is nearly a straight line.
//!
//! The estimate takes every second difference from 7 bins off, in stretches of four. Other lines are not noise, so the loudest third of
//! each side's stretches is left out. Censoring lowers white noise by a known factor. The geometric mean of both sides cancels any slope in
//! decibels.
//!
//! With four stretches on each side the standard deviation is 0.85 dB: 50 degrees of freedom.
//!
//! `own` evaluates the left side of the equation less the tone's share on the right, in floats or in integers, and sums its squares over a
//! stretch; near an end of a real spectrum the share of the mirror image is subtracted, too.

use super::own::{Own, OwnInIntegers, STEP, Stretch};
use super::power::{Noise, rounding};
use super::whole;
use crate::math::scalar::Scalar;
use crate::spectrum::fft::integer::Point;
use crate::spectrum::neighbourhood::{GROUPS, GUARD, LENT, Neighbourhood, has_ring, room};
use crate::spectrum::view::View;
use crate::tone::arithmetic::Arithmetic;
use crate::tone::fit::Fit;
use crate::tone::statistic::{Statistic, Test};
use core::mem::MaybeUninit;
use core::ops::Range;

/// The noise beside a tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalNoise {
    /// The noise at the tone.
    pub noise: Noise,
    /// The power on the louder side, which a peak must exceed.
    pub loud: f32,
    /// Two powers that enclose the noise: the quieter side's and the louder side's. If there is only one side, the powers of its quieter
    /// stretches and of its loudest one.
    range: [f32; 2],
    sides: [Side; 2],
}

/// Bins from the tone to the middle of the first difference.
pub(crate) const FIRST: i32 = GUARD;

/// Stretches on each side. If an end of the spectrum cuts one side short, the other takes at most two more: the noise farther away is
/// different.
const WANTED: usize = GROUPS;
const MOST: usize = WANTED + LENT;

/// Share of white noise's power and relative variance of the censored mean (all but the loudest third), by number of stretches.
const KEPT: [(f32, f32); WIDE + 1] = [
    (1.0, 1.0),
    (1.0, 0.2600),
    (1.0, 0.1310),
    (0.7798, 0.1136),
    (0.8149, 0.0789),
    (0.8391, 0.0604),
    (0.7499, 0.0577),
    (0.7738, 0.0472),
];

/// Bins from the tone to the last difference of the ring, if there is room on one side alone.
pub(crate) const OUTERMOST: i32 = FIRST - 1 + (STEP * MOST) as i32;

/// The bins of one side.
type Window = [MaybeUninit<Point>; STEP * MOST + 1];

/// Degrees of freedom of a side of three stretches: such a side says little by itself.
const FEW: f32 = 24.0;

/// Stretches on each side of the wide ring, which decides whether a weak peak is a tone.
const WIDE: usize = 7;

/// The noise beside the tone that `fit` found. Records of fewer than 256 samples (I/Q: 128) have no room for a ring. Their
/// noise comes from all bins, see [`whole::noise`].
///
/// Cost: 32 differences.
pub fn beside(near: &Neighbourhood, fit: &Fit<f32>, arithmetic: Arithmetic) -> LocalNoise {
    beside_by(near, fit, arithmetic.available())
}

/// [`beside`] in floats, also in a program that has integers elsewhere.
#[inline(never)] // so that all who fit share one
pub(crate) fn beside_in_floats(near: &Neighbourhood, fit: &Fit<f32>) -> LocalNoise {
    beside_by(near, fit, Arithmetic::Float)
}

#[inline(always)]
fn beside_by(near: &Neighbourhood, fit: &Fit<f32>, arithmetic: Arithmetic) -> LocalNoise {
    let &Neighbourhood { n, iq, .. } = near;
    if !has_ring(n, iq) {
        return LocalNoise::from_noise(whole::noise(near, fit, arithmetic));
    }
    let own = Own::new(iq, near.peak, n, fit, near.exponent);
    let sides = sides(near).map(|(bins, first)| own.side(bins, first, arithmetic));
    from_sides(sides, unit(near), rounding(near.iq))
}

/// The noise beside one tone of several, in a record that has room for a ring. `less_others(k, stretch)` subtracts the others' leakage from
/// the differences around `k`, `k + 2` and so on.
pub(crate) fn beside_others(
    near: &Neighbourhood,
    fit: &Fit<f32>,
    less_others: impl Fn(i32, &mut Stretch),
) -> LocalNoise {
    let own = Own::new(near.iq, near.peak, near.n, fit, near.exponent);
    let sides = sides(near)
        .map(|(bins, first)| powers(bins, first, |bins, k| own.power(bins, k, &less_others)));
    from_sides(sides, unit(near), rounding(near.iq))
}

/// The bins of the ring below a peak and above it, and the place of the first bin.
fn sides<'a>(near: &Neighbourhood<'a>) -> [(&'a [Point], i32); 2] {
    let [left, right] = near.groups.map(|groups| STEP * groups);
    let (low, high) = (near.peak - FIRST + 1 - left as i32, near.peak + FIRST - 1);
    [(near.from(low, left + 1), low), (near.from(high, right + 1), high)]
}

/// The noise in a ring nearly twice as wide as the ring of `beside`. A peak that is hardly stronger than the noise must exceed this one,
/// too.
///
/// Cost: up to 50 bins read, 24 differences.
#[inline(never)]
pub fn loud(
    view: &View,
    at: &Neighbourhood,
    fit: &Fit<f32>,
    beside: &LocalNoise,
    arithmetic: Arithmetic,
) -> Option<LocalNoise> {
    let arithmetic = arithmetic.available();
    let &Neighbourhood { n, iq, .. } = at;
    if !has_ring(n, iq) {
        return None;
    }
    let own = Own::new(iq, at.peak, n, fit, at.exponent);
    let [left, right] = room(n, iq, at.peak);
    let [near_left, near_right] = beside.sides;
    let side = |outward: i32, near: Side, room: usize| {
        let places = near.count..room.min(WIDE).max(near.count);
        let all = near.and(own.read(view, outward, places, arithmetic));
        let (share, variance) = all.kept();
        if all.count == 0 { (0.0, 0.0) } else { (all.quiet() / share, 2.0 / variance) }
    };
    let (left, right) = (side(-1, near_left, left), side(1, near_right, right));
    let (quieter, louder) = if left.0 < right.0 { (left, right) } else { (right, left) };
    let power = (louder.0 * unit(at)).max(rounding(at.iq));
    let spread = (2.0 / louder.1.max(1.0) + 2.0 / quieter.1.max(1.0)).root();
    // A side that is quieter by more than chance has another noise, and makes the louder side no more accurate.
    let apart = louder.1 > FEW && louder.0 > (1.0 + 3.0 * spread) * quieter.0;
    let dof = if apart { louder.1 } else { louder.1 + quieter.1 };
    (dof > 0.0).then_some(LocalNoise {
        noise: Noise { power, dof },
        loud: power,
        range: [power; 2],
        sides: beside.sides,
    })
}

/// Degrees of freedom of the noise beside a tone away from the ends of the spectrum.
pub(crate) const fn dof(n: usize, iq: bool) -> f32 {
    if has_ring(n, iq) { const { 4.0 / KEPT[WANTED].1 } } else { whole::dof(n, iq) }
}

/// The noise power per sample, in squared codes, for which a stretch has the power 1 in stored units. A stretch sums the squares of four half
/// second differences, each of which has 3/2 of a bin's power, and a bin's power is N times a sample's: 6 N times a sample's.
fn unit(near: &Neighbourhood) -> f32 {
    f32::two_to(2 * near.exponent - near.n.trailing_zeros() as i32) / 6.0
}

/// If one side is this many times as loud as the other, the noise has an edge between them: a
/// slope is less steep.
const EDGE: f32 = 8.0;

impl LocalNoise {
    /// The noise of a record without a ring.
    pub(crate) fn from_noise(noise: Noise) -> Self {
        let Noise { power, .. } = noise;
        Self { noise, loud: power, range: [power; 2], sides: [Side::default(); 2] }
    }

    /// Whether the noise comes from a ring.
    pub(crate) fn has_sides(&self) -> bool {
        self.sides.iter().any(|side| side.count > 0)
    }

    /// Whether the noise has an edge between both sides.
    #[inline]
    pub fn has_edge(&self) -> bool {
        let [quiet, loud] = self.range;
        loud > EDGE * quiet
    }

    /// The test for such an edge.
    pub(crate) fn edge(&self) -> Test {
        let [quiet, loud] = self.range;
        Test { statistic: Statistic::NoiseEdge, value: loud / quiet, limit: EDGE }
    }

    /// At an edge of the noise near the tone the ring cannot decide on which side the tone is. The fit's residual from five bins off can:
    /// this power, with these degrees of freedom, held between the powers of both sides.
    #[inline]
    pub fn on_an_edge(self, power: f32, dof: f32) -> Self {
        let [quiet, loud] = self.range;
        let power = power.max(quiet).min(loud);
        Self { noise: Noise { power, dof }, loud: self.loud.max(power), ..self }
    }

    /// The noise of the quieter side, where the louder side has a line that leaks into the tone's bins.
    #[inline]
    pub fn quieter(self, dof: f32) -> Self {
        let [power, _] = self.range;
        Self { noise: Noise { power, dof }, loud: power, ..self }
    }
}

/// The noise from both sides.
#[inline]
fn from_sides(sides: [Side; 2], scale: f32, least: f32) -> LocalNoise {
    if let [Side { count: WANTED, .. }, Side { count: WANTED, .. }] = sides {
        return from_whole_sides(sides, scale, least);
    }
    let [left, right] = sides.map(|side| {
        let (share, variance) = side.kept();
        (side.quiet() * scale / share, variance)
    });
    let [none, nothing] = sides.map(|side| side.count == 0);
    let (power, variance, loud, range) = if none || nothing {
        let ((power, variance), side) = if none { (right, 1) } else { (left, 0) };
        let loudest = sides.get(side).map_or(0.0, |side: &Side| side.loudest * scale);
        (power, variance, power, [power, loudest])
    } else {
        let variance = (left.1 + right.1) * 0.25;
        // Half of the variance makes the mean right: a geometric mean is too low. A quarter takes a quarter off the bias of (error /
        // sigma)^2.
        let middle = (left.0 * right.0).root() * (1.0 + 0.75 * variance);
        let loud = left.0.max(right.0);
        (middle, variance, loud, [left.0.min(right.0), loud])
    };
    let noise = Noise { power: power.max(least), dof: 2.0 / variance };
    LocalNoise { noise, loud: loud.max(least), range: range.map(|power| power.max(least)), sides }
}

/// The noise from both sides, with four stretches on each.
#[inline]
fn from_whole_sides(sides: [Side; 2], scale: f32, least: f32) -> LocalNoise {
    /// The mean of both sides: its share of white noise's power, and half its relative variance.
    const SHARE: f32 = KEPT[WANTED].0;
    const VARIANCE: f32 = KEPT[WANTED].1 * 0.5;
    let scale = scale * const { 1.0 / (SHARE * (WANTED - WANTED / 3) as f32) };
    let [left, right] = sides.map(|side| (side.sum - side.loudest) * scale);
    let (quiet, loud) = if left < right { (left, right) } else { (right, left) };
    let power = (left * right).root() * const { 1.0 + 0.75 * VARIANCE };
    let noise = Noise { power: power.max(least), dof: const { 2.0 / VARIANCE } };
    LocalNoise { noise, loud: loud.max(least), range: [quiet.max(least), loud.max(least)], sides }
}

/// The powers of the stretches on one side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Side {
    sum: f32,
    loudest: f32,
    second: f32,
    count: usize,
}

impl Side {
    #[inline(always)]
    fn add(&mut self, power: f32) {
        self.count += 1;
        self.sum += power;
        // `max` would test for NaN as well.
        if power > self.loudest {
            self.second = self.loudest;
            self.loudest = power;
        } else if power > self.second {
            self.second = power;
        }
    }

    fn and(self, other: Self) -> Self {
        Self {
            sum: self.sum + other.sum,
            loudest: self.loudest.max(other.loudest),
            second: self.second.max(other.second).max(self.loudest.min(other.loudest)),
            count: self.count + other.count,
        }
    }

    /// The mean of the quieter stretches as a share of white noise, and its relative variance.
    fn kept(&self) -> (f32, f32) {
        KEPT.get(self.count).copied().unwrap_or((1.0, 1.0))
    }

    /// The mean without the loudest third, which is at most two stretches.
    fn quiet(&self) -> f32 {
        let without = self.count / 3;
        let loud = match without {
            0 => 0.0,
            1 => self.loudest,
            _ => self.loudest + self.second,
        };
        (self.sum - loud) / self.count.saturating_sub(without).max(1) as f32
    }
}

impl Own {
    /// Reads stretches on one side. `outward` is -1 or 1; stretch 0 is the one nearest to the
    /// tone.
    fn read(
        &self,
        view: &View,
        outward: i32,
        stretches: Range<usize>,
        arithmetic: Arithmetic,
    ) -> Side {
        let mut window: Window = [MaybeUninit::uninit(); _];
        let (bins, first) = self.window(view, outward, stretches, &mut window);
        self.side(bins, first, arithmetic)
    }

    /// The bins of stretches on one side, and the place of the first bin.
    #[inline(always)]
    fn window<'w>(
        &self,
        view: &View,
        outward: i32,
        stretches: Range<usize>,
        window: &'w mut Window,
    ) -> (&'w [Point], i32) {
        let count = stretches.len().min(MOST);
        let near = FIRST - 1 + (STEP * stretches.start) as i32;
        let first =
            if outward > 0 { self.peak + near } else { self.peak - near - (STEP * count) as i32 };
        let window = window.get_mut(..STEP * count + 1).unwrap_or_default();
        (view.fill_beside_offset(first, window), first)
    }

    /// The stretches of the bins from `first` on. A program with one arithmetic holds one of the two.
    #[inline(always)]
    fn side(&self, bins: &[Point], first: i32, arithmetic: Arithmetic) -> Side {
        match arithmetic {
            Arithmetic::Fixed => self.side_in_integers(bins, first),
            Arithmetic::Float => self.side_in_floats(bins, first),
        }
    }

    #[inline(never)]
    fn side_in_integers(&self, bins: &[Point], first: i32) -> Side {
        let own = OwnInIntegers::from_own(self);
        powers(bins, first, |bins, k| own.power(bins, k))
    }

    #[inline(never)]
    fn side_in_floats(&self, bins: &[Point], first: i32) -> Side {
        powers(bins, first, |bins, k| self.power(bins, k, |_, _| ()))
    }
}

#[inline(always)]
fn powers(bins: &[Point], first: i32, power: impl Fn(&[Point; STEP + 1], i32) -> f32) -> Side {
    let (mut side, mut rest, mut centre) = (Side::default(), bins, first + 1);
    while let Some(bins) = rest.first_chunk() {
        side.add(power(bins, centre));
        rest = rest.get(STEP..).unwrap_or(&[]);
        centre += STEP as i32;
    }
    side
}
