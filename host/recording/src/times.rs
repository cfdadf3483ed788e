//! The column of times beside samples: its unit, the rate by least squares over the whole column, where it pauses or becomes another
//! one, and how evenly the samples were taken.
//!
//! Times `t_i = a + b i + e_i` have two kinds of errors. Each one's own, as by printing too few digits (variance `w^2`); and those that
//! stay, as of a loop that waits a little longer now and then (`r^2` a step). Second differences over L steps have the variance
//! `6 w^2 + 2 L r^2`, whatever the rate, and two L tell both. The step b of M rows then has the variance `12 w^2 / M^3 + 1.2 r^2 / M`.

use super::unit::{self, Meaning, Named};
use std::ops::Range;

/// Times that are kept: what is behind them goes on as they do.
pub(super) const KEPT: usize = 1 << 22;
/// Rows of a part that has a rate of its own, at least; and parts at most.
const LEAST: usize = 64;
const PARTS: usize = 16;
/// A rate counts as changed if it differs by this share, and by this many sigmas.
const OTHER: f64 = 2e-3;
const SIGMAS: f64 = 6.0;
/// No pause is filled with more samples than this.
const LONGEST: u64 = 1 << 20;

/// How the samples lie in time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Timing {
    /// Samples per second, and one standard deviation of it; `None` where only the user knows.
    pub clock: Option<Clock>,
    /// The rows that are read.
    pub rows: Range<u64>,
    /// Rows before which samples are missing, and how many.
    pub gaps: Vec<(u64, u64)>,
    /// What is to be said of it.
    pub note: String,
}

/// A rate, and how evenly it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Samples per second.
    pub rate_hz: f64,
    /// One standard deviation of it, over the whole recording.
    pub sigma_hz: f64,
    /// The samples' own errors of time, root mean square, s; 0 where they were taken evenly.
    pub own_s: f64,
    /// The error that a step adds to those before it, root mean square, s.
    pub walk_s: f64,
}

impl Clock {
    /// One standard deviation of the rate as a share of it, in a block of this many samples.
    pub fn share(&self, samples: usize) -> f64 {
        let block = slope_sigma(self.own_s, self.walk_s, samples as f64) * self.rate_hz;
        (self.sigma_hz / self.rate_hz).hypot(block)
    }

    /// Whether the samples were taken evenly.
    pub fn is_even(&self) -> bool {
        self.own_s == 0.0 && self.walk_s == 0.0
    }
}

/// One standard deviation of the step, from this many rows.
fn slope_sigma(own: f64, walk: f64, rows: f64) -> f64 {
    (12.0 * own * own / rows.powi(3) + 1.2 * walk * walk / rows).sqrt()
}

/// What is wrong with a column as times.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Untimely {
    /// It is none.
    Other,
    /// It is named so, and falls; or there is no such part.
    Said(String),
}

/// A stretch of rows without a pause, and its line.
#[derive(Clone, Debug)]
struct Piece {
    rows: Range<usize>,
    step: f64,
    sigma: f64,
}

