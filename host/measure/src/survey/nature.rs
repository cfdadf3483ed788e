//! What kind of signal a recording holds, and which way of measuring it is consistent on the recording itself.

use super::series::Series;
use super::trial::{Ground, Of, Shot, Way};
use super::ways::{Held, Trials, harmonics};
use crate::length::LENGTHS;
use picket_transform::Transform;
use picket_transform::num_complex::Complex;
use std::f64::consts::TAU;

/// Samples that ways are tried on.
pub(super) const TRIED: usize = 1 << 18;
/// Frames of the spectrogram, and how far above its median a frame's peak stands where there is a signal, in dB: a peak of 500 bins of
/// noise stands 10 dB above it.
const FRAMES: usize = 400;
const ABOVE_DB: f64 = 14.0;

/// The kinds of signals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Nature {
    /// One tone of constant frequency.
    Steady,
    /// One tone whose frequency changes.
    Moving,
    /// More than one tone.
    Several,
    /// A tone that comes and goes.
    Bursts,
    /// Segments that come again and again, of this many samples.
    Chirps(usize),
    /// Separate records, with this many samples.
    Records(usize),
    /// Lines at multiples of a fundamental, Hz.
    Series(f64),
    /// Every sample is the same.
    Silence,
    /// A signal of none of the kinds above.
    Unknown,
    /// Noise alone.
    Noise,
}

impl Nature {
    /// The words for it.
    pub fn text(self) -> String {
        match self {
            Nature::Steady => "steady: one tone of constant frequency".into(),
            Nature::Moving => "moving: one tone whose frequency changes".into(),
            Nature::Several => "several: more than one tone; --most 2 measures two of them".into(),
            Nature::Bursts => "bursts: a tone that comes and goes".into(),
            Nature::Chirps(period) => format!("chirps: the signal repeats every {period} samples"),
            Nature::Records(row) => format!("records of {row} samples with a tone in each"),
            Nature::Series(hz) => format!("series: harmonics of {hz:.2} Hz"),
            Nature::Silence => "silence: every sample is the same".into(),
            Nature::Unknown => {
                "unknown: there is a signal, but no command measured it consistently".into()
            }
            Nature::Noise => "noise: no signal stands out".into(),
        }
    }
}

/// What the trial ended with.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The kind of signal.
    pub nature: Nature,
    /// The way that held, the share of the blocks that it answers for, and its answers.
    pub held: Option<(Way, f64, Vec<Shot>)>,
    /// A further remark on it.
    pub note: Option<String>,
}

impl Finding {
    /// A kind without a way.
    pub fn bare(nature: Nature) -> Self {
        Self { nature, held: None, note: None }
    }
}

/// A frame's strongest bin.
#[derive(Clone, Copy, Debug)]
struct Ridge {
    hz: f64,
    above_db: f64,
}

/// What is known before: the mains, bands to try, and whether a line stands out.
#[derive(Clone, Debug)]
pub struct Known {
    /// The mains' frequency.
    pub hum_hz: Option<f64>,
    /// The mains' frequency, where the only line is there: what was recorded, or beside something that moves.
    pub alone_hz: Option<f64>,
    /// Bands around lines.
    pub bands: Vec<(f64, f64)>,
    /// Lines that are not the mains'.
    pub lines: usize,
    /// The distance of lines that are evenly apart.
    pub comb_hz: Option<f64>,
    /// Samples of a record, where the recording has records of their own.
    pub row: Option<usize>,
    /// The strongest line that is not the mains', where a record of it is good: its frequency and sigma.
    pub line: Option<(f64, f64)>,
    /// The lines' common fundamental.
    pub series: Option<Series>,
}

