//! The float engine: its error, its extremes, and the tones found with it.

use crate::each_length;
use crate::fft::{least_ratios, worst_by};
use crate::signal::{Kind, anywhere, error, mean, measure_by, rng, trials};
use crate::trust::noise_and_sigma_by;
use host_tests::prepare_images;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::config::Config;
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::engine::F32;
use picket_dsp::tone::Verdict;
use picket_host::emulator::Capture;
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

/// What [`found`] saw of many tones.
struct Found {
    /// The mean of `(error / sigma)^2`.
    square: f64,
    /// The share with a good verdict.
    good: f64,
    /// The largest error in bins.
    worst: f64,
}

/// Tones in noise of half a code, at full scale and 40 dB below.
fn found<R: Kind, const N: usize>(name: &str, amplitude: f64) -> Found {
    const SEED: u64 = 1500;
    let seen = trials(SEED, 1000, |rng| {
        let line = anywhere::<R, N>(rng, amplitude);
        let tone = measure_by::<R, N, F32>(&R::record::<N>(rng, &[line], 0.5));
        let verdict = matches!(tone.verdict, Verdict::Good | Verdict::NearEdge);
        (error::<R, N>(&tone, line.bins), f64::from(tone.sigma) * N as f64, verdict)
    });
    let square = mean(seen.iter().map(|t| (t.0 / t.1).powi(2)));
    let worst = seen.iter().map(|t| t.0.abs()).fold(0.0, f64::max);
    let good = mean(seen.iter().map(|t| f64::from(t.2)));
    let sigma = mean(seen.iter().map(|t| t.1));
    println!(
        "{name}, {N}, seed {SEED}: (error/sigma)^2 {square:.3}, sigma {sigma:.1e} bins, good {good:.3}, worst {worst:.1e}"
    );
    Found { square, good, worst }
}

/// Each is found where it is, and sigma holds for its errors.
fn check_sigma<R: Kind, const N: usize>(name: &str, amplitude: f64) {
    let Found { square, good, worst } = found::<R, N>(name, amplitude);
    assert!(good > 0.99 && worst < 0.01 && (0.88..=1.15).contains(&square), "{name}");
}

#[test]
fn tones_are_found_with_the_right_sigma() {
    for (name, amplitude) in [("0 dBFS", 2044.0), ("-40 dBFS", 20.47)] {
        check_sigma::<Real, 256>(name, amplitude);
        check_sigma::<Real, 1024>(name, amplitude);
        check_sigma::<Real, 4096>(name, amplitude);
        check_sigma::<Iq, 256>(name, amplitude);
        check_sigma::<Iq, 1024>(name, amplitude);
    }
}

/// As the default engine's, in `trust`: no bias of the noise, and sigma right. Long records have the noise from second differences
/// of the bins, short ones from the bins themselves.
#[test]
fn noise_and_sigma_are_right() {
    for snr_db in [10.0, 30.0, 60.0] {
        noise_and_sigma_by::<Real, 256, F32>(None, snr_db);
        noise_and_sigma_by::<Real, 1024, F32>(None, snr_db);
        noise_and_sigma_by::<Real, 4096, F32>(None, snr_db);
        noise_and_sigma_by::<Iq, 256, F32>(None, snr_db);
        noise_and_sigma_by::<Iq, 1024, F32>(None, snr_db);
    }
    // From 2 dB above the threshold, and noise below a code.
    noise_and_sigma_by::<Real, 1024, F32>(None, -8.4);
    noise_and_sigma_by::<Real, 4096, F32>(None, -14.2);
    noise_and_sigma_by::<Real, 1024, F32>(Some(0.3), 60.0);
    noise_and_sigma_by::<Real, 1024, F32>(Some(0.3), 10.0);
}

/// Random records of every strength: their bins by the counting image, to the last bit.
fn check_bits<R: Kind, const N: usize>(core: &Core, image: &Path) {
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
        let mut rng = rng(SEED ^ N as u64, block);
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
