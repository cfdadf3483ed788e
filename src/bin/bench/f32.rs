//! What `bench` counts, with the float engine.
#![no_std]
#![no_main]

mod equality;
mod stages;

use cortex_m_rt::entry;
use picket::acquire::capture::for_record;
use picket::board::halt::{Exit, exit};
use picket::board::mps2::handlers;
use picket::spectrum::engine::F32;
use stages::Stages;

picket::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    let stages = Stages::<F32>::open();
    let (iq, n) = stages.kind();
    for_record(iq, n, stages);
    exit(Exit::Done)
}
