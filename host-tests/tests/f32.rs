//! The float engine: its error, its extremes, and its bits.

use crate::each_length;
use crate::fft::{least_ratios, worst_by};
use host_tests::prepare_images;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real, Record};
use picket_dsp::config::Config;
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::engine::F32;
use picket_host::emulator::Capture;
use picket_host::simulate::generator;
use picket_host::toolchain::Target;
use picket_lab::bench::{self, CORES, Core, FLOAT, Scope};
use picket_wire::capture::Header;
use rand::RngExt;
use std::path::Path;
use std::time::Duration;

#[test]
fn snr_against_float64() {
    // The weak tone's error is that of bins cut to integers, not the transform's.
    for (name, amplitude, bars) in
        [("full scale", 2047.0, [136.0; 2]), ("-40 dBFS", 20.47, [115.0, 112.0])]
    {
        let least = least_ratios::<F32>(name, amplitude);
        assert!(least.iter().zip(&bars).all(|(least, bar)| least >= bar), "{name}: {least:?}");
    }
}

/// Each of the transform's log2 N steps may round by 2^-24 of the largest sum, 2^31 units, some twice.
fn check_extremes<const N: usize>() {
    for codes in [Codes::signed::<12>(), Codes::signed::<16>(), Codes::unsigned::<12>()] {
        let worst = worst_by::<N, F32>(codes);
        println!("{N} {codes:?}: {worst:.1} stored units");
        assert!(worst < 2.0 * 128.0 * f64::from(N.ilog2()), "{N} {codes:?}: {worst}");
    }
}

#[test]
fn no_extreme_overflows() {
    println!("seed 7");
    each_length!(check_extremes);
}

/// Random records of every strength: their bins by the counting image, to the last bit.
fn check_bits<R: Record, const N: usize>(core: &Core, image: &Path) {
    const SEED: u64 = 1501;
    const BLOCKS: u64 = 8;
    let codes = [Codes::signed::<12>(), Codes::unsigned::<12>(), Codes::signed::<16>()]
        [N.ilog2() as usize % 3];
    let config = Config { codes, ..Config::new(1.0, Codes::signed::<12>()) };
    let header =
        Header { period_us: 0, ..Header::from_config::<R>(config, N as u32, BLOCKS as u32) };
    let (mut capture, mut spectrum) =
        (Capture::create(&header).unwrap(), Spectrum::<R, N, F32>::new());
    let (low, high) = codes.rails();
    let mut here: Vec<[f32; 2]> = Vec::new();
    for block in 0..BLOCKS {
        let mut rng = generator(SEED ^ N as u64, block);
        let (middle, span) = (codes.middle(), (i32::from(high) - i32::from(low)) >> block);
        let mut code = || {
            let code = i32::from(middle) + rng.random_range(-span / 2..=span / 2);
            code.clamp(low.into(), high.into()) as i16
        };
        let samples: [R::Sample; N] = std::array::from_fn(|_| R::from_parts([code(), code()]));
        capture.push::<R>(&samples).unwrap();
        spectrum.transform(&samples, codes);
        // The image writes so many, as floats, which these integers are.
        let bins = (0..N as i32 / 2).map(|k| spectrum.bin(k));
        here.extend(bins.map(|bin| [bin.re as f32, bin.im as f32]));
    }
    let outcome = capture.run(core.machine, image, Duration::from_secs(300), |_| {}).unwrap();
    let floats = outcome.results.as_chunks().0.iter().map(|&bytes| f32::from_le_bytes(bytes));
    let there: Vec<f32> = floats.collect();
    let same = here.as_flattened() == there;
    println!("{}, {codes:?}, N = {N}, I/Q {}, seed {SEED}: same bins {same}", core.name, R::IQ);
    assert!(same, "{}, N = {N}", core.name);
}

#[test]
#[ignore = "needs an image of the float engine: cargo test --test all -- --ignored"]
fn emulated_cores_give_the_same_bits() {
    for core in CORES.iter().filter(|core| core.target == Target::M4f) {
        prepare_images(core.target);
        let image = bench::image(core, &FLOAT, Scope::Ours).unwrap();
        check_bits::<Real, 64>(core, &image);
        check_bits::<Real, 256>(core, &image);
        check_bits::<Real, 1024>(core, &image);
        check_bits::<Real, 4096>(core, &image);
        check_bits::<Iq, 128>(core, &image);
        check_bits::<Iq, 512>(core, &image);
        check_bits::<Iq, 4096>(core, &image);
    }
}
