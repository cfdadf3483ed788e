//! Each impairment does what it says, measured on the samples.

use num_complex::Complex;
use picket::acquire::sample::{Iq, Real};
use picket_host::impair::{Impaired, Impairment, Setup, help};
use picket_host::simulate::{Kind, Width, generator};
use picket_transform::Transform;
use std::f64::consts::TAU;

const N: usize = 1024;
const SEED: u64 = 7;
const RAIL: f64 = 2048.0;

fn setup(snr_db: f64) -> Setup {
    let mut setup = Setup::new(N, snr_db);
    (setup.width, setup.amplitude) = (Width::Float, Some(1000.0));
    // One range for all, so that the tones of one trial lie in one place.
    setup.bins = Some((20.0, 250.0));
    setup
}

fn one(text: &str) -> Impairment {
    let all = Impairment::parse(text).unwrap();
    assert_eq!(all.len(), 1, "{text}");
    all.into_iter().next().unwrap()
}

/// The voltages of a record without noise, neither rounded nor clipped.
fn clean<R: Kind>(text: &str, trial: u64) -> Impaired {
    one(text).record::<R>(&setup(f64::INFINITY), &mut generator(SEED, trial))
}

/// What an impairment adds to the pure tone of the same trial.
fn added<R: Kind>(text: &str, trial: u64) -> Vec<Complex<f64>> {
    let pure = clean::<R>("none", trial);
    clean::<R>(text, trial).samples.iter().zip(&pure.samples).map(|(x, p)| x - p).collect()
}

