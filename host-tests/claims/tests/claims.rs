//! The table of claims. `cargo test -p picket-claims -- --nocapture` prints it.

mod bursts;
mod chirps;
mod efforts;
mod faults;
mod field;
mod frames;
mod lines;
mod phases;
mod sums;
mod tones;
mod tracks;
