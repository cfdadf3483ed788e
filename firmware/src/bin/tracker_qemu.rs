//! The instrument with the tracker on an emulated board: `frontend_qemu` for real records of 1024 samples, with tracks of its measurements.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use picket_dsp::acquire::sample::Real;
use picket_dsp::tracker::Tracker;
use picket_firmware::mps2::converter::Acquisition;
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::playback::{Playback, fail, send};
use picket_firmware::mps2::{Uart, figure};
use picket_wire::follow::Follow;
use picket_wire::telemetry::Health;

picket_firmware::converter_vectors!();

/// Samples in a block.
const N: usize = 1024;

#[entry]
fn main() -> ! {
    let mut playback = Playback::open();
    if playback.header.iq || playback.header.n as usize != N {
        fail(Exit::Config, "this image follows real records of 1024 samples");
    }
    // The proof that no panic is reachable must find this one.
    #[cfg(feature = "deliberate-panic")]
    assert!(playback.header.blocks < 1_000_000, "a panic that can be reached");
    let plan = playback.plan::<Real, N>();
    let method = plan.options.method;
    let mut tracker = Tracker::<Real, N>::new(plan);
    let Some(mut acquisition) = Acquisition::new(&playback.header) else {
        exit(Exit::Stalled);
    };
    let (counters, _) = acquisition.play::<Real, N>(&mut playback, |stamp, counters, samples| {
        let measurement = tracker.block(stamp, samples);
        let health = Health { lost: counters.lost(), faults: counters.faults() };
        send(measurement, method, health);
        Uart::ZERO.send(&Follow::from_tracker(&tracker, stamp).to_frame());
    });
    figure(Uart::ONE, "tracker_bytes", size_of::<Tracker<Real, N>>() as u64);
    if counters.filled() != playback.header.blocks {
        exit(Exit::Stalled);
    }
    exit(Exit::Done)
}
