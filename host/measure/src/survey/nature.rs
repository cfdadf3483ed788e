//! What kind of signal a recording holds, and which way of measuring it holds on the recording itself.

use super::trial::{Ground, Of, Shot, Way};
use crate::length::LENGTHS;
use picket_transform::Transform;
use picket_transform::num_complex::Complex;
use std::f64::consts::TAU;

/// Samples that ways are tried on.
pub(super) const TRIED: usize = 1 << 18;
/// A way that answers for less of the blocks than this is not proposed.
const LEAST: f64 = 0.3;
/// Frames of the spectrogram, and how far above its median a frame's peak stands where there is a signal, in dB: a peak of 500 bins of
/// noise stands 10 dB above it.
const FRAMES: usize = 400;
const ABOVE_DB: f64 = 14.0;

/// The kinds of signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nature {
    /// One tone that stays where it is.
    Steady,
    /// One tone whose frequency changes.
    Moving,
    /// More than one tone.
    Several,
    /// A tone that comes and goes.
    Bursts,
    /// Segments that come again and again, of this many samples.
    Chirps(usize),
    /// Records of their own, of so many samples.
    Records(usize),
    /// Every sample is the same.
    Silence,
    /// No tone of the kinds above stands out.
    Unknown,
    /// Nothing stands out.
    Noise,
}

