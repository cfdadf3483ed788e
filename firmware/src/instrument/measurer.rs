//! Measures blocks: by the pipeline, or, in an image that follows tones, by the tracker around it.

#[cfg(image = "signals")]
pub use super::signals::Gatherer as Meter;
use crate::slot::Slot;
use heapless::Vec;
use picket::acquire::frontend::Block;
use picket::acquire::sample::{Iq, Real, Stamp};
use picket::config::Config;
#[cfg(not(any(image = "signals", image = "tracking")))]
pub use picket::pipeline::Pipeline as Meter;
use picket::pipeline::{Alternating, Measurement};
use picket::plan::{EitherPlan, Plan};
use picket::tone::harmonic::Harmonic;
use picket::tone::lines::MOST;
use picket::tone::phasor::Phasor;
#[cfg(image = "tracking")]
pub use picket::tracker::Tracker as Meter;
use picket_wire::burst::Burst;
use picket_wire::follow::Follow;
use picket_wire::fundamental::Fundamental;
use picket_wire::lines::Lines;
use picket_wire::settings::{Mode, Settings};
use picket_wire::sum::Sum;

/// Whether this image follows tones.
pub const FOLLOWS: bool = cfg!(image = "tracking");

/// Whether this image reports more than one tone of a block.
pub const LINES: bool = cfg!(image = "lines");

/// Whether this image adds blocks and cuts bursts out of the stream.
pub const SIGNALS: bool = cfg!(image = "signals");

/// What a block gave.
// The first case is zeros, so that a meter in static memory is.
#[derive(Clone, Debug)]
#[repr(u8)]
#[expect(clippy::large_enum_variant, reason = "nothing is allocated here, and there is one of it")]
pub enum Gathered {
    /// Its own measurement.
    Block,
    /// Nothing to report yet.
    Nothing,
    /// It completed a sum, whose measurement its own is.
    Sum(Sum),
    /// It completed bursts.
    Bursts(Vec<Burst, BURSTS>),
}

/// The most bursts that a block completes: their records do not overlap by more than half.
pub const BURSTS: usize = 4;

/// Measures I/Q records: of pairs that two converters take at once, or that one takes by turns.
pub trait IqMeter<const N: usize>: 'static {
    /// Follows another plan from the next block on.
    fn adopt(&mut self, plan: Plan<Iq, N>);

    /// Measures a block, whose codes are the same again afterwards.
    fn block(&mut self, stamp: Stamp, pairs: &mut [[i16; 2]; N]) -> Measurement;

    /// Adds blocks, or cuts bursts, as the mode says; a sum of noise passes for a tone with the probability given.
    fn choose(&mut self, _: Mode, _: f64) {}

    /// What the last block gave.
    fn gathered(&mut self) -> Gathered {
        Gathered::Block
    }

    /// Tracks and targets after a block, if the plan follows tones.
    fn followed(&self, _: &Stamp) -> Option<Follow> {
        None
    }

    /// Up to so many tones of the last block, whose measurement this is.
    fn lines(&self, _: &Measurement, _: usize) -> Vec<Phasor, MOST> {
        Vec::new()
    }

    /// The fundamental of the last block's harmonics up to an order. The block is that of this measurement.
    fn harmonic(&self, _: &Measurement, _: u32) -> Option<Harmonic> {
        None
    }
}

impl<const N: usize> IqMeter<N> for Meter<Iq, N> {
    fn adopt(&mut self, plan: Plan<Iq, N>) {
        Meter::adopt(self, plan);
    }

    fn block(&mut self, stamp: Stamp, pairs: &mut [[i16; 2]; N]) -> Measurement {
        Meter::block(self, stamp, pairs)
    }

    #[cfg(image = "signals")]
    fn choose(&mut self, mode: Mode, false_alarm: f64) {
        Meter::choose(self, mode, false_alarm);
    }

    #[cfg(image = "signals")]
    fn gathered(&mut self) -> Gathered {
        Meter::gathered(self)
    }

    #[cfg(image = "tracking")]
    fn followed(&self, stamp: &Stamp) -> Option<Follow> {
        self.follows().then(|| Follow::of(self, stamp))
    }

    #[cfg(image = "lines")]
    fn lines(&self, measurement: &Measurement, most: usize) -> Vec<Phasor, MOST> {
        Meter::lines(self, measurement, most)
    }

    #[cfg(image = "lines")]
    fn harmonic(&self, measurement: &Measurement, order: u32) -> Option<Harmonic> {
        Meter::harmonic(self, measurement, order)
    }
}

impl<const N: usize, const TWICE: usize> IqMeter<N> for Alternating<N, TWICE> {
    fn adopt(&mut self, plan: Plan<Iq, N>) {
        Alternating::adopt(self, plan);
    }

    fn block(&mut self, stamp: Stamp, pairs: &mut [[i16; 2]; N]) -> Measurement {
        Alternating::block(self, stamp, pairs)
    }
}

/// A meter for each kind of record, in static memory: built at run time, they would pass over the
/// stack.
pub type Meters<const N: usize, Q = Meter<Iq, N>> = (&'static mut Meter<Real, N>, &'static mut Q);

