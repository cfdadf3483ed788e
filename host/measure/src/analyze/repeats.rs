//! Where the ramps of a continuous recording begin: by a channel with a trigger's pulses, or by the recording itself.
//!
//! A tone within a ramp follows from the samples before by linear prediction; where the next ramp begins it does not. The power of what
//! prediction leaves repeats with the ramps, a comb of lines at multiples of their rate, whatever the targets do. Its autocorrelation
//! tells the period, and folded by it, where in a period the ramps begin and end.

use super::cut::Cut;
use crate::cli;
use crate::recording::{self, Recording};
use picket_transform::Transform;
use picket_transform::num_complex::Complex;
use std::path::Path;

/// The most samples that are looked at.
const LOOKED_AT: usize = 1 << 20;

/// Samples that a sample is predicted from: two each for four real tones.
const ORDER: usize = 8;

/// Fewer periods are no repetition.
const FEWEST: f64 = 6.0;

/// The autocorrelation of noise exceeds so many deviations once in a recording of a million lags in a hundred.
const CLEAR: f64 = 5.5;

/// In a pause there is at most this part of the power that is beside it.
const QUIET: f64 = 3.0;

/// What repeats half as well repeats with another period as well.
const AS_WELL: f64 = 0.5;

/// How ramps repeat, in samples.
#[derive(Clone, Copy, Debug)]
pub struct Repeats {
    /// From the beginning of the recording, less what is skipped, to the first ramp's.
    pub first: u64,
    /// From one ramp to the next.
    pub period: f64,
}

impl Repeats {
    /// By the pulses of a channel, each of which begins a ramp, or several of one chirp.
    ///
    /// # Errors
    /// There is no such channel, or its pulses are not even in time.
    pub fn by_trigger(file: &Path, cut: &Cut, channel: usize) -> Result<Self, String> {
        let read = recording::Options { channel: Some((channel, None)), iq: false, ..cut.read };
        let samples = samples(file, cut, read)?;
        let levels: Vec<f64> = samples.iter().map(|sample| sample.re).collect();
        let (low, high) = levels
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
        let (middle, band) = (f64::midpoint(low, high), 0.2 * (high - low));
        // An edge is where the level passes the middle, after it was well below.
        let (mut edges, mut armed) = (Vec::new(), false);
        for (at, pair) in levels.windows(2).enumerate() {
            armed |= pair[0] < middle - band;
            if armed && pair[1] > middle {
                edges.push((at + 1) as f64);
                armed = false;
            }
        }
        let wrong = |what: &str| {
            format!("channel {channel} is no trigger: {what}; --period-s and --skip tell the ramps")
        };
        if (edges.len() as f64) < FEWEST {
            return Err(wrong(&format!("it has {} pulses", edges.len())));
        }
        // The line through the edges' times.
        let count = edges.len() as f64;
        let (half, mean) = (0.5 * (count - 1.0), edges.iter().sum::<f64>() / count);
        let places = || edges.iter().enumerate().map(|(k, edge)| (k as f64 - half, edge - mean));
        let period = places().map(|(k, edge)| k * edge).sum::<f64>()
            / places().map(|(k, _)| k * k).sum::<f64>();
        // A pulse is seen at the next sample.
        let off = places().map(|(k, edge)| (edge - k * period).abs()).fold(0.0, f64::max);
        if off > 1.5 {
            return Err(wrong(&format!("its pulses are up to {off:.0} samples off even times")));
        }
        let first = (mean - half * period).max(0.0);
        Ok(Self::of(first, period, levels.len()))
    }

    /// By the recording itself, of ramps of so many samples with a pause or without.
    ///
    /// # Errors
    /// Nothing repeats clearly, or the ramps' beginning is not clear.
    pub fn by_comb(file: &Path, cut: &Cut, ramp: f64) -> Result<Self, String> {
        let samples = samples(file, cut, cut.read)?;
        let surprise = surprise(&samples);
        let unclear = |what: &str| {
            format!(
                "{what}: tell --period-s and --skip, or --trigger and the channel of its pulses"
            )
        };
        let period = period(&surprise, ramp)
            .ok_or_else(|| unclear("no ramps that repeat are clear in the recording"))?;
        let first = begin(&samples, &surprise, period, ramp)
            .ok_or_else(|| unclear("where in its period a ramp begins is not clear"))?;
        Ok(Self::of(first, period, samples.len()))
    }

