//! Transform and search of the integer engine, for every length: compares the kernels with their definition, on the M55 under interrupts,
//! too, and counts them. The image builds in a tenth of the time of `bench`.
//!
//! Like `bench`, it reads the number of random blocks from the header's period, and their seed from its stride.
#![no_std]
#![no_main]

mod equality;
#[cfg(an547)]
mod interrupted;

use core::hint::black_box;
use cortex_m_rt::entry;
use equality::Equality;
use picket_dsp::acquire::kind::{ForRecord, for_record};
use picket_dsp::acquire::sample::Record;
use picket_dsp::plan::Plan;
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::engine::I32;
use picket_dsp::spectrum::fft::twiddle::MAX_LENGTH;
use picket_dsp::spectrum::peak;
use picket_firmware::mps2::count::count;
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::playback::Playback;
use picket_firmware::mps2::{Timer, Uart, figure, handlers};
use picket_wire::capture::decode;

picket_firmware::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    let playback = Playback::open();
    Timer::ONE.run_free();
    let (iq, n) = (playback.header.iq, playback.header.n as usize);
    for_record(iq, n, Kernels(playback));
    exit(Exit::Done)
}

/// This number of blocks is compared in everything.
const WHOLE: u32 = 2_000;

struct Kernels(Playback);

/// Counts the transform of a block, the search for its peak, and both.
fn count_stages<R: Record, const N: usize>(
    spectrum: &mut Spectrum<R, N, I32>,
    samples: &[R::Sample; N],
    plan: &Plan<R, N>,
) {
    count("fft", || spectrum.transform(samples, plan.codes));
    count("peak", || peak::find(&spectrum.view(), plan.band));
    count("fft_peak", || {
        spectrum.transform(samples, plan.codes);
        peak::find(&spectrum.view(), plan.band)
    });
}

impl ForRecord for Kernels {
    type Output = ();

    #[inline(never)]
    fn run<R: Record, const N: usize>(self) {
        let Kernels(mut playback) = self;
        let header = playback.header;
        let plan = playback.plan::<R, N>();
        let mut spectrum = Spectrum::<R, N, I32>::new();
        let mut equality = Equality::<R, N, I32>::default();
        let mut bytes = [0; 4 * MAX_LENGTH];
        let mut samples = [R::Sample::default(); N];
        for _ in 0..header.blocks {
            if let Some(bytes) = bytes.get_mut(..header.block_bytes()) {
                playback.read(bytes);
                decode::<R>(bytes, &mut samples);
            }
            let samples = black_box(&samples);
            count_stages(&mut spectrum, samples, &plan);
            equality.compare(samples, plan.codes);
        }
        equality.whole = WHOLE;
        equality.drive(header.period_us, header.stride);
        #[cfg(an547)]
        if !R::IQ && N == 1024 {
            let (interrupts, unequal) = interrupted::drive();
            figure(Uart::ONE, "interrupts", interrupts.into());
            figure(Uart::ONE, "unequal", unequal.into());
        }
        equality.report();
    }
}
