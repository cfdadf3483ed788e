//! A trial: the records of a run of the scene, measured.

use crate::bound::{self, Line};
use crate::case::{Case, Engine, Path, Truths};
use crate::seen::{Seen, Trial};
use picket_dsp::config::Config;
use picket_dsp::solve::track::{State, Track};
use picket_dsp::spectrum::engine;
use picket_dsp::spectrum::layout::Layout;
use picket_dsp::spectrum::zoom::Oscillator;
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::zoomed::{self, Place};
use picket_dsp::{
    Accumulator, Alternating, Ambiguity, Burst, BurstProcessor, F32, I32, Iq, Outcome, Pipeline,
    Real, Record, Segment, Stamp, Target, Tone, ToneWithPhase, Tracker, Usable, Validation,
    Verdict,
};
use picket_simulator::scene::Source;
use picket_simulator::{Passed, Run, Truth};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// A trial of a case.
pub fn trial(case: &Case, number: u64) -> Trial {
    let mut run = match case.scene.run(number) {
        Ok(run) => run,
        Err(error) => panic!("{}: {error}", case.label),
    };
    let mut trial = match (case.scene.receiver.iq, case.engine) {
        (false, Engine::I32) => sized::<Real, I32>(case, &mut run),
        (false, Engine::F32) => sized::<Real, F32>(case, &mut run),
        (true, Engine::I32) => sized::<Iq, I32>(case, &mut run),
        (true, Engine::F32) => sized::<Iq, F32>(case, &mut run),
    };
    if case.whatever {
        let answers = trial.seen.iter_mut().filter(|seen| !seen.off[0].is_nan());
        answers.for_each(|seen| seen.verdict = Verdict::Good);
    }
    trial
}

fn sized<R: Record, E: engine::Engine>(case: &Case, run: &mut Run) -> Trial {
    if case.path == Path::ByTurns {
        return match case.n {
            64 => by_turns::<64, 128>(case, run),
            128 => by_turns::<128, 256>(case, run),
            256 => by_turns::<256, 512>(case, run),
            512 => by_turns::<512, 1024>(case, run),
            1024 => by_turns::<1024, 2048>(case, run),
            n => panic!("{}: no records of {n} pairs", case.label),
        };
    }
    match case.n {
        64 => measured::<R, 64, E>(case, run),
        128 => measured::<R, 128, E>(case, run),
        256 => measured::<R, 256, E>(case, run),
        512 => measured::<R, 512, E>(case, run),
        1024 => measured::<R, 1024, E>(case, run),
        2048 => measured::<R, 2048, E>(case, run),
        4096 => measured::<R, 4096, E>(case, run),
        n => panic!("{}: no records of {n} samples", case.label),
    }
}

fn measured<R: Record, const N: usize, E: engine::Engine>(case: &Case, run: &mut Run) -> Trial {
    let plan = match case.config.plan::<R, N>() {
        Ok(plan) => plan,
        Err(error) => panic!("{}: {error}", case.label),
    };
    let mut pipeline = Box::new(Pipeline::<R, N, E>::new(plan));
    match case.path {
        Path::Block => {
            let samples = samples::<R, N>(run, 0);
            let measurement = pipeline.block(&Stamp::default(), &samples);
            let against = Against::new::<R>(case, run, 0);
            Trial { seen: vec![against.tone(&measurement.tone)], ..Trial::default() }
        }
        Path::Lines(most) => {
            let samples = samples::<R, N>(run, 0);
            let measurement = pipeline.block(&Stamp::default(), &samples);
            let lines = pipeline.lines(&measurement, most);
            Against::new::<R>(case, run, 0).lines(&lines)
        }
        Path::Sum(blocks, drift) => {
            let mut sum = Box::new(
                Accumulator::<R, N>::new(blocks)
                    .with_drift(drift)
                    .with_false_alarm(case.config.false_alarm),
            );
            for block in 0..blocks {
                let samples = samples::<R, N>(run, block as usize);
                let stamp = Stamp { sequence: block, ..Stamp::default() };
                let measurement = pipeline.block(&stamp, &samples);
                if let Some(accumulated) = sum.add(&measurement, &pipeline) {
                    // The middle of the sum.
                    let against = Against::summed::<R>(case, run, blocks);
                    let seen = vec![against.tone(&accumulated.tone)];
                    return Trial { seen, ..Trial::default() };
                }
            }
            Trial { seen: vec![Seen::NOTHING], ..Trial::default() }
        }
        Path::Blocks(count) => {
            let block = |index: usize| {
                let samples = samples::<R, N>(run, index);
                let stamp = Stamp { sequence: index as u32, ..Stamp::default() };
                let tone = pipeline.block(&stamp, &samples).tone;
                Against::new::<R>(case, run, index).tone(&tone)
            };
            Trial { seen: (0..count).map(block).collect(), ..Trial::default() }
        }
        Path::Harmonic(orders) => {
            let samples = samples::<R, N>(run, 0);
            let measurement = pipeline.block(&Stamp::default(), &samples);
            let against = Against::new::<R>(case, run, 0);
            let found = pipeline.harmonic(&measurement, orders);
            let seen = vec![found.map_or(Seen::NOTHING, |found| against.tone(&found.tone))];
            Trial { seen, ..Trial::default() }
        }
        Path::Locked(bins) => {
            let seen = vec![locked::<R, N>(case, run, bins)];
            Trial { seen, ..Trial::default() }
        }
        Path::Tracks(settled, more) => {
            let mut tracker = Box::new(Tracker::<R, N>::new(plan));
            tracks(case, run, &mut tracker, settled, more)
        }
        Path::Bursts(records) => bursts(case, run, BurstProcessor::<R, N>::new(plan), records),
        // Measured before.
        Path::ByTurns => Trial::default(),
        Path::Chirps(laps) => chirps::<R, N, E>(case, run, &mut pipeline, laps),
    }
}

