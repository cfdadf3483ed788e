//! The frequency of a burst, its sigma, and whether one particle made it.
//!
//! The search weighs the record with the envelope that the detector guesses. 64 points of the signal around the found line (`baseband`)
//! then give a better envelope, and search and points are repeated until the envelope settles. The frequency is the maximum of
//!
//! ```text
//! |sum over n of e(t) z[n] exp(-j 2 pi f t)|^2        t = n / 64 less the envelope's middle, e(t) the envelope
//! ```
//!
//! which is the maximum of the likelihood in white noise; its curvature gives sigma. The level of one tone, whatever its envelope, is in phase
//! with it and does not move its frequency. So a second particle shows in quadrature to the tone, by more power than the noise around the
//! burst or by a phase that bends; and by a level that falls and rises again.

use super::baseband::{Baseband, CORRELATION, PASSED, POINTS, place, taper, used};
use super::envelope::{self, Envelope, median};
use super::{Burst, Validation};
use crate::acquire::burst::Cut;
use crate::acquire::codes::Codes;
use crate::acquire::sample::{Data, Record, Statistics};
use crate::chance::over_mean;
use crate::frequency::Frequency;
use crate::math::scalar::Scalar as _;
use crate::plan::Terms;
use crate::spectrum::Spectrum;
use crate::spectrum::engine::Engine;
use crate::spectrum::layout::Layout;
use crate::spectrum::peak::Band;
use crate::spectrum::view::View;
use crate::tone::fit::descent::Descent;
use crate::tone::fit::normal::Products;
use crate::tone::sigma::CLIPPED;
use crate::tone::{Reasons, Tone, Verdict};
use core::f32::consts::{PI, TAU};
use num_complex::Complex;

/// How often the envelope is estimated: each time, the search is weighted with the envelope before.
const ROUNDS: usize = 3;
/// The probability that the noise of a record passes for a burst's line. A detector cuts few records out of noise.
const FALSE_ALARM: f32 = 1e-5;
/// The fewest cycles between the points where the power is down by `exp(-2)`.
const CYCLES: f32 = 4.0;
/// Standard deviations on each side of the middle within which a burst is tested for a second particle.
const NEAR: f32 = 2.5;
/// The limit in normal deviations that a single particle's residual exceeds in one of a hundred bursts by its power over the noise next to
/// the burst, and (in simulation, in one of a thousand) by the correlation of its neighbouring points.
const POWER_LIMIT: f32 = 2.33;
const CORRELATION_LIMIT: f32 = 3.2;
/// Orders of time to which the phase of a burst is fitted: its phase, its frequency, and bends of second to fourth order. One particle in
/// 180 exceeds this limit by noise alone (chi-square with three degrees of freedom).
const ORDERS: usize = 5;
const BEND_LIMIT: f32 = 12.5;
/// A single envelope rises and falls once. By chance the dip between two humps exceeds this many deviations of its noise in one of a thousand
/// flat pulses. The ripple of the 64 bins makes dips of this share of the level.
const DIP: f32 = 5.0;
const RIPPLE: f32 = 0.1;

/// Measures a burst in the record cut around it.
pub(crate) fn measure<R: Record, const N: usize, E: Engine>(
    spectrum: &mut Spectrum<R, N, E>,
    terms: &Terms,
    cut: &Cut<R, N>,
) -> Burst {
    let mut look =
        Measuring::new(Data::of::<R>(cut.samples), cut.clock, [cut.middle, cut.deviation], terms);
    let mut samples = *cut.samples;
    for round in 1..=ROUNDS {
        look.weigh(R::pairs_mut(&mut samples));
        spectrum.transform(&samples, look.codes);
        let Some(found) = look.strongest(&spectrum.view()) else { break };
        look.taper(R::pairs_mut(&mut samples));
        spectrum.transform(&samples, look.codes);
        if look.finds(&spectrum.view(), found, round) {
            break;
        }
    }
    look.burst
}

/// The strongest bin of a weighted record, its power over the mean of the others, and the least such ratio that is not noise.
type Strongest = (i32, f32, f32);

/// A burst while it is measured.
struct Measuring<'a> {
    data: Data<'a>,
    n: usize,
    terms: &'a Terms,
    clock: u64,
    clipped: u32,
    offset: Complex<f32>,
    /// Codes about the offset: as far from it as the farther rail.
    codes: Codes,
    guess: Envelope,
    burst: Burst,
}

