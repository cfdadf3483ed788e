//! Measures blocks: by the pipeline, or, in an image that follows tones, by the tracker around it.

use crate::slot::Slot;
use picket::acquire::frontend::Block;
use picket::acquire::sample::{Iq, Real, Stamp};
use picket::pipeline::Measurement;
#[cfg(not(feature = "tracking"))]
pub use picket::pipeline::Pipeline as Meter;
use picket::plan::EitherPlan;
#[cfg(feature = "tracking")]
pub use picket::tracker::Tracker as Meter;
use picket_wire::follow::Follow;
use picket_wire::fundamental::Fundamental;
use picket_wire::lines::Lines;

/// Whether this image follows tones.
pub const FOLLOWS: bool = cfg!(feature = "tracking");

/// Whether this image reports more than one tone of a block.
pub const LINES: bool = cfg!(all(feature = "lines", not(feature = "tracking")));

/// A meter for each kind of record, in static memory: built at run time, they would pass over the
/// stack.
pub type Meters<const N: usize> = (&'static mut Meter<Real, N>, &'static mut Meter<Iq, N>);

/// The meters of an image whose blocks have this many samples, in static memory; `None` at the
/// second call.
#[macro_export]
macro_rules! meters {
    ($n:expr) => {{
        use picket::acquire::sample::{Iq, Real};
        use picket::plan::Plan;
        use $crate::instrument::measurer::Meter;
        static REAL: static_cell::ConstStaticCell<Meter<Real, { $n }>> =
            static_cell::ConstStaticCell::new(Meter::new(Plan::IDLE));
        static IQ: static_cell::ConstStaticCell<Meter<Iq, { $n }>> =
            static_cell::ConstStaticCell::new(Meter::new(Plan::IDLE));
        REAL.try_take().zip(IQ.try_take())
    }};
}

/// The meter for the kind of record in use.
pub enum Measurer<const N: usize> {
    /// For records of one converter.
    Real(&'static mut Meter<Real, N>),
    /// For records of two converters.
    Iq(&'static mut Meter<Iq, N>),
}

impl<const N: usize> Measurer<N> {
    /// The meter for this plan.
    pub fn new((real, iq): Meters<N>, plan: &EitherPlan<N>) -> Self {
        match plan {
            EitherPlan::Real(plan) => {
                real.adopt(*plan);
                Measurer::Real(real)
            }
            EitherPlan::Iq(plan) => {
                iq.adopt(*plan);
                Measurer::Iq(iq)
            }
        }
    }

    /// Measures a block without its guard.
    pub fn block<const WORDS: usize>(
        &mut self,
        block: &Block<Slot<WORDS>>,
        guard: u16,
    ) -> Measurement {
        match self {
            Measurer::Real(meter) => meter.block(block.stamp, block.slot.samples::<Real, N>(guard)),
            Measurer::Iq(meter) => meter.block(block.stamp, block.slot.samples::<Iq, N>(guard)),
        }
    }

    /// Tracks and targets after a block, if the plan follows tones.
    #[cfg(feature = "tracking")]
    pub fn followed(&self, stamp: &Stamp) -> Option<Follow> {
        match self {
            Measurer::Real(tracker) => tracker.follows().then(|| Follow::of(tracker, stamp)),
            Measurer::Iq(tracker) => tracker.follows().then(|| Follow::of(tracker, stamp)),
        }
    }

    /// All tones of the last block, if the settings ask for some beyond the first. The block is that of this
    /// measurement.
    #[cfg(all(feature = "lines", not(feature = "tracking")))]
    pub fn lines(&self, measurement: &Measurement, further: u8) -> Option<Lines> {
        let tones = |most: usize| match self {
            Measurer::Real(meter) => meter.lines(measurement, most),
            Measurer::Iq(meter) => meter.lines(measurement, most),
        };
        (further > 0).then(|| Lines::of(&measurement.stamp, tones(1 + usize::from(further))))
    }

    /// The fundamental of the last block's harmonics up to an order above 0. The block is that of this
    /// measurement.
    #[cfg(all(feature = "lines", not(feature = "tracking")))]
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
    #[cfg(not(all(feature = "lines", not(feature = "tracking"))))]
    pub fn fundamental(&self, _: &Measurement, _: u8) -> Option<Fundamental> {
        None
    }

    /// Nothing: this image reports one tone of a block.
    #[cfg(not(all(feature = "lines", not(feature = "tracking"))))]
    pub fn lines(&self, _: &Measurement, _: u8) -> Option<Lines> {
        None
    }

    /// Nothing: this image does not follow tones.
    #[cfg(not(feature = "tracking"))]
    pub fn followed(&self, _: &Stamp) -> Option<Follow> {
        None
    }
}
