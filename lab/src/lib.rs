//! The program `lab`, for developers: benchmarks on emulated cores, campaigns, the papers' figures.

#[macro_use]
extern crate picket_measure;

pub mod bench;
pub mod bits;
pub mod campaign;
pub mod cli;
pub mod docs;
pub mod exact;
pub mod firmware;
pub mod impair;
pub mod report;
pub mod schema;
pub mod soak;
pub mod sweep;

use picket_host::{board, demo, device, emulator, rates, toolchain};
use picket_measure::{
    analyze, arithmetic, end, estimator, output, plot, progress, recording, reference, scenario,
    simulate, trials,
};
