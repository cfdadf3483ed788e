//! Records of a radar, a lidar or a velocimeter, computed from the phase of its transmitter.
//!
//! A [`Waveform`] is the transmitter's frequency over time. A [`Target`] delays its phase by `tau = 2 R(t) / c`, where `R(t)` is the
//! range in metres at the time `t` in seconds. A [`Receiver`] multiplies one signal by the conjugate of the other and
//! samples the product. The phase of a sample is the integral of the transmitter's frequency from `t - tau` to `t`. Nothing
//! here knows the frequency of a beat: whoever solves the records cannot have put the solution into them.
//!
//! The same seed gives the same records on every machine: the elementary functions are those of the crate `libm`.

mod fringes;
mod random;
mod receiver;
mod sensor;
mod target;
mod waveform;

pub use fringes::{Fringes, Particle};
pub use random::{Speckle, walk};
pub use receiver::Receiver;
pub use sensor::Sensor;
pub use target::Target;
pub use waveform::{Segment, Waveform};