impl Nature {
    /// The words for it.
    pub fn text(self) -> String {
        match self {
            Nature::Steady => "steady: one tone that stays where it is".into(),
            Nature::Moving => "moving: one tone whose frequency changes".into(),
            Nature::Several => {
                "several: tones beside each other; --most 2 measures two of them".into()
            }
            Nature::Bursts => "bursts: a tone that comes and goes".into(),
            Nature::Chirps(period) => format!("chirps: it comes again every {period} samples"),
            Nature::Records(row) => format!("records of {row} samples with a tone in each"),
            Nature::Silence => "silence: every sample is the same".into(),
            Nature::Unknown => {
                "unknown: something stands out, but no way of measuring it held in a trial".into()
            }
            Nature::Noise => "noise: nothing stands out".into(),
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
    /// Bands around lines.
    pub bands: Vec<(f64, f64)>,
    /// Lines that are not the mains'.
    pub lines: usize,
    /// The distance of lines that are evenly apart.
    pub comb_hz: Option<f64>,
    /// Samples of a record, where the recording has records of their own.
    pub row: Option<usize>,
}

/// Tries the ways that may suit, and gives the one that holds best.
pub fn finding(ground: Ground, known: &Known) -> Finding {
    let samples = &ground.samples[..ground.samples.len().min(TRIED)];
    let ground = Ground { samples, ..ground };
    let ridges = ridges(&ground, known.hum_hz);
    let seen = ridges.iter().filter(|ridge| ridge.above_db > ABOVE_DB).count();
    let share = seen as f64 / ridges.len().max(1) as f64;
    let mut best: Option<(f64, Way, f64, Vec<Shot>)> = None;
    let mut offer = |way: Way, bonus: f64| {
        let Some((share, shots)) = ground.tried(&way) else { return };
        let bin_hz = ground.rate_hz / way.n as f64;
        let of_hum = |shot: &&Shot| known.hum_hz.is_some_and(|hum| of_hum(shot.hz, hum, bin_hz));
        let hums = shots.iter().filter(of_hum).count();
        if share < LEAST || (known.lines > 0 || seen > ridges.len() / 4) && 20 * hums > shots.len()
        {
            return;
        }
        // A longer block is as good as a few more answers.
        let score = share.min(1.0) + 0.04 * (way.n as f64).log2() + bonus;
        if best.as_ref().is_none_or(|(other, ..)| score > *other) {
            best = Some((score, way, share.min(1.0), shots));
        }
    };
    let mut chirps = known.row.is_some();
    if let Some(row) = known.row {
        let n = LENGTHS.into_iter().rev().find(|&n| n <= row);
        for n in n.into_iter().flat_map(|n| [n, n / 2]).filter(|&n| n >= 64) {
            for skip in [0, (row - n) / 2] {
                let of = Of::Blocks;
                offer(Way { n, hop: row, skip, band_hz: None, of }, 0.0);
                if let Some(&band) = known.bands.first() {
                    offer(Way { n, hop: row, skip, band_hz: Some(band), of }, -0.03);
                }
            }
        }
    }
    // The mains' harmonics are evenly apart, too.
    if let Some(comb_hz) = known.comb_hz.filter(|_| known.hum_hz.is_none() && !chirps) {
        let samples = ground.rate_hz / comb_hz;
        let mut hops = vec![samples.round() as usize];
        // The lines beside the strongest one are weak, and tell their distance to a hundredth. What comes again tells it to a sample.
        let again = again(&ground, samples);
        hops.extend(again.filter(|again| !hops.contains(again)));
        for hop in hops {
            // Many periods long the segments stay where they are, and within a period, too: a tone whose frequency swings is none.
            if hop < 80 || ground.samples.len() <= 6 * hop || swings(&ground, hop) {
                continue;
            }
            let n = LENGTHS.into_iter().rev().find(|&n| n <= hop * 9 / 10);
            for n in n.into_iter().flat_map(|n| [n, n / 2]).filter(|&n| n >= 64) {
                for step in 0..16 {
                    let skip = step * hop / 16;
                    let way = Way { n, hop, skip, band_hz: None, of: Of::Blocks };
                    offer(way, -0.1);
                    // Beside what the ramp itself leaves at the lowest frequencies.
                    if let Some(&band) = known.bands.first() {
                        offer(Way { band_hz: Some(band), ..way }, -0.13);
                    }
                }
            }
            chirps = true;
        }
    }
    let mut bands = vec![None];
    bands.extend(known.bands.iter().copied().map(Some));
    bands.extend(ridge_band(&ridges, &ground).map(Some));
    for band_hz in bands.into_iter().filter(|_| known.row.is_none()) {
        for n in LENGTHS.into_iter().filter(|n| n * 4 <= ground.samples.len()) {
            let way = Way { n, hop: n, skip: 0, band_hz, of: Of::Blocks };
            let narrow = if band_hz.is_some() { -0.03 } else { 0.0 };
            offer(way, narrow);
            offer(Way { of: Of::Track, ..way }, narrow - 0.06);
        }
    }
    let held = best.map(|(_, way, share, shots)| (way, share, shots));
    // What comes and goes is measured where it is.
    let comes = (0.02..0.6).contains(&share) && !chirps;
    if let Some(bursts) = comes.then(|| bursts(&ground)).flatten() {
        return Finding { nature: Nature::Bursts, held: Some(bursts) };
    }
    let nature = match &held {
        None if seen == 0 && known.lines == 0 => Nature::Noise,
        None => Nature::Unknown,
        Some(_) if known.row.is_some() => Nature::Records(known.row.unwrap_or(0)),
        Some((way, ..)) if way.hop > way.n => Nature::Chirps(way.hop),
        Some((way, _, shots)) => match () {
            () if comes && way.of == Of::Blocks => Nature::Bursts,
            () if moves(shots, ground.rate_hz / way.n as f64) => Nature::Moving,
            () if known.lines > 1 => Nature::Several,
            () => Nature::Steady,
        },
    };
    Finding { nature, held }
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

/// The lag, within a twentieth of this one, at which the samples are most like themselves: a segment that comes again is, but for its noise.
fn again(ground: &Ground, near: f64) -> Option<usize> {
    /// Samples that are compared.
    const COMPARED: usize = 1 << 16;
    let lags = (0.95 * near) as usize..=(1.05 * near) as usize;
    let alike = |lag: usize| {
        let pairs = ground.samples.iter().zip(ground.samples.get(lag..)?).take(COMPARED);
        let (sum, power) = pairs.fold((Complex::new(0.0, 0.0), 0.0), |(sum, power), (a, b)| {
            (sum + a.conj() * b, power + a.norm_sqr() + b.norm_sqr())
        });
        // Of a target that moves the phase goes on, which I/Q samples show.
        Some((lag, if ground.iq { sum.norm() } else { sum.re } / power))
    };
    lags.filter_map(alike).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(lag, _)| lag)
}

/// Whether the tone changes within a period: blocks of a quarter of it have other frequencies than each other.
fn swings(ground: &Ground, period: usize) -> bool {
    let n = LENGTHS.into_iter().rev().find(|&n| 4 * n <= period);
    n.is_some_and(|n| {
        let way = Way { n, hop: n, skip: 0, band_hz: None, of: Of::Blocks };
        let shots: Vec<Shot> = ground.shots(&way).into_iter().filter(Shot::holds).collect();
        moves(&shots, ground.rate_hz / n as f64)
    })
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

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Whether a frequency is the mains' or one of its harmonics, or so near to one that a block of such bins may have taken it for the tone.
fn of_hum(hz: f64, hum: f64, bin_hz: f64) -> bool {
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
