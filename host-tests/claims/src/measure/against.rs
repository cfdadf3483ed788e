//! Answers beside what is true.

use crate::bound::{self, Line};
use crate::case::{Case, Path, Truths};
use crate::seen::{Seen, Trial};
use picket_dsp::{Record, Tone, ToneWithPhase, Verdict};
use picket_simulator::scene::Source;
use picket_simulator::{Run, Truth};
use std::f64::consts::TAU;

/// What a record's answers are held against.
pub(super) struct Against {
    pub n: usize,
    iq: bool,
    any: bool,
    pub truths: Truths,
    pub lines: Vec<Truth>,
    /// The bounds of the frequencies, bins.
    pub bounds: Vec<f64>,
    /// The noise of each part, as dense as it is at the first line.
    pub noise: f64,
    rate_hz: f64,
}

impl Against {
    pub(super) fn new<R: Record>(case: &Case, run: &Run, index: usize) -> Self {
        let from_s = case.scene.start_s(index, case.n);
        Self::stretch::<R>(case, run, from_s, case.n)
    }

    /// A sum's blocks all together: the bound is that of one over the root of their number.
    pub(super) fn summed<R: Record>(case: &Case, run: &Run, blocks: u32) -> Self {
        let middle_s = 0.5 * f64::from(blocks - 1) * case.n as f64 / case.scene.rate_hz;
        let mut against = Self::stretch::<R>(case, run, middle_s, case.n);
        against.bounds.iter_mut().for_each(|bound| *bound /= f64::from(blocks).sqrt());
        against
    }

    pub(super) fn stretch<R: Record>(case: &Case, run: &Run, from_s: f64, n: usize) -> Self {
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
    pub(super) fn error(&self, tone: &Tone, source: usize) -> f64 {
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

    pub(super) fn tone(&self, tone: &Tone) -> Seen {
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
            // What is off has no sigma where none is told.
            off: [if tone.sigma < 1.0 { bins / sigma } else { f64::INFINITY }, 0.0],
            over_bound: [bins / bound, 0.0],
            bins,
            sigma: sigma / bound,
            snr_db: f64::from(tone.snr_db()) - snr_db,
            level: level.abs() - 6.0 * self.noise * (2.0 / self.n as f64).sqrt() / amplitude,
            verdict: tone.verdict,
            candidate: None,
            cycles: None,
        }
    }

    /// Several lines: each is the source within .7 bins of it that no other one has.
    pub(super) fn lines(&self, found: &[ToneWithPhase]) -> Trial {
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