fn by_turns<const N: usize, const TWICE: usize>(case: &Case, run: &mut Run) -> Trial {
    let plan = match case.config.plan::<Iq, N>() {
        Ok(plan) => plan,
        Err(error) => panic!("{}: {error}", case.label),
    };
    let mut pairs = samples::<Iq, N>(run, 0);
    let before = pairs;
    let mut turns = Box::new(Alternating::<N, TWICE>::new(plan));
    let tone = turns.block(&Stamp::default(), &mut pairs).tone;
    assert_eq!(pairs, before, "{}: the codes are not what they were", case.label);
    let seen = vec![Against::new::<Iq>(case, run, 0).tone(&tone)];
    Trial { seen, ..Trial::default() }
}

fn tracks<R: Record, const N: usize>(
    case: &Case,
    run: &mut Run,
    tracker: &mut Tracker<R, N>,
    settled: usize,
    more: usize,
) -> Trial {
    let mut trial = Trial::default();
    let mut numbers = BTreeSet::new();
    let mut first = None;
    for block in 0..settled + more {
        let samples = samples::<R, N>(run, block);
        let stamp = Stamp { sequence: block as u32, ..Stamp::default() };
        tracker.block(&stamp, &samples);
        if block < settled {
            continue;
        }
        let against = Against::new::<R>(case, run, block);
        let held = tracker.tracks(Segment::Continuous).iter();
        let held: Vec<&Track> = held.filter(|track| track.state == State::Held).collect();
        if held.is_empty() {
            trial.seen.push(Seen::NOTHING);
        }
        trial.seen.extend(held.iter().map(|track| against.tone(&track.tone)));
        let usable = held.iter().filter(|track| track.tone.verdict.usable() <= Usable::WithinSigma);
        numbers.extend(usable.map(|track| track.number));
        let holder = |source| {
            let near = |track: &&&Track| against.error(&track.tone, source).abs() < 1.5;
            held.iter().find(near).map(|track| track.number)
        };
        let holders: Vec<Option<u32>> = (0..against.lines.len()).map(holder).collect();
        match (holders.iter().all(Option::is_some), trial.held_after) {
            (true, None) => trial.held_after = Some(block + 1 - settled),
            (false, Some(_)) => trial.lost = true,
            _ => {}
        }
        let began = first.get_or_insert_with(|| holders.clone());
        trial.exchanged = holders.contains(&None) || *began != holders;
    }
    trial.identities = numbers.len();
    trial
}