/// The steps of the phase of an I/Q tone from sample to sample, in bins.
fn steps(samples: &[Complex<f64>]) -> Vec<f64> {
    samples.windows(2).map(|x| (x[1] * x[0].conj()).arg() / TAU * N as f64).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[track_caller]
fn near(measured: f64, stated: f64, tolerance: f64) {
    assert!((measured - stated).abs() <= tolerance, "{measured}, stated {stated}, +- {tolerance}");
}

#[test]
fn frequencies_change_as_stated() {
    for trial in 0..10 {
        let chirp = clean::<Iq>("chirp:0.3", trial);
        let found = steps(&chirp.samples);
        // From the first step to the last there are N - 2 samples.
        near((found[N - 2] - found[0]).abs(), 0.3 * (N - 2) as f64 / N as f64, 1e-6);
        near(mean(&found), chirp.bins, 1e-6);

        let step = clean::<Iq>("frequency-step:10", trial);
        let found = steps(&step.samples);
        // Continuous in phase: the mean over the samples there are is that over the block, but for an end.
        near(mean(&found), step.bins, 10.0 * 2.0 / N as f64);
        near(found[0], step.nominal_bins, 1e-6);
        near((found[N - 2] - found[0]).abs(), 10.0, 1e-6);

        let jump = clean::<Iq>("phase-jump:0.3", trial);
        let found = steps(&jump.samples);
        let odd: Vec<f64> =
            found.iter().map(|s| s - jump.bins).filter(|s| s.abs() > 1e-6).collect();
        assert!(odd.len() <= 1, "{odd:?}");
        odd.iter().for_each(|step| near(step.abs(), 0.3 / TAU * N as f64, 1e-6));

        let walk = clean::<Iq>("phase-walk:0.3", trial);
        let found = steps(&walk.samples);
        near(mean(&found), walk.bins, 1e-6);
        let own: Vec<f64> =
            found.iter().map(|s| (s - walk.nominal_bins) * TAU / N as f64).collect();
        let total = own.iter().map(|s| s * s).sum::<f64>().sqrt();
        // A thousand squares of a normal number: the root of their mean is within 2.2 %, one sigma.
        near(total, 0.3, 0.3 * 0.1);
    }
}

#[test]
fn levels_change_as_stated() {
    let level = |text: &str| -> Vec<f64> {
        clean::<Iq>(text, 0).samples.iter().map(|x| x.norm() / 1000.0).collect()
    };
    let am = level("am:depth=0.5,cycles=1");
    near(am.iter().copied().fold(0.0, f64::max), 1.5, 1e-4);
    near(am.iter().copied().fold(9.0, f64::min), 0.5, 1e-4);
    let decay = level("decay:0.5");
    near((decay[N / 2] / decay[0]).ln(), -1.0, 1e-9);
    let start = level("start:0.2");
    assert_eq!(start.iter().filter(|x| **x == 0.0).count(), 205);
    near(start[205], 1.0, 1e-9);
}

#[test]
fn what_is_added_is_what_is_stated() {
    for trial in 0..5 {
        for x in added::<Real>("dc:0.05", trial) {
            near(x.re.abs(), 0.05 * RAIL, 1e-6);
        }
        for x in added::<Iq>("dc:0.05", trial) {
            near(x.norm(), 0.05 * RAIL, 1e-6);
        }
        let hum = added::<Real>("hum:cycles=2,fs=0.01", trial);
        let bin = |k: f64| -> Complex<f64> {
            let turn =
                |i: usize| Complex::from_polar(2.0 / N as f64, -TAU * k * i as f64 / N as f64);
            hum.iter().enumerate().map(|(i, x)| turn(i) * x.re).sum()
        };
        near(bin(2.0).norm(), 0.01 * RAIL, 1e-6);
        near(bin(1.0).norm(), 0.0, 1e-6);
        let line = added::<Real>("drift:fs=0.01,order=1", trial);
        near((line[N - 1] - line[0]).re.abs(), 2.0 * 0.01 * RAIL, 0.1);
        near((line[2] - line[1]).re, (line[1] - line[0]).re, 1e-9);
        let parabola = added::<Real>("drift:fs=0.01,order=2", trial);
        near(parabola[0].re.abs(), 0.01 * RAIL, 1e-6);
        near((parabola[N / 2] / parabola[0]).re, -0.5, 1e-3);

        let second = added::<Iq>("second-tone:offset=0.75,level-db=-20", trial);
        let found = steps(&second);
        let place = clean::<Iq>("none", trial).bins;
        near((mean(&found) - place).abs(), 0.75, 1e-6);
        second.iter().for_each(|x| near(x.norm(), 100.0, 1e-6));

        // The part of what is added that turns twice and three times as fast as the tone.
        let tone: Vec<_> =
            clean::<Iq>("none", trial).samples.iter().map(|x| x / x.norm()).collect();
        let harmonics = added::<Iq>("harmonics:-20", trial);
        for (order, level) in [(2, 100.0), (3, 100.0), (4, 0.0)] {
            let part: Complex<f64> =
                harmonics.iter().zip(&tone).map(|(x, t)| x * t.powi(order).conj()).sum();
            near(part.norm() / N as f64, level, 2.0);
        }

        let impulses = added::<Real>("impulses:count=5,fs=0.5", trial);
        let heights: Vec<f64> = impulses.iter().map(|x| x.re.abs()).filter(|x| *x > 0.0).collect();
        // Two may fall onto the same sample.
        assert!((3..=5).contains(&heights.len()), "{heights:?}");
        near(heights[0], 0.5 * RAIL, 1e-6);

        let burst = added::<Iq>("tone-burst:share=0.2,level-db=-6", trial);
        let on: Vec<usize> = (0..N).filter(|&k| burst[k].norm() > 0.0).collect();
        near(on.len() as f64, 0.2 * N as f64, 1.0);
        assert_eq!(on.last().unwrap() - on[0] + 1, on.len());
        near(burst[on[0]].norm(), 501.187, 1e-2);

        let burst = added::<Iq>("noise-burst:share=0.5,level-db=0", trial);
        let power = burst.iter().map(|x| x.norm_sqr()).sum::<f64>() / (0.5 * N as f64);
        // 512 samples: 4 % of spread.
        near(power / 1e6, 1.0, 0.2);
    }
}

#[test]
fn clocks_are_wrong_as_stated() {
    for trial in 0..5 {
        let pure = clean::<Iq>("none", trial);
        let lost = clean::<Iq>("lost:4", trial);
        let turns: Vec<f64> =
            steps(&lost.samples).iter().map(|s| (s - pure.bins).rem_euclid(N as f64)).collect();
        let odd: Vec<&f64> = turns.iter().filter(|x| **x > 1e-6 && N as f64 - **x > 1e-6).collect();
        assert_eq!(odd.len(), 1);
        near(*odd[0], (4.0 * pure.bins).rem_euclid(N as f64), 1e-6);

        let doubled = clean::<Iq>("doubled:4", trial).samples;
        let first = (1..N).find(|&k| doubled[k] == doubled[k - 1]).unwrap();
        let copies = (first..N).take_while(|&k| doubled[k] == doubled[k - 1]).count();
        assert_eq!(copies, 4.min(N - first));
        assert_eq!(doubled[..first], pure.samples[..first]);
        assert_eq!(doubled[first + copies..], pure.samples[first..N - copies]);

        let late = |samples: &[Complex<f64>]| -> Vec<f64> {
            let turn = |(x, p): (&Complex<f64>, &Complex<f64>)| (x * p.conj()).arg();
            let per_sample = TAU * pure.bins / N as f64;
            samples.iter().zip(&pure.samples).map(turn).map(|turn| turn / per_sample).collect()
        };
        let jitter = late(&clean::<Iq>("jitter:0.1", trial).samples);
        near(mean(&jitter.iter().map(|x| x * x).collect::<Vec<_>>()).sqrt(), 0.1, 0.01);
        let skew = late(&clean::<Iq>("skew:0.2", trial).samples);
        for (k, late) in skew.iter().enumerate() {
            near(*late, if k % 2 == 1 { 0.2 } else { 0.0 }, 1e-6);
        }
        let delay = clean::<Iq>("iq-delay:1", trial).samples;
        delay.iter().zip(&pure.samples).for_each(|(x, p)| near(x.re, p.re, 1e-6));
        delay.iter().skip(1).zip(&pure.samples).for_each(|(x, p)| near(x.im, p.im, 1e-6));
    }
}

#[test]
fn converters_are_wrong_as_stated() {
    let largest = |samples: &[Complex<f64>]| samples.iter().map(|x| x.re.abs()).fold(0.0, f64::max);
    near(largest(&clean::<Real>("clip-analogue:3", 0).samples), 1000.0 * 10f64.powf(-0.15), 1e-6);
    // At the rails: where the cosine is beyond 1/1.122.
    let codes = Setup::new(N, f64::INFINITY);
    let over = one("clip-converter:1").record::<Real>(&codes, &mut generator(SEED, 0));
    let at_rails = over.samples.iter().filter(|x| x.re == 2047.0 || x.re == -2048.0).count();
    near(at_rails as f64 / N as f64, 2.0 * (10f64.powf(-0.05)).acos() / std::f64::consts::PI, 0.02);

    // An amplitude of 1000 codes is but half of the characteristic.
    let bend = added::<Real>("inl:16", 0);
    assert!((8.0..=16.0).contains(&largest(&bend)), "{}", largest(&bend));
    let steps = added::<Real>("steps:8", 0);
    for x in &steps {
        near(x.re, 2.0 * (x.re / 2.0).round(), 1e-6);
        assert!(x.re.abs() <= 14.0);
    }
    let mut values: Vec<i64> = steps.iter().map(|x| x.re.round() as i64).collect();
    values.sort_unstable();
    values.dedup();
    assert!((2..=4).contains(&values.len()), "{values:?}");

    let few = one("quantise:2").record::<Real>(&Setup::new(N, 10.0), &mut generator(SEED, 0));
    assert!(few.samples.iter().all(|x| x.re.fract() == 0.0 && x.re.abs() <= 3.0));
    assert!(!one("quantise:2").noisy());

    let pure = clean::<Iq>("none", 0).samples;
    for (x, p) in clean::<Iq>("iq-gain:3", 0).samples.iter().zip(&pure) {
        near(x.im, p.im * 10f64.powf(0.15), 1e-6);
        near(x.re, p.re, 1e-6);
    }
    let skewed = clean::<Iq>("iq-phase:20", 0).samples;
    let product: f64 = skewed.iter().map(|x| x.re * x.im).sum::<f64>() / (N as f64 / 2.0 * 1e6);
    near(product, 20f64.to_radians().sin(), 0.01);
    // Nothing: not even noise.
    let dead = one("iq-dead:1").record::<Iq>(&setup(0.0), &mut generator(SEED, 0)).samples;
    assert!(dead.iter().all(|x| x.im == 0.0) && dead.iter().any(|x| x.re != 0.0));
    let dead = one("iq-dead:0").record::<Iq>(&setup(0.0), &mut generator(SEED, 0)).samples;
    assert!(dead.iter().all(|x| x.re == 0.0) && dead.iter().any(|x| x.im != 0.0));
}

#[test]
fn codes_are_wrong_as_stated() {
    let of = |text: &str, amplitude: f64| -> Vec<f64> {
        let mut codes = Setup::new(N, f64::INFINITY);
        codes.amplitude = Some(amplitude);
        let samples = one(text).record::<Real>(&codes, &mut generator(SEED, 0)).samples;
        samples.iter().map(|x| x.re).collect()
    };
    let pure = of("none", 2000.0);
    for (x, p) in of("swapped", 2000.0).chunks(2).zip(pure.chunks(2)) {
        assert_eq!([x[1], x[0]], [p[0], p[1]]);
    }
    for (x, p) in of("wrong-sign", 2000.0).iter().zip(&pure) {
        assert_eq!((*p as i16 as u16 ^ 0x800) & 0xFFF, *x as i16 as u16 & 0xFFF);
    }
    for level in [0, 1] {
        for (x, p) in of(&format!("stuck-bit:bit=8,level={level}"), 2000.0).iter().zip(&pure) {
            assert_eq!(*x as i16, (*p as i16 & !0x100) | level << 8, "{p}");
        }
    }
    let missing = of("missing-codes:4", 2000.0);
    assert!(missing.iter().all(|x| x.rem_euclid(512.0) >= 4.0));
    let moved = missing.iter().zip(&pure).filter(|(x, p)| x != p);
    assert!(moved.clone().count() > 0);
    moved.for_each(|(x, p)| {
        assert!(p.rem_euclid(512.0) < 4.0 && (1.0..=4.0).contains(&(p - x)), "{p} {x}")
    });
    // Twice the rail: the codes of a converter that is twice as wide, less a whole number of its ranges.
    let wrapped = of("wrap:6.0206", 2000.0);
    let mut wide = Setup::new(N, f64::INFINITY);
    (wide.amplitude, wide.width) = (Some(4096.0), Width::Float);
    let wide = one("none").record::<Real>(&wide, &mut generator(SEED, 0)).samples;
    for (x, p) in wrapped.iter().zip(&wide) {
        assert!((-2048.0..2048.0).contains(x));
        let ranges = (p.re - x) / 4096.0;
        near(ranges, ranges.round(), 1.0 / 4096.0);
    }
    let carried = wrapped.iter().zip(&wide).filter(|(x, p)| (p.re - *x).abs() > 1.0).count();
    // Beyond half of its crest a sine is for two thirds of the time.
    near(carried as f64 / N as f64, 2.0 / 3.0, 0.05);
    // A tone goes on from where it was a block earlier.
    let (stale, whole) = (of("stale-buffer:0.25", 2000.0), clean::<Iq>("none", 0));
    assert_eq!(stale[..768], pure[..768]);
    assert_ne!(stale[768..], pure[768..]);
    let late = clean::<Iq>("stale-buffer:0.25", 0).samples;
    let turn = Complex::cis(-TAU * whole.bins);
    for (x, whole) in late.iter().zip(&whole.samples).skip(768) {
        near((x - whole * turn).norm(), 0.0, 1e-6);
    }
}

/// The power density of the noise of an impairment over bins, of white noise 1: 200 records through Hann's window, and
/// what they say of it at the tone.
fn density<R: Kind>(text: &str) -> (Vec<f64>, f64, f64) {
    let (noisy, silent) = (setup(10.0), setup(f64::INFINITY));
    let fft = f64::forward(N);
    let (mut powers, mut stated, mut place) = (vec![0.0; N], 0.0, 0.0);
    let trials = 200;
    for trial in 0..trials {
        // All tones in one place, so that what lies beside them does, too.
        let (mut noisy, mut silent) = (noisy.clone(), silent.clone());
        (noisy.bins, silent.bins) = (Some((128.0, 128.0)), Some((128.0, 128.0)));
        let with = one(text).record::<R>(&noisy, &mut generator(SEED, trial));
        let without = one(text).record::<R>(&silent, &mut generator(SEED, trial));
        let window = |k: usize| 1.0 - (TAU * k as f64 / N as f64).cos();
        let difference = with.samples.iter().zip(&without.samples).enumerate();
        let mut x: Vec<Complex<f64>> = difference.map(|(k, (x, y))| (x - y) * window(k)).collect();
        fft.process(&mut x);
        // 10 dB below 1000 codes: 1e6 / 20 in each part; Hann's window holds 3/2 of the power.
        let white = 1e6 / 20.0 * 1.5 * N as f64 * if R::IQ { 2.0 } else { 1.0 };
        powers
            .iter_mut()
            .zip(x)
            .for_each(|(p, x)| *p += x.norm_sqr() / white / f64::from(trials as u32));
        stated = 10f64.powf(1.0 - with.local_snr_db / 10.0);
        place = with.bins;
    }
    (powers, stated, place)
}

#[test]
fn noise_has_the_shape_that_is_stated() {
    // The mean over bins a..b, dB.
    let db = |powers: &[f64], a: usize, b: usize| 10.0 * mean(&powers[a..b]).log10();
    let of = |text: &str| {
        let (powers, stated, place) = density::<Real>(text);
        // All of it is what the ratio says; less so where few bins hold it.
        near(10.0 * mean(&powers).log10(), 0.0, 0.4);
        let k = place.round() as usize;
        // Twenty-one bins of 200 records: 2 %, and what the shape changes over them.
        near(db(&powers, k - 3, k + 4), 10.0 * stated.log10(), 0.6);
        powers
    };
    let white = of("none");
    near(db(&white, 100, 120), 0.0, 0.3);
    let slope = of("noise-slope:20");
    near(db(&slope, 450, 475) - db(&slope, 38, 63), 20.0 * 412.0 / 512.0, 0.5);
    let notch = of("noise-notch:level-db=-20,width=40,offset=0");
    near(db(&notch, 125, 132) - db(&notch, 400, 500), -20.0, 0.6);
    let hump = of("noise-hump:level-db=10,width=10,offset=0");
    near(db(&hump, 127, 130) - db(&hump, 400, 500), 10.0, 0.8);
    let flicker = of("noise-flicker:1");
    near(db(&flicker, 95, 106) - db(&flicker, 380, 421), 6.0, 0.5);
    let low = of("noise-low-pass:corner=0.5,order=8");
    near(db(&low, 30, 200), 3.0, 0.3);
    near(db(&low, 254, 259) - db(&low, 30, 200), -3.0, 0.6);
    assert!(db(&low, 400, 500) < -25.0, "{}", db(&low, 400, 500));
    let rc = of("noise-rc:corner=0.5,sections=2");
    near(db(&rc, 246, 267) - db(&rc, 3, 30), -6.0, 0.6);
    let band = of("noise-band-pass:middle=0.25,width=0.125");
    near(db(&band, 110, 146), 9.0, 0.5);
    assert!(db(&band, 300, 500) < -30.0 && db(&band, 10, 50) < -20.0);
    // Of I/Q the slope goes on through DC.
    let (slope, ..) = density::<Iq>("noise-slope:20");
    near(db(&slope, 380, 400) - db(&slope, 624, 644), 20.0 * 780.0 / 1024.0, 0.6);
}

#[test]
fn a_seed_gives_the_same_records_and_everything_is_different() {
    fn of<R: Kind>(impairment: &Impairment, trial: u64) -> Vec<Complex<f64>> {
        impairment.record::<R>(&Setup::new(256, 30.0), &mut generator(SEED, trial)).samples
    }
    let mut names = Vec::new();
    for impairment in Impairment::all().into_iter().chain(Impairment::front_end()) {
        let pair = |trial| match impairment.fits::<Real>() {
            true => (of::<Real>(&impairment, trial), of::<Real>(&one("none"), trial)),
            false => (of::<Iq>(&impairment, trial), of::<Iq>(&one("none"), trial)),
        };
        let label = format!("{}:{}", impairment.name(), impairment.label());
        assert_eq!(pair(3), pair(3), "{label}");
        assert_ne!(pair(3).0, pair(4).0, "{label}");
        assert_eq!(pair(3).0 == pair(3).1, impairment.name() == "none", "{label}");
        assert_eq!(pair(3).0.len(), 256);
        // What is printed is what is read.
        if !impairment.label().is_empty() {
            assert_eq!(one(&label), impairment);
        }
        names.push(impairment.name());
        assert!(help().contains(&format!("  {} ", impairment.name())), "{label}");
    }
    // Of I/Q tones, half turn backwards.
    let turns =
        |trial| one("none").record::<Iq>(&Setup::new(64, 30.0), &mut generator(SEED, trial)).bins;
    let backwards = (0..100).filter(|&trial| turns(trial) < 0.0).count();
    assert!((30..70).contains(&backwards), "{backwards}");
    // A generator goes on.
    let (mut rng, none) = (generator(SEED, 0), one("none"));
    let mut next = || none.record::<Real>(&Setup::new(64, 30.0), &mut rng).samples;
    assert_ne!(next(), next());
    names.dedup();
    for name in "dc hum drift harmonics clip-analogue clip-converter impulses lost doubled inl quantise chirp am phase-walk \
                 phase-jump frequency-step second-tone tone-burst noise-burst noise-slope noise-notch noise-hump noise-flicker \
                 noise-low-pass noise-band-pass start decay jitter skew iq-gain iq-phase iq-delay iq-dead steps wrap swapped wrong-sign stuck-bit missing-codes stale-buffer"
        .split_whitespace()
    {
        assert!(names.contains(&name), "no {name}");
    }
}

#[test]
fn severities_as_they_are_typed() {
    let labels = |text: &str| -> Vec<String> {
        let all = Impairment::parse(text).unwrap();
        all.iter().map(|i| format!("{}:{}", i.name(), i.label())).collect()
    };
    assert_eq!(labels("chirp:0.3"), ["chirp:rate=0.3"]);
    assert_eq!(labels("chirp:rate-bins=0.3/1"), ["chirp:rate=0.3", "chirp:rate=1"]);
    assert_eq!(
        labels("hum:cycles=2,fs=0.1/0.2, dc:0.5"),
        ["hum:cycles=2,fs=0.1", "hum:cycles=2,fs=0.2", "dc:fs=0.5"]
    );
    assert_eq!(labels("second-tone").len(), 24);
    assert_eq!(labels("all").len(), Impairment::all().len());
    assert_eq!(labels("front-end").len(), Impairment::front_end().len());
    let wrong = |text: &str, says: &str| {
        let error = Impairment::parse(text).unwrap_err();
        assert!(error.contains(says) && error.lines().count() == 1, "{text}: {error}");
    };
    wrong("chrip", "no impairment \"chrip\"");
    wrong("", "no impairment");
    wrong("chirp,", "no impairment");
    wrong("chirp:fast", "rate=fast: give a number from 0");
    wrong("chirp:speed=1", "chirp has no \"speed\", but rate");
    wrong("chirp:nan", "give a number");
    wrong("dc:1.5", "from 0 to 1");
    wrong("none:1", "none has no severities");
    wrong("hum,rate=1", "hum has no \"rate\", but cycles, fs");
}