impl<'a> Measuring<'a> {
    fn new(data: Data<'a>, clock: u64, [middle, deviation]: [f32; 2], terms: &'a Terms) -> Self {
        let n = terms.n as usize;
        Self {
            data,
            n,
            terms,
            clock,
            clipped: Statistics::clipped(data, terms.codes),
            offset: Statistics::from_samples(data, terms.codes).mean(n),
            codes: around(terms.codes),
            guess: Envelope {
                middle: middle / n as f32,
                deviation: (deviation / n as f32).clamp(envelope::LEAST, envelope::MOST),
            },
            burst: Burst {
                arrival: clock as f64 + f64::from(middle),
                deviation,
                validation: Validation::Weak,
                tone: Tone { verdict: Verdict::Weak, rate_hz: terms.rate_hz, ..Tone::ZERO },
            },
        }
    }

    /// Writes the samples weighted with the envelope.
    fn weigh(&self, to: &mut [[i16; 2]]) {
        weigh::<8>(self.data, to, self.n, self.offset, self.codes, |t| self.guess.at(t));
    }

    /// Writes the samples under the taper. The points are divided by it, so it must be exact.
    fn taper(&self, to: &mut [[i16; 2]]) {
        weigh::<1>(self.data, to, self.n, self.offset, self.codes, taper);
    }

    fn strongest(&self, view: &View) -> Option<Strongest> {
        strongest(view, self.terms.band, &self.guess)
    }

    /// Measures the burst in the tapered record; false if the envelope has to be estimated once more.
    fn finds(&mut self, view: &View, (peak, ratio, limit): Strongest, round: usize) -> bool {
        let Layout { n, iq, .. } = *view.layout;
        let points = Baseband::from_view(view, peak).points;
        let found = self.guess.fitted(&points.map(|z| z.norm_sqr()));
        let near = (found.middle - self.guess.middle).abs() < 0.3 * self.guess.deviation;
        let alike = (0.75..1.33).contains(&(found.deviation / self.guess.deviation));
        self.guess = found;
        if !(near && alike) && round < ROUNDS {
            return false;
        }
        let (guess, burst) = (&self.guess, &mut self.burst);
        burst.arrival = self.clock as f64 + f64::from(guess.middle * n as f32);
        burst.deviation = guess.deviation * n as f32;
        let Some(line) = EnvelopedTone::fitted(&points, guess) else {
            return true;
        };
        let Some(frequency) = Frequency::from_bins(peak, line.offset, n) else {
            return true;
        };
        let bins = frequency.bins(n).abs() as f32;
        let cycles = bins * guess.deviation * 8.0f32.root();
        burst.validation = if self.clipped as f32 > CLIPPED * n as f32 {
            Validation::Clipped
        } else if ratio < limit {
            Validation::Weak
        } else if guess.deviation < 1.02 * envelope::LEAST {
            Validation::Short
        } else if guess.deviation > 0.98 * envelope::MOST {
            Validation::Long
        } else if cycles < CYCLES || peak.abs() <= pedestal(guess) + 1 {
            Validation::FewCycles
        } else if line.mixed {
            Validation::TwoParticles
        } else {
            Validation::Valid
        };
        let engine = view.error();
        let sigma = (line.variance + engine * engine).root() / n as f32;
        let amplitude = if iq { line.level } else { 2.0 * line.level };
        // A point holds the noise of 64 of N bins.
        let noise = line.noise * (n / POINTS) as f32;
        let power = if iq { amplitude * amplitude } else { 0.5 * amplitude * amplitude };
        let reasons = match burst.validation {
            Validation::Valid => Reasons::NONE,
            Validation::TwoParticles => Reasons::NONE.with(Verdict::Unresolved),
            Validation::FewCycles => Reasons::NONE.with(Verdict::NearEdge),
            Validation::Short | Validation::Long => Reasons::NONE.with(Verdict::Moving),
            Validation::Weak => Reasons::NONE.with(Verdict::Weak),
            Validation::Clipped => Reasons::NONE.with(Verdict::Clipped),
        };
        let reasons = reasons.with_sigma(sigma);
        burst.tone = Tone {
            frequency,
            sigma,
            snr: power / noise.max(f32::MIN_POSITIVE),
            amplitude,
            ..Tone::with_reasons(reasons, self.terms.rate_hz)
        };
        true
    }
}

/// Codes centred on 0 that reach as far as the whole range of the given codes: the offset may lie anywhere in this range.
fn around(codes: Codes) -> Codes {
    let (low, high) = codes.rails();
    let most = (i32::from(high) - i32::from(low)).min(i16::MAX.into()) as i16;
    Codes::between(most.saturating_neg(), most).unwrap_or(Codes::signed::<16>())
}

