//! The meter of an image that has all modes: the settings choose what its memory holds.

use crate::either::{Either, Held, Idle};
use crate::gatherer::Gatherer;
use crate::meter::{Gathered, Meter};
use heapless::Vec;
use picket_dsp::acquire::sample::{Record, Stamp};
use picket_dsp::pipeline::Measurement;
use picket_dsp::plan::Plan;
use picket_dsp::tone::Tone;
use picket_dsp::tone::harmonic::Harmonic;
use picket_dsp::tone::lines::MOST;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::tracker::Tracker;
use picket_wire::follow::Follow;
use picket_wire::settings::Mode;

/// Measures block by block, with tracks, further tones or a fundamental where the settings ask for them, or sums and bursts.
pub struct Every<R: Record, const N: usize>(Either<Tracker<R, N>, Gatherer<R, N>>);

impl<R: Record, const N: usize> Idle for Every<R, N> {
    const IDLE: Self = Self(Either::IDLE);
}

impl<R: Record, const N: usize> Meter<R, N> for Every<R, N> {
    const FOLLOWS: bool = true;
    const LINES: bool = true;
    const SIGNALS: bool = true;

    fn set_plan(&mut self, plan: Plan<R, N>) {
        match self.0.get_mut() {
            Held::First(tracker) => tracker.set_plan(plan),
            Held::Second(gatherer) => gatherer.set_plan(plan),
        }
    }

    fn choose(&mut self, mode: Mode, false_alarm: f64) {
        if let Held::First(tracker) = self.0.get_mut()
            && mode != Mode::Blocks
        {
            let plan = *tracker.pipeline().plan();
            self.0.second().set_plan(plan);
        }
        if let Held::Second(gatherer) = self.0.get_mut() {
            gatherer.choose(mode, false_alarm);
        }
    }

    fn block(&mut self, stamp: &Stamp, samples: &mut [R::Sample; N]) -> Measurement {
        match self.0.get_mut() {
            Held::First(tracker) => Meter::block(tracker, stamp, samples),
            Held::Second(gatherer) => gatherer.block(stamp, samples),
        }
    }

    fn gathered(&mut self) -> Gathered {
        match self.0.get_mut() {
            Held::First(_) => Gathered::Block,
            Held::Second(gatherer) => gatherer.gathered(),
        }
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