/// Tries the ways that may suit, and gives the one that holds best.
pub fn finding(ground: Ground, known: &Known) -> Finding {
    let samples = &ground.samples[..ground.samples.len().min(TRIED)];
    let ground = Ground { samples, ..ground };
    let ridges = ridges(&ground, known.hum_hz.or(known.alone_hz));
    let seen = ridges.iter().filter(|ridge| ridge.above_db > ABOVE_DB).count();
    let share = seen as f64 / ridges.len().max(1) as f64;
    let stands = seen > ridges.len() / 4;
    if let Some(mains) = known.alone_hz.filter(|_| stands) {
        let known = Known {
            hum_hz: Some(mains),
            alone_hz: None,
            bands: vec![],
            lines: 0,
            line: None,
            ..known.clone()
        };
        return finding(ground, &known);
    }
    if let Some(series) = known.series
        && let Some(held) = harmonics(&ground, &series)
    {
        return Finding { nature: Nature::Series(series.hz), held: Some(held), note: None };
    }
    let mut trials = Trials { ground, known, stands, held: Vec::new() };
    let mut chirps = known.row.is_some();
    if let Some(row) = known.row {
        trials.records(row);
    } else {
        // The mains' harmonics are evenly apart, too.
        if let Some(comb_hz) = known.comb_hz.filter(|_| known.hum_hz.is_none()) {
            chirps = trials.chirps(comb_hz);
        }
        let mut bands = vec![None];
        bands.extend(known.bands.iter().copied().map(Some));
        let ridge = ridge_band(&ridges, &ground);
        bands.extend(ridge.map(Some));
        bands.extend(
            ridge.zip(known.hum_hz).and_then(|(band, hum)| beside_mains(band, hum)).map(Some),
        );
        trials.blocks(&bands);
        if trials.held.is_empty() {
            trials.whole();
        }
    }
    // What comes and goes is measured where it is.
    let comes = (0.02..0.6).contains(&share) && !chirps;
    if let Some(bursts) = comes.then(|| bursts(&ground)).flatten() {
        return Finding { nature: Nature::Bursts, held: Some(bursts), note: None };
    }
    if trials.held.is_empty()
        && comes
        && let Some(found) = stretch(&ground, known, &ridges)
    {
        return found;
    }
    let Some(best) = trials.best() else {
        let noise = seen == 0 && known.lines == 0;
        return Finding::bare(if noise { Nature::Noise } else { Nature::Unknown });
    };
    if let Some(note) = trials.disagreement(best) {
        return Finding { note: Some(note), ..Finding::bare(Nature::Unknown) };
    }
    let Held { way, share, shots, moves, .. } = best.clone();
    let nature = match () {
        () if known.row.is_some() => Nature::Records(known.row.unwrap_or(0)),
        () if way.hop > way.n => Nature::Chirps(way.hop),
        // One block of a whole recording does not show what comes and goes.
        () if comes && way.of == Of::Blocks && 4 * way.n <= ground.samples.len() => Nature::Bursts,
        () if moves => Nature::Moving,
        () if known.lines > 1 => Nature::Several,
        () => Nature::Steady,
    };
    Finding { nature, held: Some((way, share, shots)), note: None }
}

/// The part of a band that is free of the mains' harmonics: between the two around its middle.
fn beside_mains((low, high): (f64, f64), hum: f64) -> Option<(f64, f64)> {
    const OFF_HZ: f64 = 7.0;
    let below = (f64::midpoint(low, high).abs() / hum).floor() * hum;
    let free = (low.max(below + OFF_HZ), high.min(below + hum - OFF_HZ));
    (low >= 0.0 && free.0 < free.1 && free != (low, high)).then_some(free)
}

/// Frames that may be empty within a stretch.
const HOLES: usize = 4;

/// The ways on the longest stretch in which something stands.
fn stretch(ground: &Ground, known: &Known, ridges: &[Ridge]) -> Option<Finding> {
    let (mut best, mut from, mut last) = (0..0, None::<usize>, 0);
    for (at, _) in ridges.iter().enumerate().filter(|(_, ridge)| ridge.above_db > ABOVE_DB) {
        let begin = *from.get_or_insert(at);
        if at > last + HOLES + 1 && at != begin {
            from = Some(at);
        }
        last = at;
        let own = from.unwrap_or(at)..at + 1;
        if own.len() > best.len() {
            best = own;
        }
    }
    let frame = ground.samples.len() as f64 / ridges.len().max(1) as f64;
    let [start, end] = [best.start, best.end].map(|at| (at as f64 * frame) as usize);
    if best.len() < 8 || best.len() * 10 > ridges.len() * 9 {
        return None;
    }
    let samples = ground.samples.get(start..end)?;
    let ground = Ground { samples, ..*ground };
    let mut trials = Trials { ground, known, stands: true, held: Vec::new() };
    let band = ridge_band(&ridges[best], &ground);
    trials.blocks(&[None, band]);
    let Held { way, share, shots, moves, .. } = trials.best()?.clone();
    let nature = if moves { Nature::Moving } else { Nature::Steady };
    let [begin_s, end_s] = [start, end].map(|at| at as f64 / ground.rate_hz);
    let shots =
        shots.into_iter().map(|shot| Shot { middle: shot.middle + start as f64, ..shot }).collect();
    let note = format!(
        "it stands from {begin_s:.2} to {end_s:.2} s, where this was tried; elsewhere blocks are weak"
    );
    Some(Finding { nature, held: Some((way, share, shots)), note: Some(note) })
}

