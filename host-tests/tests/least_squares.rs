//! Least squares over FFT bins: against the golden vectors, its bias, and the Cramer-Rao bound in the
//! target's arithmetic.

use crate::vectors::{Case, golden};
use host_tests::sized;
use num_complex::Complex;
use picket_claims::bound::{self, Line};
use picket_claims::samples;
use picket_claims::scenes::{self, Kind, amplitude, deviation, tone, tones};
use picket_dsp::Codes;
use picket_dsp::acquire::sample::{Iq, Real, Record};
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::bins::{Bins, Rectangular};
use picket_dsp::spectrum::neighbourhood::{Neighbourhood, Places};
use picket_dsp::spectrum::peak::{self, Band};
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::fit::{FitStart, Reach, fit, fit_near, least_squares, least_squares_real};
use picket_dsp::tone::noise::ring;
use picket_simulator::Scene;
use picket_transform::Transform;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

const CODES: Codes = Codes::signed::<12>();

fn exact(samples: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let mut x = samples.to_vec();
    f64::forward(x.len()).process(&mut x);
    x
}

fn bins<R: Record>(x: &[Complex<f64>], peak: i32) -> Bins<f64, R, Rectangular> {
    Bins::gather(x.len(), peak, |k| x[k])
}

fn single<R: Record>(x: &[Complex<f64>], peak: i32) -> Bins<f32, R, Rectangular> {
    Bins::gather(x.len(), peak, |k| Complex::new(x[k].re as f32, x[k].im as f32))
}

/// A noise-free real tone.
fn pure(n: usize, f: f64, phase: f64) -> Vec<Complex<f64>> {
    (0..n).map(|i| Complex::new((TAU * f * i as f64 / n as f64 + phase).cos(), 0.0)).collect()
}

/// No bias without noise, anywhere between 1.5 bins from DC and from Nyquist.
#[test]
fn real_fit_is_exact() {
    let mut worst = [0.0f64; 2];
    for n in [64usize, 256, 1024, 4096] {
        for f in [1.5, 1.51, 1.9, 2.3, 3.0, 5.5, 17.49, n as f64 / 4.0 + 0.2, n as f64 / 2.0 - 1.5]
        {
            for phase in [0.0, 0.4, 1.2, 2.0, 2.9] {
                let x = exact(&pure(n, f, phase));
                let peak = (1..n / 2).max_by(|&a, &b| x[a].norm().total_cmp(&x[b].norm()));
                let peak = peak.unwrap() as i32;
                let d = fit::<f64, Real>(&bins(&x, peak), Reach::Eight, FitStart::Usual).unwrap();
                let error = (f64::from(peak) + d.offset - f).abs();
                worst[0] = worst[0].max(error);
                let amplitude = d.tone::<Real>(n);
                assert!(
                    (amplitude - Complex::from_polar(1.0, phase)).norm() < 1e-5,
                    "{n} {f} {phase}: {amplitude}"
                );
                if n >= 1024 {
                    let d = least_squares_real::<f32, 8>(&single(&x, peak));
                    let error = (f64::from(peak) + f64::from(d) - f).abs();
                    worst[1] = worst[1].max(error);
                }
            }
        }
    }
    println!("largest bias: f64 {:.2e} bin, f32 {:.2e} bin", worst[0], worst[1]);
    assert!(worst[0] < 1e-6 && worst[1] < 5e-6);
}

