//! Several tones of one record, each with sigma and phase, and nothing else taken for a tone. In the target's arithmetic.

use crate::signal::*;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::{Codes, Config, Iq, Measurement, Pipeline, Real, Stamp, Verdict};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::{PI, TAU};

const N: usize = 1024;

/// So many records, ten times as many in the long form.
fn records(count: u64) -> u64 {
    host_tests::sized(count, 10 * count)
}

fn lines<R: Kind>(samples: &[R::Sample; N], most: usize) -> (Measurement, Vec<ToneWithPhase>) {
    let plan = Config::new(1.0, Codes::signed::<12>()).plan::<R, N>().unwrap();
    let mut pipeline = Pipeline::<R, N>::new(plan);
    let measurement = pipeline.block(&Stamp::default(), samples);
    let lines = pipeline.lines(&measurement, most);
    (measurement, lines.into_iter().collect())
}

/// The phase of a line at sample N/2 less the measured one, radians.
fn phase_error(phasor: &ToneWithPhase, line: &Line) -> f64 {
    let true_phase = line.phase + PI * line.bins;
    (f64::from(phasor.phase) - true_phase + PI).rem_euclid(TAU) - PI
}

/// The bound of a phase, radians, for noise of `sigma` in each part.
fn phase_bound<R: Kind>(line: &Line, sigma: f64) -> f64 {
    let real = if R::IQ { 1.0 } else { 2.0 };
    (real / N as f64).sqrt() * sigma / line.amplitude
}

/// Whether a line may stand beside others: three bins from them, and from their mirror images in I/Q.
fn stands_apart<R: Kind>(bins: f64, others: &[Line]) -> bool {
    let circle = |x: f64| x.rem_euclid(N as f64).min((-x).rem_euclid(N as f64));
    others.iter().all(|other| {
        (other.bins - bins).abs() > 2.999 && (!R::IQ || circle(other.bins + bins) > 3.0)
    })
}

/// So many lines, the first the strongest: `spacing` bins from one to the next, or anywhere.
fn scene<R: Kind>(rng: &mut ChaCha8Rng, count: usize, spacing: Option<f64>) -> (Vec<Line>, f64) {
    let amplitude = 1900.0 / (1.0 + 4.0 * sigma(1.0, 40.0)) / count as f64;
    let end = if R::IQ { 1020.0 } else { 508.0 };
    loop {
        let first = rng.random_range(4.0..end - spacing.unwrap_or(0.0) * (count - 1) as f64);
        let mut lines: Vec<Line> = Vec::new();
        for index in 0..count {
            let bins = match spacing {
                Some(spacing) => first + spacing * index as f64,
                None => rng.random_range(4.0..end),
            };
            let level: f64 = if index == 0 { 0.0 } else { rng.random_range(-30.0..=0.0) };
            if stands_apart::<R>(bins, &lines) {
                let amplitude = amplitude * 10f64.powf(level / 20.0);
                lines.push(Line { bins, amplitude, phase: rng.random_range(0.0..TAU) });
            }
        }
        // I/Q tones near DC are disturbed by its offset.
        let clear = |line: &Line| !R::IQ || (4.0..1020.0).contains(&line.bins);
        if lines.len() == count && lines.iter().all(clear) {
            return (lines, sigma(amplitude, 40.0));
        }
    }
}

