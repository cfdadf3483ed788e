//! The meters of an image, with or without more than one tone of a block, and the memory for them.

use picket_dsp::acquire::sample::{Iq, Real};
#[cfg(not(any(image = "signals", image = "tracking", image = "lines")))]
pub use picket_dsp::pipeline::Pipeline as Meter;
#[cfg(image = "tracking")]
pub use picket_dsp::tracker::Tracker as Meter;
#[cfg(image = "signals")]
pub use picket_instrument::gatherer::Gatherer as Meter;
#[cfg(image = "lines")]
pub use picket_instrument::meter::Several as Meter;

/// A meter for each kind of record, in static memory: built at run time, the meters would pass over the stack.
pub type Meters<const N: usize, Q = Meter<Iq, N>> =
    picket_instrument::meter::Meters<'static, Meter<Real, N>, Q>;

/// The meters of an image whose blocks have this many samples, in static memory; `None` at the
/// second call. A board that takes the pairs of an I/Q record by turns names their meter, too.
#[macro_export]
macro_rules! meters {
    ($n:expr) => {
        $crate::meters!(
            $n,
            $crate::instrument::meter::Meter<picket_dsp::acquire::sample::Iq, { $n }>,
            $crate::instrument::meter::Meter::new(picket_dsp::plan::Plan::IDLE)
        )
    };
    ($n:expr, $iq:ty, $idle:expr) => {{
        use picket_dsp::acquire::sample::Real;
        use picket_dsp::plan::Plan;
        use $crate::instrument::meter::Meter;
        static REAL: static_cell::ConstStaticCell<Meter<Real, { $n }>> =
            static_cell::ConstStaticCell::new(Meter::new(Plan::IDLE));
        static IQ: static_cell::ConstStaticCell<$iq> = static_cell::ConstStaticCell::new($idle);
        REAL.try_take().zip(IQ.try_take())
    }};
}
