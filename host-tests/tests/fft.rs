//! The integer FFT against float64, and at its extremes.

use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Iq, Real, Record};
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::engine::{Engine, I32};
use picket_dsp::spectrum::peak::{Band, find, find_portably};
use picket_transform::{Transform, num_complex::Complex};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The exact transform of a record, in codes.
fn exact<R: Record>(samples: &[R::Sample]) -> Vec<Complex<f64>> {
    let mut x: Vec<Complex<f64>> = samples
        .iter()
        .map(|&s| R::parts(s))
        .map(|[i, q]| Complex::new(i.into(), q.into()))
        .collect();
    f64::forward(x.len()).process(&mut x);
    x
}

/// The largest error of any part over all bins, in stored units, and the SNR in dB over bins 1..N/2-1
/// (real) or all (I/Q).
pub fn compare_by<R: Record, const N: usize, E: Engine>(
    samples: &[R::Sample; N],
    codes: Codes,
) -> (f64, f64) {
    let mut spectrum = Spectrum::<R, N, E>::new();
    spectrum.transform(samples, codes);
    let unit = f64::from(spectrum.exponent()).exp2();
    let (mut worst, mut signal, mut noise) = (0.0f64, 0.0, 0.0);
    for (k, x) in exact::<R>(samples).iter().take(spectrum.bins()).enumerate() {
        if k == 0 && E::CENTRED && codes == Codes::unsigned::<12>() {
            continue;
        }
        let got = spectrum.bin(k as i32);
        let error = Complex::new(f64::from(got.re) * unit, f64::from(got.im) * unit) - x;
        worst = worst.max(error.re.abs()).max(error.im.abs());
        if R::IQ || (k >= 1 && k < N / 2) {
            signal += x.norm_sqr();
            noise += error.norm_sqr();
        }
    }
    (worst / unit, 10.0 * (signal / noise).log10())
}

pub fn tone<const N: usize>(bins: f64, amplitude: f64, phase: f64) -> [i16; N] {
    std::array::from_fn(|n| {
        let angle = std::f64::consts::TAU * bins * n as f64 / N as f64 + phase;
        (amplitude * angle.cos()).round() as i16
    })
}

pub fn iq_tone<const N: usize>(bins: f64, amplitude: f64, phase: f64) -> [[i16; 2]; N] {
    let (i, q) = (
        tone::<N>(bins, amplitude, phase),
        tone::<N>(bins, amplitude, phase - std::f64::consts::FRAC_PI_2),
    );
    std::array::from_fn(|n| [i[n], q[n]])
}

/// Calls a check for every length.
#[macro_export]
macro_rules! each_length {
    ($check:ident) => {
        $check::<64>();
        $check::<128>();
        $check::<256>();
        $check::<512>();
        $check::<1024>();
        $check::<2048>();
        $check::<4096>();
    };
}

/// The least ratio of a tone to the error of an engine's transform in dB, N = 1024, wherever the tone is: real and I/Q.
pub fn least_ratios<E: Engine>(name: &str, amplitude: f64) -> [f64; 2] {
    let mut least = [f64::INFINITY; 2];
    for bin in [5.3, 64.0, 100.37, 255.5, 256.0, 300.2, 505.1] {
        let samples = tone(bin, amplitude, 0.3);
        let (_, real) = compare_by::<Real, 1024, E>(&samples, Codes::signed::<12>());
        let pairs = iq_tone(bin, amplitude, 0.3);
        let (_, iq) = compare_by::<Iq, 1024, E>(&pairs, Codes::signed::<12>());
        println!("{name}, bin {bin}: real {real:.2} dB, I/Q {iq:.2} dB");
        least = [least[0].min(real), least[1].min(iq)];
    }
    least
}

#[test]
fn snr_against_float64() {
    for (name, amplitude) in [("full scale", 2047.0), ("-40 dBFS", 20.47)] {
        let least = least_ratios::<I32>(name, amplitude);
        assert!(least[0] >= 90.0 && least[1] >= 90.0, "{name}: {least:?}");
    }
}

