//! Measures blocks: by the pipeline, or, in an image that follows tones, by the tracker around it.

use crate::slot::Slot;
use heapless::Vec;
use picket::acquire::frontend::Block;
use picket::acquire::sample::{Iq, Real, Stamp};
#[cfg(not(feature = "tracking"))]
pub use picket::pipeline::Pipeline as Meter;
use picket::pipeline::{Alternating, Measurement};
use picket::plan::{EitherPlan, Plan};
use picket::tone::harmonic::Harmonic;
use picket::tone::lines::MOST;
use picket::tone::phasor::Phasor;
#[cfg(feature = "tracking")]
pub use picket::tracker::Tracker as Meter;
use picket_wire::follow::Follow;
use picket_wire::fundamental::Fundamental;
use picket_wire::lines::Lines;

/// Whether this image follows tones.
pub const FOLLOWS: bool = cfg!(feature = "tracking");

/// Whether this image reports more than one tone of a block.
pub const LINES: bool = cfg!(all(feature = "lines", not(feature = "tracking")));

/// Measures I/Q records: of pairs that two converters take at once, or that one takes by turns.
pub trait IqMeter<const N: usize>: 'static {
    /// Follows another plan from the next block on.
    fn adopt(&mut self, plan: Plan<Iq, N>);

    /// Measures a block, whose codes are the same again afterwards.
    fn block(&mut self, stamp: Stamp, pairs: &mut [[i16; 2]; N]) -> Measurement;

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

    #[cfg(feature = "tracking")]
    fn followed(&self, stamp: &Stamp) -> Option<Follow> {
        self.follows().then(|| Follow::of(self, stamp))
    }

    #[cfg(all(feature = "lines", not(feature = "tracking")))]
    fn lines(&self, measurement: &Measurement, most: usize) -> Vec<Phasor, MOST> {
        Meter::lines(self, measurement, most)
    }

    #[cfg(all(feature = "lines", not(feature = "tracking")))]
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
    /// The meter for this plan.
    pub fn new((real, iq): Meters<N, Q>, plan: &EitherPlan<N>) -> Self {
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

    /// Tracks and targets after a block, if the plan follows tones.
    #[cfg(feature = "tracking")]
    pub fn followed(&self, stamp: &Stamp) -> Option<Follow> {
        match self {
            Measurer::Real(tracker) => tracker.follows().then(|| Follow::of(tracker, stamp)),
            Measurer::Iq(meter) => meter.followed(stamp),
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
