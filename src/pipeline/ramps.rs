//! The beats of one chirp's segments, until its last ramp gives the target.

use super::Outcome;
use crate::acquire::sample::Stamp;
use crate::frequency::Frequency;
use crate::list::first;
use crate::plan::Solver;
use crate::solve::chirp::{self, Shape};
use crate::solve::doppler;
use crate::solve::equations::Equations;
use crate::solve::hypotheses::solve;
use crate::solve::hypothesis::{Last, Line};
use crate::solve::segments::{Segments, TRAPEZOID, TRIANGLE};
use crate::tone::lines::MOST;
use crate::tone::{FrequencyDrift, Tone, Verdict};
use heapless::Vec;

/// Collects the tones of one chirp.
#[derive(Clone, Debug)]
pub(crate) struct Ramps {
    beats: [Vec<Beat, MOST>; 3],
    /// The rise of each segment's line, if it has only one.
    drifts: [Option<FrequencyDrift>; 3],
    segments: Segments,
    last: Last,
    /// The sample clock at this chirp's rising ramp, and at the last chirp's falling one.
    begin: u64,
    clock: Option<u64>,
}

/// The part of a line that a solver reads.
#[derive(Clone, Copy, Debug)]
struct Beat {
    frequency: Frequency,
    sigma: f32,
    snr: f32,
    amplitude: f32,
    verdict: Verdict,
}

impl Beat {
    const fn from_line(line: &Line) -> Self {
        let Tone { frequency, sigma, snr, amplitude, verdict, .. } = line.tone;
        Self { frequency, sigma, snr, amplitude, verdict }
    }

    const fn line(&self, drift: Option<FrequencyDrift>) -> Line {
        let Self { frequency, sigma, snr, amplitude, verdict } = *self;
        let tone = Tone { frequency, sigma, snr, amplitude, verdict, ..Tone::ZERO };
        Line { tone, drift }
    }
}

impl Ramps {
    pub const fn new() -> Self {
        let beats = [const { Vec::new() }; 3];
        Self {
            beats,
            drifts: [None; 3],
            segments: Segments::new(),
            last: Last::new(),
            begin: 0,
            clock: None,
        }
    }

    /// The next block starts a chirp that no other precedes.
    pub fn forget(&mut self) {
        self.segments.forget();
        self.last.forget();
        self.clock = None;
    }

    /// The velocity or target computed from a block's lines, the strongest first; `signed` says that their frequencies have the right
    /// signs.
    pub fn solve(
        &mut self,
        solver: &Solver,
        stamp: &Stamp,
        lines: &[Line],
        signed: bool,
    ) -> Outcome {
        let Some(Line { tone, .. }) = lines.first() else { return Outcome::None };
        match *solver {
            Solver::None => Outcome::None,
            Solver::Doppler(scale) => Outcome::Velocity(doppler::velocity(tone, scale)),
            Solver::Chirp(ref equations) => match equations.shape {
                Shape::Sawtooth => Outcome::Target(chirp::sawtooth(tone, signed, equations)),
                Shape::Triangle => self.pair(stamp, lines, TRIANGLE, signed, equations),
                Shape::Trapezoid => self.pair(stamp, lines, TRAPEZOID, signed, equations),
            },
        }
    }

    /// Takes a segment's lines; the falling ramp completes a chirp and gives its target.
    #[inline(never)]
    fn pair(
        &mut self,
        stamp: &Stamp,
        lines: &[Line],
        wanted: u8,
        signed: bool,
        equations: &Equations,
    ) -> Outcome {
        let Some(index) = self.segments.push(stamp) else { return Outcome::None };
        if index == 0 {
            self.begin = stamp.clock;
        }
        if let (Some(beats), Some(drift)) = (self.beats.get_mut(index), self.drifts.get_mut(index))
        {
            *beats = first(lines.iter().map(Beat::from_line));
            *drift = lines.first().and_then(|line| line.drift);
        }
        if !self.segments.complete(stamp.segment, wanted) {
            return Outcome::None;
        }
        let mut drifts = self.drifts.into_iter();
        let lines = self.beats.each_ref().map(|beats| {
            let drift = drifts.next().flatten();
            first(beats.iter().map(|beat| beat.line(drift)))
        });
        // Some clocks do not count the guard: the time between the ramps, which is known, is their unit.
        let ramps = stamp.clock.checked_sub(self.begin).filter(|&samples| samples > 0);
        let passed = self.clock.and_then(|clock| stamp.clock.checked_sub(clock));
        let passed = passed.filter(|&samples| samples > 0);
        let time_s = ramps.zip(passed);
        let time_s = time_s.map(|(ramps, passed)| equations.apart * (passed as f32 / ramps as f32));
        self.clock = Some(stamp.clock);
        let last = Some((&mut self.last, time_s));
        Outcome::Target(solve(&lines, 0, signed, equations, last))
    }
}
