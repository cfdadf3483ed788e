//! The meter of an image that has all modes: the settings choose what its memory holds.

use crate::either::{Either, Held, Idle};
use crate::frames::Frames;
use crate::gatherer::Gatherer;
use crate::meter::{Advance, Framed, Gathered, Meter};
use heapless::Vec;
use picket_dsp::acquire::sample::{Record, Stamp};
use picket_dsp::frame::FrameTarget;
use picket_dsp::pipeline::Measurement;
use picket_dsp::plan::Plan;
use picket_dsp::tone::Tone;
use picket_dsp::tone::harmonic::Harmonic;
use picket_dsp::tone::lines::MOST;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::tracker::Tracker;
use picket_wire::follow::Follow;
use picket_wire::settings::{Mode, Settings};

/// Measures block by block, with tracks, further tones or a fundamental where the settings ask for them, or sums and bursts, or frames of
/// chirps of at most so many cells.
pub struct Every<R: Record, const N: usize, const CELLS: usize>(
    Either<Tracker<R, N>, Either<Gatherer<R, N>, Frames<R, N, CELLS>>>,
);

impl<R: Record, const N: usize, const CELLS: usize> Idle for Every<R, N, CELLS> {
    const IDLE: Self = Self(Either::IDLE);
}

impl<R: Record, const N: usize, const CELLS: usize> Meter<R, N> for Every<R, N, CELLS> {
    const FOLLOWS: bool = true;
    const LINES: bool = true;
    const SIGNALS: bool = true;
    const CELLS: usize = CELLS;

    fn set_plan(&mut self, plan: Plan<R, N>) {
        match self.0.get_mut() {
            Held::First(tracker) => tracker.set_plan(plan),
            Held::Second(other) => match other.get_mut() {
                Held::First(gatherer) => gatherer.set_plan(plan),
                Held::Second(frames) => frames.set_plan(plan),
            },
        }
    }

    fn choose(&mut self, settings: &Settings) {
        if let Held::First(tracker) = self.0.get_mut()
            && settings.mode != Mode::Blocks
        {
            let plan = *tracker.pipeline().plan();
            let other = self.0.second();
            match settings.mode {
                Mode::Frames { .. } => other.second().set_plan(plan),
                _ => other.first().set_plan(plan),
            }
        }
        if let Held::Second(other) = self.0.get_mut() {
            match other.get_mut() {
                Held::First(gatherer) => gatherer.choose(settings),
                Held::Second(frames) => frames.choose(settings),
            }
        }
    }

    fn block(&mut self, stamp: &Stamp, samples: &mut [R::Sample; N]) -> Measurement {
        match self.0.get_mut() {
            Held::First(tracker) => Meter::block(tracker, stamp, samples),
            Held::Second(other) => match other.get_mut() {
                Held::First(gatherer) => gatherer.block(stamp, samples),
                Held::Second(frames) => frames.block(stamp, samples),
            },
        }
    }

    fn gathered(&mut self) -> Gathered {
        match self.0.get_mut() {
            Held::First(_) => Gathered::Block,
            Held::Second(other) => match other.get_mut() {
                Held::First(gatherer) => gatherer.gathered(),
                Held::Second(frames) => frames.gathered(),
            },
        }
    }

    fn advance(&mut self) -> Advance {
        if let Held::Second(other) = self.0.get_mut()
            && let Held::Second(frames) = other.get_mut()
        {
            return frames.advance();
        }
        Advance::Idle
    }

    fn framed(&self) -> Option<(Framed, &[FrameTarget])> {
        if let Held::Second(other) = self.0.get()
            && let Held::Second(frames) = other.get()
        {
            return frames.framed();
        }
        None
    }

    fn followed(&self, stamp: &Stamp, widen: impl Fn(&mut Tone)) -> Option<Follow> {
        match self.0.get() {
            Held::First(tracker) => tracker.followed(stamp, widen),
            Held::Second(_) => None,
        }
    }

    fn lines(&self, measurement: &Measurement, most: usize) -> Vec<ToneWithPhase, MOST> {
        match self.0.get() {
            Held::First(tracker) => tracker.lines(measurement, most),
            Held::Second(_) => Vec::new(),
        }
    }

    fn harmonic(&self, measurement: &Measurement, order: u32) -> Option<Harmonic> {
        match self.0.get() {
            Held::First(tracker) => tracker.harmonic(measurement, order),
            Held::Second(_) => None,
        }
    }
}
