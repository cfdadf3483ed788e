//! What `bench` counts, with the 16-bit engine.
#![no_std]
#![no_main]

mod equality;
mod stages;

use cortex_m_rt::entry;
use picket::board::mps2::handlers;
use picket::spectrum::engine::Q15;

picket::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    stages::play::<Q15>()
}
