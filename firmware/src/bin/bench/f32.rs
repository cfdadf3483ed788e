//! `bench` with the float engine.
#![no_std]
#![no_main]

mod equality;
mod stages;

use cortex_m_rt::entry;
use picket_dsp::acquire::kind::for_record;
use picket_dsp::spectrum::engine::F32;
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::handlers;
use stages::Stages;

picket_firmware::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    let stages = Stages::<F32>::open();
    let (iq, n) = stages.kind();
    for_record(iq, n, stages);
    exit(Exit::Done)
}
