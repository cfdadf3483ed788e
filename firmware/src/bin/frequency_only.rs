//! The smallest image of all: the frequency of real records of 1,024 samples, without a verdict. `single` is the smallest image that says
//! whether its answers may be used; `cargo lab bench` states the sizes of both.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Real;
use picket_dsp::pipeline::FrequencyOnly;
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::handlers;
use static_cell::ConstStaticCell;

picket_firmware::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    // The memory is all zeros before the program runs, so the program file does not hold it.
    static ONLY: ConstStaticCell<FrequencyOnly<Real, 1024>> =
        ConstStaticCell::new(FrequencyOnly::new());
    static SAMPLES: ConstStaticCell<[i16; 1024]> = ConstStaticCell::new([0; 1024]);
    if let Some((only, samples)) = ONLY.try_take().zip(SAMPLES.try_take()) {
        black_box(only.block(black_box(samples), Codes::signed::<12>()));
    }
    exit(Exit::Done)
}
