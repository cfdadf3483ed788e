//! Measures blocks: by a pipeline, by the tracker around it, or as sums, bursts and frames of chirps.

use crate::either::{Either, Held, Idle};
use crate::slot::Slot;
use heapless::Vec;
use picket_dsp::acquire::frontend::Block;
use picket_dsp::acquire::sample::{Iq, Real, Record, Stamp};
use picket_dsp::frame::FrameTarget;
use picket_dsp::pipeline::{Alternating, Measurement, Pipeline};
use picket_dsp::plan::{EitherPlan, Plan};
use picket_dsp::tone::Tone;
use picket_dsp::tone::harmonic::Harmonic;
use picket_dsp::tone::lines::MOST;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::tracker::Tracker;
use picket_wire::burst::Burst;
use picket_wire::follow::Follow;
use picket_wire::fundamental::Fundamental;
use picket_wire::lines::Lines;
use picket_wire::settings::Settings;
use picket_wire::sum::Sum;

/// The result of a block.
// The first variant is zeros, so that a meter in static memory is zeros, too.
#[derive(Clone, Debug)]
#[repr(u8)]
#[expect(clippy::large_enum_variant, reason = "nothing is allocated here, and there is one of it")]
pub enum Gathered {
    /// The block's own measurement.
    Block,
    /// Nothing to report yet.
    Nothing,
    /// A completed sum, whose measurement is the block's.
    Sum(Sum),
    /// Completed bursts.
    Bursts(Vec<Burst, BURSTS>),
}

/// A frame of chirps whose targets are known.
#[derive(Clone, Copy, Debug, Default)]
pub struct Framed {
    /// The number of the frame, from 0 on.
    pub number: u32,
    /// Its first chirp.
    pub first: Stamp,
    /// The chirps before it that are in no frame.
    pub passed: u32,
    /// Samples that touch a rail.
    pub clipped: u32,
}

/// What work that outlasts a block has come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Advance {
    /// There is none.
    Idle,
    /// There is more of it.
    More,
    /// It is done.
    Done,
}

/// The most bursts that a block completes: their records overlap by at most half.
pub const BURSTS: usize = 4;

/// Measures blocks of `N` samples. Settings beyond the meter's constants are refused.
pub trait Meter<R: Record, const N: usize>: Idle {
    /// Whether the meter follows tones from block to block.
    const FOLLOWS: bool = false;
    /// Whether the meter finds more than one tone of a block, and a fundamental.
    const LINES: bool = false;
    /// Whether the meter adds blocks, and cuts bursts out of the stream.
    const SIGNALS: bool = false;
    /// The cells that the meter has for a frame of chirps; 0 for a meter without frames.
    const CELLS: usize = 0;

    /// Follows another plan from the next block on.
    fn set_plan(&mut self, plan: Plan<R, N>);

    /// Measures a block, whose codes are unchanged afterwards.
    fn block(&mut self, stamp: &Stamp, samples: &mut [R::Sample; N]) -> Measurement;

    /// Adds blocks, cuts bursts or gathers frames, by the settings' mode; a sum of noise passes for a tone with their probability.
    fn choose(&mut self, _: &Settings) {}

    /// Goes on with what outlasts a block, by a part that takes some tens of milliseconds: the search for the targets of a frame.
    fn advance(&mut self) -> Advance {
        Advance::Idle
    }

    /// The frame whose search is done, and its targets.
    fn framed(&self) -> Option<(Framed, &[FrameTarget])> {
        None
    }

    /// The result of the last block beyond its measurement.
    fn gathered(&mut self) -> Gathered {
        Gathered::Block
    }

    /// Tracks and targets after a block, if the plan follows tones. The closure adds the board's part to a tone's sigma.
    fn followed(&self, _: &Stamp, _: impl Fn(&mut Tone)) -> Option<Follow> {
        None
    }

