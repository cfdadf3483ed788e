//! The library without a front end. It measures a capture block by block, for comparison with other
//! machines: records of four kinds, or of all fourteen with the feature `every-kind`.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use picket_dsp::acquire::kind::ForRecord;
#[cfg(feature = "every-kind")]
use picket_dsp::acquire::kind::for_record;
use picket_dsp::acquire::sample::Record;
#[cfg(not(feature = "every-kind"))]
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::pipeline::Pipeline;
use picket_dsp::spectrum::fft::twiddle::MAX_LENGTH;
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::playback::{Playback, send};
use picket_firmware::mps2::{Timer, Uart, figure, handlers};
use picket_wire::capture::decode;
use picket_wire::telemetry::Health;

picket_firmware::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    let playback = Playback::open();
    let (iq, n) = (playback.header.iq, playback.header.n as usize);
    let check = Check(playback);
    #[cfg(feature = "every-kind")]
    for_record(iq, n, check);
    // The shortest record and the usual one, I/Q, and the longest.
    #[cfg(not(feature = "every-kind"))]
    match (iq, n) {
        (false, 64) => check.run::<Real, 64>(),
        (false, 1024) => check.run::<Real, 1024>(),
        (true, 256) => check.run::<Iq, 256>(),
        (true, 4096) => check.run::<Iq, 4096>(),
        _ => exit(Exit::Capture),
    }
    exit(Exit::Done)
}

struct Check(Playback);

impl ForRecord for Check {
    type Output = ();

    #[inline(never)]
    fn run<R: Record, const N: usize>(self) {
        let Check(mut playback) = self;
        let header = playback.header;
        let plan = playback.plan::<R, N>();
        let mut pipeline = Pipeline::<R, N>::new(plan);
        let mut bytes = [0; 4 * MAX_LENGTH];
        let mut samples = [R::Sample::default(); N];
        Timer::ONE.run_free();
        let mut ticks = 0u64;
        for sequence in 0..header.blocks {
            if let Some(bytes) = bytes.get_mut(..header.block_bytes()) {
                playback.read(bytes);
                decode::<R>(bytes, &mut samples);
            }
            let stamp = header.timing().stamp(sequence.into(), false);
            let start = Timer::ONE.elapsed();
            let measurement = pipeline.block(&stamp, &samples);
            let end = Timer::ONE.elapsed();
            ticks = ticks.saturating_add(end.wrapping_sub(start).into());
            send(measurement, plan.options.method, Health::default());
        }
        figure(Uart::ONE, "ticks", ticks);
        figure(Uart::ONE, "pipeline_bytes", size_of::<Pipeline<R, N>>() as u64);
    }
}