/// The timing of rows with these times, NaN where a row has none. `part` is the part that is wanted, from 1, where the rate changes.
pub(super) fn timing(
    times: &[f64],
    named: &Named,
    part: Option<usize>,
) -> Result<Timing, Untimely> {
    let whole = |note: String, clock| Timing { clock, rows: 0..u64::MAX, gaps: Vec::new(), note };
    let mut points: Vec<(usize, f64)> =
        times.iter().copied().enumerate().filter(|(_, time)| time.is_finite()).collect();
    let quantum = quantum(&points);
    unwrap(&mut points, quantum);
    let (&(first, begin), &(last, end)) =
        points.first().zip(points.last()).ok_or(Untimely::Other)?;
    let mean = (end - begin) / (last - first).max(1) as f64;
    let mut steps: Vec<f64> = points
        .windows(2)
        .map(|pair| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0) as f64)
        .collect();
    if points.len() < 4 {
        return Err(Untimely::Other);
    }
    let falls = steps.iter().filter(|step| **step < 0.0).count();
    if falls > 2 && falls * 100 > steps.len() {
        let told = format!("falls in {falls} of its {} steps", steps.len());
        return Err(if named.timely() { Untimely::Said(told) } else { Untimely::Other });
    }
    steps.sort_by(f64::total_cmp);
    let at = |share: f64| steps[((steps.len() - 1) as f64 * share) as usize];
    let usual = if at(0.5) > 0.0 { at(0.5) } else { mean };
    if !(usual > 0.0 && usual.is_finite()) {
        let told = "does not rise".to_owned();
        return Err(if named.timely() { Untimely::Said(told) } else { Untimely::Other });
    }
    let pause = 1.5 * at(0.99).max(usual);
    // Rows that are numbered have no time.
    let first_column = named.column == "1" || [0.0, 1.0].contains(&begin);
    let numbered = at(0.0) == 1.0 && at(1.0) == 1.0 && begin.fract() == 0.0 && first_column;
    let pieces = pieces(&points, pause, -2.0 * usual);
    let parts = parts(&points, pieces);
    let chosen = match part {
        Some(part) => part.checked_sub(1).filter(|&part| part < parts.len()).ok_or_else(|| {
            Untimely::Said(format!(
                "has {} parts of one rate each: choose one of them",
                parts.len()
            ))
        })?,
        None => {
            let length =
                |at: &usize| parts[*at].iter().map(|piece| piece.rows.len()).sum::<usize>();
            (0..parts.len()).rev().max_by_key(length).unwrap_or(0)
        }
    };
    let own = &parts[chosen];
    let step = pooled(&points, own);
    let meaning = unit::meaning(named, step, begin, quantum, numbered);
    let seconds = match meaning {
        Meaning::Seconds { of_one, .. } => of_one,
        Meaning::Step { .. } => 1.0,
        Meaning::Unknown { note } => return Ok(whole(note, None)),
    };
    let (even, white, walk) = errors(&points, own, step, quantum, usual);
    let rows = own.iter().map(|piece| piece.rows.len()).sum::<usize>() as f64;
    let sigma = slope_sigma(white, walk, rows) / step;
    let (rate_hz, note) = match meaning {
        Meaning::Step { seconds, note } => (rounded(1.0 / seconds, 0.0), note),
        Meaning::Seconds { note, .. } => (rounded(1.0 / (step * seconds), sigma), note),
        Meaning::Unknown { .. } => return Err(Untimely::Other),
    };
    let mut clock = Clock { rate_hz, sigma_hz: sigma * rate_hz, own_s: 0.0, walk_s: 0.0 };
    if sigma < 1e-9 || note.is_empty() {
        clock.sigma_hz = 0.0;
    }
    let mut said = vec![note];
    if !even {
        (clock.own_s, clock.walk_s) = (white * seconds, walk * seconds);
        let jitter = (white * white + walk * walk).sqrt() / step;
        said.push(format!("the samples are not even in time, {:.2} % of a step", 100.0 * jitter));
    }
    let range = |pieces: &[Piece]| {
        let ends = pieces.first().zip(pieces.last());
        ends.map_or(0..0, |(first, last)| {
            points[first.rows.start].0 as u64..points[last.rows.end - 1].0 as u64 + 1
        })
    };
    let mut gaps = Vec::new();
    for pair in own.windows(2) {
        let (before, after) = (pair[0].rows.end - 1, pair[1].rows.start);
        let lost = (points[after].1 - points[before].1) / step
            - (points[after].0 - points[before].0) as f64;
        // Behind a step back nobody knows how many.
        let lost = if lost.is_finite() && lost > 0.0 { lost.round() } else { 0.0 };
        gaps.push((points[after].0 as u64, (lost as u64).clamp(1, LONGEST)));
    }
    if !gaps.is_empty() {
        let missing: u64 = gaps.iter().map(|gap| gap.1).sum();
        let pauses = if gaps.len() == 1 { "pause" } else { "pauses" };
        said.push(format!("{} {pauses}, {missing} samples are missing", gaps.len()));
    }
    let mut rows = range(own);
    if parts.len() > 1 {
        let rate = |pieces: &Vec<Piece>| 1.0 / (pooled(&points, pieces) * seconds);
        let rates: Vec<String> =
            parts.iter().map(|part| format!("{:.6}", Short(rate(part)))).collect();
        said.push(format!(
            "its rate changes, {} Hz: part {} is read, rows {} to {}; --part chooses",
            rates.join(", "),
            chosen + 1,
            rows.start + 1,
            rows.end
        ));
    } else {
        rows.start = 0;
    }
    if chosen + 1 == parts.len() {
        rows.end = u64::MAX;
    }
    said.retain(|note| !note.is_empty());
    Ok(Timing { clock: Some(clock), rows, gaps, note: said.join("; ") })
}

