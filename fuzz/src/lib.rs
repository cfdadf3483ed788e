//! What random bytes are given to, and what must hold whatever they are. libFuzzer calls these
//! functions by `fuzz/run`, and a test gives them the kept corpus.

mod input;
pub mod instrument;
mod line;
mod measure;
mod paths;
mod recordings;

pub use instrument::instrument;
pub use line::{command, frame, message, settings};
pub use measure::{pipeline, tracker};
pub use paths::paths;
pub use recordings::{archive, csv, json, list, npy, raw, times, wav};

/// A target: its name, which is also its corpus's folder, and its body.
pub type Target = (&'static str, fn(&[u8]));

/// Every target.
pub const TARGETS: [Target; 16] = [
    ("frame", frame),
    ("message", message),
    ("command", command),
    ("settings", settings),
    ("pipeline", pipeline),
    ("tracker", tracker),
    ("instrument", instrument),
    ("paths", paths),
    ("wav", wav),
    ("npy", npy),
    ("raw", raw),
    ("csv", csv),
    ("list", list),
    ("times", times),
    ("archive", archive),
    ("json", json),
];
