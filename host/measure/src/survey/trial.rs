//! A way to measure, tried on the samples themselves: its answers, and whether blocks of half its length agree.

use super::nature::moves;
use crate::simulate::Kind;
use crate::{length, with_record};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::config::{Config, Following};
use picket_dsp::pipeline::Pipeline;
use picket_dsp::solve::track::State;
use picket_dsp::tone::effort::Effort;
use picket_dsp::tracker::Tracker;
use picket_dsp::{BurstProcessor, Plan, Usable, Validation};
use picket_transform::num_complex::Complex;

/// A way to measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// Samples in a block.
    pub n: usize,
    /// From one block's start to the next.
    pub hop: usize,
    /// Samples left out at the start.
    pub skip: usize,
    /// The band that is searched.
    pub band_hz: Option<(f64, f64)>,
    /// What is measured.
    pub of: Of,
}

/// What a way measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Of {
    /// Each block by itself.
    Blocks,
    /// A tone that is followed from block to block.
    Track,
    /// Bursts, wherever they are.
    Bursts,
    /// The fundamental of each block, from its harmonics up to this order.
    Harmonics(u32),
}

/// One answer.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// The block's middle, in samples.
    pub middle: f64,
    /// The frequency, and one standard deviation of it.
    pub hz: f64,
    /// One standard deviation.
    pub sigma_hz: f64,
    /// What it may be used for.
    pub usable: Usable,
}

/// Samples that ways are tried on.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// The samples, in codes.
    pub samples: &'a [Complex<f64>],
    /// I/Q.
    pub iq: bool,
    /// Samples per second.
    pub rate_hz: f64,
    /// The converter's codes, and the factor to them.
    pub codes: Codes,
    /// The factor from the samples to these codes.
    pub scale: f64,
    /// The samples are records of their own, one behind the other.
    pub records: bool,
}

/// Standard deviations that an answer may be off.
const SIGMAS: f64 = 3.0;
/// Of a hundred comparisons this many have to agree: by chance one in 370 does not, and a half that is moving or
/// weak has less to say.
const AGREE: f64 = 0.93;
/// Comparisons that are needed.
const ENOUGH: usize = 6;

impl Shot {
    /// Whether sigma is its error.
    pub fn holds(&self) -> bool {
        self.usable <= Usable::WithinSigma
    }
}