/// Records that drive the sums as high as they go.
pub fn extremes<const N: usize>(codes: Codes) -> Vec<[i16; N]> {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (low, high) = codes.rails();
    let mut records: Vec<[i16; N]> = vec![
        [low; N],
        [high; N],
        std::array::from_fn(|n| if n % 2 == 0 { low } else { high }),
        std::array::from_fn(|n| if n % 4 < 2 { low } else { high }),
        std::array::from_fn(|n| if n == 0 { low } else { 0 }),
        std::array::from_fn(|n| if n == N - 1 { high } else { 0 }),
    ];
    for period in [3, 6, 8, 10, 16, 32, 64, N / 3, N / 2] {
        records.push(std::array::from_fn(|n| if n % period < period / 2 { low } else { high }));
    }
    // The record that lines up every term of one part of one bin.
    for bin in [1, 2, 3, 5, N / 8, N / 8 + 1, N / 4 - 1, N / 4, N / 3, N / 2 - 1] {
        for quarter in 0..8 {
            let phase = f64::from(quarter) * std::f64::consts::FRAC_PI_4;
            records.push(std::array::from_fn(|n| {
                let angle = std::f64::consts::TAU * (bin * n) as f64 / N as f64 + phase;
                if angle.cos() > 0.0 { high } else { low }
            }));
        }
    }
    for _ in 0..20 {
        records.push(std::array::from_fn(|_| rng.random_range(low..=high)));
        records.push(std::array::from_fn(|_| if rng.random() { low } else { high }));
    }
    records
}

/// Every extreme as a real record, and with others as an I/Q record; the worst error of any part, in stored units.
pub fn worst_by<const N: usize, E: Engine>(codes: Codes) -> f64 {
    let records = extremes::<N>(codes);
    let (low, high) = codes.rails();
    let mut worst = 0.0f64;
    for (index, i) in records.iter().enumerate() {
        worst = worst.max(compare_by::<Real, N, E>(i, codes).0);
        let others =
            [i, &records[(index * 7 + 3) % records.len()], &i.map(|x| (-1 - x).clamp(low, high))];
        for q in others {
            let pairs = std::array::from_fn(|n| [i[n], q[n]]);
            worst = worst.max(compare_by::<Iq, N, E>(&pairs, codes).0);
        }
    }
    worst
}

/// A wrapped sum would be off by 2^32 stored units; the allowed error is that of Q15 factors on a full-scale spectrum.
fn check_extremes<const N: usize>() {
    for codes in [Codes::signed::<12>(), Codes::signed::<16>(), Codes::unsigned::<12>()] {
        let (worst, allowed) = (worst_by::<N, I32>(codes), 2f64.powi(31) * 6e-5 + 8.0);
        assert!(worst < allowed, "{N} {codes:?}: {worst}");
    }
}

#[test]
fn no_extreme_overflows() {
    println!("seed 7");
    each_length!(check_extremes);
}

/// Every part of a short spectrum, and of longer ones many, as bin by bin.
fn check_parts<const N: usize>() {
    let step = N / 64;
    for samples in extremes::<N>(Codes::signed::<12>()) {
        let mut spectrum = Spectrum::<Real, N>::new();
        spectrum.transform(&samples, Codes::signed::<12>());
        let last = N as i32 / 2 - 1;
        for low in (1..=last).step_by(step) {
            for high in (low..=last).step_by(step) {
                let band = Band::new(low, high);
                assert_eq!(
                    find(&spectrum.view(), band),
                    find_portably(&spectrum.view(), band),
                    "{N} {band:?}"
                );
            }
        }
    }
}

#[test]
fn a_part_is_searched_as_bin_by_bin() {
    check_parts::<64>();
    check_parts::<128>();
    check_parts::<1024>();
}