    /// The tones of the last block, at most the given number. The measurement belongs to the last block.
    fn lines(&self, _: &Measurement, _: usize) -> Vec<ToneWithPhase, MOST> {
        Vec::new()
    }

    /// The fundamental of the last block's harmonics up to an order. The measurement belongs to the last block.
    fn harmonic(&self, _: &Measurement, _: u32) -> Option<Harmonic> {
        None
    }
}

impl<R: Record, const N: usize> Idle for Pipeline<R, N> {
    const IDLE: Self = Pipeline::new(Plan::IDLE);
}

impl<R: Record, const N: usize> Meter<R, N> for Pipeline<R, N> {
    fn set_plan(&mut self, plan: Plan<R, N>) {
        Pipeline::set_plan(self, plan);
    }

    #[inline(never)] // once in an image, not in each place that measures
    fn block(&mut self, stamp: &Stamp, samples: &mut [R::Sample; N]) -> Measurement {
        Pipeline::block(self, stamp, samples)
    }
}

impl<R: Record, const N: usize> Idle for Tracker<R, N> {
    const IDLE: Self = Tracker::new(Plan::IDLE);
}

/// A tracker whose plan follows no tones reports further tones of a block, and a fundamental.
impl<R: Record, const N: usize> Meter<R, N> for Tracker<R, N> {
    const FOLLOWS: bool = true;
    const LINES: bool = true;

    fn set_plan(&mut self, plan: Plan<R, N>) {
        Tracker::set_plan(self, plan);
    }

    #[inline(never)] // once in an image, not in each place that measures
    fn block(&mut self, stamp: &Stamp, samples: &mut [R::Sample; N]) -> Measurement {
        Tracker::block(self, stamp, samples)
    }

    fn followed(&self, stamp: &Stamp, widen: impl Fn(&mut Tone)) -> Option<Follow> {
        self.follows().then(|| Follow::widened(self, stamp, widen))
    }

    fn lines(&self, measurement: &Measurement, most: usize) -> Vec<ToneWithPhase, MOST> {
        self.pipeline().lines(measurement, most)
    }

    fn harmonic(&self, measurement: &Measurement, order: u32) -> Option<Harmonic> {
        self.pipeline().harmonic(measurement, order)
    }
}

impl<const N: usize, const TWICE: usize> Idle for Alternating<N, TWICE> {
    const IDLE: Self = Alternating::IDLE;
}

/// Pairs that one converter takes in turn.
impl<const N: usize, const TWICE: usize> Meter<Iq, N> for Alternating<N, TWICE> {
    fn set_plan(&mut self, plan: Plan<Iq, N>) {
        Alternating::set_plan(self, plan);
    }

    #[inline(never)] // once in an image, not in each place that measures
    fn block(&mut self, stamp: &Stamp, pairs: &mut [[i16; 2]; N]) -> Measurement {
        Alternating::block(self, stamp, pairs)
    }
}

/// No meter, for a board without such records, whose plan refuses them: the type takes no memory.
impl<R: Record, const N: usize> Meter<R, N> for () {
    fn set_plan(&mut self, _: Plan<R, N>) {}

    fn block(&mut self, stamp: &Stamp, _: &mut [R::Sample; N]) -> Measurement {
        Measurement { stamp: *stamp, ..Measurement::default() }
    }
}

/// The meter for the kind of record in use. In static memory it needs no room on the stack.
pub struct Meters<M, Q>(Either<M, Q>);

impl<M: Idle, Q: Idle> Meters<M, Q> {
    /// Waiting for the first plan.
    pub const IDLE: Self = Self(Either::IDLE);

    /// Makes the meter one for checked settings.
    #[inline(never)] // once in an image, not in each place that sets
    pub fn set<const N: usize>(&mut self, plan: &super::plan::Plan<N>)
    where
        M: Meter<Real, N>,
        Q: Meter<Iq, N>,
    {
        let settings = &plan.settings;
        match plan.plan {
            EitherPlan::Real(plan) => {
                let meter = self.0.first();
                meter.set_plan(plan);
                meter.choose(settings);
            }
            EitherPlan::Iq(plan) => {
                let meter = self.0.second();
                meter.set_plan(plan);
                meter.choose(settings);
            }
        }
    }

