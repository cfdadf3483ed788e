//! Scenes in front of a radar, a lidar or a velocimeter, and the records that its converter takes of them.
//!
//! A [`Scene`] describes what is in front of the sensor, what the sensor transmits, and how a converter samples it; it is also a JSON file. A
//! [`Run`] of it has drawn what is random, and returns samples and the truth about them.
//!
//! What reflects delays the transmitter's phase by `tau = 2 R(t) / c`, where `R(t)` is the range in metres at the time `t` in seconds; the
//! phase of a sample is the integral of the transmitter's frequency from `t - tau` to `t`. Nothing here knows the frequency of a
//! beat, or a formula of the library: whoever solves the records cannot have put the solution into them.
//!
//! The same seed gives the same codes on every machine: the elementary functions are those of the crate `libm`.

mod change;
mod draw;
mod flow;
mod noise;
mod path;
mod random;
mod run;
pub mod scene;
mod value;
mod waveform;

pub use draw::Draw;
pub use flow::Passed;
pub use run::{Run, Truth};
pub use scene::Scene;
pub use value::Value;

#[cfg(feature = "json")]
impl Scene {
    /// A scene from its JSON.
    ///
    /// # Errors
    /// The text is no scene; the sentence says where.
    pub fn from_json(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }
}