/// The burst of the first source: of the valid ones near it the nearest, or the worst where other sources may be meant. Valid ones elsewhere
/// have no source.
fn bursts<R: Record, const N: usize>(
    case: &Case,
    run: &mut Run,
    mut processor: BurstProcessor<R, N>,
    records: usize,
) -> Trial {
    let codes = run.codes(0.0, records * N);
    let samples: Vec<R::Sample> = codes.into_iter().map(R::from_parts).collect();
    let mut valid = Vec::new();
    for chunk in samples.chunks(777) {
        processor.push(chunk, |burst| {
            if burst.validation == Validation::Valid {
                valid.push(*burst);
            }
        });
    }
    let cut = [records as u64, u64::from(processor.counters().bursts)];
    let rate_hz = case.scene.rate_hz;
    let Some(source) = case.scene.sources.first() else {
        return Trial { more: valid.len(), cut, ..Trial::default() };
    };
    let mut against = Against::stretch::<R>(case, run, 0.0, 1);
    (against.n, against.truths) = (N, Truths::Carrier);
    let mut near = None;
    if let Source::Particles(of) = source {
        let mut passed: Vec<&Passed> = run.particles(0).iter().collect();
        passed.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
        let deviation = |of_one: &Passed| 0.5 * of.radius_m / of_one.velocity_mps.abs() * rate_hz;
        let truth = |of_one: &&Passed| Truth {
            nominal_hz: of_one.velocity_mps / of.fringe_m + of.shift_hz,
            amplitude: of_one.amplitude,
            ..Truth::default()
        };
        let noise = against.noise;
        let bound =
            |of_one: &&Passed| bound::burst(N, R::IQ, of_one.amplitude, deviation(of_one), noise);
        against.bounds = passed.iter().map(bound).collect();
        against.lines = passed.iter().map(truth).collect();
        near = passed
            .first()
            .map(|first| (first.middle_s * rate_hz, 4.0 * deviation(first).max(N as f64 / 20.0)));
    }
    let is_near =
        |burst: &&Burst| near.is_none_or(|(middle, reach)| (burst.arrival - middle).abs() < reach);
    let found: Vec<&Burst> = valid.iter().filter(is_near).collect();
    let more = valid.len() - found.len();
    let from_middle =
        |burst: &Burst| near.map_or(0.0, |(middle, _)| (burst.arrival - middle).abs());
    let off = |burst: &Burst| against.tone(&burst.tone).worst();
    // Where another particle may be meant, none of them may be wrong.
    let chosen = match case.any_source {
        true => found.iter().max_by(|a, b| off(a).total_cmp(&off(b))),
        false => found.iter().min_by(|a, b| from_middle(a).total_cmp(&from_middle(b))),
    };
    let seen = vec![chosen.map_or(Seen::NOTHING, |burst| against.tone(&burst.tone))];
    Trial { seen, more, cut, ..Trial::default() }
}

/// The locked way: where its tone is expected, with sigma from the true noise.
fn locked<R: Record, const N: usize>(case: &Case, run: &mut Run, bins: i32) -> Seen {
    let samples = samples::<R, N>(run, 0);
    let against = Against::new::<R>(case, run, 0);
    let Some(centre) = zoomed::centre(bins as f32, Layout::of::<R, N>()) else {
        return Seen::NOTHING;
    };
    let zoom = Oscillator::new(centre, Layout::of::<R, N>()).zoom::<R, N>(&samples);
    let Some(found) = Place::new(centre, Layout::of::<R, N>()).fit(&zoom, (bins - centre) as f32)
    else {
        return Seen::NOTHING;
    };
    let parts = if R::IQ { 2.0 } else { 1.0 };
    let noise = parts * against.noise * against.noise;
    let variance = N as f64 * noise / (2.0 * f64::from(found.information));
    let Some(frequency) = Frequency::from_bins(centre, f64::from(found.offset), N) else {
        return Seen::NOTHING;
    };
    let sigma = (variance.sqrt() / N as f64) as f32;
    against.tone(&Tone { frequency, sigma, verdict: Verdict::Good, ..Tone::default() })
}

fn samples<R: Record, const N: usize>(run: &mut Run, index: usize) -> [R::Sample; N] {
    let codes = run.record(index, N);
    std::array::from_fn(|n| R::from_parts(codes.get(n).copied().unwrap_or_default()))
}

/// What a record's answers are held against.
struct Against {
    n: usize,
    iq: bool,
    any: bool,
    truths: Truths,
    lines: Vec<Truth>,
    /// The bounds of the frequencies, bins.
    bounds: Vec<f64>,
    /// The noise of each part, as dense as it is at the first line.
    noise: f64,
    rate_hz: f64,
}

impl Against {
    fn new<R: Record>(case: &Case, run: &Run, index: usize) -> Self {
        let from_s = case.scene.start_s(index, case.n);
        Self::stretch::<R>(case, run, from_s, case.n)
    }

    /// A sum's blocks all together: the bound is that of one over the root of their number.
    fn summed<R: Record>(case: &Case, run: &Run, blocks: u32) -> Self {
        let middle_s = 0.5 * f64::from(blocks - 1) * case.n as f64 / case.scene.rate_hz;
        let mut against = Self::stretch::<R>(case, run, middle_s, case.n);
        against.bounds.iter_mut().for_each(|bound| *bound /= f64::from(blocks).sqrt());
        against
    }

