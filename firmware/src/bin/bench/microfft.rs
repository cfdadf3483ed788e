//! Counts the instructions in which microfft's transform finds a tone: the transform, the largest bin, and Jacobsen's interpolation of the
//! three bins there (E. Jacobsen and P. Kootsookos, "Fast, Accurate Frequency Estimators", IEEE Signal Processing Magazine 24(3), 2007).
//! The bin and the offset from it are the results.
//!
//! The crate may panic, so this image is not part of the proof that no panic is reachable.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use microfft::{Complex32, real};
use picket_dsp::acquire::sample::Real;
use picket_dsp::spectrum::fft::twiddle::MAX_LENGTH;
use picket_firmware::mps2::count::count;
use picket_firmware::mps2::halt::{Exit, exit};
use picket_firmware::mps2::playback::{Playback, Results, fail};
use picket_firmware::mps2::{Timer, handlers};
use picket_wire::capture::decode;

picket_firmware::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    let playback = Playback::open();
    Timer::ONE.run_free();
    match playback.header.n {
        64 => run::<64>(playback, |input| real::rfft_64(input)),
        128 => run::<128>(playback, |input| real::rfft_128(input)),
        256 => run::<256>(playback, |input| real::rfft_256(input)),
        512 => run::<512>(playback, |input| real::rfft_512(input)),
        1024 => run::<1024>(playback, |input| real::rfft_1024(input)),
        2048 => run::<2048>(playback, |input| real::rfft_2048(input)),
        4096 => run::<4096>(playback, |input| real::rfft_4096(input)),
        _ => fail(Exit::Config, "this image takes records of 64, 128, ... 4096 samples"),
    }
    exit(Exit::Done)
}

#[inline(never)]
fn run<const N: usize>(
    mut playback: Playback,
    transform: impl for<'a> Fn(&'a mut [f32; N]) -> &'a mut [Complex32],
) {
    let mut bytes = [0; 2 * MAX_LENGTH];
    let mut samples = [0i16; N];
    let mut results = Results::open();
    for _ in 0..playback.header.blocks {
        if let Some(bytes) = bytes.get_mut(..2 * N) {
            playback.read(bytes);
            decode::<Real>(bytes, &mut samples);
        }
        let mut input = black_box(samples.map(f32::from));
        let (bin, offset) = count("frequency", || {
            let spectrum = transform(&mut input);
            let bin = strongest(spectrum);
            (bin, offset(spectrum, bin))
        });
        results.write([bin as f32, offset]);
    }
}

/// The strongest bin. The first one holds DC and half the rate.
fn strongest(spectrum: &[Complex32]) -> usize {
    let (mut strongest, mut most) = (0, 0.0);
    for (bin, x) in spectrum.iter().enumerate().skip(1) {
        let power = x.norm_sqr();
        if power > most {
            (strongest, most) = (bin, power);
        }
    }
    strongest
}

/// The tone's distance above this bin, in bins.
fn offset(spectrum: &[Complex32], bin: usize) -> f32 {
    let Some(&[below, here, above]) =
        spectrum.get(bin.saturating_sub(1)..).and_then(<[_]>::first_chunk)
    else {
        return 0.0;
    };
    let bend = here + here - below - above;
    ((below - above) * bend.conj()).re / bend.norm_sqr()
}