fn tones_reach_their_bounds<R: Kind>(count: usize, spacing: Option<f64>, seed: u64) {
    struct Seen {
        /// (error / bound)^2 and (error / sigma)^2 of frequency, then of phase.
        squares: Vec<[f64; 4]>,
        right: bool,
        others: usize,
        good: usize,
    }
    let seen = trials(seed, records(400), |rng| {
        let (mut left, noise) = scene::<R>(rng, count, spacing);
        let samples = R::record::<N>(rng, &left, noise);
        let noise = noise.hypot((1.0f64 / 12.0).sqrt());
        let (_, found) = lines::<R>(&samples, 4);
        let (mut squares, mut others, mut good) = (Vec::new(), 0, 0);
        for phasor in &found {
            let near = |line: &Line| error::<R, N>(&phasor.tone, line.bins).abs() < 0.7;
            let Some(at) = left.iter().position(near) else {
                others += 1;
                continue;
            };
            let line = left.remove(at);
            let (off, turned) =
                (error::<R, N>(&phasor.tone, line.bins), phase_error(phasor, &line));
            squares.push([
                (off / R::bound(N, line, noise)).powi(2),
                (off / (f64::from(phasor.tone.sigma) * N as f64)).powi(2),
                (turned / phase_bound::<R>(&line, noise)).powi(2),
                (turned / f64::from(phasor.sigma_phase)).powi(2),
            ]);
            good += usize::from(phasor.tone.verdict == Verdict::Good);
        }
        Seen { squares, right: left.is_empty() && others == 0, others, good }
    });
    let all: Vec<_> = seen.iter().flat_map(|seen| &seen.squares).collect();
    let [rms, trust, phase_rms, phase_trust] =
        [0, 1, 2, 3].map(|i| mean(all.iter().map(|squares| squares[i])));
    let (rms, phase_rms) = (rms.sqrt(), phase_rms.sqrt());
    let right = mean(seen.iter().map(|seen| f64::from(seen.right)));
    let others = mean(seen.iter().map(|seen| seen.others as f64));
    let good = seen.iter().map(|seen| seen.good).sum::<usize>() as f64 / all.len() as f64;
    println!(
        "{} {count} tones, {spacing:?} bins apart, seed {seed}: {rms:.3} x bound, (error/sigma)^2 {trust:.3}; phase \
         {phase_rms:.3} x, {phase_trust:.3}; right number {right:.4}, false {others:.5}, good {good:.4}",
        if R::IQ { "I/Q," } else { "real," }
    );
    // Two standard errors of a mean of squares.
    let error = 2.0 * (2.0 / all.len() as f64).sqrt();
    assert!(rms * (1.0 - 0.5 * error) <= 1.1);
    assert!(trust * (1.0 + error) >= 0.85 && trust * (1.0 - error) <= 1.15);
    assert!(phase_rms * (1.0 - 0.5 * error) <= 1.1);
    assert!(phase_trust * (1.0 + error) >= 0.85 && phase_trust * (1.0 - error) <= 1.15);
    assert!(right >= 0.99 && others <= 1e-3 && good >= 0.99);
}

/// Two to four tones, the strongest at 40 dB, the others down to 30 dB weaker.
#[test]
fn several_tones_reach_their_bounds() {
    for count in [2, 3, 4] {
        for (seed, spacing) in [(21, None), (22, Some(3.0)), (23, Some(8.0))] {
            tones_reach_their_bounds::<Real>(count, spacing, seed);
            tones_reach_their_bounds::<Iq>(count, spacing, seed);
        }
    }
}

/// A record of a source: the analogue values of a sample by its number and two numbers of noise.
type Source<'a> = &'a (dyn Fn(&mut ChaCha8Rng) -> Box<dyn FnMut(f64, [f64; 2]) -> [f64; 2]> + Sync);

/// The share of records in which a line beside the first is reported.
fn further<R: Kind>(source: Source, count: u64) -> f64 {
    let seen = trials(24, count, |rng| {
        let mut analogue = source(rng);
        let samples = std::array::from_fn(|n| {
            let noise = [0; 2].map(|_| rng.sample::<f64, _>(StandardNormal));
            R::from_parts(analogue(n as f64, noise).map(quantise))
        });
        lines::<R>(&samples, 4).1.len() > 1
    });
    mean(seen.iter().map(|&more| f64::from(more)))
}

/// A tone whose phase and level follow functions of the time in records, in noise.
fn tone(
    rng: &mut ChaCha8Rng,
    amplitude: f64,
    noise: f64,
    level_and_turns: impl Fn(f64) -> [f64; 2] + 'static,
) -> Box<dyn FnMut(f64, [f64; 2]) -> [f64; 2]> {
    let (bins, phase) = (rng.random_range(10.0..500.0), rng.random_range(0.0..TAU));
    Box::new(move |n, [a, b]| {
        let time = n / N as f64;
        let [level, turns] = level_and_turns(time);
        let (sin, cos) = (TAU * (bins * time + turns) + phase).sin_cos();
        [amplitude * level * cos + noise * a, amplitude * level * sin + noise * b]
    })
}