    fn stretch<R: Record>(case: &Case, run: &Run, from_s: f64, n: usize) -> Self {
        let rate_hz = case.scene.rate_hz;
        let bounded = case.alone || case.asked.iter().any(crate::limit::Asked::needs_bound);
        let truth = |source| match case.truths {
            // A carrier is known without the phases of the samples.
            Truths::Carrier if !bounded => {
                run.truth(source, from_s + 0.5 * (n - 1) as f64 / rate_hz, 1)
            }
            _ => run.truth(source, from_s, n),
        };
        let lines: Vec<Truth> = (0..case.scene.sources.len()).map(truth).collect();
        // Where the first line is; rounding to codes is noise, too.
        let dense = lines.first().map_or(1.0, |line| run.dense(line.nominal_hz));
        let noise = (run.noise() * run.noise() * dense + 1.0 / 12.0).sqrt();
        let bounds = if bounded {
            let line = |truth: &Truth| {
                let bins = truth.frequency_hz * n as f64 / rate_hz;
                let phase = TAU * (truth.phase_turns - bins * (n / 2) as f64 / n as f64);
                Line { bins, amplitude: truth.amplitude, phase }
            };
            let mut lines: Vec<Line> = lines.iter().map(line).collect();
            if case.alone {
                lines.truncate(1);
                lines.iter_mut().for_each(|line| line.amplitude = run.amplitude(0));
            }
            let mut bounds = match R::IQ {
                true => lines.iter().map(|line| bound::iq(n, line.amplitude, noise)).collect(),
                false => bound::real(n, &lines, noise),
            };
            // Each multiple knows the fundamental by its order more exactly.
            let sources = case.scene.sources.iter().zip(&lines).zip(&mut bounds);
            for ((source, line), bound) in sources {
                if let Source::Tone(tone) = source
                    && matches!(case.path, Path::Harmonic(_))
                {
                    let multiple = |&[order, level_db]: &[f64; 2]| {
                        let amplitude = line.amplitude * 10f64.powf(level_db / 20.0);
                        let of = Line { bins: order * line.bins, amplitude, ..*line };
                        let bound = match R::IQ {
                            true => bound::iq(n, amplitude, noise),
                            false => bound::real(n, &[of], noise).remove(0),
                        };
                        (order / bound).powi(2)
                    };
                    let all: f64 = tone.harmonics.iter().map(multiple).sum();
                    *bound = (bound.powi(-2) + all).sqrt().recip();
                }
            }
            bounds
        } else {
            vec![f64::NAN; lines.len()]
        };
        let (any, truths) = (case.any_source, case.truths);
        Against { n, iq: R::IQ, any, truths, lines, bounds, noise, rate_hz }
    }

    /// The error of a frequency against a source, bins.
    fn error(&self, tone: &Tone, source: usize) -> f64 {
        let Some(truth) = self.lines.get(source) else { return f64::NAN };
        let hertz = match self.truths {
            Truths::Line => truth.frequency_hz,
            Truths::Mean => truth.mean_hz,
            Truths::Carrier => truth.nominal_hz,
        };
        let n = self.n as f64;
        let bins = hertz * n / self.rate_hz;
        // A real record has no sign.
        let error = tone.frequency.bins(self.n) - if self.iq { bins } else { bins.abs() };
        if self.iq { (error + n / 2.0).rem_euclid(n) - n / 2.0 } else { error }
    }

    /// The source that is meant.
    fn meant(&self, tone: &Tone) -> usize {
        if !self.any {
            return 0;
        }
        let nearest = |a: &usize, b: &usize| {
            self.error(tone, *a).abs().total_cmp(&self.error(tone, *b).abs())
        };
        (0..self.lines.len()).min_by(nearest).unwrap_or(0)
    }

    fn tone(&self, tone: &Tone) -> Seen {
        self.of(tone, self.meant(tone))
    }

    fn of(&self, tone: &Tone, source: usize) -> Seen {
        let bins = self.error(tone, source);
        let sigma = f64::from(tone.sigma) * self.n as f64;
        let bound = self.bounds.get(source).or(self.bounds.first()).copied().unwrap_or(f64::NAN);
        let amplitude = self.lines.get(source).map_or(0.0, |line| line.amplitude);
        let power = self.noise * self.noise;
        let snr_db = 10.0 * (amplitude * amplitude / 2.0 / power).log10();
        let level = f64::from(tone.amplitude) / amplitude - 1.0;
        Seen {
            off: [bins / sigma, 0.0],
            over_bound: [bins / bound, 0.0],
            bins,
            sigma: sigma / bound,
            snr_db: f64::from(tone.snr_db()) - snr_db,
            level: level.abs() - 6.0 * self.noise * (2.0 / self.n as f64).sqrt() / amplitude,
            verdict: tone.verdict,
            candidate: None,
        }
    }