/// Whether numbers rise evenly, except for two steps.
pub(super) fn is_even(times: &[f64]) -> bool {
    let Some((&first, &last)) = times.first().zip(times.last()) else { return false };
    let step = (last - first) / (times.len() as f64 - 1.0);
    let off = |(at, &time): (usize, &f64)| (time - first - at as f64 * step).abs();
    let rises = times.windows(2).all(|pair| pair[1] >= pair[0]);
    times.len() >= 4
        && step > 0.0
        && rises
        && times.iter().enumerate().map(off).fold(0.0, f64::max) <= 2.0 * step
}

/// A number with six digits, without zeros behind.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let six: f64 = format!("{:.5e}", self.0).parse().unwrap_or(self.0);
        write!(f, "{six}")
    }
}

/// Counters of 32 bits begin again at 0.
fn unwrap(points: &mut [(usize, f64)], quantum: f64) {
    const TURN: f64 = 4_294_967_296.0;
    let mut turns = 0.0;
    let mut last = f64::NAN;
    for (_, time) in points.iter_mut().filter(|_| quantum >= 1.0) {
        let told = *time;
        if told - last < -0.9 * TURN {
            turns += TURN;
        }
        last = told;
        *time += turns;
    }
}

/// The step that all times are multiples of, as they are written; 0 where there is none.
fn quantum(points: &[(usize, f64)]) -> f64 {
    let Some(&(_, first)) = points.first() else { return 0.0 };
    let some = &points[..points.len().min(4096)];
    let largest = some.iter().map(|(_, time)| time.abs()).fold(1e-300, f64::max);
    for digits in -3..=12i32 {
        let tens = 10f64.powi(digits);
        let scaled = |time: f64| (time - first) * tens;
        let near = (1e-15 * largest * tens * 8.0).max(1e-9);
        if near > 0.2 {
            return 0.0;
        }
        if some.iter().all(|&(_, time)| (scaled(time) - scaled(time).round()).abs() <= near) {
            let steps = some.windows(2).map(|pair| (scaled(pair[1].1) - scaled(pair[0].1)).abs());
            let common = steps.fold(0u64, |sum, step| divisor(sum, step.round() as u64));
            return common as f64 / tens;
        }
    }
    0.0
}

fn divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { divisor(b, a % b) }
}

/// Stretches between pauses and steps back.
fn pieces(points: &[(usize, f64)], pause: f64, back: f64) -> Vec<Range<usize>> {
    let (mut pieces, mut from) = (Vec::new(), 0);
    for at in 1..points.len() {
        let step = (points[at].1 - points[at - 1].1) / (points[at].0 - points[at - 1].0) as f64;
        if step > pause || step < back {
            pieces.push(from..at);
            from = at;
        }
    }
    pieces.push(from..points.len());
    pieces
}

