//! What `bench` counts, with the 16-bit engine.
#![no_std]
#![no_main]

mod equality;
mod stages;

use cortex_m_rt::entry;
use picket::acquire::capture::for_record;
use picket::board::halt::{Exit, exit};
use picket::board::mps2::{Timer, handlers};
use picket::board::playback::Playback;
use picket::spectrum::engine::Q15;
use stages::Stages;

picket::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    let playback = Playback::open();
    let (iq, n) = (playback.header.iq, playback.header.n as usize);
    Timer::ONE.run_free();
    for_record(iq, n, Stages::<Q15>::new(playback));
    exit(Exit::Done)
}