    /// A whole number of samples where the period cannot be told from one.
    fn of(first: f64, period: f64, looked_at: usize) -> Self {
        let count = looked_at as f64 / period;
        let whole = (period - period.round()).abs() * count < 1.0;
        Self { first: first.round() as u64, period: if whole { period.round() } else { period } }
    }

    /// Says what was found, in a line.
    pub fn tell(&self, file: &Path, rate_hz: f64) {
        let Self { first, period, .. } = self;
        let digits = if period.fract() == 0.0 { 0 } else { 3 };
        eprintln!(
            "{}: ramps each {:.6} us, {period:.digits$} samples, the first at sample {first} (--period-s and --skip say otherwise)",
            cli::name(file),
            1e6 * period / rate_hz
        );
    }
}

fn samples(file: &Path, cut: &Cut, read: recording::Options) -> Result<Vec<Complex<f64>>, String> {
    let recording = Recording::open(file, read).map_err(super::text)?;
    if recording.row().is_some() {
        return Err(
            "the ramps of an array are already cut: state the time from chirp to chirp by --period-s".into()
        );
    }
    let skip = usize::try_from(cut.skip).map_err(super::text)?;
    let samples = recording.samples().skip(skip).take(LOOKED_AT);
    let values: Result<Vec<_>, _> = samples.map(|it| it.map(|sample| sample.value)).collect();
    values.map_err(super::text)
}

/// The power that linear prediction leaves of each sample, at most a hundred times its median: the surprise of one jump is no greater.
fn surprise(samples: &[Complex<f64>]) -> Vec<f64> {
    let mean = samples.iter().sum::<Complex<f64>>() / samples.len().max(1) as f64;
    let samples: Vec<_> = samples.iter().map(|sample| sample - mean).collect();
    let lag = |k: usize| -> Complex<f64> {
        samples.iter().zip(samples.get(k..).unwrap_or_default()).map(|(a, b)| b * a.conj()).sum()
    };
    let lags: Vec<_> = (0..=ORDER).map(lag).collect();
    // Levinson's recursion, with the noise that keeps it regular.
    let mut left = lags[0].re * (1.0 + 1e-9);
    let mut weights: Vec<Complex<f64>> = Vec::new();
    for k in 1..=ORDER {
        let sum: Complex<f64> = weights.iter().enumerate().map(|(i, w)| w * lags[k - 1 - i]).sum();
        let turn = (lags[k] - sum) / left.max(1e-300);
        let before = weights.clone();
        for (weight, other) in weights.iter_mut().zip(before.iter().rev()) {
            *weight -= turn * other.conj();
        }
        weights.push(turn);
        left *= 1.0 - turn.norm_sqr();
    }
    let left = samples.windows(ORDER + 1).map(|window| {
        let predicted: Complex<f64> =
            weights.iter().zip(window.iter().rev().skip(1)).map(|(w, x)| w * x).sum();
        (window[ORDER] - predicted).norm_sqr()
    });
    let mut powers = vec![0.0; ORDER.min(samples.len())];
    powers.extend(left);
    let mut sorted = powers.clone();
    let middle = sorted.len() / 2;
    let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    powers.iter().map(|power| power.min(100.0 * median)).collect()
}

/// The time between repetitions of at least so many samples, by the autocorrelation.
fn period(surprise: &[f64], ramp: f64) -> Option<f64> {
    let count = surprise.len();
    let mean = surprise.iter().sum::<f64>() / count.max(1) as f64;
    // Twice as long, so that nothing comes round.
    let length = (2 * count).next_power_of_two();
    let mut points: Vec<_> = surprise.iter().map(|x| Complex::new(x - mean, 0.0)).collect();
    points.resize(length, Complex::default());
    f64::forward(length).process(&mut points);
    points.iter_mut().for_each(|point| *point = Complex::new(point.norm_sqr(), 0.0));
    f64::inverse(length).process(&mut points);
    // The share of the power at a lag, of as many pairs as there are.
    let whole = points.first()?.re / count as f64;
    let share = |lag: usize| points[lag].re / (count - lag) as f64 / whole;
    let (low, high) = ((0.99 * ramp) as usize, (count as f64 / FEWEST) as usize);
    let lags = low.max(2)..=high.min(count.saturating_sub(2));
    let best = lags.clone().map(share).fold(0.0, f64::max);
    // A pair of independent samples has a product of variance 1.
    if lags.is_empty() || best < CLEAR / ((count - high) as f64).sqrt() || best < 0.02 {
        return None;
    }
    let summit = |at: f64, reach: f64| {
        let from = (at - reach).floor().max(1.0) as usize;
        let to = ((at + reach).ceil() as usize).min(count - 2);
        let top = (from..=to).max_by(|a, b| share(*a).total_cmp(&share(*b)))?;
        let [a, b, c] = [top - 1, top, top + 1].map(share);
        let bend = a - 2.0 * b + c;
        let off = if bend < 0.0 { (0.5 * (a - c) / bend).clamp(-0.5, 0.5) } else { 0.0 };
        Some(top as f64 + off)
    };
    // Between two samples it is in both.
    let pair = |lag: usize| share(lag) + share(lag + 1);
    let most = lags.clone().map(pair).fold(0.0, f64::max);
    let first = lags.into_iter().find(|&lag| pair(lag) >= AS_WELL * most)?;
    let mut period = summit(first as f64, 3.0)?;
    // Over twice as many periods it is known twice as well.
    let mut times = 2.0;
    while times * period < 0.75 * count as f64 {
        let at = summit(times * period, 2.0)?;
        period = at / times;
        times *= 2.0;
    }
    Some(period)
}