/// Sidelobes, skirts of moving tones, harmonics and images of a front end, steps of a converter, drifts and humps of noise are no
/// targets.
#[test]
fn what_is_no_tone_is_no_line() {
    let still = |_: f64| [1.0, 0.0];
    let sources: [(&str, Source); 12] = [
        ("a tone at 0 dB", &|rng| tone(rng, 400.0, 283.0, still)),
        ("a tone at 70 dB", &|rng| tone(rng, 2000.0, 0.447, still)),
        ("a chirp of half a bin", &|rng| tone(rng, 1000.0, 7.1, |t| [1.0, 0.25 * t * t])),
        ("a chirp of two bins", &|rng| tone(rng, 1000.0, 7.1, |t| [1.0, t * t])),
        ("a level that swings", &|rng| {
            tone(rng, 1000.0, 7.1, |t| [1.0 + 0.3 * (8.0 * t).cos(), 0.0])
        }),
        ("no noise but the steps", &|rng| {
            let amplitude = rng.random_range(20.0..2000.0);
            tone(rng, amplitude, 0.0, still)
        }),
        ("noise", &|_| Box::new(|_, noise| noise.map(|x| 30.0 * x))),
        ("noise below an eighth of Nyquist", &|_| {
            let mut filter = [[0.0; 2]; 2];
            Box::new(move |_, noise| {
                for (state, x) in filter.iter_mut().zip(noise) {
                    state[0] += 0.3 * (300.0 * x - state[0]);
                    state[1] += 0.3 * (state[0] - state[1]);
                }
                filter.map(|state| state[1])
            })
        }),
        ("harmonics at -50 dB", &|rng| {
            let mut tone = tone(rng, 1500.0, 0.0, still);
            Box::new(move |n, noise| {
                let bent =
                    |x: f64| x + 0.0063 * x * x / 1500.0 + 0.007 * x.powi(3) / 1500f64.powi(2);
                let [i, q] = tone(n, [0.0; 2]).map(bent);
                [i + 1.1 * noise[0], q + 1.1 * noise[1]]
            })
        }),
        ("an image at -30 dB", &|rng| {
            let mut tone = tone(rng, 1000.0, 0.0, still);
            Box::new(move |n, noise| {
                let [i, q] = tone(n, [0.0; 2]);
                [i + 2.2 * noise[0], 0.94 * q + 2.2 * noise[1]]
            })
        }),
        ("an offset and a drift", &|rng| {
            let (mut tone, slope) = (tone(rng, 1000.0, 7.1, still), rng.random_range(-0.3..0.3));
            Box::new(move |n, noise| tone(n, noise).map(|x| x + 200.0 + slope * n))
        }),
        ("a tenth of the samples clipped", &|rng| tone(rng, 2600.0, 5.8, still)),
    ];
    for (name, source) in sources {
        let count = records(if name == "noise" { 1000 } else { 100 });
        let [real, iq] = [further::<Real>(source, count), further::<Iq>(source, count)];
        println!(
            "{name}, seed 24: more than one line in {real:.4} (real), {iq:.4} (I/Q) of {count}"
        );
        assert!(real <= 1e-3 && iq <= 1e-3, "{name}");
    }
}

fn phases<R: Kind>(snr_db: f64) {
    let amplitude = amplitude(snr_db);
    let noise = sigma(amplitude, snr_db);
    let seen = trials(25, records(2000), |rng| {
        let bins = rng.random_range(5.0..507.0);
        let line = Line { bins, amplitude, phase: rng.random_range(0.0..TAU) };
        let (measurement, found) = lines::<R>(&R::record::<N>(rng, &[line], noise), 1);
        let [phasor] = found.as_slice() else { panic!("{} lines", found.len()) };
        assert_eq!(phasor.tone, measurement.tone);
        let error = phase_error(phasor, &line);
        let bound = phase_bound::<R>(&line, noise.hypot((1.0f64 / 12.0).sqrt()));
        [(error / bound).powi(2), (error / f64::from(phasor.sigma_phase)).powi(2)]
    });
    let [rms, trust] = [0, 1].map(|i| mean(seen.iter().map(|squares| squares[i])));
    let rms = rms.sqrt();
    let kind = if R::IQ { "I/Q" } else { "real" };
    println!("phase, {kind}, {snr_db} dB, seed 25: {rms:.3} x bound, (error/sigma)^2 {trust:.3}");
    let error = 2.0 * (2.0 / seen.len() as f64).sqrt();
    assert!(rms * (1.0 - 0.5 * error) <= 1.05);
    assert!((0.85..=1.15).contains(&trust));
}

#[test]
fn a_phase_reaches_its_bound() {
    for snr_db in [0.0, 20.0, 40.0, 60.0] {
        phases::<Real>(snr_db);
        phases::<Iq>(snr_db);
    }
}
