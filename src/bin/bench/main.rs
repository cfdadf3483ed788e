//! Counts instructions: every stage of a measurement of the capture's blocks, and, in an image with the feature
//! `rivals`, other people's transforms of the same blocks. Also compares the kernels with their
//! definition, on the capture's blocks and on random ones.
//!
//! The header's period, which has no other meaning here, is the number of random blocks.
#![no_std]
#![no_main]

mod equality;
#[cfg(feature = "rivals")]
mod rivals;
mod stages;

use cortex_m_rt::entry;
use picket::acquire::capture::{ForRecord, for_record};
use picket::acquire::sample::Real;
use picket::board::halt::{Exit, exit};
use picket::board::mps2::{Timer, handlers};
use picket::board::playback::Playback;
use picket::spectrum::engine::I32;
use stages::Stages;

picket::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    let playback = Playback::open();
    let (iq, n) = (playback.header.iq, playback.header.n as usize);
    Timer::ONE.run_free();
    let stages = Stages::<I32>::new(playback);
    if !cfg!(feature = "short") {
        for_record(iq, n, stages);
    } else if !iq && n == 1024 {
        stages.run::<Real, 1024>();
    }
    exit(Exit::Done)
}