    /// Measures a block without its guard.
    #[inline(never)] // once in an image, not in each place that measures
    pub fn block<const N: usize, const WORDS: usize>(
        &mut self,
        block: &mut Block<Slot<WORDS>>,
        guard: u16,
    ) -> Measurement
    where
        M: Meter<Real, N>,
        Q: Meter<Iq, N>,
    {
        match self.0.get_mut() {
            Held::First(meter) => {
                meter.block(&block.stamp, block.slot.samples_mut::<Real, N>(guard))
            }
            Held::Second(meter) => {
                meter.block(&block.stamp, block.slot.samples_mut::<Iq, N>(guard))
            }
        }
    }

    /// The result of the last block beyond its measurement.
    pub fn gathered<const N: usize>(&mut self) -> Gathered
    where
        M: Meter<Real, N>,
        Q: Meter<Iq, N>,
    {
        match self.0.get_mut() {
            Held::First(meter) => meter.gathered(),
            Held::Second(meter) => meter.gathered(),
        }
    }

    /// Goes on with what outlasts a block.
    pub fn advance<const N: usize>(&mut self) -> Advance
    where
        M: Meter<Real, N>,
        Q: Meter<Iq, N>,
    {
        match self.0.get_mut() {
            Held::First(meter) => meter.advance(),
            Held::Second(meter) => meter.advance(),
        }
    }

    /// The frame whose search is done, and its targets.
    pub fn framed<const N: usize>(&self) -> Option<(Framed, &[FrameTarget])>
    where
        M: Meter<Real, N>,
        Q: Meter<Iq, N>,
    {
        match self.0.get() {
            Held::First(meter) => meter.framed(),
            Held::Second(meter) => meter.framed(),
        }
    }

    /// Tracks and targets after a block, if the plan follows tones. `widen` adds the board's part to a tone's sigma.
    pub fn followed<const N: usize>(
        &self,
        stamp: &Stamp,
        widen: impl Fn(&mut Tone),
    ) -> Option<Follow>
    where
        M: Meter<Real, N>,
        Q: Meter<Iq, N>,
    {
        match self.0.get() {
            Held::First(meter) => meter.followed(stamp, widen),
            Held::Second(meter) => meter.followed(stamp, widen),
        }
    }

    /// All tones of the last block, if the settings ask for more than the first. The measurement belongs to the last block.
    pub fn lines<const N: usize>(&self, measurement: &Measurement, further: u8) -> Option<Lines>
    where
        M: Meter<Real, N>,
        Q: Meter<Iq, N>,
    {
        if !(M::LINES || Q::LINES) || further == 0 {
            return None;
        }
        let most = 1 + usize::from(further);
        let tones = match self.0.get() {
            Held::First(meter) => meter.lines(measurement, most),
            Held::Second(meter) => meter.lines(measurement, most),
        };
        Some(Lines::from_tones(&measurement.stamp, tones))
    }

    /// The fundamental of the last block's harmonics up to an order above 0. The measurement belongs to the last block.
    pub fn fundamental<const N: usize>(
        &self,
        measurement: &Measurement,
        order: u8,
    ) -> Option<Fundamental>
    where
        M: Meter<Real, N>,
        Q: Meter<Iq, N>,
    {
        if !(M::LINES || Q::LINES) || order == 0 {
            return None;
        }
        let harmonic = match self.0.get() {
            Held::First(meter) => meter.harmonic(measurement, order.into()),
            Held::Second(meter) => meter.harmonic(measurement, order.into()),
        };
        Some(Fundamental::from_harmonic(&measurement.stamp, harmonic?))
    }
}
