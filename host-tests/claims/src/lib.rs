//! What is claimed of Picket's answers, as a table: each [`Case`] is a scene, how it is measured, and what must come out.
//!
//! The scenes are those of `picket-simulator`, which knows no formula of the library. A claim on a share or on a mean of squares is
//! held to by the binomial or the chi-square distribution, at [`limit::RISK`]: a right library fails one case by chance in four
//! million. The seed of a case follows from its label, so that no two have the same noise; `PICKET_SEED=7` gives others, `PICKET_LONG=1` ten
//! times as many trials, `PICKET_CLAIM=text` only the cases whose label has this text.

pub mod bound;
mod case;
pub mod figures;
pub mod limit;
mod measure;
mod rows;
pub mod scenes;
mod seen;
mod table;
mod words;

pub use case::{Case, Engine, Path, Truths, told};
pub use limit::{Asked, Event};
pub use measure::samples;
pub use seen::{Seen, Trial};
pub use table::{hold, hold_together};
pub use words::ANYTHING;