/// Writes the samples less their offset times a weight of 0 to 1, which is a straight line over `STEP` samples.
fn weigh<const STEP: usize>(
    from: Data,
    to: &mut [[i16; 2]],
    n: usize,
    offset: Complex<f32>,
    codes: Codes,
    weight: impl Fn(f32) -> f32,
) {
    let (low, high) = codes.rails();
    let [i0, q0] = [offset.re, offset.im].map(|x| libm::rintf(x) as i32);
    let q15 = |index: usize| libm::rintf(32768.0 * weight(index as f32 / n as f32)) as i32;
    let (mut first, mut next, mut index) = (0, q15(0), 0);
    let mut factor = || {
        let part = index % STEP;
        index += 1;
        if part == 0 {
            (first, next) = (next, q15(index - 1 + STEP));
        }
        first + (((next - first) * part as i32) >> STEP.trailing_zeros())
    };
    let weighed = |part: i16, offset: i32, factor: i32| {
        // At most 16 bits times 15. No clamp, which would panic if the rails were in the wrong order.
        let product = i32::from(part).wrapping_sub(offset).wrapping_mul(factor);
        (product.saturating_add(1 << 14) >> 15).max(low.into()).min(high.into()) as i16
    };
    for (&[a, b], place) in from.pairs.iter().zip(to) {
        *place = if from.iq {
            let factor = factor();
            [weighed(a, i0, factor), weighed(b, q0, factor)]
        } else {
            [weighed(a, i0, factor()), weighed(b, i0, factor())]
        };
    }
}

/// The highest bin that the pedestal of a burst reaches: the light of the particle without its fringes, four standard deviations of the
/// spectrum of the weighted envelope.
fn pedestal(envelope: &Envelope) -> i32 {
    let bins = 4.0 * core::f32::consts::SQRT_2 / (2.0 * PI * envelope.deviation);
    (bins as i32).max(3)
}

/// The strongest bin of a weighted record outside of the pedestal, its power over the mean of the others, and the least such ratio that is
/// not noise.
fn strongest(view: &View, band: Band, envelope: &Envelope) -> Option<Strongest> {
    let Layout { n, iq, .. } = *view.layout;
    let low = pedestal(envelope);
    let half = n as i32 / 2;
    let ranges = if iq { [(low, half - 1), (-half, -low)] } else { [(low, half - 3), (1, 0)] };
    // An I/Q band may count negative frequencies from 0 down, or on from N/2.
    let turns: &[i32] = if iq { &[0, n as i32] } else { &[0] };
    let (mut best, mut total, mut bins): (Option<(i32, u64)>, u64, u32) = (None, 0, 0);
    for (first, last) in ranges {
        for turn in turns {
            let (first, last) = (first.max(band.low - turn), last.min(band.high - turn));
            if first > last {
                continue;
            }
            let wrapped = if first < 0 { n as i32 } else { 0 };
            let scan = view.search(Band::new(first + wrapped, last + wrapped));
            if best.is_none_or(|(_, power)| scan.power > power) {
                best = Some((scan.bin - wrapped, scan.power));
            }
            total = total.saturating_add(scan.total);
            bins = bins.saturating_add((last - first) as u32 + 1);
        }
    }
    let (peak, power) = best?;
    // The line's own skirt, three deviations of its spectrum to each side.
    let reach = (3.0 / (2.0 * PI * envelope.deviation) * core::f32::consts::SQRT_2) as i32 + 2;
    let mut skirt = 0u64;
    let mut count = 0u32;
    for k in peak - reach..=peak + reach {
        let inside = ranges.iter().any(|&(first, last)| (first..=last).contains(&k))
            && turns.iter().any(|turn| (band.low..=band.high).contains(&(k + turn)));
        if inside {
            skirt = skirt.saturating_add(view.power(k));
            count += 1;
        }
    }
    // A scan may sum points for bins: the remainder is at least zero.
    let left = total.saturating_sub(skirt) as f32;
    let others = bins.saturating_sub(count) as f32;
    if power == 0 || others < 8.0 {
        return None;
    }
    let ratio = power as f32 * others / left.max(1.0);
    // Of the bins, the share of the record that the weight has is independent: the root of pi times its deviation.
    let dof = (others * (1.772 * envelope.deviation).min(1.0)).max(4.0);
    let limit = over_mean((bins as f32 / FALSE_ALARM).log_e(), dof);
    Some((peak, ratio, limit))
}

