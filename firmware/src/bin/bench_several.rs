//! Counts the instructions of a block's further tones. The image sends every tone that it finds, for comparison with other machines. The
//! solvers of tones are called as well, so that the linker proves them free of panics.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use picket_dsp::acquire::sample::Real;
use picket_dsp::pipeline::{Measurement, Outcome, Pipeline};
use picket_dsp::solve::chirp::Mixing;
use picket_dsp::solve::displacement::{Between, Unwrapper};
use picket_dsp::solve::equations::Equations;
use picket_dsp::solve::pairing::{MotionModel, Pairing};
use picket_dsp::tone::lines::MOST;
use picket_firmware::mps2::count::count;
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::playback::{Playback, fail, send};
use picket_firmware::mps2::{Timer, handlers};
use picket_wire::capture::decode;
use picket_wire::telemetry::Health;

picket_firmware::vectors!(handlers(&[]));

/// Samples in a block.
const N: usize = 1024;

#[entry]
fn main() -> ! {
    let mut playback = Playback::open();
    let header = playback.header;
    if header.iq || header.n as usize != N {
        fail(Exit::Config, "this image takes real records of 1024 samples");
    }
    Timer::ONE.run_free();
    let plan = playback.plan::<Real, N>();
    let mut pipeline = Pipeline::<Real, N>::new(plan);
    let mut unwrapper =
        Unwrapper::new(black_box(1e-3), Mixing::TxConjRx, black_box(Between::Frequency));
    let habits = MotionModel { period_s: 0.05, acceleration: 10.0 };
    let mut pairing = Pairing::new(Equations::default(), black_box(false), habits);
    let (mut bytes, mut samples) = ([0; 2 * N], [0; N]);
    for sequence in 0..header.blocks {
        playback.read(&mut bytes);
        decode::<Real>(&bytes, &mut samples);
        let stamp = header.timing().stamp(sequence.into(), false);
        let measurement = count("whole", || pipeline.block(&stamp, black_box(&samples)));
        count("phase", || pipeline.lines(&measurement, 1));
        let lines = count("lines", || pipeline.lines(&measurement, MOST));
        count("fundamental", || pipeline.harmonic(&measurement, 8));
        count("targets", || pairing.push(&black_box(stamp), &lines));
        for phasor in &lines {
            black_box(unwrapper.as_mut().map(|unwrapper| unwrapper.push(&stamp, phasor)));
            let each = Measurement { tone: phasor.tone, result: Outcome::None, ..measurement };
            send(each, plan.options.method, Health::default());
        }
    }
    exit(Exit::Done)
}
