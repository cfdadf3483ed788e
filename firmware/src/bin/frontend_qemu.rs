//! The whole instrument on an emulated board: converter, DMA, interrupts, front end, pipeline, telemetry.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use picket_dsp::acquire::kind::{ForRecord, for_record};
use picket_dsp::acquire::sample::Record;
use picket_dsp::pipeline::Pipeline;
use picket_firmware::mps2::converter::Acquisition;
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::playback::{Playback, send};
use picket_firmware::mps2::{Uart, figure};
use picket_wire::telemetry::Health;

#[cfg(feature = "log")]
use defmt_semihosting as _;

picket_firmware::converter_vectors!();

/// Writes a log line, in images with the feature `log`. No interrupt logs.
macro_rules! info {
    ($($line:tt)*) => {
        #[cfg(feature = "log")]
        defmt::info!($($line)*);
    };
}

#[entry]
fn main() -> ! {
    let playback = Playback::open();
    let (iq, n) = (playback.header.iq, playback.header.n as usize);
    for_record(iq, n, Playthrough(playback));
    exit(Exit::Done)
}

struct Playthrough(Playback);

impl ForRecord for Playthrough {
    type Output = ();

    #[inline(never)]
    fn run<R: Record, const N: usize>(self) {
        let Playthrough(mut playback) = self;
        let plan = playback.plan::<R, N>();
        let method = plan.options.method;
        info!("{} blocks of {} samples, bins {}, {}", playback.header.blocks, N, plan.band, method);
        let mut pipeline = Pipeline::<R, N>::new(plan);
        let Some(mut acquisition) = Acquisition::new(&playback.header) else {
            exit(Exit::Stalled);
        };
        let (counters, interrupts) =
            acquisition.play::<R, N>(&mut playback, |stamp, counters, samples| {
                let measurement = pipeline.block(stamp, samples);
                if stamp.gap {
                    info!("a gap before block {}: {}", stamp.sequence, counters);
                }
                let health = Health { lost: counters.lost(), faults: counters.faults() };
                send(measurement, method, health);
            });
        for (name, value) in [
            ("blocks", counters.blocks),
            ("overruns", counters.overruns),
            ("lost", counters.lost()),
            ("faults", counters.faults()),
            ("conversions", interrupts.timer),
            ("transfers", interrupts.dma),
            ("pipeline_bytes", size_of::<Pipeline<R, N>>() as u32),
        ] {
            figure(Uart::ONE, name, value.into());
        }
        info!("end: {}", counters);
        if counters.filled() != playback.header.blocks {
            exit(Exit::Stalled);
        }
    }
}