    /// Several lines: each is the source within .7 bins of it that no other one has.
    fn lines(&self, found: &[ToneWithPhase]) -> Trial {
        let mut left: Vec<usize> = (0..self.lines.len()).collect();
        let mut trial = Trial::default();
        for phasor in found {
            let near = |&&source: &&usize| self.error(&phasor.tone, source).abs() < 0.7;
            let Some(&source) = left.iter().find(near) else {
                // What is said not to stand out is no line.
                trial.more += usize::from(phasor.tone.verdict < Verdict::Weak);
                continue;
            };
            left.retain(|&other| other != source);
            let mut seen = self.of(&phasor.tone, source);
            if let Some(truth) = self.lines.get(source) {
                let turns = f64::from(phasor.phase) / TAU - truth.phase_turns;
                let turns = turns - turns.round();
                seen.off[1] = turns * TAU / f64::from(phasor.sigma_phase);
                seen.over_bound[1] =
                    turns / bound::phase(self.n, self.iq, truth.amplitude, self.noise);
            }
            trial.seen.push(seen);
        }
        trial.missing = left.len();
        trial
    }
}

/// The target of the last chirp, held against the nearest source at the moment to which it refers. A chirp one of whose beats is within
/// three bins of half the rate, or on a ramp of 0 Hz, where no tone can be told from its image or an offset, is left out.
fn chirps<R: Record, const N: usize, E: engine::Engine>(
    case: &Case,
    run: &mut Run,
    pipeline: &mut Pipeline<R, N, E>,
    laps: usize,
) -> Trial {
    let Config { scene: picket_dsp::Scene::Chirp(told), .. } = case.config else {
        panic!("{}: no chirp is told", case.label)
    };
    let segments = told.shape.segments();
    let rate_hz = case.scene.rate_hz;
    let mut answer = None;
    for index in 0..laps * segments.len() {
        let start_s = case.scene.start_s(index, N);
        let Some(&segment) = segments.get(index % segments.len()) else { continue };
        let stamp = Stamp {
            segment,
            sequence: index as u32,
            clock: (start_s * rate_hz).round() as u64,
            ..Stamp::default()
        };
        let samples = samples::<R, N>(run, index);
        if let Outcome::Target(target) = pipeline.block(&stamp, &samples).result {
            answer = Some(target);
        }
        for source in 0..case.scene.sources.len() {
            let beat = run.truth(source, start_s, N).frequency_hz.abs() * N as f64 / rate_hz;
            let low = segment != Segment::Flat && beat < 3.0;
            if low || beat > N as f64 / 2.0 - 3.0 {
                return Trial::default();
            }
        }
    }
    let Some(target) = answer else {
        return Trial { seen: vec![Seen::NOTHING], ..Trial::default() };
    };
    let ends = [(laps - 1) * segments.len(), laps * segments.len() - 1];
    let [first, last] = ends.map(|index| case.scene.start_s(index, N));
    let middle_s = 0.5 * (first + last) + 0.5 * (N - 1) as f64 / rate_hz;
    let truths: Vec<Truth> =
        (0..case.scene.sources.len()).map(|source| run.truth(source, middle_s, 1)).collect();
    let off = |target: &Target, truth: &Truth| {
        let range = target.range.to_num::<f64>() - truth.range_m.unwrap_or(f64::NAN);
        let velocity = target.velocity.map_or(0.0, |velocity| {
            velocity.to_num::<f64>() - truth.velocity_mps.unwrap_or(f64::NAN)
        });
        let sigma = f64::from(target.sigma_velocity);
        [
            range / f64::from(target.sigma_range),
            if velocity == 0.0 { 0.0 } else { velocity / sigma },
        ]
    };
    let worst = |off: [f64; 2]| off[0].abs().max(off[1].abs());
    let nearest = |target: &Target| {
        let all = truths.iter().map(|truth| off(target, truth));
        all.min_by(|a, b| worst(*a).total_cmp(&worst(*b))).unwrap_or([f64::NAN; 2])
    };
    let candidate = match &target.ambiguity {
        Ambiguity::Several(candidates) => candidates
            .iter()
            .map(|candidate| {
                let (range, velocity) = (candidate.range, Some(candidate.velocity));
                worst(nearest(&Target { range, velocity, ..target }))
            })
            .min_by(f64::total_cmp),
        _ => None,
    };
    let (off, verdict) = (nearest(&target), target.verdict);
    let seen = Seen { off, verdict, candidate, ..Seen::NOTHING };
    Trial { seen: vec![seen], ..Trial::default() }
}