#[test]
fn iq_fit_is_exact() {
    let mut worst = [0.0f64; 2];
    for n in [64usize, 1024, 4096] {
        for f in [0.0, 0.3, 7.5, 20.0, 33.1, n as f64 - 0.8] {
            let x: Vec<_> = (0..n)
                .map(|i| Complex::from_polar(1.0, TAU * f * i as f64 / n as f64 + 0.7))
                .collect();
            let x = exact(&x);
            let peak = (0..n).max_by(|&a, &b| x[a].norm().total_cmp(&x[b].norm())).unwrap() as i32;
            let d = fit::<f64, Iq>(&bins(&x, peak), Reach::Sixteen, FitStart::Usual).unwrap();
            worst[0] = worst[0].max((f64::from(peak) + d.offset - f).abs());
            let amplitude = d.tone::<Iq>(n);
            assert!(
                (amplitude - Complex::from_polar(1.0, 0.7)).norm() < 1e-6,
                "{n} {f}: {amplitude} {d:?}"
            );
            let d = least_squares::<f32, 16>(&single(&x, peak));
            worst[1] = worst[1].max((f64::from(peak) + f64::from(d) - f).abs());
        }
    }
    println!("largest bias: f64 {:.2e} bin, f32 {:.2e} bin", worst[0], worst[1]);
    assert!(worst[0] < 1e-9 && worst[1] < 5e-6);
}

/// The reference starts from Candan's offset, without the image.
fn candan(x: &[Complex<f64>], peak: i32) -> f64 {
    let n = x.len() as f64;
    let e = TAU / 2.0 / n;
    let z = |i: i32| {
        x[(peak + i).rem_euclid(x.len() as i32) as usize] * Complex::cis(-e * f64::from(i))
    };
    let j = ((z(-1) - z(1)) / (z(0) * 2.0 * e.cos() - z(-1) - z(1))).re;
    (e.tan() * j).atan() / e
}

/// From the reference's start by the reference's number of steps, the reference's
/// result; from the own start, and in the target's arithmetic, within a small share of the bound.
#[test]
fn golden_vectors() {
    let golden = golden();
    for case in &golden.cases {
        if case.iq() {
            golden_case::<Iq>(case, "lsi");
        } else {
            golden_case::<Real>(case, "rlsi");
        }
    }
}