/// Bursts, by the length of record that has the most valid ones: of like ones the longest.
fn bursts(ground: &Ground) -> Option<(Way, f64, Vec<Shot>)> {
    let lengths = LENGTHS.into_iter().filter(|n| (128..=2048).contains(n));
    let ways = lengths.map(|n| Way { n, hop: n, skip: 0, band_hz: None, of: Of::Bursts });
    let tried = ways.filter_map(|way| {
        let (share, shots) = ground.tried_bursts(&way)?;
        Some((way, share, shots))
    });
    tried.max_by(|(a, _, some), (b, _, others)| (some.len(), a.n).cmp(&(others.len(), b.n)))
}

/// Whether answers differ by more than their sigmas.
pub(super) fn moves(shots: &[Shot], bin_hz: f64) -> bool {
    let sigma = median(shots.iter().map(|shot| shot.sigma_hz));
    spread(shots) > (6.0 * sigma).max(0.02 * bin_hz)
}

/// The distance between the lowest and the highest tenth of the answers.
fn spread(shots: &[Shot]) -> f64 {
    let mut hz: Vec<f64> = shots.iter().map(|shot| shot.hz).collect();
    hz.sort_by(f64::total_cmp);
    let at = |share: usize| hz.get(hz.len() * share / 10).or(hz.last()).copied().unwrap_or(0.0);
    at(9) - at(1)
}

pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Whether a frequency is the mains' or one of its harmonics, or so near to one that a block of such bins may have taken it for the tone.
pub(super) fn of_hum(hz: f64, hum: f64, bin_hz: f64) -> bool {
    let order = (hz.abs() / hum).round();
    (1.0..=12.0).contains(&order)
        && (hz.abs() - order * hum).abs() < (0.004 * order * hum).max(bin_hz)
}

/// The strongest bin of each frame that is not the mains'.
fn ridges(ground: &Ground, hum_hz: Option<f64>) -> Vec<Ridge> {
    let count = ground.samples.len();
    // Frames of so many samples have as many bins as there are frames, about.
    let n = (1usize << ((count as f64).sqrt().log2().ceil() as u32)).clamp(64, 4096).min(count);
    let hop = ((count - n) / FRAMES).max(n / 2).max(1);
    let transform = f64::forward(n);
    let window = |k: usize| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / n as f64).cos();
    let bins = if ground.iq { n } else { n / 2 };
    let bin_hz = ground.rate_hz / n as f64;
    ground
        .samples
        .windows(n)
        .step_by(hop)
        .filter_map(|frame| {
            let mean = frame.iter().sum::<Complex<f64>>() / n as f64;
            let mut x: Vec<Complex<f64>> =
                frame.iter().enumerate().map(|(k, x)| (x - mean) * window(k)).collect();
            transform.process(&mut x);
            let hz = |k: usize| if k > n / 2 { k as f64 - n as f64 } else { k as f64 } * bin_hz;
            let near_hum = |k: usize| {
                hum_hz.is_some_and(|hum| {
                    let order = (hz(k).abs() / hum).round();
                    (hz(k).abs() - order * hum).abs() < 2.0 * bin_hz && hum > 6.0 * bin_hz
                })
            };
            let edge = |k: usize| k < 2 || (ground.iq && k > n - 2);
            let powers: Vec<(usize, f64)> = (0..bins)
                .filter(|&k| !edge(k) && !near_hum(k))
                .map(|k| (k, x[k].norm_sqr()))
                .collect();
            let median = median(powers.iter().map(|power| power.1));
            let &(peak, power) = powers.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
            let above_db = 10.0 * ((power + 1e-30) / (median + 1e-30)).log10();
            Some(Ridge { hz: hz(peak), above_db })
        })
        .collect()
}

/// The band in which the ridge lies nearly always.
fn ridge_band(ridges: &[Ridge], ground: &Ground) -> Option<(f64, f64)> {
    let mut hz: Vec<f64> =
        ridges.iter().filter(|ridge| ridge.above_db > ABOVE_DB).map(|ridge| ridge.hz).collect();
    if hz.len() < 4 || hz.len() < ridges.len() / 20 {
        return None;
    }
    hz.sort_by(f64::total_cmp);
    let at = |share: f64| hz[((hz.len() - 1) as f64 * share) as usize];
    let (low, high) = (at(0.04), at(0.96));
    let margin = (0.3 * (high - low)).max(0.1 * low.abs().max(high.abs()));
    let half = ground.rate_hz / 2.0;
    let least = if ground.iq { -half } else { 0.0 };
    Some(((low - margin).max(least), (high + margin).min(half)))
}