/// The meters of an image whose blocks have this many samples, in static memory; `None` at the
/// second call. A board that takes the pairs of an I/Q record by turns names their meter, too.
#[macro_export]
macro_rules! meters {
    ($n:expr) => {
        $crate::meters!(
            $n,
            $crate::instrument::measurer::Meter<picket::acquire::sample::Iq, { $n }>,
            $crate::instrument::measurer::Meter::new(picket::plan::Plan::IDLE)
        )
    };
    ($n:expr, $iq:ty, $idle:expr) => {{
        use picket::acquire::sample::Real;
        use picket::plan::Plan;
        use $crate::instrument::measurer::Meter;
        static REAL: static_cell::ConstStaticCell<Meter<Real, { $n }>> =
            static_cell::ConstStaticCell::new(Meter::new(Plan::IDLE));
        static IQ: static_cell::ConstStaticCell<$iq> = static_cell::ConstStaticCell::new($idle);
        REAL.try_take().zip(IQ.try_take())
    }};
}

/// The meter for the kind of record in use.
pub enum Measurer<const N: usize, Q: IqMeter<N> = Meter<Iq, N>> {
    /// For records of one input.
    Real(&'static mut Meter<Real, N>),
    /// For records of two inputs.
    Iq(&'static mut Q),
}

impl<const N: usize, Q: IqMeter<N>> Measurer<N, Q> {
    /// The meter for checked settings.
    pub fn new((real, iq): Meters<N, Q>, plan: &super::plan::Plan<N>) -> Self {
        let Settings { mode, config: Config { false_alarm, .. }, .. } = plan.settings;
        match &plan.plan {
            EitherPlan::Real(plan) => {
                real.adopt(*plan);
                #[cfg(image = "signals")]
                real.choose(mode, false_alarm);
                Measurer::Real(real)
            }
            EitherPlan::Iq(plan) => {
                iq.adopt(*plan);
                iq.choose(mode, false_alarm);
                Measurer::Iq(iq)
            }
        }
    }

    /// Measures a block without its guard. It is called at two places; the smallest cores have it once.
    #[cfg_attr(short_products, inline(never))]
    pub fn block<const WORDS: usize>(
        &mut self,
        block: &mut Block<Slot<WORDS>>,
        guard: u16,
    ) -> Measurement {
        match self {
            Measurer::Real(meter) => meter.block(block.stamp, block.slot.samples::<Real, N>(guard)),
            Measurer::Iq(meter) => meter.block(block.stamp, block.slot.samples_mut::<Iq, N>(guard)),
        }
    }

    /// What the last block gave.
    pub fn gathered(&mut self) -> Gathered {
        match self {
            #[cfg(image = "signals")]
            Measurer::Real(meter) => meter.gathered(),
            #[cfg(not(image = "signals"))]
            Measurer::Real(_) => Gathered::Block,
            Measurer::Iq(meter) => meter.gathered(),
        }
    }

    /// Tracks and targets after a block, if the plan follows tones.
    #[cfg(image = "tracking")]
    pub fn followed(&self, stamp: &Stamp) -> Option<Follow> {
        match self {
            Measurer::Real(tracker) => tracker.follows().then(|| Follow::of(tracker, stamp)),
            Measurer::Iq(meter) => meter.followed(stamp),
        }
    }

    /// All tones of the last block, if the settings ask for some beyond the first. The block is that of this
    /// measurement.
    #[cfg(image = "lines")]
    pub fn lines(&self, measurement: &Measurement, further: u8) -> Option<Lines> {
        let tones = |most: usize| match self {
            Measurer::Real(meter) => meter.lines(measurement, most),
            Measurer::Iq(meter) => meter.lines(measurement, most),
        };
        (further > 0).then(|| Lines::of(&measurement.stamp, tones(1 + usize::from(further))))
    }

    /// The fundamental of the last block's harmonics up to an order above 0. The block is that of this
    /// measurement.
    #[cfg(image = "lines")]
    pub fn fundamental(&self, measurement: &Measurement, order: u8) -> Option<Fundamental> {
        if order == 0 {
            return None;
        }
        let harmonic = match self {
            Measurer::Real(meter) => meter.harmonic(measurement, order.into()),
            Measurer::Iq(meter) => meter.harmonic(measurement, order.into()),
        };
        Some(Fundamental::of(&measurement.stamp, harmonic?))
    }

    /// Nothing: this image seeks no harmonics.
    #[cfg(not(image = "lines"))]
    pub fn fundamental(&self, _: &Measurement, _: u8) -> Option<Fundamental> {
        None
    }

    /// Nothing: this image reports one tone of a block.
    #[cfg(not(image = "lines"))]
    pub fn lines(&self, _: &Measurement, _: u8) -> Option<Lines> {
        None
    }

    /// Nothing: this image does not follow tones.
    #[cfg(not(image = "tracking"))]
    pub fn followed(&self, _: &Stamp) -> Option<Follow> {
        None
    }
}
