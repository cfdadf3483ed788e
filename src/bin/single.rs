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
    // All zeros before the program runs, and so no part of it.
    static mut PIPELINE: Pipeline<Real, 1024> = Pipeline::new(Plan::IDLE);
    static mut SAMPLES: [i16; 1024] = [0; 1024];
    PIPELINE.adopt(const { Plan::tone::<Real>(1024) });
    black_box(PIPELINE.tone(&Stamp::default(), black_box(SAMPLES)));
    exit(Exit::Done)
}