/// A tone with a Gaussian envelope in the points.
struct EnvelopedTone {
    /// The offset beyond the points' centre, bins.
    offset: f32,
    /// The variance of the offset, squared bins.
    variance: f32,
    /// The amplitude at the envelope's top.
    level: f32,
    /// The noise power of a point in the bins that pass whole.
    noise: f32,
    /// Whether the points hold more than this tone and noise.
    mixed: bool,
}

impl EnvelopedTone {
    /// The frequency at which the sum of the points, weighted with the envelope, is largest: maximum likelihood in white noise.
    fn fitted(points: &[Complex<f32>; POINTS], envelope: &Envelope) -> Option<Self> {
        const STEPS: u32 = 8;
        /// The move after which the place is as exact as a float.
        const ENOUGH: f32 = 1e-6;
        let zero = Complex::new(0.0f32, 0.0);
        let level: [f32; POINTS] =
            core::array::from_fn(|index| if used(index) { envelope.at(place(index)) } else { 0.0 });
        let time = |index: usize| place(index) - envelope.middle;
        let mut moments = [0.0f32; 3];
        for (index, e) in level.iter().enumerate() {
            let t = time(index);
            for (moment, power) in moments.iter_mut().zip([1.0, t, t * t]) {
                *moment += e * e * power;
            }
        }
        let [power, first, second] = moments;
        let descent =
            Descent { start: 0.0, steps: STEPS, longest: 0.7, limits: [-8.0, 8.0], further: false };
        // The column is the envelope turned by the frequency; its derivative is that times j 2 pi t.
        let end = descent.to_the_end(|offset| {
            let (mut sum, mut timed) = (zero, zero);
            for (index, (&z, &e)) in points.iter().zip(&level).enumerate() {
                if e > 0.0 {
                    let t = time(index);
                    let term = z * e * f32::unit(-offset * t);
                    sum += term;
                    timed += term * t;
                }
            }
            let turned = Complex::new(0.0, -TAU * first);
            let along = Complex::new(timed.im, -timed.re) * TAU;
            let step = Products::complex(power, turned, TAU * TAU * second, sum, along).step();
            (step.forward(1.0), ENOUGH, sum)
        });
        let (offset, sum) = (end.at, end.last);
        let size = sum.norm_sqr().root();
        if !(size > 0.0 && power > 0.0) {
            return None;
        }
        let amplitude = size / power;
        // The points in phase with the tone, and across.
        let turned: [Complex<f32>; POINTS] = core::array::from_fn(|index| {
            let z = points.get(index).copied().unwrap_or(zero);
            z * f32::unit(-offset * time(index)) * (sum.conj() / size)
        });
        let across = Across::of(&turned, &level, envelope);
        let judged = Judged::from_across(&across, &turned, envelope);
        // Noise passes by the squares of the weights, the tone by the weights and its own level, which may be another than the weights.
        let spread = |weights: &mut dyn Iterator<Item = f32>| {
            let (mut weight, mut first, mut second) = (0.0, 0.0, 0.0);
            for (index, e) in weights.enumerate() {
                let t = time(index);
                weight += e;
                first += e * t;
                second += e * t * t;
            }
            second - first * first / weight
        };
        let noise = judged.noise;
        let passed = spread(&mut level.iter().map(|e| e * e));
        let slope = 2.0 * PI * spread(&mut level.iter().zip(&turned).map(|(e, z)| e * z.re));
        let variance = 0.5 * noise * passed / (slope * slope);
        let line = Self { offset, variance, level: amplitude, noise, mixed: judged.mixed };
        (variance.is_finite() && offset.is_finite()).then_some(line)
    }
}

/// The part of the points in quadrature to the tone, beyond its frequency and phase. The tone's own level, whatever its envelope, is in phase
/// with it and does not move its frequency.
struct Across {
    /// The parts across the tone.
    left: [f32; POINTS],
    /// The square of what lies along the envelope times polynomials of second to fourth order: the bend of the phase.
    bend: f32,
}

