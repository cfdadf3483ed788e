//! The memory of an image's meters.

pub use picket_instrument::every::Every;
pub use picket_instrument::meter::Meters;

/// The meters of an image in static memory, for real and for I/Q records: built at run time, they would pass over the stack. `None` at the
/// second call.
#[macro_export]
macro_rules! meters {
    ($real:ty, $iq:ty) => {{
        use $crate::instrument::meter::Meters;
        static METERS: static_cell::ConstStaticCell<Meters<$real, $iq>> =
            static_cell::ConstStaticCell::new(Meters::<$real, $iq>::IDLE);
        METERS.try_take()
    }};
}