/// The first sample of the first ramp: what is folded by the period is high where one begins, and where one ends.
fn begin(samples: &[Complex<f64>], surprise: &[f64], period: f64, ramp: f64) -> Option<f64> {
    let places = period.floor() as usize;
    let (mut sums, mut counts) = (vec![0.0; places], vec![0.0f64; places]);
    for (at, power) in surprise.iter().enumerate().skip(ORDER) {
        let place = ((at as f64 % period) as usize).min(places - 1);
        (sums[place], counts[place]) = (sums[place] + power, counts[place] + 1.0);
    }
    let means: Vec<f64> = sums.iter().zip(&counts).map(|(sum, n)| sum / n.max(1.0)).collect();
    let mut sorted = means.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[places / 2];
    let spread = median - sorted[places * 16 / 100];
    let top = sorted[places - 1];
    // As far beyond the noise as it is clear, and a third of the highest.
    let least = (median + CLEAR * spread).max(median + (top - median) / 3.0);
    if top <= median + 2.0 * CLEAR * spread {
        return None;
    }
    // Places that are high, with those as near as a prediction reaches as one.
    let mut high: Vec<(usize, usize)> = Vec::new();
    for place in (0..places).filter(|&place| means[place] > least) {
        match high.last_mut() {
            Some((_, last)) if place - *last <= ORDER => *last = place,
            _ => high.push((place, place)),
        }
    }
    if high.len() > 1 && high[0].0 + places - high[high.len() - 1].1 <= ORDER {
        let (from, _) = high.pop()?;
        high[0].0 = from;
    }
    // Each begins where the noise ends.
    let floor = median + CLEAR * spread;
    for (from, _) in &mut high {
        for _ in 0..ORDER {
            let before = (*from + places - 1) % places;
            if means[before] <= floor {
                break;
            }
            *from = before;
        }
    }
    let pause = period - ramp;
    let near = |a: f64, b: f64| {
        let apart = (a - b).rem_euclid(period);
        apart.min(period - apart) <= 0.5 * ORDER as f64
    };
    match high[..] {
        [(from, _)] if pause.abs() <= ORDER as f64 => Some(from as f64),
        // One end of a pause may go on as a ramp does. In the pause itself nothing beats.
        [(at, _)] => {
            let at = at as f64;
            let [after, before] = [at, at - pause].map(|from| swing(samples, from, pause, period));
            match () {
                () if after * QUIET < before => Some((at + pause) % period),
                () if before * QUIET < after => Some(at),
                () => None,
            }
        }
        [(a, _), (b, _)] => {
            let (a, b) = (a as f64, b as f64);
            let ends = |from: f64, to: f64| near(from + ramp, to);
            match (ends(a, b), ends(b, a)) {
                (true, false) => Some(a),
                (false, true) => Some(b),
                _ => None,
            }
        }
        _ => None,
    }
}

/// The power about their mean of the samples that lie in this part of a period.
fn swing(samples: &[Complex<f64>], from: f64, length: f64, period: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    let mut start = from.rem_euclid(period);
    while let Some(part) = samples.get(start as usize..(start + length) as usize) {
        let mean = part.iter().sum::<Complex<f64>>() / part.len().max(1) as f64;
        sum += part.iter().map(|sample| (sample - mean).norm_sqr()).sum::<f64>();
        (count, start) = (count + part.len() as f64, start + period);
    }
    sum / f64::max(count, 1.0)
}