/// The offset of a complex tone whose bins leave the least power in the bins within `reach` of the peak, near `start`: where the power that a
/// tone explains is as large a little above as a little below.
fn least_residual(x: &[Complex<f64>], peak: i32, reach: i32, start: f64) -> f64 {
    const APART: f64 = 1e-5;
    let n = x.len() as f64;
    let explained = |d: f64| {
        let (mut product, mut power) = (Complex::new(0.0, 0.0), 0.0);
        for i in -reach..=reach {
            let away = d - f64::from(i);
            let size = (PI * away).sin() / (PI * away / n).sin();
            let line = Complex::from_polar(size, PI * away * (1.0 - 1.0 / n));
            product += line.conj() * x[(peak + i).rem_euclid(x.len() as i32) as usize];
            power += line.norm_sqr();
        }
        product.norm_sqr() / power
    };
    let (mut low, mut high) = (start - 0.1, start + 0.1);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if explained(middle + APART) > explained(middle - APART) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

fn golden_case<R: Record>(case: &Case, name: &str) {
    let samples: Vec<_> = (0..case.n)
        .map(|n| case.parts(n))
        .map(|[re, im]| Complex::new(re.into(), im.into()))
        .collect();
    let x = exact(&samples);
    let circle = |a: f64| (a + 0.5 * case.n as f64).rem_euclid(case.n as f64) - 0.5 * case.n as f64;
    let off = |d: f64, steps: &str| {
        let expected = case.expect_bins[&format!("{name}{steps}")].unwrap();
        circle(f64::from(case.km) + d - expected).abs()
    };
    let bins64 = bins::<R>(&x, case.km);
    let start = candan(&x, case.km);
    let by_steps =
        |reach, steps| fit::<f64, R>(&bins64, reach, FitStart::From(start, steps)).unwrap().offset;
    if R::IQ {
        // The reference's steps end a little beside the least squares, ours at them.
        for (reach, bins) in [(Reach::Sixteen, 16), (Reach::Eight, 8)] {
            let error = (by_steps(reach, 30) - least_residual(&x, case.km, bins, start)).abs();
            assert!(error < 1e-8, "{} {reach:?}: {error:e}", case.id);
        }
    } else {
        for (reach, steps, name) in
            [(Reach::Sixteen, 2, "16_2"), (Reach::Eight, 2, "8_2"), (Reach::Sixteen, 3, "16_3")]
        {
            let error = off(by_steps(reach, steps), name);
            assert!(error < 1e-9, "{} {name}: {error:e}", case.id);
        }
    }
    // Rounding is noise too; and the arithmetic of the target is asked for no more than 60 dB.
    let rounding = (1.0f64 / 12.0).sqrt();
    let sigma = deviation(case.amp, case.snr_db.unwrap_or(60.0)).max(rounding);
    let line = Line { bins: case.f_true, amplitude: case.amp, phase: case.phase };
    let bound = bound::tone::<R>(case.n, line, sigma);
    let bins32 = single::<R>(&x, case.km);
    let course = FitStart::From(start as f32, 2);
    let error = off(fit::<f32, R>(&bins32, Reach::Sixteen, course).unwrap().offset.into(), "16_2");
    assert!(error < 0.05 * bound, "{} f32: {:.3} bound", case.id, error / bound);
    let target = match case.n {
        64 => target_offset::<R, 64>(case),
        _ => target_offset::<R, 256>(case),
    };
    let error = off(target, "16_2");
    println!("{} {:?} {:.3}", case.id, case.snr_db, error / bound);
    assert!(error < 0.4 * bound, "{} target: {:.3} bound", case.id, error / bound);
}

fn target_offset<R: Record, const N: usize>(case: &Case) -> f64 {
    let mut spectrum = Spectrum::<R, N>::new();
    spectrum.transform(&case.samples::<R, N>(), CODES);
    fit::<f32, R>(&Bins::from_view(&spectrum.view(), case.km), Reach::Sixteen, FitStart::Usual)
        .unwrap()
        .offset
        .into()
}

/// The sums in integers against those in `f32`, on the same bins: offset in bounds, rms and worst, and
/// the largest relative differences of sigma and noise.
fn fixed_against_float<R: Record, const N: usize>(reach: Reach, snr_db: f64) {
    let scene = Scene { seed: 17, ..tone(Kind::of::<R>(), N, snr_db) };
    let one = |trial: u64| {
        let mut run = scene.run(trial).unwrap();
        let (samples, truth) = (samples::<R, N>(&mut run, 0), run.truth(0, 0.0, N));
        let phase = TAU * (truth.phase_turns - 0.5 * truth.frequency_hz);
        let line = Line { bins: truth.frequency_hz, amplitude: truth.amplitude, phase };
        let mut spectrum = Spectrum::<R, N>::new();
        spectrum.transform(&samples, CODES);
        let band = if R::IQ { Band::iq(N) } else { Band::real(N) };
        let peak = peak::find(&spectrum.view(), band).unwrap().bin;
        let mut places = Places::new();
        let near = Neighbourhood::read(&spectrum.view(), peak, &mut places);
        let [float, fixed] = [Arithmetic::Float, Arithmetic::Fixed]
            .map(|arithmetic| fit_near::<R>()(&near, arithmetic, reach, FitStart::Usual).unwrap());
        let bound = bound::tone::<R>(N, line, run.noise().hypot((1.0f64 / 12.0).sqrt()));
        let noise = [
            ring::beside(&near, &float, Arithmetic::Float).noise.power,
            ring::beside(&near, &fixed, Arithmetic::Fixed).noise.power,
        ];
        let away = |a: f32, b: f32| f64::from(a / b - 1.0).abs();
        (
            f64::from(fixed.offset - float.offset) / bound,
            away(fixed.information, float.information),
            away(fixed.residual, float.residual),
            away(noise[1], noise[0]),
        )
    };
    let seen: Vec<_> = (0..sized(200, 1000)).into_par_iter().map(one).collect();
    let rms = (seen.iter().map(|d| d.0 * d.0).sum::<f64>() / seen.len() as f64).sqrt();
    let worst = seen.iter().fold([0.0f64; 4], |w, d| {
        [w[0].max(d.0.abs()), w[1].max(d.1), w[2].max(d.2), w[3].max(d.3)]
    });
    let kind = if R::IQ { "I/Q" } else { "real" };
    println!(
        "{kind} N {N}, {reach:?}, {snr_db} dB, seed 17: fixed from float {rms:.4} x bound rms, {:.4} worst; \
         information {:.1e}, residual {:.1e}, noise {:.1e}",
        worst[0], worst[1], worst[2], worst[3]
    );
    assert!(rms < 0.03 && worst[0] < 0.1);
    assert!(worst[1] < 1e-4 && worst[2] < 5e-3 && worst[3] < 1e-3);
}

#[test]
fn fixed_sums_equal_float() {
    for snr_db in [5.0, 30.0, 60.0] {
        fixed_against_float::<Real, 64>(Reach::Sixteen, snr_db);
        fixed_against_float::<Real, 1024>(Reach::Eight, snr_db);
        fixed_against_float::<Real, 1024>(Reach::Sixteen, snr_db);
        fixed_against_float::<Real, 4096>(Reach::Sixteen, snr_db);
        fixed_against_float::<Iq, 64>(Reach::Sixteen, snr_db);
        fixed_against_float::<Iq, 1024>(Reach::Four, snr_db);
        fixed_against_float::<Iq, 4096>(Reach::Sixteen, snr_db);
    }
}

/// How far a tone of one frequency is off on average, in bounds and squared, less what noise leaves of so many records: each has
/// noise and a phase of its own.
fn offset_squared<R: Record, const N: usize>(seed: u64, records: u64) -> f64 {
    let kind = Kind::of::<R>();
    let drawn = Scene { seed, ..tone(kind, N, 60.0) };
    let (bins, amplitude) = (drawn.run(0).unwrap().truth(0, 0.0, N).frequency_hz, amplitude(60.0));
    let line = Line { bins, amplitude, phase: 0.7 };
    let noise = deviation(amplitude, 60.0);
    let bound = bound::tone::<R>(N, line, noise.hypot((1.0f64 / 12.0).sqrt()));
    let scene = Scene { seed, ..tones(kind, N, [scenes::line(bins, amplitude)], noise) };
    let mut spectrum = Spectrum::<R, N>::new();
    let band = if R::IQ { Band::iq(N) } else { Band::real(N) };
    let errors = (1..=records).map(|record| {
        spectrum.transform(&samples::<R, N>(&mut scene.run(record).unwrap(), 0), CODES);
        let peak = peak::find(&spectrum.view(), band).unwrap().bin;
        let fit = fit::<f32, R>(
            &Bins::from_view(&spectrum.view(), peak),
            Reach::Sixteen,
            FitStart::Usual,
        );
        let error = f64::from(peak) + f64::from(fit.unwrap().offset) - bins;
        let error = if R::IQ { error - (error / N as f64).round() * N as f64 } else { error };
        error / bound
    });
    let (sum, squares) = errors.fold((0.0, 0.0), |(sum, squares), e| (sum + e, squares + e * e));
    let n = records as f64;
    let mean = sum / n;
    mean * mean - (squares / n - mean * mean) / (n - 1.0)
}

/// What averaging does not remove: with factors of 16 bits anywhere on the way from the samples to the fitted bins it is .17 (real)
/// and .23 (I/Q) times the bound. The estimate of its square is good to .0013.
#[test]
fn long_records_have_no_offset_of_their_own() {
    fn check<R: Record>(seeds: std::ops::Range<u64>) {
        let count = seeds.end - seeds.start;
        let squares: Vec<_> = seeds
            .clone()
            .into_par_iter()
            .map(|seed| offset_squared::<R, 4096>(seed, 160))
            .collect();
        let rms = (squares.iter().sum::<f64>() / count as f64).max(0.0).sqrt();
        let kind = if R::IQ { "I/Q" } else { "real" };
        println!(
            "{kind} N 4096, 60 dB, {count} frequencies of seeds {seeds:?}: offset {rms:.3} x bound rms"
        );
        assert!(rms < 0.08);
    }
    check::<Real>(900..948);
    check::<Iq>(900..948);
}
