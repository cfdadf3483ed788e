//! One fundamental from all its harmonics: of the mains, a motor, blades, a string.
//!
//! A harmonic of order k determines the fundamental k times as precisely as its own frequency. The lines of a record are fitted together
//! ([`super::lines`]). A candidate for the fundamental is a line's frequency over a whole number. The right one explains the most lines, each
//! weighed by how improbable its place is by chance; among candidates that explain the same lines it is the highest. So a fundamental that
//! is weaker than its harmonics, or missing, is not mistaken for a harmonic as long as two lines of orders without a common factor are seen.
//! With `f_k` and `s_k` the
//! frequency of order k and its sigma by the noise alone,
//!
//! ```text
//! f = (sum k f_k / s_k^2) / (sum k^2 / s_k^2)        sigma^2 = 1 / sum k^2 / s_k^2
//! ```
//!
//! The orders of a wave with edges fold at half the rate. A line that folds there counts for the series, and sigma covers what folded orders
//! do to the lower ones (see `aliases`).
//!
//! The partials of a stiff string are stretched, `f_k = k f sqrt((1 + B k^2) / (1 + B))` with B up to 3e-4 (Fletcher 1964,
//! doi:10.1121/1.1918981). Where the lines are off the multiples by more than their sigmas, f and `f B / 2` are fitted together, with `k (k^2 - 1)` beside k.

use super::aliases::{Orders, pulls};
use super::evidence::Evidence;
use super::line_class::LineClass;
use super::lines::{Hunt, every_line};
use super::options::Options;
use super::phasor::ToneWithPhase;
use crate::acquire::sample::Stamp;
use crate::frequency::Frequency;
use crate::math::scalar::Scalar as _;
use crate::spectrum::layout::Layout;
use crate::spectrum::peak::Band;
use crate::spectrum::view::View;
use crate::tone::{Reasons, Tone};
use fixed::types::I0F32;
use heapless::Vec;

/// The highest order.
pub const HIGHEST: u32 = 32;

/// A fundamental and the orders that it was found by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Harmonic {
    /// The fundamental: its frequency and sigma from all lines. The signal-to-noise ratio is of all lines together; the amplitude belongs
    /// to order 1, 0 if order 1 is not seen.
    pub tone: Tone,
    /// The orders that were seen: bit k stands for order k + 1.
    pub orders: u32,
}

impl Harmonic {
    /// The orders that were seen, in order: 1 is the fundamental itself.
    pub fn seen(&self) -> impl Iterator<Item = u32> + use<> {
        let orders = self.orders;
        (1..=HIGHEST).filter(move |order| orders >> (order - 1) & 1 == 1)
    }
}

/// A line is a harmonic if it lies within this many sigmas of a multiple; a line's sigma ignores other signals in the line.
const OFF: f32 = 6.0;
const LEAST_BINS: f32 = 0.02;

/// The amplitude of an order times its number is the same for all orders of an edge, unless two edges cancel. So orders that fold are at
/// most this many times as strong as the strongest of the others.
const EDGE: f32 = 2.0;

/// Prior: one series in twenty has edges and no filter before the converter.
const FOLDING: f32 = 3.0;

/// Half of the largest B, as a share of the fundamental that a line may be off for each `k (k^2 - 1)`.
const STRETCH: f32 = 1.5e-4;

/// From here on sigma covers a stretch: the stretch lowers the sum of the squared distances of the lines, in their sigmas, by this much. Noise
/// does so in one series of 150. If lines contradict the multiples and a stretch removes the contradiction, the series is stretched.
const BETTER: f32 = 6.0;

/// From this many sigmas on a line contradicts the others.
const CONTRADICTS: f32 = 5.0;

