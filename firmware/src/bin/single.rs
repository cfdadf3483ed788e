//! The smallest measurement with a verdict: real records of 1,024 samples and one default plan, without any choice at run time. The size of
//! this image is the cost to its user; `cargo lab bench` states it.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Real, Stamp};
use picket_dsp::pipeline::Pipeline;
use picket_dsp::plan::Plan;
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::handlers;
use static_cell::ConstStaticCell;

picket_firmware::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    // The memory is all zeros before the program runs, so the program file does not hold it.
    static PIPELINE: ConstStaticCell<Pipeline<Real, 1024>> =
        ConstStaticCell::new(Pipeline::new(Plan::IDLE));
    static SAMPLES: ConstStaticCell<[i16; 1024]> = ConstStaticCell::new([0; 1024]);
    if let Some((pipeline, samples)) = PIPELINE.try_take().zip(SAMPLES.try_take()) {
        pipeline.set_plan(const { Plan::tone(1.0, Codes::signed::<12>()) });
        black_box(pipeline.tone(&Stamp::default(), black_box(samples)));
    }
    exit(Exit::Done)
}