impl Across {
    fn of(turned: &[Complex<f32>; POINTS], level: &[f32; POINTS], envelope: &Envelope) -> Self {
        let mut left: [f32; POINTS] = core::array::from_fn(|index| {
            if used(index) { turned.get(index).map_or(0.0, |z| z.im) } else { 0.0 }
        });
        let mut bend = 0.0;
        let mut basis = [[0.0f32; POINTS]; ORDERS];
        for order in 0..ORDERS {
            let (known, rest) = basis.split_at_mut_checked(order).unwrap_or_default();
            let Some(new) = rest.first_mut() else {
                continue;
            };
            for (index, (value, &e)) in new.iter_mut().zip(level).enumerate() {
                let u = (place(index) - envelope.middle) / envelope.deviation;
                *value = (0..order).fold(e, |value, _| value * u);
            }
            // Twice, so that rounding leaves nothing of the other functions.
            for other in known.iter().chain(known.iter()) {
                let along: f32 = other.iter().zip(&*new).map(|(a, b)| a * b).sum();
                new.iter_mut().zip(other).for_each(|(value, other)| *value -= along * other);
            }
            let length = new.iter().map(|x| x * x).sum::<f32>().root();
            if length > 0.0 {
                new.iter_mut().for_each(|value| *value /= length);
            }
            let along: f32 = left.iter().zip(&*new).map(|(a, b)| a * b).sum();
            left.iter_mut().zip(&*new).for_each(|(z, &b)| *z -= along * b);
            if order > 1 {
                bend += along * along;
            }
        }
        Self { left, bend }
    }
}

/// The noise of the points, and whether they hold another signal.
struct Judged {
    noise: f32,
    mixed: bool,
}

impl Judged {
    fn from_across(across: &Across, turned: &[Complex<f32>; POINTS], envelope: &Envelope) -> Self {
        let near =
            |index: usize| (place(index) - envelope.middle).abs() < NEAR * envelope.deviation;
        let (mut inside, mut count) = (0.0f32, 0.0f32);
        let mut beside = heapless::Vec::<f32, POINTS>::new();
        let mut product = 0.0f32;
        let mut before: Option<f32> = None;
        for (index, &z) in across.left.iter().enumerate() {
            // Leakage at the record's ends is largest under the taper.
            if !used(index) || taper(place(index)) < 0.9 {
                before = None;
            } else if near(index) {
                inside += 2.0 * z * z;
                count += 1.0;
                if let Some(before) = before {
                    product += 2.0 * before * z;
                }
                before = Some(z);
            } else {
                // There is room.
                let _ = beside.push(2.0 * z * z);
                before = None;
            }
        }
        /// The median of a squared normal number over its mean.
        const MEDIAN: f32 = 0.4549;
        // Five real parameters were fitted, all in the bins that pass whole.
        let free = (count - ORDERS as f32 / PASSED).max(1.0);
        let own = inside / free;
        let others = beside.len() as f32;
        let told = others >= 8.0;
        let quiet = if told { median(&beside) / MEDIAN } else { own };
        // The logarithm of a ratio is nearly normal; points are correlated and count for fewer. A median of squares has 2.7 times the variance
        // of their mean.
        let spread = (4.0 / (1.6 * free) + 2.7 * 4.0 / (1.6 * others.max(1.0))).root();
        let loud = told && own > quiet * libm::expf(POWER_LIMIT * spread);
        let correlation = product / inside.max(f32::MIN_POSITIVE) - CORRELATION;
        let alike = correlation.abs() * count.root() > CORRELATION_LIMIT;
        let noise = if told { (inside + quiet * others) / (free + others) } else { own };
        // A residual that is louder than the noise beside it is the noise of this burst.
        let noise = (if loud { own.max(noise) } else { noise }) / PASSED;
        let bent = across.bend > 0.5 * noise * BEND_LIMIT;
        let mixed = loud || alike || bent || has_two_humps(turned, noise, near);
        Self { noise, mixed }
    }
}

/// Whether the level rises again after a fall, in the points near the envelope's middle.
fn has_two_humps(
    turned: &[Complex<f32>; POINTS],
    noise: f32,
    near: impl Fn(usize) -> bool,
) -> bool {
    let mut levels = [0.0f32; POINTS];
    let mut count = 0;
    for (index, three) in (1..).zip(turned.windows(3)) {
        if near(index)
            && used(index)
            && taper(place(index)) >= 0.9
            && let Some(level) = levels.get_mut(count)
        {
            *level = three.iter().map(|z| z.re).sum::<f32>() * const { 1.0 / 3.0 };
            count += 1;
        }
    }
    let levels = levels.get(..count).unwrap_or_default();
    let highest = levels.iter().copied().fold(0.0, f32::max);
    let most = (DIP * (noise * const { 1.0 / 6.0 }).root()).max(RIPPLE * highest);
    // From either end up to the highest level, none is far below one before it.
    let below = |levels: &mut dyn Iterator<Item = &f32>| {
        let mut before = 0.0f32;
        for &level in levels {
            // Noise beside the burst is no hump.
            if level.max(0.0) < before - most {
                return true;
            }
            before = before.max(level);
            if level >= highest {
                break;
            }
        }
        false
    };
    below(&mut levels.iter()) || below(&mut levels.iter().rev())
}
