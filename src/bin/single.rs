//! The smallest measurement: real records of 1,024 samples, one default plan, nothing to choose at run time. What is left in
//! this image is what such a user's image pays for it; `cargo bench-target` states its size.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use picket::acquire::sample::{Real, Stamp};
use picket::board::halt::{Exit, exit};
use picket::board::mps2::handlers;
use picket::config::Plan;
use picket::pipeline::Pipeline;

picket::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    let mut pipeline = Pipeline::<Real, 1024>::new(const { Plan::tone::<Real>(1024) });
    let samples = black_box([0; 1024]);
    black_box(pipeline.tone(&Stamp::default(), &samples));
    exit(Exit::Done)
}
