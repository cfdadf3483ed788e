//! What kind of signal a recording holds, and which way of measuring it holds on the recording itself.

use super::series::Series;
use super::trial::{Ground, Of, Shot, Way};
use crate::length::LENGTHS;
use picket_dsp::Usable;
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
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// Lines at multiples of a fundamental, Hz.
    Series(f64),
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
            Nature::Series(hz) => format!("series: harmonics of {hz:.2} Hz"),
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
    /// What else is to be said of it.
    pub note: Option<String>,
}

impl Finding {
    /// A kind without a way.
    pub fn bare(nature: Nature) -> Self {
        Self { nature, held: None, note: None }
    }
}

/// A way that held.
#[derive(Clone, Debug)]
struct Held {
    score: f64,
    way: Way,
    share: f64,
    shots: Vec<Shot>,
    /// The median answer and the median sigma, and whether the answers move.
    hz: f64,
    sigma_hz: f64,
    moves: bool,
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

/// Of a bin this much may an answer's sigma be, and a block's answer off the line that it is for.
const WIDEST: f64 = 0.5;
const OFF_LINE: f64 = 0.25;
/// A band of fewer bins shows no noise beside a line.
const NARROWEST: f64 = 6.0;
/// Two lengths disagree if their answers differ by so many sigmas of a block.
const DISAGREE: f64 = 8.0;
/// A way that answers for so much needs no shorter block beside it.
const PLENTY: f64 = 0.95;

/// Ways that are tried on samples.
struct Trials<'a> {
    ground: Ground<'a>,
    known: &'a Known,
    /// Something stands out of many frames.
    stands: bool,
    held: Vec<Held>,
}

impl Trials<'_> {
    /// Tries a way; true if it holds for nearly all blocks.
    fn offer(&mut self, way: Way, bonus: f64) -> bool {
        let (ground, known) = (&self.ground, self.known);
        let bin_hz = ground.rate_hz / way.n as f64;
        if way.band_hz.is_some_and(|(low, high)| high - low < NARROWEST * bin_hz) {
            return false;
        }
        let Some((share, shots)) = ground.tried(&way) else { return false };
        let of_hum = |shot: &&Shot| known.hum_hz.is_some_and(|hum| of_hum(shot.hz, hum, bin_hz));
        let hums = shots.iter().filter(of_hum).count();
        if share < LEAST || (known.lines > 0 || self.stands) && 20 * hums > shots.len() {
            return false;
        }
        let moves = moves(&shots, bin_hz);
        let (hz, sigma_hz) =
            (median(shots.iter().map(|it| it.hz)), median(shots.iter().map(|it| it.sigma_hz)));
        // It has to answer the line that it is for, and as a measurement.
        let off = known.line.filter(|_| !moves).map_or(0.0, |(line, sigma)| {
            ((hz - line).abs() - 5.0 * sigma.hypot(sigma_hz)).max(0.0)
        });
        if off > OFF_LINE * bin_hz || sigma_hz > WIDEST * bin_hz {
            return false;
        }
        let share = share.min(1.0);
        // The most that is learnt of the frequency in a time: a longer block is as good as a few more answers.
        let cycles = (sigma_hz / ground.rate_hz).max(1e-9);
        let score = share - 0.02 * (way.n as f64 * cycles * cycles).log2()
            + 0.01 * (way.n as f64).log2()
            + bonus;
        self.held.push(Held { score, way, share, shots, hz, sigma_hz, moves });
        share > PLENTY && !moves
    }

    /// Whole records of their own.
    fn records(&mut self, row: usize) {
        let n = LENGTHS.into_iter().rev().find(|&n| n <= row);
        for n in n.into_iter().flat_map(|n| [n, n / 2]).filter(|&n| n >= 64) {
            for skip in [0, (row - n) / 2] {
                let of = Of::Blocks;
                self.offer(Way { n, hop: row, skip, band_hz: None, of }, 0.0);
                if let Some(&band) = self.known.bands.first() {
                    self.offer(Way { n, hop: row, skip, band_hz: Some(band), of }, -0.03);
                }
            }
        }
    }

    /// Segments that come again; false where none do.
    fn chirps(&mut self, comb_hz: f64) -> bool {
        let ground = self.ground;
        let samples = ground.rate_hz / comb_hz;
        let mut hops = vec![samples.round() as usize];
        // The lines beside the strongest one are weak, and tell their distance to a hundredth. What comes again tells it to a sample.
        let again = again(&ground, samples);
        hops.extend(again.filter(|again| !hops.contains(again)));
        let mut chirps = false;
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
                    self.offer(way, -0.1);
                    // Beside what the ramp itself leaves at the lowest frequencies.
                    if let Some(&band) = self.known.bands.first() {
                        self.offer(Way { band_hz: Some(band), ..way }, -0.13);
                    }
                }
            }
            chirps = true;
        }
        chirps
    }

    /// Blocks of every length, end to end, and tones that are followed.
    fn blocks(&mut self, bands: &[Option<(f64, f64)>]) {
        let samples = self.ground.samples.len();
        for &band_hz in bands {
            let narrow = if band_hz.is_some() { -0.03 } else { 0.0 };
            let mut enough = 0;
            // From the longest on: where it answers for all blocks, shorter ones say less.
            for n in LENGTHS.into_iter().rev().filter(|n| n * 4 <= samples) {
                let way = Way { n, hop: n, skip: 0, band_hz, of: Of::Blocks };
                enough += u32::from(self.offer(way, narrow));
                if enough == 0 {
                    self.offer(Way { of: Of::Track, ..way }, narrow - 0.06);
                }
                if enough > 1 {
                    break;
                }
            }
        }
    }

    /// The whole recording in one block or a few, of a tone too slow or too short for more.
    fn whole(&mut self) {
        let samples = self.ground.samples.len();
        for n in LENGTHS.into_iter().rev().filter(|&n| n <= samples && n * 4 > samples) {
            let way = Way { n, hop: n, skip: 0, band_hz: None, of: Of::Blocks };
            let shots: Vec<Shot> =
                self.ground.shots(&way).into_iter().filter(|it| it.usable == Usable::Yes).collect();
            let blocks = samples / n;
            let (hz, sigma_hz) =
                (median(shots.iter().map(|it| it.hz)), median(shots.iter().map(|it| it.sigma_hz)));
            let alike =
                shots.iter().all(|it| (it.hz - hz).abs() <= 5.0 * it.sigma_hz.hypot(sigma_hz));
            // A block that begins elsewhere answers alike.
            let later = Way { skip: (samples - n).min(n / 4), ..way };
            let elsewhere = self.ground.shots(&later);
            let borne = elsewhere.iter().filter(|it| it.holds());
            let alike = alike
                && borne.clone().all(|it| (it.hz - hz).abs() <= 5.0 * it.sigma_hz.hypot(sigma_hz));
            let bin_hz = self.ground.rate_hz / n as f64;
            let line = self.known.line.is_none_or(|(line, sigma)| {
                (hz - line).abs() <= 5.0 * sigma.hypot(sigma_hz) + OFF_LINE * bin_hz
            });
            if 2 * shots.len() > blocks && alike && line && sigma_hz < 0.1 * bin_hz {
                let share = shots.len() as f64 / blocks as f64;
                self.held.push(Held {
                    score: share,
                    way,
                    share,
                    shots,
                    hz,
                    sigma_hz,
                    moves: false,
                });
                return;
            }
        }
    }

    /// Two lengths whose answers differ by more than their sigmas, of a tone that both say stays where it is.
    fn disagreement(&self, best: &Held) -> Option<String> {
        let other = self.held.iter().find(|other| {
            let same = other.way.hop == best.way.hop * other.way.n / best.way.n
                && !other.moves
                && !best.moves;
            let sigma = best
                .sigma_hz
                .hypot(other.sigma_hz)
                .max(1e-4 * self.ground.rate_hz / best.way.n as f64);
            same && other.share > 0.5
                && best.share > 0.5
                && (other.hz - best.hz).abs() > DISAGREE * sigma
        })?;
        Some(format!(
            "blocks of {} samples answer {:.6} Hz, of {} {:.6} Hz, apart by more than their sigmas: samples may be lost",
            best.way.n, best.hz, other.way.n, other.hz
        ))
    }

    fn best(&self) -> Option<&Held> {
        self.held.iter().max_by(|a, b| a.score.total_cmp(&b.score))
    }
}

