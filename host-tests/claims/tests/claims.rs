//! The table of claims. `cargo test -p picket-claims -- --nocapture` prints it.

mod chirps;
mod lines;
mod sums;
mod tones;
mod tracks;
