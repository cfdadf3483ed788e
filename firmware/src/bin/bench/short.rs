//! `bench` for real records of 1,024 samples alone, which builds in a tenth of the time.
#![no_std]
#![no_main]

mod equality;
mod stages;

use cortex_m_rt::entry;
use picket_dsp::acquire::kind::ForRecord;
use picket_dsp::acquire::sample::Real;
use picket_dsp::spectrum::engine::I32;
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::handlers;
use picket_firmware::mps2::playback::fail;
use stages::Stages;

picket_firmware::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    let stages = Stages::<I32>::open();
    if stages.kind() != (false, 1024) {
        fail(Exit::Config, "this image takes real records of 1024 samples");
    }
    stages.run::<Real, 1024>();
    exit(Exit::Done)
}