/// The parts of one rate each.
fn parts(points: &[(usize, f64)], ranges: Vec<Range<usize>>) -> Vec<Vec<Piece>> {
    let mut pieces = Vec::new();
    for range in ranges {
        split(points, range, PARTS, &mut pieces);
    }
    let mut parts: Vec<Vec<Piece>> = Vec::new();
    for piece in pieces {
        let same = parts.last().is_some_and(|part| {
            let long =
                part.iter().filter(|it| it.rows.len() >= LEAST).max_by_key(|it| it.rows.len());
            match long.filter(|_| piece.rows.len() >= LEAST) {
                Some(long) => !differs(long, &piece),
                None => true,
            }
        });
        match parts.last_mut().filter(|_| same) {
            Some(part) => part.push(piece),
            None => parts.push(vec![piece]),
        }
    }
    parts
}

fn differs(a: &Piece, b: &Piece) -> bool {
    let off = (a.step - b.step).abs();
    off > OTHER * a.step && off > SIGMAS * a.sigma.hypot(b.sigma)
}

/// Splits a stretch where its rate changes.
fn split(points: &[(usize, f64)], rows: Range<usize>, left: usize, into: &mut Vec<Piece>) {
    let piece = piece(points, rows.clone());
    if left > 1
        && rows.len() >= 2 * LEAST
        && let Some(at) = bend(points, &rows)
    {
        let [a, b] = [rows.start..at, at..rows.end].map(|rows| self::piece(points, rows));
        if differs(&a, &b) {
            split(points, rows.start..at, left / 2, into);
            split(points, at..rows.end, left / 2, into);
            return;
        }
    }
    into.push(piece);
}

/// The line of a stretch.
fn piece(points: &[(usize, f64)], rows: Range<usize>) -> Piece {
    let own = &points[rows.clone()];
    let (_, step) = line(own);
    let (white, walk) = scatter(own);
    Piece { sigma: slope_sigma(white, walk, own.len() as f64), rows, step }
}

/// The height in the middle and the step of the line through points.
fn line(points: &[(usize, f64)]) -> ([f64; 2], f64) {
    let Some(&(from, begin)) = points.first() else { return ([0.0; 2], f64::NAN) };
    let n = points.len() as f64;
    let own = || points.iter().map(|&(at, time)| ((at - from) as f64, time - begin));
    let (i, t) = own().fold((0.0, 0.0), |sum, it| (sum.0 + it.0, sum.1 + it.1));
    let (i, t) = (i / n, t / n);
    let (above, below) = own().fold((0.0, 0.0), |(above, below), it| {
        (above + (it.0 - i) * (it.1 - t), below + (it.0 - i) * (it.0 - i))
    });
    ([i + from as f64, t + begin], above / below)
}

/// The step of several stretches together, each with a beginning of its own.
fn pooled(points: &[(usize, f64)], pieces: &[Piece]) -> f64 {
    let (mut above, mut below) = (0.0, 0.0);
    for piece in pieces.iter().filter(|piece| piece.rows.len() > 1) {
        let weight = (piece.rows.len() as f64).powi(3);
        above += weight * piece.step;
        below += weight;
    }
    if below > 0.0 { above / below } else { line(points).1 }
}

/// Where two lines fit best in place of one, each of a share of the rows.
fn bend(points: &[(usize, f64)], rows: &Range<usize>) -> Option<usize> {
    let own = &points[rows.clone()];
    let (middle, step) = line(own);
    // Sums of what is left of one line are small numbers.
    let left = |&(at, time): &(usize, f64)| {
        (at as f64 - middle[0], time - middle[1] - step * (at as f64 - middle[0]))
    };
    let sums = own.iter().map(left).scan([0.0; 5], |sum, (i, e)| {
        for (sum, more) in sum.iter_mut().zip([1.0, i, e, i * i, i * e]) {
            *sum += more;
        }
        Some(*sum)
    });
    let sums: Vec<[f64; 5]> = sums.collect();
    let whole = sums.last()?;
    let gain = |sum: [f64; 5]| {
        let [n, i, e, ii, ie] = sum;
        let (below, along) = (ii - i * i / n, ie - i * e / n);
        e * e / n + if below > 0.0 { along * along / below } else { 0.0 }
    };
    let ends = LEAST..own.len() - LEAST;
    let each = ends.step_by((own.len() / 20_000).max(1)).map(|at| {
        let before = sums[at - 1];
        let after = std::array::from_fn(|k| whole[k] - before[k]);
        (at, gain(before) + gain(after))
    });
    let best = each.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(rows.start + best.0)
}

