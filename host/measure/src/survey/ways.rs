//! Trials of the ways that may suit a recording, and which were consistent.

use super::nature::{Known, median, moves, of_hum};
use super::series::Series;
use super::trial::{Ground, Of, Shot, Way};
use crate::length::LENGTHS;
use picket_dsp::Usable;
use picket_transform::num_complex::Complex;

/// A way that answers for less of the blocks than this is not proposed.
const LEAST: f64 = 0.3;
/// Of a bin this much may an answer's sigma be, and a block's answer off the line that it is for.
const WIDEST: f64 = 0.5;
const OFF_LINE: f64 = 0.25;
/// A band of fewer bins shows no noise beside a line.
const NARROWEST: f64 = 6.0;
/// Two lengths disagree if their answers differ by this many sigmas of a block.
const DISAGREE: f64 = 8.0;
/// A way that answers for this share needs no shorter block in addition.
const PLENTY: f64 = 0.95;

/// Ways that are tried on samples.
pub(super) struct Trials<'a> {
    pub ground: Ground<'a>,
    pub known: &'a Known,
    /// Something stands out of many frames.
    pub stands: bool,
    pub held: Vec<Held>,
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
    pub fn records(&mut self, row: usize) {
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
    pub fn chirps(&mut self, comb_hz: f64) -> bool {
        let ground = self.ground;
        let samples = ground.rate_hz / comb_hz;
        // The lines beside the strongest one are weak, and tell their distance to a hundredth. What comes again tells it to a sample, if it does:
        // the lines' own is tried where nothing holds with it.
        let mut hops: Vec<usize> = again(&ground, samples).into_iter().collect();
        let rough = samples.round() as usize;
        if !hops.contains(&rough) {
            hops.push(rough);
        }
        let mut chirps = false;
        for hop in hops {
            // Many periods long the segments stay where they are, and within a period, too: a tone whose frequency swings is none.
            if hop < 80 || ground.samples.len() <= 6 * hop || swings(&ground, hop) {
                continue;
            }
            let before = self.held.len();
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
            if self.held.len() > before {
                break;
            }
        }
        chirps
    }

    /// Blocks of every length, end to end, and tones that are followed.
    pub fn blocks(&mut self, bands: &[Option<(f64, f64)>]) {
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
    pub fn whole(&mut self) {
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
    pub fn disagreement(&self, best: &Held) -> Option<String> {
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

    pub fn best(&self) -> Option<&Held> {
        self.held.iter().max_by(|a, b| a.score.total_cmp(&b.score))
    }
}

/// The way for a series of harmonics: of the lengths that separate them the one that is good most often, or else one that sees it at all.
pub(super) fn harmonics(ground: &Ground, series: &Series) -> Option<(Way, f64, Vec<Shot>)> {
    let lengths = LENGTHS.into_iter().rev();
    let lengths = lengths
        .filter(|&n| n <= ground.samples.len() && series.hz * n as f64 > 4.0 * ground.rate_hz);
    let tried = lengths.take(3).filter_map(|n| {
        let band_hz = Some((0.72 * series.hz, 1.35 * series.hz));
        let way =
            Way { n, hop: n, skip: 0, band_hz, of: Of::Harmonics(series.highest.clamp(4, 32)) };
        let shots = ground.shots(&way);
        // A weak one may be a comb of ramps, whose low lines are missing.
        let is_near = |it: &Shot| it.usable < Usable::No && (it.hz / series.hz - 1.0).abs() < 0.015;
        let near: Vec<Shot> = shots.iter().copied().filter(is_near).collect();
        let good: Vec<Shot> = near.iter().copied().filter(Shot::holds).collect();
        let blocks = (ground.samples.len() / n).max(1) as f64;
        // Most of what it answers is the fundamental, and none of the good ones is another.
        let others = shots.iter().filter(|it| it.holds()).count() - good.len();
        let holds =
            10 * near.len() > 6 * shots.len() && 20 * others <= good.len() && !near.is_empty();
        let share = good.len() as f64 / blocks;
        holds.then_some((way, share, if good.is_empty() { near } else { good }))
    });
    tried.max_by(|a, b| {
        (a.1 + 0.1 * (a.0.n as f64).log2()).total_cmp(&(b.1 + 0.1 * (b.0.n as f64).log2()))
    })
}

/// A way that held.
#[derive(Clone, Debug)]
pub(super) struct Held {
    score: f64,
    pub way: Way,
    pub share: f64,
    pub shots: Vec<Shot>,
    /// The median answer and the median sigma, and whether the answers move.
    hz: f64,
    sigma_hz: f64,
    pub moves: bool,
}

/// The lag, within a twentieth of this one, at which the samples are most like themselves: a repeated segment is, except for its noise.
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
