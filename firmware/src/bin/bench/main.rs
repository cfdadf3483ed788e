//! Counts instructions: of every stage of a measurement of the capture's blocks and, with the feature `rivals`, of third-party transforms
//! of these blocks. It also compares the kernels with their definition, on the capture's blocks and on random ones.
//!
//! Two fields of the header have another meaning here: the period is the number of random blocks, the
//! stride their seed.
#![no_std]
#![no_main]

mod equality;
#[cfg(feature = "rivals")]
mod rivals;
mod stages;

use cortex_m_rt::entry;
use picket_dsp::acquire::kind::for_record;
use picket_dsp::spectrum::engine::I32;
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::handlers;
use stages::Stages;

picket_firmware::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    let stages = Stages::<I32>::open();
    let (iq, n) = stages.kind();
    for_record(iq, n, stages);
    exit(Exit::Done)
}