impl Ground<'_> {
    /// What a way answers; nothing where it cannot be taken.
    pub fn shots(&self, way: &Way) -> Vec<Shot> {
        if length::check(way.n).is_err() {
            return Vec::new();
        }
        with_record!(self.iq, way.n, R, N => self.of::<R, N>(way))
    }

    fn of<R: Kind, const N: usize>(&self, way: &Way) -> Vec<Shot> {
        let following = match way.of {
            Of::Track => Following::default(),
            Of::Blocks | Of::Bursts | Of::Harmonics(_) => Following::NONE,
        };
        // A joint fit explains much that a proposal is not for, such as one line of a comb of ramps: tests alone let an answer pass.
        let config = Config {
            band_hz: way.band_hz,
            following,
            effort: Effort::LOOK,
            ..Config::new(self.rate_hz, self.codes)
        };
        let Ok(plan) = config.plan::<R, N>() else { return Vec::new() };
        if way.of == Of::Bursts {
            return self.bursts(plan);
        }
        let windows = self.samples.get(way.skip..).unwrap_or_default();
        let blocks = (0u32..).zip(windows.windows(N).step_by(way.hop.max(1)));
        let record = |window: &[Complex<f64>]| {
            let scaled: Vec<Complex<f64>> = window.iter().map(|x| x * self.scale).collect();
            crate::follow::record::<R, N>(&scaled)
        };
        let middle = |block: u32| (way.skip + block as usize * way.hop + N / 2) as f64;
        if way.of == Of::Track {
            let mut tracker = Box::new(Tracker::<R, N>::new(plan));
            let mut shots = Vec::new();
            for (block, window) in blocks {
                let stamp = Stamp { sequence: block, ..Stamp::default() };
                tracker.block(&stamp, &record(window));
                for track in tracker.tracks(Segment::Continuous) {
                    if track.state == State::Held {
                        shots.push(Shot {
                            middle: middle(block),
                            hz: track.tone.frequency.hertz(self.rate_hz),
                            sigma_hz: f64::from(track.tone.sigma) * self.rate_hz,
                            usable: track.tone.verdict.usable(),
                        });
                    }
                }
            }
            return shots;
        }
        let mut pipeline = Box::new(Pipeline::<R, N>::new(plan));
        blocks
            .filter_map(|(block, window)| {
                let stamp = Stamp { sequence: block, ..Stamp::default() };
                let measurement = pipeline.block(&stamp, &record(window));
                let tone = match way.of {
                    Of::Harmonics(order) => pipeline.harmonic(&measurement, order)?.tone,
                    _ => measurement.tone,
                };
                Some(Shot {
                    middle: middle(block),
                    hz: tone.hertz(),
                    sigma_hz: tone.sigma_hertz(),
                    usable: tone.verdict.usable(),
                })
            })
            .collect()
    }

    /// The bursts that are valid, or that are something else than noise.
    fn bursts<R: Kind, const N: usize>(&self, plan: Plan<R, N>) -> Vec<Shot> {
        let mut processor = Box::new(BurstProcessor::<R, N>::new(plan));
        let mut shots = Vec::new();
        for part in self.samples.chunks(4096) {
            let code = |x: &Complex<f64>| {
                let [re, im] = [x.re, x.im].map(|part| (part * self.scale).round() as i16);
                R::from_parts([re, im])
            };
            let codes: Vec<R::Sample> = part.iter().map(code).collect();
            processor.push(&codes, |burst| {
                if burst.validation != Validation::Weak {
                    let valid = burst.validation == Validation::Valid;
                    shots.push(Shot {
                        middle: burst.arrival,
                        hz: burst.tone.hertz(),
                        sigma_hz: burst.tone.sigma_hertz(),
                        usable: if valid { burst.tone.verdict.usable() } else { Usable::No },
                    });
                }
            });
        }
        shots
    }

    /// The share of the bursts that are valid in records of this length, if records of half and twice the length bear their frequencies
    /// out; else `None`.
    pub fn tried_bursts(&self, way: &Way) -> Option<(f64, Vec<Shot>)> {
        let all = self.shots(way);
        let valid: Vec<Shot> = all.iter().copied().filter(Shot::holds).collect();
        let lengths = [way.n / 2, 2 * way.n];
        let others: Vec<Shot> =
            lengths.into_iter().flat_map(|n| self.shots(&Way { n, ..*way })).collect();
        let agreement = |others: &mut dyn Iterator<Item = &Shot>| {
            let (mut agree, mut count) = (0, 0);
            for other in others {
                let apart = |shot: &&Shot| (shot.middle - other.middle).abs();
                let near = valid.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
                let Some(near) = near.filter(|near| apart(near) < 0.1 * way.n as f64) else {
                    continue;
                };
                count += 1;
                let sigma = near.sigma_hz.hypot(other.sigma_hz);
                agree += usize::from((near.hz - other.hz).abs() <= SIGMAS * sigma);
            }
            (agree, count)
        };
        let (mut agree, mut count) = agreement(&mut others.iter().filter(|other| other.holds()));
        if count < ENOUGH {
            // Far above the noise an envelope that is half as long as the record, or a twentieth, is seen not to be whole, or not to be Gaussian. Its
            // frequency is measured all the same.
            (agree, count) = agreement(&mut others.iter());
        }
        let holds = count >= ENOUGH && agree as f64 >= AGREE * count as f64;
        (holds && valid.len() >= ENOUGH).then(|| (valid.len() as f64 / all.len() as f64, valid))
    }

    /// The share of the blocks that a way answers for, if other cuts of the recording bear its answers out; else `None`.
    pub fn tried(&self, way: &Way) -> Option<(f64, Vec<Shot>)> {
        let shots: Vec<Shot> = self.shots(way).into_iter().filter(Shot::holds).collect();
        let blocks = self.samples.len().saturating_sub(way.skip + way.n) / way.hop + 1;
        let half = Way { n: way.n / 2, hop: way.hop.div_ceil(2), of: Of::Blocks, ..*way };
        let other = match way.hop > way.n || self.records {
            // Chirps: each half of the segment on its own.
            true => vec![
                Way { hop: way.hop, ..half },
                Way { hop: way.hop, skip: way.skip + way.n / 2, ..half },
            ],
            false => vec![half, Way { skip: way.skip + way.n / 2, of: Of::Blocks, ..*way }],
        };
        let verdicts = other.iter().map(|other| agreement(&shots, &self.shots(other), way));
        let mut agreed: Vec<(f64, usize)> = verdicts.collect();
        if way.of == Of::Blocks && !moves(&shots, self.rate_hz / way.n as f64) {
            // Of a tone that stays where it is blocks beside each other agree, too. What breaks a tone now and then biases a block and its halves alike.
            let every = |first: usize| shots.iter().skip(first).step_by(2).copied().collect();
            let [even, odd]: [Vec<Shot>; 2] = [every(0), every(1)];
            agreed.push(agreement(&even, &odd, &Way { hop: 2 * way.hop, ..*way }));
        }
        let enough: Vec<f64> = agreed
            .iter()
            .filter(|(_, count)| *count >= ENOUGH.min(shots.len() / 2).max(3))
            .map(|(share, _)| *share)
            .collect();
        let holds = !enough.is_empty() && enough.iter().all(|share| *share >= AGREE);
        (holds && shots.len() >= 3).then(|| (shots.len() as f64 / blocks as f64, shots))
    }
}

/// The share of other answers that agree with these, where these were, and how many could be compared.
fn agreement(shots: &[Shot], others: &[Shot], way: &Way) -> (f64, usize) {
    let (mut agree, mut count, mut at) = (0, 0, 0);
    for other in others.iter().filter(|other| other.holds()) {
        while shots.get(at + 1).is_some_and(|next| next.middle <= other.middle) {
            at += 1;
        }
        let Some(near) = shots.get(at) else { break };
        let next =
            shots.get(at + 1).filter(|next| next.middle - near.middle < 1.5 * way.hop as f64);
        let off = other.middle - near.middle;
        let (expected, sigma) = match next {
            Some(next) if off >= 0.0 => {
                let share = off / (next.middle - near.middle);
                let hz = near.hz + share * (next.hz - near.hz);
                let variance =
                    (near.sigma_hz * (1.0 - share)).powi(2) + (next.sigma_hz * share).powi(2);
                (hz, variance.sqrt())
            }
            _ if off.abs() < 0.3 * way.n as f64 => (near.hz, near.sigma_hz),
            _ => continue,
        };
        count += 1;
        let sigma = sigma.hypot(other.sigma_hz);
        agree += usize::from((other.hz - expected).abs() <= SIGMAS * sigma);
    }
    (agree as f64 / f64::from(count.max(1) as u32), count)
}