/// The way for a series of harmonics: of the lengths that tell them apart the one that is good most often, else that answers at all.
fn harmonics(ground: &Ground, series: &Series) -> Option<(Way, f64, Vec<Shot>)> {
    let lengths = LENGTHS.into_iter().rev();
    let lengths = lengths
        .filter(|&n| n <= ground.samples.len() && series.hz * n as f64 > 4.0 * ground.rate_hz);
    let tried = lengths.take(3).filter_map(|n| {
        let band_hz = Some((0.72 * series.hz, 1.35 * series.hz));
        let way =
            Way { n, hop: n, skip: 0, band_hz, of: Of::Harmonics(series.highest.clamp(4, 32)) };
        let shots = ground.shots(&way);
        let near: Vec<Shot> =
            shots.iter().copied().filter(|it| (it.hz / series.hz - 1.0).abs() < 0.015).collect();
        let good: Vec<Shot> = near.iter().copied().filter(Shot::holds).collect();
        let blocks = (ground.samples.len() / n).max(1) as f64;
        // Most of what it answers is the fundamental, and none of the good ones is another.
        let others = shots.iter().filter(|it| it.holds()).count() - good.len();
        let holds =
            10 * near.len() > 6 * shots.len() && 20 * others <= good.len() && !near.is_empty();
        let share = good.len() as f64 / blocks;
        holds.then(|| (way, share, if good.is_empty() { near } else { good }))
    });
    tried.max_by(|a, b| {
        (a.1 + 0.1 * (a.0.n as f64).log2()).total_cmp(&(b.1 + 0.1 * (b.0.n as f64).log2()))
    })
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
        () if comes && way.of == Of::Blocks => Nature::Bursts,
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
    let Held { way, share, shots, .. } = trials.best()?.clone();
    let [begin_s, end_s] = [start, end].map(|at| at as f64 / ground.rate_hz);
    let shots =
        shots.into_iter().map(|shot| Shot { middle: shot.middle + start as f64, ..shot }).collect();
    let note = format!(
        "it stands from {begin_s:.2} to {end_s:.2} s, where this was tried; elsewhere blocks are weak"
    );
    Some(Finding { nature: Nature::Moving, held: Some((way, share, shots)), note: Some(note) })
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