/// The fundamental within `band`, from its harmonics up to `order`, at most [`HIGHEST`]; `None` if nothing is seen. `tone` is the tone that
/// was measured in this spectrum.
///
/// One line alone does not determine its order. It is taken for the lowest order that the band admits; if the band admits another, the
/// verdict is [`Unresolved`](super::verdict::Verdict::Unresolved).
pub fn harmonic(
    view: &View,
    tone: &Tone,
    band: Band,
    clipped: u32,
    stamp: &Stamp,
    options: &Options,
    order: u32,
) -> Option<Harmonic> {
    let (hunt, lines) = every_line(view, tone, clipped, stamp, options)?;
    let Layout { n, iq, .. } = *view.layout;
    let order = order.clamp(1, HIGHEST) as i32;
    let search = Search { n, iq, highest: order };
    let mut best: Option<Series> = None;
    let mut rivals = 0;
    for seed in &lines {
        for h in 1..=order {
            if !holds(band, n, &seed.tone, h) {
                continue;
            }
            let series = Series::from_seed(&lines, &seed.tone, h, &search);
            rivals += 1;
            if best.as_ref().is_none_or(|best| series.explains_more(best)) {
                best = Some(series);
            }
        }
    }
    let best = best?;
    let mut harmonic = best.harmonic(&hunt, &lines)?;
    let alone = best.count == 1 && rivals > lines.len();
    if alone || best.count == 1 && lines.len() > 1 && rivals > 1 {
        let said = harmonic.tone.said();
        harmonic.tone.conclude(&Evidence { line: LineClass::Unresolved, ..Evidence::new(said) });
    }
    Some(harmonic)
}

/// Whether a band holds a line's frequency over h, with half a bin at each end.
fn holds(band: Band, n: usize, line: &Tone, h: i32) -> bool {
    let bins = line.frequency.bins(n) as f32 / h as f32;
    let inside = |bins: f32| bins > band.low as f32 - 0.5 && bins < band.high as f32 + 0.5;
    inside(bins) || inside(bins + n as f32)
}

/// Steps of a frequency in a cycle per sample: 2^32.
const STEPS: f32 = 4_294_967_296.0;

/// A line's place in a series.
struct Place {
    order: i32,
    /// The distance from this multiple of the fundamental, cycles per sample.
    rest: f32,
    /// Whether only a stretch explains it.
    stretched: bool,
    /// The probability that a line anywhere lies on a multiple by chance, and how many times as large it is with a stretch.
    chance: f32,
    room: f32,
}

/// The lines and limits among which candidates are sought.
#[derive(Clone, Copy)]
struct Search {
    n: usize,
    iq: bool,
    /// The highest order that the fundamental is measured by. Higher orders only distinguish series.
    highest: i32,
}

/// A candidate for the fundamental: a line's frequency over a whole number.
struct Series {
    seed: Tone,
    over: i32,
    search: Search,
    /// The logarithm of the odds that its lines are where they are by chance: of each line at most that of its signal-to-noise ratio.
    evidence: f32,
    count: u32,
    /// The fundamental, cycles per sample.
    cycles: f32,
    /// Whether lines off their multiples belong to the series.
    stretches: bool,
}

impl Series {
    fn from_seed(lines: &[ToneWithPhase], seed: &Tone, over: i32, search: &Search) -> Self {
        let cycles = seed.frequency.cycles_f32() / over as f32;
        let mut series = Self {
            seed: *seed,
            over,
            search: *search,
            evidence: 0.0,
            count: 0,
            cycles,
            stretches: false,
        };
        let size = |line: &ToneWithPhase| {
            let place = series.seek(&line.tone).filter(|place| !place.stretched);
            place.map(|place| place.order as f32 * line.tone.amplitude)
        };
        let edge = EDGE * lines.iter().filter_map(size).fold(0.0, f32::max);
        // A single line off its multiple is another line; two or more mean a stretch.
        let (mut beside, mut more, mut most_room, mut last, mut fold) = (0, 0.0, 1.0f32, 0, 0.0);
        for ToneWithPhase { tone, .. } in lines {
            // The probability that a line anywhere is at a place of the series by chance.
            let odds = 1.0 + tone.snr * search.n as f32;
            let evidence = |chance: f32| libm::logf(odds.min(1.0 / chance)).max(0.0);
            let Some(Place { order, stretched, chance, room, .. }) = series.seek(tone) else {
                fold += series.folded(tone, edge).map_or(0.0, evidence);
                continue;
            };
            last = last.max(order);
            if stretched {
                (beside, more, most_room) =
                    (beside + 1, more + evidence(chance), most_room.max(room));
            } else {
                series.count += u32::from(order <= search.highest);
                series.evidence += evidence(chance);
            }
        }
        if beside > 1 {
            series.stretches = true;
            // All lines share one stretch.
            let more = more - libm::logf(most_room);
            (series.count, series.evidence) = (series.count + beside, series.evidence + more);
        }
        // Most series do not fold, so one line where an order would fold is no evidence.
        series.evidence += (fold - FOLDING).max(0.0);
        // Each order up to the last may as well be missing.
        series.evidence -= core::f32::consts::LN_2 * last as f32;
        series
    }