/// The root mean squares of the times' own errors and of those that stay, by second differences.
fn scatter(points: &[(usize, f64)]) -> (f64, f64) {
    let rows = points.len();
    let square = |lag: usize| {
        let mut squares: Vec<f64> = (2 * lag..rows)
            .map(|k| (points[k].1 - 2.0 * points[k - lag].1 + points[k - 2 * lag].1).powi(2))
            .collect();
        squares.sort_by(f64::total_cmp);
        // Where the rate changes some are larger.
        squares.truncate((squares.len() * 98).div_ceil(100));
        squares.iter().sum::<f64>() / squares.len().max(1) as f64
    };
    let lag = 64.min(rows / 8).max(1);
    let (near, far) = (square(1), square(lag));
    let apart = (rows as f64 / (2 * lag) as f64).max(1.0);
    if lag > 1 && far > near * (1.0 + 3.0 * (2.0 / apart).sqrt()) {
        let walk = (far - near) / (2 * lag - 2) as f64;
        (((near - 2.0 * walk).max(0.0) / 6.0).sqrt(), walk.sqrt())
    } else {
        ((near / 6.0).sqrt(), 0.0)
    }
}

/// Whether the times are even except for their last digit, and their two kinds of errors.
fn errors(
    points: &[(usize, f64)],
    pieces: &[Piece],
    step: f64,
    quantum: f64,
    usual: f64,
) -> (bool, f64, f64) {
    let (mut squares, mut count, mut range, mut most) = (0.0, 0.0, 0f64, 0f64);
    for piece in pieces {
        let own = &points[piece.rows.clone()];
        let (middle, _) = line(own);
        let left = own.iter().map(|&(at, time)| time - middle[1] - step * (at as f64 - middle[0]));
        let (low, high) = left.fold((f64::MAX, f64::MIN), |(low, high), e| {
            squares += e * e;
            count += 1.0;
            (low.min(e), high.max(e))
        });
        range = range.max(high - low);
        let largest = points[piece.rows.end - 1].1.abs().max(own[0].1.abs());
        most = most.max(largest);
    }
    // Times that come in batches have their batch's.
    let still = points.windows(2).filter(|pair| pair[0].1 == pair[1].1).count();
    let batch = points.windows(2).map(|pair| pair[1].1 - pair[0].1).fold(0.0, f64::max);
    let digit = match 2 * still > points.len() && batch < 4096.0 * step {
        true => batch,
        false => quantum,
    };
    if range <= 1.3 * digit || range <= 1e-6 * usual + 4e-15 * most {
        return (true, (squares / f64::max(count, 1.0)).sqrt(), 0.0);
    }
    let long = pieces.iter().max_by_key(|piece| piece.rows.len());
    let (white, walk) = long.map_or((0.0, 0.0), |piece| scatter(&points[piece.rows.clone()]));
    (false, white, walk)
}

/// A number with as few digits as lie within its uncertainty, relative; of it or of its reciprocal, as a period is.
fn rounded(value: f64, uncertainty: f64) -> f64 {
    let tolerance = uncertainty.max(1e-9);
    let near = |value: f64, digits: usize| format!("{value:.digits$e}").parse().unwrap_or(value);
    let fits = |short: f64| ((short - value) / value).abs() <= tolerance;
    (0..12)
        .flat_map(|digits| [near(value, digits), 1.0 / near(1.0 / value, digits)])
        .find(|&short| fits(short))
        .unwrap_or(value)
}
