//! What measures a block: the pipeline, or, in an image built to follow tones, the tracker around it.

use super::N;
use super::converter::Slot;
use crate::acquire::frontend::Block;
use crate::acquire::sample::{Iq, Real, Stamp};
use crate::control::settings::Instrument as Plan;
use crate::pipeline::Measurement;
#[cfg(not(feature = "tracking"))]
use crate::pipeline::Pipeline as Meter;
use crate::report::follow::Follow;
#[cfg(feature = "tracking")]
use crate::tracker::Tracker as Meter;
use static_cell::ConstStaticCell;

/// One for the kind of record in use.
pub enum Measurer {
    /// One converter's.
    Real(&'static mut Meter<Real, N>),
    /// Two converters'.
    Iq(&'static mut Meter<Iq, N>),
}

impl Measurer {
    /// Whether this image follows tones.
    pub const FOLLOWS: bool = cfg!(feature = "tracking");

    /// The one for these settings. Both are filled before the program runs: built here, they would pass over the stack.
    pub fn take(plan: &Plan) -> Option<Self> {
        const IDLE: crate::config::Plan = crate::config::Plan::IDLE;
        static REAL: ConstStaticCell<Meter<Real, N>> = ConstStaticCell::new(Meter::new(IDLE));
        static IQ: ConstStaticCell<Meter<Iq, N>> = ConstStaticCell::new(Meter::new(IDLE));
        let (real, iq) = (REAL.try_take()?, IQ.try_take()?);
        real.adopt(plan.plan);
        iq.adopt(plan.plan);
        Some(if plan.settings.iq { Measurer::Iq(iq) } else { Measurer::Real(real) })
    }

    /// Measures a block behind its guard.
    pub fn block(&mut self, block: &Block<Slot>, guard: u16) -> Measurement {
        match self {
            Measurer::Real(meter) => meter.block(block.stamp, block.slot.samples::<Real>(guard)),
            Measurer::Iq(meter) => meter.block(block.stamp, block.slot.samples::<Iq>(guard)),
        }
    }

    /// What is followed after a block, where that is asked for.
    #[cfg(feature = "tracking")]
    pub fn followed(&self, stamp: &Stamp) -> Option<Follow> {
        match self {
            Measurer::Real(tracker) => tracker.follows().then(|| tracker.follow(stamp)),
            Measurer::Iq(tracker) => tracker.follows().then(|| tracker.follow(stamp)),
        }
    }

    /// Nothing is.
    #[cfg(not(feature = "tracking"))]
    pub fn followed(&self, _: &Stamp) -> Option<Follow> {
        None
    }
}