    /// Whether this series has more evidence, or equal evidence and a higher fundamental.
    fn explains_more(&self, other: &Self) -> bool {
        let margin = 1e-3 * other.evidence.abs();
        self.evidence > other.evidence + margin
            || self.evidence > other.evidence - margin && self.cycles.abs() > other.cycles.abs()
    }

    /// The order and the distance of a line of the series.
    fn place(&self, line: &Tone) -> Option<(i32, f32)> {
        let Place { order, rest, stretched, .. } = self.seek(line)?;
        (order <= self.search.highest && (self.stretches || !stretched)).then_some((order, rest))
    }

    /// How far a line of an order may be off its multiple, cycles per sample.
    fn within(&self, line: &Tone, order: i32) -> f32 {
        let own = self.seed.sigma * order as f32 / self.over as f32;
        let sigma = (line.sigma * line.sigma + own * own).root();
        (OFF * sigma).max(LEAST_BINS / self.search.n as f32)
    }

    /// The probability that a line anywhere is where an order folds by chance; `None` if this line is not. Beyond half the rate are only the orders of
    /// edges, whose amplitude times their number is `edge` at most.
    fn folded(&self, line: &Tone, edge: f32) -> Option<f32> {
        let step = self.seed.frequency.0.to_bits() / self.over.max(1);
        let theirs = line.frequency.0.to_bits();
        let mut at = 0i32;
        for order in 1..=HIGHEST as i32 {
            at = at.wrapping_add(step);
            if line.amplitude * order as f32 > edge {
                return None;
            }
            if self.cycles.abs() * order as f32 <= 0.5 {
                continue;
            }
            let off = |place: i32| theirs.wrapping_sub(place).unsigned_abs();
            let off = if self.search.iq { off(at) } else { off(at).min(off(at.wrapping_neg())) };
            let within = self.within(line, order);
            if (off as f32 / STEPS) < within {
                return Some(2.0 * within * self.density());
            }
        }
        None
    }

    /// The places of orders in a cycle per sample, of those that fold as well.
    fn density(&self) -> f32 {
        let room = if self.search.iq { 1.0 } else { 0.5 };
        (1.0 / self.cycles.abs()).max(HIGHEST as f32 / room)
    }

    /// Where a line is in the series.
    fn seek(&self, line: &Tone) -> Option<Place> {
        let (ours, theirs) = (self.seed.frequency.0.to_bits(), line.frequency.0.to_bits());
        let ratio = theirs as f32 / ours as f32 * self.over as f32;
        let order = libm::rintf(ratio) as i32;
        if !(1..=HIGHEST as i32).contains(&order) {
            return None;
        }
        let rest = i64::from(theirs) * i64::from(self.over) - i64::from(ours) * i64::from(order);
        let rest = rest as f32 / STEPS / self.over as f32;
        let within = self.within(line, order);
        // Stretched upwards, away from 0 Hz.
        let most = STRETCH * stretched(order) * self.cycles.abs();
        let out = if self.cycles < 0.0 { -rest } else { rest };
        let stretched = out >= within;
        let chance = 2.0 * within * self.density();
        let room = 1.0 + 0.5 * most / within;
        (out > -within && out < within + most).then_some(Place {
            order,
            rest,
            stretched,
            chance,
            room,
        })
    }

    /// The fundamental from all its lines.
    fn harmonic(&self, hunt: &Hunt, lines: &[ToneWithPhase]) -> Option<Harmonic> {
        let n = self.search.n;
        let placed = || lines.iter().filter_map(|line| Some((line, self.place(&line.tone)?)));
        let mut harmonic = Harmonic { tone: Tone { ..self.seed }, orders: 0 };
        (harmonic.tone.amplitude, harmonic.tone.snr) = (0.0, 0.0);
        let mut said = Reasons::NONE;
        for (ToneWithPhase { tone, .. }, (order, _)) in placed() {
            harmonic.orders |= 1u32.checked_shl(order as u32 - 1).unwrap_or(0);
            harmonic.tone.snr += tone.snr;
            said = said.union(tone.said());
            if order == 1 {
                harmonic.tone.amplitude = tone.amplitude;
            }
        }
        let start = self.seed.frequency.cycles() / f64::from(self.over);
        let (mut along, mut weight, mut variance) = (0.0, 0.0, 0.0);
        for (ToneWithPhase { tone, .. }, (order, rest)) in placed() {
            // A movement widens the sigma of every line, but all of them move together: only the noise counts in the weights.
            let k = order as f32;
            let share = k * tone.snr;
            // In bins, so that no square is too small.
            let sigma = tone.sigma * n as f32;
            along += share * (rest * n as f32);
            weight += share * k;
            variance += (share * sigma) * (share * sigma);
        }
        let mut more = along / weight / n as f32;
        let mut sigma = variance.root() / weight / n as f32;
        let mut of = Orders { lines, orders: Vec::new() };
        for line in lines {
            let order = self.place(&line.tone).map_or(0, |(order, _)| order);
            of.orders.push(order).unwrap_or_default();
        }
        let pulls = pulls(hunt, &of, start + f64::from(more), sigma * n as f32);
        // How far a line is off, in its sigmas.
        let off = |more: f32, bend: f32, (line, (order, rest)): (&ToneWithPhase, (i32, f32))| {
            let pulled = of.orders.iter().position(|it| *it == order);
            let pulled =
                pulled.and_then(|index| pulls.lines.get(index)).map_or(0.0, |it| it.root());
            (rest - order as f32 * more - bend * stretched(order))
                / libm::hypotf(line.tone.sigma, pulled / n as f32)
        };
        let squares = |more: f32, bend: f32| -> f32 {
            placed().map(|it| off(more, bend, it)).map(|off| off * off).sum()
        };
        let contradict =
            |more: f32, bend: f32| placed().any(|it| off(more, bend, it).abs() > CONTRADICTS);
        let mut bend = 0.0;
        if let Some(fit) = Bent::fit(placed(), n)
            && fit.bend.abs() < STRETCH * self.cycles.abs()
            && fit.bend * self.cycles > 0.0
        {
            let better = squares(more, 0.0) - squares(fit.more, fit.bend);
            if better > BETTER {
                sigma = fit.sigma;
            }
            if better > CONTRADICTS * CONTRADICTS && contradict(more, 0.0) {
                (more, bend) = (fit.more, fit.bend);
            }
        }
        let line = if contradict(more, bend) { LineClass::Unresolved } else { LineClass::Steady };
        harmonic.tone.conclude(&Evidence { line, ..Evidence::new(said) });
        let cycles = start + f64::from(more);
        let steps = libm::rint(cycles * 4_294_967_296.0);
        if !steps.is_finite() {
            return None;
        }
        harmonic.tone.frequency = Frequency(I0F32::from_bits(steps as i64 as i32));
        harmonic.tone.sigma = libm::hypotf(sigma, pulls.fundamental.root() / n as f32);
        Some(harmonic)
    }
}

/// How far order k is off its multiple, in shares of `f B / 2`.
fn stretched(order: i32) -> f32 {
    let k = order as f32;
    k * (k * k - 1.0)
}

/// The fundamental of a stretched series, cycles per sample: how far it is off the seed's, its sigma, and `f B / 2`.
struct Bent {
    more: f32,
    bend: f32,
    sigma: f32,
}

impl Bent {
    /// The fit of both to lines with their orders and distances; `None` for fewer than three lines.
    fn fit<'a>(
        placed: impl Iterator<Item = (&'a ToneWithPhase, (i32, f32))> + Clone,
        n: usize,
    ) -> Option<Self> {
        let bins = n as f32;
        let (mut kk, mut ks, mut ss, mut kr, mut sr, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0, 0);
        // A thousandth of the stretch, so that both columns are of one size.
        let columns = |order: i32| (order as f32, 1e-3 * stretched(order));
        for (line, (order, rest)) in placed.clone() {
            let ((k, s), weight, rest) = (columns(order), line.tone.snr, rest * bins);
            kk += weight * k * k;
            ks += weight * k * s;
            ss += weight * s * s;
            kr += weight * k * rest;
            sr += weight * s * rest;
            count += 1;
        }
        let determinant = kk * ss - ks * ks;
        let apart = determinant > 1e-4 * kk * ss;
        if count < 3 || !apart {
            return None;
        }
        let mut variance = 0.0;
        for (line, (order, _)) in placed {
            let (k, s) = columns(order);
            let share = line.tone.snr * (k * ss - s * ks) / determinant * line.tone.sigma * bins;
            variance += share * share;
        }
        Some(Self {
            more: (kr * ss - sr * ks) / determinant / bins,
            bend: 1e-3 * (sr * kk - kr * ks) / determinant / bins,
            sigma: variance.root() / bins,
        })
    }
}
